#pragma once
/// @file
/// How the beam moves within the step at hand.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "udar/motion/contact_state.hpp"

namespace udar {

/// @brief The dense output of the last step: what is asked of it at any time within the step.
class DenseOutput {
 public:
  DenseOutput() = default;
  DenseOutput(const DenseOutput&) = delete;
  DenseOutput& operator=(const DenseOutput&) = delete;
  virtual ~DenseOutput() = default;

  /// @brief Ym [m], Vm [m/s] and nonzero where resting, at a time within the step, before the events at its end.
  virtual void masses(double time, std::span<double> position, std::span<double> velocity,
                      std::span<std::uint8_t> resting) const = 0;
  /// @brief Integrals of Ym and the stretch [m s] at local nodes that have a load, from the start of the step to a time
  /// within it.
  virtual void line_integrals(std::span<const std::size_t> nodes, double until, std::span<double> integrals) const = 0;
  /// @brief Integrals of Ym [m s] at all local points over the same time; asked for only where places that hold points
  /// move.
  virtual void mass_integrals(double /*until*/, std::span<double> /*integrals*/) const {}
  /// @brief Where the line is at such nodes and a time [m]; asked for only where a load jumps within a step, which
  /// those of fixed length alone do not end at.
  virtual void line_places(std::span<const std::size_t> /*nodes*/, double /*at*/, std::span<double> /*places*/) const {}
  /// @brief Integrals of the stretch's amplitudes in the corrected modes [m kg^(1/2) s], from the start of the step to
  /// a time within it; asked for where loads change. @note Collective.
  [[nodiscard]] virtual std::vector<double> amplitude_integrals(double /*until*/) const { return {}; }
  /// @brief Plastic rotations of all hinges [rad] at a time within the step; empty: those that they have now.
  [[nodiscard]] virtual std::vector<double> rotations(double /*time*/) const { return {}; }
  /// @brief What flowed besides impacts from the start of the step to a time within it, this rank's share.
  [[nodiscard]] virtual EnergyFlow flow(double /*until*/) const { return {}; }
  /// @brief Adds what each support gave from the start of the step to a time within it [N s], y up, this rank's share.
  /// @return false: it knows no more than the journal of the step
  [[nodiscard]] virtual bool add_impulses(double /*until*/, std::span<double> /*sums*/) const { return false; }
};

}  // namespace udar
