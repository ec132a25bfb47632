#pragma once
/// @file
/// What a study compares of its runs, each number defined in docs/theory.md, "Convergence studies".

#include <mpi.h>

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "udar/app/case.hpp"
#include "udar/app/rebound.hpp"
#include "udar/app/run.hpp"

namespace udar::study {

/// @brief The beam as a whole at one time, without what strikes it; equal on every rank.
struct Sample {
  double time = 0.0;               ///< [s]
  double height = 0.0;             ///< of the centre of mass [m]
  double velocity = 0.0;           ///< of the centre of mass [m/s]
  std::vector<double> position;    ///< of the line at the gauges [m]
  std::vector<double> deflection;  ///< of the line at the gauges from its best straight line, by mass [m]
  double striking = 0.0;           ///< kinetic energy of strikers and masses that travel [J]
  EnergyLedger energy;             ///< [J], strikers' with it
};

/// @brief Collects samples at every row of the output. One reduction per row.
class Sampler final : public Observer {
 public:
  /// @param points must live as long as the run @note Collective.
  Sampler(const app::Case& input, const MassPoints& points);

  [[nodiscard]] double interval() const override { return interval_; }

  void snapshot(const Snapshot& state) override;

  [[nodiscard]] const std::vector<Sample>& samples() const noexcept { return samples_; }
  [[nodiscard]] double mass() const noexcept { return total_; }  ///< of the whole beam [kg]

 private:
  const MassPoints* points_;  // with strikers
  double interval_;
  std::vector<double> mass_;  // of what moves along y
  std::vector<double> x_;     // from the centre of mass
  double total_ = 0.0;
  double inertia_ = 0.0;
  std::vector<std::vector<std::pair<std::size_t, double>>> gauge_;  // local points and what a gauge reads of each
  std::vector<double> gauge_x_;
  std::vector<Sample> samples_;
};

/// @brief How the beam leaves its first contact, as `app::ReboundSearch` finds it in the rows.
/// @param[in] first_contact [s] @param[in] gravity downward [m/s^2]
app::Rebound rebound(std::span<const Sample> samples, double first_contact, double gravity);

/// @brief The largest value of a smooth curve known at its rows, by the parabola through the largest three.
template <class Value>
double largest(std::span<const Sample> samples, const Value& value) {
  const auto peak = std::ranges::max_element(samples, {}, value);
  if (peak == samples.begin() || peak + 1 == samples.end()) {
    return value(*peak);
  }
  const double before = peak->time - (peak - 1)->time;
  const double after = (peak + 1)->time - peak->time;  // shorter at the end of a run
  const double rise = (value(*peak) - value(*(peak - 1))) / before;
  const double drop = (value(*peak) - value(*(peak + 1))) / after;
  const double slope = (rise * after - drop * before) / (before + after);
  const double bend = (rise + drop) / (before + after);
  return bend > 0.0 ? value(*peak) + slope * slope / (4.0 * bend) : value(*peak);
}

/// @brief One number of a run.
struct Quantity {
  std::string name;
  std::string unit;
  std::optional<double> value;
  bool compared = true;  ///< else it is counted, and no order is looked for
};

/// @brief All that a study compares of a run.
std::vector<Quantity> quantities(const app::Case& input, const io::Summary& summary, const Sampler& sampler);

}  // namespace udar::study
