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
  /// @brief Integral of Ym and the stretch [m s] at a local node that has a load, from the start of the step to a time
  /// within it.
  [[nodiscard]] virtual double line_integral(std::size_t node, double until) const = 0;
  /// @brief Where the line is at such a node and time [m]; asked for only where a load jumps within a step, which those
  /// of fixed length alone do not end at.
  [[nodiscard]] virtual double line_place(std::size_t /*node*/, double /*at*/) const { return 0.0; }
  /// @brief Integrals of the stretch's amplitudes in the corrected modes [m kg^(1/2) s], from the start of the step to
  /// a time within it; asked for where loads change. @note Collective.
  [[nodiscard]] virtual std::vector<double> amplitude_integrals(double /*until*/) const { return {}; }
  /// @brief What flowed besides impacts from the start of the step to a time within it, this rank's share.
  [[nodiscard]] virtual EnergyFlow flow(double /*until*/) const { return {}; }
  /// @brief Adds what each support gave from the start of the step to a time within it [N s], y up, this rank's share.
  /// @return false: it knows no more than the journal of the step
  [[nodiscard]] virtual bool add_impulses(double /*until*/, std::span<double> /*sums*/) const { return false; }
};

}  // namespace udar
