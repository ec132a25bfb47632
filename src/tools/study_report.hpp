#pragma once
/// @file
/// What a study says of its runs: orders, limits, budgets, work against precision; as JSON, CSV and tables.

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "tools/study_analysis.hpp"
#include "tools/study_plan.hpp"
#include "tools/study_quantities.hpp"
#include "tools/study_runs.hpp"

namespace udar::study {

/// @brief A convergence study when its runs are done, on one rank.
class Report {
 public:
  /// @param reference name of the series whose limits count as true, or "own": each series its own
  Report(Runs runs, std::string reference);

  /// The content of study.json.
  [[nodiscard]] const Json& json() const noexcept { return study_; }

  /// The content of study.csv.
  [[nodiscard]] std::string csv() const { return all_.csv(); }

  /// What the user reads.
  [[nodiscard]] std::string tables() const;

 private:
  // In this order in the tables; study.json and study.csv have all.
  static constexpr std::array kShown{"impulse",          "rebound_velocity", "penetration",
                                     "deflection_down",  "deflection_up",    "energy_centre",
                                     "energy_vibration", "energy_springs",   "energy_lost"};

  [[nodiscard]] std::string label(const Quantity& quantity) const { return quantity.name + " [" + quantity.unit + "]"; }

  /// The quantities of the tables that some run has.
  [[nodiscard]] std::vector<Quantity> shown() const { return all_.known(kShown); }

  /// The runs along one axis of a series, the others at their finest.
  [[nodiscard]] std::vector<const PlannedRun*> line(std::size_t series, std::size_t axis) const;

  /// Whether the analysis looks at a run: at most one axis is not at its finest.
  [[nodiscard]] bool on_a_line(const PlannedRun& run) const;

  static Json error_json(double error, Bound bound) { return bound == Bound::unknown ? Json(nullptr) : Json(error); }

  [[nodiscard]] Json analyse(std::size_t number) const;

  void work_precision();

  [[nodiscard]] std::string trend_tables(std::size_t number) const;

  /// "~" where it is only the size of the changes, ">" where it is more than the number, "?" where nothing is known.
  static std::string error_text(const Json& entry);
  static bool converged(const Json& entry) { return entry["error_is"] == name(Bound::estimate); }

  static std::string joined(const Json& words);

  static std::string others(const Json& series, const std::string& key);

  [[nodiscard]] std::string budget_table(std::size_t number) const;

  [[nodiscard]] std::string precision_table() const;

  Runs all_;
  std::string reference_;
  std::map<std::string, double> scale_;  // of quantities with this unit
  Json study_;
};

}  // namespace udar::study
