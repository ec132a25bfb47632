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
#include "udar/structure/load.hpp"

namespace udar {

/// @brief What a reduced model is made of.
struct ModalChoice {
  PetscInt modes = 0;                   ///< those without frequency included; 0: chosen by the supports
  std::vector<double> damping_ratio{};  ///< of the flexible modes, the last of all that follow; empty: undamped
  double retardation = 0.0;             ///< alpha: the static rest lags by alpha over the last frequency
};

/// @brief The reduced model of a structure with its loads and supports, and the way back to the structure.
class ModalModel {
 public:
  /// @param structure what is simulated @param parameters of its line @param loads on it; must outlive this object
  /// @param axis where nothing strains it [m], local points @param points that supports can touch, of all ranks
  /// @note Collective: as `ModalBasis` and about ten line solves for each point and load, for each number of modes
  /// tried.
  /// @throws InputError if modes are too few or too many, or points too close together
  ModalModel(const Structure& structure, const FilterParameters& parameters, const Loads& loads,
             std::vector<double> axis, std::span<const LinePoint> points, const ModalChoice& choice);

  [[nodiscard]] const ReducedModel& reduced() const noexcept { return reduced_; }
  [[nodiscard]] const ModalBasis& basis() const noexcept { return *basis_; }
  /// @brief What loads and supports do from a time on, until one of their tables has its next row.
  /// @note Collective: one reduction.
  void drive_from(double time);
  /// As told last; at first from t = 0.
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
  /// @brief Integral of where the line is [m s] at a local point, of what modes and rest forces had as integrals.
  [[nodiscard]] double passed(std::size_t point, double from, double until, std::span<const double> amplitude,
                              std::span<const double> rest_force) const;

 private:
  /// A force of one newton: what it does to the modes [kg^(-1/2)], and to the rest [m/N].
  struct UnitLoad {
    std::vector<double> modal;
    std::vector<double> rest;  // local points
    std::vector<double> at;    // contact points
  };

  void choose(const Structure& structure, const FilterParameters& parameters, PetscInt asked);
  void build(const Structure& structure, const FilterParameters& parameters, PetscInt modes);
  void set_lags(const ModalChoice& choice);
  [[nodiscard]] UnitLoad respond(std::span<const double> force);

  const MassPoints* masses_;
  const Loads* loads_;
  std::vector<LinePoint> points_;
  std::unique_ptr<ModalBasis> basis_;
  std::vector<std::vector<double>> columns_;  // G b' of each point
  UnitLoad weight_;                           // all of it
  std::vector<UnitLoad> unit_loads_;          // of each pattern of loads
  std::vector<double> force_;                 // of these from `drive_.time` on [N]
  std::vector<double> force_rate_;            // [N/s]
  std::vector<double> axis_;
  ReducedModel reduced_;
  Drive drive_;
  PetscInt solves_ = 0;
  double bound_ = 0.0;
};

}  // namespace udar
