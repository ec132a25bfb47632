#pragma once
/// @file
/// What a study says of its runs: orders, limits, budgets, work against precision; as JSON, CSV and tables.

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "tools/study_analysis.hpp"
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

/// @name Outcomes on their way between ranks
/// @{
Json packed(std::size_t number, const Outcome& outcome);

Outcome unpacked(const Json& json);
/// @}

/// @brief A study when its runs are done, on one rank.
class Report {
 public:
  /// @param reference name of the series whose limits count as true, or "own": each series its own
  Report(std::vector<Series> series, std::vector<PlannedRun> runs, std::vector<Outcome> outcomes,
         std::string reference);

  /// The content of study.json.
  [[nodiscard]] const Json& json() const noexcept { return study_; }

  /// The content of study.csv.
  [[nodiscard]] std::string csv() const;

  /// What the user reads.
  [[nodiscard]] std::string tables() const;

 private:
  using Rows = std::vector<std::vector<std::string>>;

  // In this order in the tables; study.json and study.csv have all.
  static constexpr std::array kShown{"impulse",          "rebound_velocity", "penetration",
                                     "deflection_down",  "deflection_up",    "energy_centre",
                                     "energy_vibration", "energy_springs",   "energy_lost"};

  static std::string number(const std::optional<double>& value, const char* format = "%.6g");
  static std::string number(const Json& value, const char* format = "%.6g");

  /// Columns as wide as needed; the first flush left, the others right.
  static std::string aligned(const Rows& rows);

  [[nodiscard]] std::string axis_value(const PlannedRun& run, std::string_view key) const;

  [[nodiscard]] std::string label(const Quantity& quantity) const { return quantity.name + " [" + quantity.unit + "]"; }

  /// The quantities of the tables that some run has.
  [[nodiscard]] std::vector<Quantity> shown() const;

  [[nodiscard]] Json describe(const PlannedRun& run) const;

  /// The runs along one axis of a series, the others at their finest.
  [[nodiscard]] std::vector<const PlannedRun*> line(std::size_t series, std::size_t axis) const;

  /// Whether the analysis looks at a run: at most one axis is not at its finest.
  [[nodiscard]] bool on_a_line(const PlannedRun& run) const;

  static Json error_json(double error, Bound bound) { return bound == Bound::unknown ? Json(nullptr) : Json(error); }

  [[nodiscard]] Json analyse(std::size_t number) const;

  void work_precision();

  [[nodiscard]] std::string run_table() const;

  static std::string number_of(const Outcome& outcome, const char* name, const char* format = "%.6g");
  static std::string number_of(const Outcome& outcome, const std::string& name);

  [[nodiscard]] std::string trend_tables(std::size_t number) const;

  /// "~" where it is only the size of the changes, ">" where it is more than the number, "?" where nothing is known.
  static std::string error_text(const Json& entry);
  static bool converged(const Json& entry) { return entry["error_is"] == name(Bound::estimate); }

  static std::string joined(const Json& words);

  static std::string others(const Json& series, const std::string& key);

  [[nodiscard]] std::string budget_table(std::size_t number) const;

  [[nodiscard]] std::string precision_table() const;

  [[nodiscard]] std::string failures() const;

  std::vector<Series> series_;
  std::vector<PlannedRun> runs_;
  std::vector<Outcome> outcomes_;
  std::string reference_;
  std::vector<Quantity> quantities_;
  std::map<std::string, double> scale_;  // of quantities with this unit
  std::set<std::string> valued_;         // quantities that some finished run has
  Json study_;
};

}  // namespace udar::study
