#pragma once
/// @file
/// Forces on the line: gravity and nodal forces that follow time tables.

#include <span>
#include <vector>

#include "udar/structure/beam_chain.hpp"

namespace udar {

/// @brief A force on one node over time: linear between the points, constant before the first and after the last.
struct NodalLoad {
  double position = 0.0;      ///< [m] from the left end; acts on the nearest node
  std::vector<double> time;   ///< [s], strictly ascending, at least one
  std::vector<double> force;  ///< [N], y up, same size
};

/// @brief The load vector F(t) of the line on this rank's nodes.
class Loads {
 public:
  /// @param gravity [m/s^2], acts downward on every lumped mass
  /// @note Not collective; keeps only the loads of this rank's nodes.
  /// @throws InputError if a table is empty, ragged or not ascending, or a position is off the beam
  Loads(const BeamChain& beam, double gravity, const std::vector<NodalLoad>& nodal);

  /// @brief F [N] at time t [s], one value per local node; empty: none on this rank.
  /// @param work where it is built if it must be; the result lives as long as this object and `work` do
  [[nodiscard]] std::span<const double> force(double time, std::vector<double>& work) const;
  /// @brief dF/dt [N/s] just after time t, in the same way.
  [[nodiscard]] std::span<const double> rate(double time, std::vector<double>& work) const;

  [[nodiscard]] double gravity() const noexcept { return gravity_; }
  /// All times at which some table of the whole structure has a kink, ascending, equal on every rank [s].
  [[nodiscard]] const std::vector<double>& kinks() const noexcept { return kinks_; }

  struct LocalLoad {
    PetscInt local_node = 0;
    NodalLoad table;
  };
  /// The time-dependent loads on this rank.
  [[nodiscard]] const std::vector<LocalLoad>& local() const noexcept { return local_; }
  /// Whether any load of the whole structure changes in time.
  [[nodiscard]] bool time_dependent() const noexcept { return kinks_.size() > 1; }

  /// Force and its rate of one table just after time t.
  struct ForceAndRate {
    double force;
    double rate;
  };
  [[nodiscard]] static ForceAndRate evaluate(const NodalLoad& load, double time);

 private:
  double gravity_;
  std::vector<double> weight_;  // empty without gravity
  std::size_t nodes_ = 0;
  std::vector<LocalLoad> local_;
  std::vector<double> kinks_;
};

}  // namespace udar
