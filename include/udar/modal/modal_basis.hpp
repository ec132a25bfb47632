#pragma once
/// @file
/// A structure's lowest modes and what the rest of it gives way by under its contact points.

#include <petscsys.h>

#include <cstddef>
#include <span>
#include <vector>

#include "udar/contact/obstacle_forces.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/modal/reduced_model.hpp"

namespace udar {

/// @brief The lowest modes, M-orthonormal, those without frequency first, and static columns of all others: what a
/// force moves them by at rest. Computed once; nothing is solved for afterwards.
///
/// Source: MacNeal, Computers & Structures 1 (1971) 581; Rubin, AIAA J. 13 (1975) 995; docs/theory.md, "The modal
/// integrator"
class ModalBasis {
 public:
  /// @param chain what is simulated @param formulation of its line, the filter frequency left out
  /// @param count modes wanted, those without frequency included
  /// @note Collective: about 2 `count` + 4 line solves.
  /// @throws InputError if the structure has not so many modes; SolveError if SLEPc does not find them
  ModalBasis(const BeamChain& chain, FilterParameters parameters, PetscInt count);

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
  [[nodiscard]] PetscInt solves() const noexcept { return line_.solves(); }

 private:
  void find_rigid();
  void find_flexible(PetscInt count);
  void remove_modes(std::vector<double>& values) const;
  [[nodiscard]] std::vector<double> static_under(std::vector<double> rest);

  FilteredStructure line_;
  std::vector<double> frequency_;
  std::vector<std::vector<double>> shapes_;
};

}  // namespace udar
