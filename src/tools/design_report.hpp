#pragma once
/// @file
/// What a design study says of its runs: spread of each quantity, and which variable it follows.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/study_runs.hpp"

namespace udar::study {

/// @brief Spearman's rank correlation of two columns, ties with their mean rank; empty where one does not vary.
[[nodiscard]] std::optional<double> rank_correlation(std::span<const double> a, std::span<const double> b);

/// @brief A design study when its runs are done, on one rank. It tells no limit: a design is no discretisation.
class DesignReport {
 public:
  explicit DesignReport(Runs runs);

  /// The content of study.json.
  [[nodiscard]] const Json& json() const noexcept { return study_; }
  /// The content of study.csv.
  [[nodiscard]] std::string csv() const { return all_.csv(); }
  /// What the user reads.
  [[nodiscard]] std::string tables() const;

 private:
  // In this order in the tables; study.json and study.csv have all.
  static constexpr std::array kShown{"peak_force",  "max_moment",       "max_stress", "utilisation", "sag",
                                     "penetration", "rebound_velocity", "impulse",    "energy_lost"};

  [[nodiscard]] std::vector<const PlannedRun*> finished(std::size_t series) const;
  [[nodiscard]] Json spread(std::size_t series, const Quantity& quantity) const;
  [[nodiscard]] std::string spread_table(std::size_t series) const;

  Runs all_;
  Json study_;
};

}  // namespace udar::study
