#pragma once
/// @file
/// 2 x 2 algebra in long double for the set-up of the chain recursion.

#include <cmath>

#include "udar/filter/chain_span.hpp"

namespace udar::chain {

inline Matrix2 multiply(const Matrix2& a, const Matrix2& b) {
  return {a[0] * b[0] + a[1] * b[2], a[0] * b[1] + a[1] * b[3], a[2] * b[0] + a[3] * b[2], a[2] * b[1] + a[3] * b[3]};
}
inline Matrix2 full(const Symmetric& a) { return {a[0], a[1], a[1], a[2]}; }
inline Matrix2 transposed(const Matrix2& a) { return {a[0], a[2], a[1], a[3]}; }
inline Matrix2 add(const Matrix2& a, const Matrix2& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]}; }
inline Matrix2 negative(const Matrix2& a) { return {-a[0], -a[1], -a[2], -a[3]}; }
inline Symmetric add(const Symmetric& a, const Symmetric& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Symmetric symmetric(const Matrix2& a) { return {a[0], (a[1] + a[2]) / 2, a[3]}; }
inline constexpr Matrix2 kIdentity{1, 0, 0, 1};

/// T C T'.
inline Symmetric congruent(const Matrix2& t, const Symmetric& c) {
  return symmetric(multiply(multiply(t, full(c)), transposed(t)));
}

/// A compliance that may be close to singular (behind a pinned end, displacement and rotation go together): its
/// determinant is carried along, as it cannot be computed from the entries.
struct Compliance {
  Symmetric entries{};
  long double det = 0.0;
};

/// (P^-1 + J)^-1 without inverting P, (1 + J P)^-1, and the factor by which the determinant is smaller than that of P.
/// 1 - J X would be the second, too, but not where J is large: a line fixed just behind a joint.
struct Combined {
  Compliance value;
  Matrix2 reaction{};
  long double shrink = 1.0;
};
inline Combined combine(const Compliance& p, const Symmetric& j) {
  const auto& e = p.entries;
  const long double det_j = j[0] * j[2] - j[1] * j[1];
  const long double shrink = 1 / (1 + e[0] * j[0] + 2 * e[1] * j[1] + e[2] * j[2] + p.det * det_j);
  const Matrix2 product = multiply(full(j), full(e));
  return {
      .value = {.entries = {(e[0] + p.det * j[2]) * shrink, (e[1] - p.det * j[1]) * shrink,
                            (e[2] + p.det * j[0]) * shrink},
                .det = p.det * shrink},
      .reaction = {(1 + product[3]) * shrink, -product[1] * shrink, -product[2] * shrink, (1 + product[0]) * shrink},
      .shrink = shrink};
}

/// T X T' + C, for T of given determinant.
inline Compliance carry(const Matrix2& t, long double det_t, const Compliance& x, const Compliance& added) {
  const Symmetric& c = added.entries;
  const Symmetric moved = congruent(t, x.entries);
  const long double det_moved = det_t * det_t * x.det;
  // det(M + C) = det M + det C + mixed; the mixed part by completing squares in M, which may be singular.
  const long double mixed = moved[0] > 0 ? (moved[0] * moved[0] * c[2] - 2 * moved[0] * moved[1] * c[1] +
                                            moved[1] * moved[1] * c[0] + det_moved * c[0]) /
                                               moved[0]
                                         : moved[2] * c[0];
  return {.entries = add(moved, c), .det = det_moved + added.det + mixed};
}

}  // namespace udar::chain
