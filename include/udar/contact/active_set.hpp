#pragma once
/// @file
/// Contact forces of many nodes by a primal-dual active set.

#include <petscsys.h>

#include <cstddef>
#include <span>
#include <vector>

#include "udar/contact/contact_compliance.hpp"

namespace udar {

/// @brief 0 <= r, 0 <= q + W r, r'(q + W r) = 0 by the primal-dual active set, a semismooth Newton method.
///
/// Held points pin the line to its supports; a line solve tells what they hold and where the rest of the line is. Then
/// those that pull let go, those below their support are held. Without a guess points join on ever finer grids of
/// nodes, so that a contact zone's border is never further off than a few nodes. Source: docs/theory.md, "Contact on
/// the line"; Hintermueller, Ito and Kunisch 2003.
class ActiveSet {
 public:
  /// @param line must outlive this object; its diagonal is this object's while it solves
  explicit ActiveSet(ContactCompliance& line);

  /// Where the next solve starts, ascending; on no rank any: without a guess.
  void assume(std::span<const std::size_t> points);
  /// Points of this rank that are held since the last solve, ascending.
  [[nodiscard]] std::vector<std::size_t> held() const;

  /// @param[in] gap q, in units as `ContactCompliance` has them @param[out] force r
  /// @param guessed whether any rank assumes a point, equal on every rank
  /// @return whether the set settled, equal on every rank
  /// @note Collective: for each iteration a factorisation, a line solve and a reduction or two.
  bool solve(std::span<const double> gap, bool guessed, std::span<double> force);

 private:
  bool settle(std::span<const double> gap, std::span<double> force, PetscInt stride, int most);
  void respond(std::span<const double> gap, std::span<double> force);
  void find_violating(std::span<const double> gap, std::span<const double> force, PetscInt stride);
  void keep_last();

  ContactCompliance* line_;
  std::vector<char> held_;
  std::vector<std::size_t> violating_;
  std::vector<double> right_;    // work
  std::vector<double> product_;  // W r of points that are not held
};

}  // namespace udar
