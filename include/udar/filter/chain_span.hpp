#pragma once
/// @file
/// The chain recursion on spans of equal elements, several of them side by side in SIMD lanes.

#include <array>
#include <compare>
#include <cstddef>
#include <vector>

#include "udar/filter/filter_column.hpp"

namespace udar::chain {

/// Symmetric 2 x 2 matrix (00, 01, 11) and general one (row by row), for displacement and rotation.
using Symmetric = std::array<long double, 3>;
using Matrix2 = std::array<long double, 4>;

/// @brief What distinguishes one span of equal elements between equal springs from another.
struct SpanKey {
  std::size_t elements = 0;  ///< between its two joints
  double length = 0.0;       ///< h [m]
  double flexural_compliance = 0.0;
  double shear_compliance = 0.0;
  double filter_stiffness = 0.0;  ///< of each inner node [N/m]
  double ground_stiffness = 0.0;
  std::array<double, 2> scale{};  ///< of each inner node's unknowns
  auto operator<=>(const SpanKey&) const = default;
};

/// @brief One span of equal elements, factored: its gains and its response to what acts at the inner nodes.
///
/// The state (w, theta) just right of the left joint and the force and moment (r0, r1) just left of the right joint
/// determine the span. Source: docs/theory.md, "The chain recursion".
class Span {
 public:
  /// Factors in long double. Cost O(elements).
  explicit Span(const SpanKey& key);

  [[nodiscard]] const SpanKey& key() const noexcept { return key_; }
  [[nodiscard]] std::size_t inner() const noexcept { return key_.elements - 1; }
  /// State before the right joint from the state after the left one.
  [[nodiscard]] const Matrix2& transfer() const noexcept { return transfer_; }
  /// Its determinant, which cannot be computed from the entries when they have decayed.
  [[nodiscard]] long double transfer_determinant() const noexcept { return transfer_determinant_; }
  /// Compliance seen from the right joint, the left one being fixed.
  [[nodiscard]] const Symmetric& compliance() const noexcept { return compliance_; }
  /// Stiffness seen from the left joint, the right one being free.
  [[nodiscard]] const Symmetric& stiffness() const noexcept { return stiffness_; }

  /// Gains at one inner node, for lengths in units of h and forces in units of K.
  struct Gain {
    double keep;      // 1 - forecast
    double forecast;  // g0 + h g1
    double deflect;   // g0
    double turn;      // h g1
    double release;   // 1 / (K S)
  };
  struct Units {
    double force_to_target;  // 1 / K
    double ground_ratio;     // ground / K
    double right_to_target;  // of the operator's right-hand side
    double right_to_kink;
    double shift_to_unknown;
    double moment_to_unknown;
    double stiffness;  // K
    double moment;     // K h
  };
  [[nodiscard]] const std::vector<Gain>& gains() const noexcept { return gains_; }
  [[nodiscard]] const Units& units() const noexcept { return units_; }
  /// Rows of weights over the inner nodes: 4 for kinks, then 4 for targets.
  [[nodiscard]] const double* weights() const noexcept { return weights_.data(); }
  /// 4 rows over pairs (displacement row, moment row) of the operator's right-hand side.
  [[nodiscard]] const double* pair_weights() const noexcept { return pair_weights_.data(); }

 private:
  SpanKey key_;
  Matrix2 transfer_{};
  long double transfer_determinant_ = 1.0;
  Symmetric compliance_{};
  Symmetric stiffness_{};
  Units units_{};
  std::vector<Gain> gains_;
  std::vector<double> weights_;
  std::vector<double> pair_weights_;
};

/// @brief The four numbers that a span shows its joints, or that they tell it; SI units.
///
/// Shown: the state (w, theta) before the right joint for a left joint at rest and a free right end, and the reaction
/// (force, moment) at the left joint then. Told: the state after the left joint, force and moment before the right one.
using Ends = std::array<double, 4>;

/// Most lanes of any kernel, and how many spans side by side make full use of it.
inline constexpr std::size_t kLanes = 8;

/// The lanes of this processor's vectors that the kernels use: 8 (AVX-512), 4, or 1 where an x86 has no AVX2.
[[nodiscard]] int native_lanes();

/// @brief What `blocks` equal spans, one after the other from local node `first` on, show their joints.
/// @param blocks 1, or a multiple of `kLanes`
/// @param from_memory whether the column is too long for the caches: then it is read in one stream, else in four
void condense(const Span& span, const FilterColumn& column, std::size_t first, std::size_t blocks, Ends* shown,
              int lanes, bool from_memory);

/// @brief Solves inside `blocks` equal spans whose ends are known.
/// @param scratch at least 4 * kLanes * inner() numbers
void resolve(const Span& span, const FilterColumn& column, std::size_t first, std::size_t blocks, const Ends* told,
             double* scratch, int lanes);

}  // namespace udar::chain
