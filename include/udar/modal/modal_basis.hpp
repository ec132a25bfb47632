#pragma once
/// @file
/// A structure's lowest modes and what the rest of it gives way by under its contact points.

#include <petscsys.h>

#include <cstddef>
#include <span>
#include <vector>

#include "udar/contact/obstacle_forces.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/filter/modes.hpp"
#include "udar/modal/reduced_model.hpp"

namespace udar {

/// @brief Points that can move. @note Collective: one reduction.
[[nodiscard]] PetscInt movable_points(const MassPoints& points);

/// @brief The lowest modes, M-orthonormal, those without frequency first, and static columns of all others: what a
/// force moves them by at rest. Computed once; nothing is solved for afterwards.
///
/// Of modes that share a frequency, or nearly do, all are in: any other choice among them would be as good. A single
/// beam has none of these but its rigid motions; of other structures searches beside the modes that are found end when
/// the next one is higher.
///
/// Source: MacNeal, Computers & Structures 1 (1971) 581; Rubin, AIAA J. 13 (1975) 995; docs/theory.md, "The modal
/// integrator"
class ModalBasis {
 public:
  /// @param structure what is simulated @param parameters of its line, the filter frequency left out
  /// @param count modes wanted, those without frequency included @param guess as `separate_modes`
  /// @note Collective: about 2 `count` + 4 line solves of a beam, three or four times as many of others.
  /// @throws InputError if the structure has not so many modes; SolveError if SLEPc does not find them
  ModalBasis(const Structure& structure, const FilterParameters& parameters, PetscInt count, double guess = 0.0);

  /// Of each mode [rad/s], ascending; those of a motion that nothing holds are zero.
  [[nodiscard]] std::span<const double> frequency() const noexcept { return frequency_; }
  [[nodiscard]] std::size_t modes() const noexcept { return frequency_.size(); }
  /// At the local points [kg^(-1/2)].
  [[nodiscard]] const std::vector<double>& shape(std::size_t mode) const { return shapes_[mode]; }

  /// @brief phi' M x of every mode. @note Collective: one reduction.
  [[nodiscard]] std::vector<double> amplitudes(std::span<const double> values) const;
  /// @brief phi' F of every mode. @note Collective: one reduction.
  [[nodiscard]] std::vector<double> loads(std::span<const double> force) const;
  /// @brief The share of x' M x that no mode has, in [0, 1]. @note Collective: one reduction.
  [[nodiscard]] double share_outside(std::span<const double> values) const;

  /// @brief G F: how the static rest stands under a force [m], local points.
  /// @note Collective: about ten line solves; none if modes carry all of it.
  [[nodiscard]] std::vector<double> residual(std::span<const double> force);

  /// @brief Everything about the points that can be touched, the same on every rank. @param points of all ranks
  /// @param[out] columns G b' of each, local points @note Collective: `residual` for each point.
  [[nodiscard]] ReducedModel reduce(std::span<const LinePoint> points, std::vector<std::vector<double>>& columns);

  /// Line solves so far.
  [[nodiscard]] PetscInt solves() const noexcept { return separation_.solves + line_.solves(); }
  /// Filter frequency by which it tells its modes from the rest [rad/s].
  [[nodiscard]] double separation() const noexcept { return separation_.filter.filter_frequency; }

 private:
  void find_flexible(PetscInt count);
  void add_companions(std::vector<Mode>& found);
  void settle(std::span<Mode> alike) const;
  void remove_modes(std::vector<double>& values) const;
  [[nodiscard]] std::vector<double> static_under(std::vector<double> rest);

  Separation separation_;
  FilteredStructure line_;
  std::vector<double> frequency_;
  std::vector<std::vector<double>> shapes_;
};

}  // namespace udar
