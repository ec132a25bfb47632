#pragma once
/// @file
/// The motion between impacts, exactly.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "udar/contact/altered_line.hpp"
#include "udar/filter/filtered_structure.hpp"

namespace udar {

/// @brief The free masses' motion over a stretch of time without events, by Chebyshev series of the line operator.
///
/// Between impacts z'' = -A z + a0 + t j0 with z(0) = 0, z'(0) = v0 and A = -wf^2 d(.), whose spectrum lies in
/// [0, wf^2] (the square of `FilteredStructure::frequency_bound`), resting masses left out. Its solution is z = S v0 +
/// C a0
/// + G j0 with entire functions of A, which are Chebyshev series in 2A/wf^2 - 1 with coefficients that depend on time
/// alone. The terms of the series are kept, so the motion of every node is known at any time that they reach, and more
/// terms reach further. With contact points that touch, A is that of the line which they hold (`HeldLine`), with hinges
/// that yield that which they turn (`ReleasedLine`). A rigid motion is that of its first terms for ever. Source:
/// docs/theory.md, "Exact motion between impacts".
class FreeMotion {
 public:
  /// @param held what makes the line another than the free one; null: nothing; outlives this object
  explicit FreeMotion(FilteredStructure& line, AlteredLine* held = nullptr);

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
  /// @brief Asks the line for its answer to the last term, which the next one needs. @note Collective. Two line solves
  /// in one batch, three with a jerk; none if it is known.
  void answer();
  /// After `answer` to the first terms of a motion: the largest of each, then of each answer; this rank's.
  using Sizes = std::array<double, 6>;
  [[nodiscard]] Sizes first_sizes() const;
  /// @brief Ends the series at its first terms if the line does not answer to them but by rounding, or if all that its
  /// answers add is negligible.
  /// @param sizes `first_sizes`, the largest of all ranks @param time up to which the motion is wanted [s]
  /// @param negligible way [m]; 0: rounding alone
  void end_if_rigid(const Sizes& sizes, double time, double negligible);
  /// Whether they are the whole motion.
  [[nodiscard]] bool rigid() const noexcept { return rigid_; }
  /// @brief Adds terms until there are `terms`, unless the motion is rigid. @note Collective, as `answer` for each.
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
  /// @brief Integrals over a time of where all local nodes are [m s]. @param position at the start [m]
  void integrals(std::span<const double> position, double time, std::span<double> values) const;
  /// @brief What the motion adds to the stretch Yc - Ym of a resting mass, besides j0 t / wf^2; its last term is
  /// missing.
  [[nodiscard]] double stretch(const Weights& weights, std::size_t node) const;
  /// @brief What it adds to the row of a point, as `AlteredLine` has them, besides that of j0 t / wf^2; the last
  /// term is missing, unless the motion is rigid or `answer` has been asked for it. @note Not collective: equal on
  /// every rank.
  [[nodiscard]] double row(const Weights& weights, std::size_t point) const;
  /// @brief The same for the stretch's amplitude in a corrected mode of the line [m kg^(1/2)]. @note Not collective.
  [[nodiscard]] double amplitude(const Weights& weights, std::size_t mode) const;

 private:
  [[nodiscard]] Weights rigid_weights(int derivative, double time) const;

  FilteredStructure* line_;
  AlteredLine* held_;
  double bound_;  // of all frequencies [rad/s]
  double gain_;   // wf^2 over its square
  std::size_t count_ = 0;
  std::size_t terms_ = 0;
  std::size_t answered_ = 0;  // terms
  bool rigid_ = false;
  std::size_t sequences_ = 2;
  std::array<std::vector<std::vector<double>>, 3> stored_;  // [sequence][term][node]
  std::array<std::vector<double>, 3> stretch_;              // of the last term
  std::vector<std::size_t> resting_;                        // nodes
  std::array<std::vector<double>, 3> resting_stretch_;      // [sequence][term][resting node]
  std::array<std::vector<double>, 3> amplitudes_;           // [sequence][term][corrected mode]
  std::vector<std::vector<double>> rows_;                   // [term][sequence, contact point]
};

}  // namespace udar
