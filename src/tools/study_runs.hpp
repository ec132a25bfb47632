#pragma once
/// @file
/// The runs of a study and what became of them: as tables, CSV and JSON.

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/study_plan.hpp"
#include "tools/study_quantities.hpp"

namespace udar::study {

using Json = nlohmann::ordered_json;

/// @brief How a run went.
struct Outcome {
  std::string state = "not run";  ///< or finished, stopped, failed
  std::string reason;             ///< of a failed or stopped run
  std::vector<Quantity> quantities;

  [[nodiscard]] std::optional<double> value(std::string_view name) const {
    const auto found = std::ranges::find(quantities, name, &Quantity::name);
    return state == "finished" && found != quantities.end() ? found->value : std::nullopt;
  }
};

Json to_json(const std::optional<double>& value);

/// @name Outcomes on their way between ranks, or to a later program
/// @{
Json packed(std::size_t number, const Outcome& outcome);

Outcome unpacked(const Json& json);
/// @}

/// @name Tables for the eye
/// @{
using Rows = std::vector<std::vector<std::string>>;

std::string number(const std::optional<double>& value, const char* format = "%.6g");
std::string number(const Json& value, const char* format = "%.6g");

/// Columns as wide as needed; the first flush left, the others right.
std::string aligned(const Rows& rows);
/// @}

/// @brief All runs of a study, on one rank.
class Runs {
 public:
  Runs(std::vector<Series> series, std::vector<PlannedRun> runs, std::vector<Outcome> outcomes);

  [[nodiscard]] const std::vector<Series>& series() const noexcept { return series_; }
  [[nodiscard]] const std::vector<PlannedRun>& planned() const noexcept { return runs_; }
  [[nodiscard]] const Outcome& outcome(const PlannedRun& run) const { return outcomes_[run.number]; }
  /// All that some run has.
  [[nodiscard]] const std::vector<Quantity>& quantities() const noexcept { return quantities_; }
  /// Of these names those that some finished run knows, in their order.
  [[nodiscard]] std::vector<Quantity> known(std::span<const char* const> names) const;
  /// As given; empty where the run's series has no such axis.
  [[nodiscard]] std::string axis_value(const PlannedRun& run, std::string_view key) const;

  /// The content of study.csv.
  [[nodiscard]] std::string csv() const;
  /// `quantities` and `runs` of study.json.
  void add_to(Json& study) const;
  /// Axes, quantities and counts of each run of a series. @param most rows, the rest is said to be in study.csv
  [[nodiscard]] std::string table(std::size_t series, const std::vector<Quantity>& shown, std::size_t most) const;
  /// A line for each run that did not finish.
  [[nodiscard]] std::string failures() const;

 private:
  [[nodiscard]] Json describe(const PlannedRun& run) const;
  [[nodiscard]] std::vector<std::string> row(const PlannedRun& run, const std::vector<Quantity>& shown) const;

  std::vector<Series> series_;
  std::vector<PlannedRun> runs_;
  std::vector<Outcome> outcomes_;
  std::vector<Quantity> quantities_;
};

}  // namespace udar::study
