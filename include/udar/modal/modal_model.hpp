#pragma once
/// @file
/// A structure on its supports, reduced to modes.

#include <petscsys.h>

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "udar/contact/obstacle_forces.hpp"
#include "udar/modal/modal_basis.hpp"
#include "udar/modal/reduced_model.hpp"

namespace udar {

/// @brief What a reduced model is made of.
struct ModalChoice {
  PetscInt modes = 0;  ///< those without frequency included; 0: chosen by the supports
};

/// @brief The reduced model of a beam with its loads and supports, and the way back to the beam.
class ModalModel {
 public:
  /// @param chain what is simulated @param parameters of its line @param force on it at rest [N], local points
  /// @param axis where nothing strains it [m], local points @param points that supports can touch, of all ranks
  /// @note Collective: about 2 k + 4 line solves and ten for each point, for each number of modes tried.
  /// @throws InputError if modes are too few or too many, or points too close together
  ModalModel(const BeamChain& chain, const FilterParameters& parameters, std::span<const double> force,
             std::vector<double> axis, std::span<const LinePoint> points, const ModalChoice& choice);

  [[nodiscard]] const ReducedModel& reduced() const noexcept { return reduced_; }
  [[nodiscard]] const ModalBasis& basis() const noexcept { return *basis_; }
  [[nodiscard]] const Drive& drive() const noexcept { return drive_; }
  /// Line solves that it took.
  [[nodiscard]] PetscInt solves() const noexcept { return solves_; }
  /// omega_S [rad/s].
  [[nodiscard]] double frequency_bound() const noexcept { return bound_; }

  /// @brief The modes' part of a motion, which must be nearly all of it.
  /// @note Collective. @throws InputError if a share above 1e-3 of it is in no mode
  [[nodiscard]] ModalState project(double time, std::span<const double> position,
                                   std::span<const double> velocity) const;
  /// @brief Where the line is and what moves of its masses. @param[out] position [m] @param[out] velocity [m/s]
  void expand(const ModalState& state, std::span<double> position, std::span<double> velocity) const;

 private:
  void choose(const BeamChain& chain, const FilterParameters& parameters, std::span<const LinePoint> points,
              PetscInt asked);
  void build(const BeamChain& chain, const FilterParameters& parameters, std::span<const LinePoint> points,
             PetscInt modes);

  std::unique_ptr<ModalBasis> basis_;
  std::vector<std::vector<double>> columns_;  // G b' of each point
  std::vector<double> rest_;                  // axis and G F
  std::vector<double> axis_;
  ReducedModel reduced_;
  Drive drive_;
  PetscInt solves_ = 0;
  double bound_ = 0.0;
};

}  // namespace udar
