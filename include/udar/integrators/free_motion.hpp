#pragma once
/// @file
/// The motion between impacts, exactly.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "udar/filter/filtered_structure.hpp"

namespace udar {

/// @brief The free masses' motion over a stretch of time without events, by Chebyshev series of the line operator.
///
/// Between impacts z'' = -A z + a0 + t j0 with z(0) = 0, z'(0) = v0 and A = -wf^2 d(.), whose spectrum lies in
/// [0, wf^2] (the square of `FilteredStructure::frequency_bound`), resting masses left out. Its solution is z = S v0 +
/// C a0
/// + G j0 with entire functions of A, which are Chebyshev series in 2A/wf^2 - 1 with coefficients that depend on time
/// alone. The terms of the series are kept, so the motion of every node is known at any time that they reach, and more
/// terms reach further. Source: docs/theory.md, "Exact motion between impacts".
class FreeMotion {
 public:
  explicit FreeMotion(FilteredStructure& line);

  /// @brief The state to start from, one value per local node.
  struct Start {
    std::span<const double> velocity;      ///< Vm [m/s]
    std::span<const double> acceleration;  ///< wf^2 (Yc - Ym) [m/s^2]
    /// What changing forces add to the acceleration [m/s^3], as wf^2 d' of -load_table's rate; empty: nothing
    std::span<const double> jerk;
    std::span<const std::int32_t> resting;  ///< nonzero: the mass stays where it is; empty: none
  };

  /// @brief Forgets all terms but the first. The spans are copied. @note Not collective.
  void start(const Start& start);
  /// @brief Adds terms until there are `terms`. @note Collective. Two line solves in one batch per term, three with a
  /// jerk.
  void extend(std::size_t terms);
  [[nodiscard]] std::size_t terms() const noexcept { return terms_; }

  /// @brief Up to which time [s] after the start `terms` of the series reach `tolerance`: the error of displacements is
  /// below it relative to the norms of v0 t, a0 t^2 / 2, j0 t^3 / 6, weighted with the masses.
  [[nodiscard]] double reach(std::size_t terms, double tolerance) const;

  /// @brief Weights of the terms at one time for a derivative of the motion: -1 its integral, 0 displacement, 1
  /// velocity, 2 acceleration.
  class Weights {
   public:
    friend class FreeMotion;

   private:
    std::vector<double> values_;  // [sequence][term]
  };
  [[nodiscard]] Weights weights(int derivative, double time) const;
  /// @brief The weighted sum at one node: [m s], [m], [m/s] or [m/s^2]. @note Not collective.
  [[nodiscard]] double at(const Weights& weights, std::size_t node) const;
  /// @brief The weighted sum at all local nodes.
  void at(const Weights& weights, std::span<double> values) const;
  /// @brief What the motion adds to the stretch Yc - Ym of a resting mass, besides j0 t / wf^2; its last term is
  /// missing.
  [[nodiscard]] double stretch(const Weights& weights, std::size_t node) const;
  /// @brief The same for the stretch's amplitude in a corrected mode of the line [m kg^(1/2)]. @note Not collective.
  [[nodiscard]] double amplitude(const Weights& weights, std::size_t mode) const;

 private:
  FilteredStructure* line_;
  double bound_;  // of all frequencies [rad/s]
  double gain_;   // wf^2 over its square
  std::size_t count_ = 0;
  std::size_t terms_ = 0;
  std::size_t sequences_ = 2;
  std::array<std::vector<std::vector<double>>, 3> stored_;  // [sequence][term][node]
  std::array<std::vector<double>, 3> stretch_;              // of the last term
  std::vector<std::size_t> resting_;                        // nodes
  std::array<std::vector<double>, 3> resting_stretch_;      // [sequence][term][resting node]
  std::array<std::vector<double>, 3> amplitudes_;           // [sequence][term][corrected mode]
};

}  // namespace udar
