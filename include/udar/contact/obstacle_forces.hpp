#pragma once
/// @file
/// Contact forces of many nodes of the line.

#include <petsctao.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "udar/contact/active_set.hpp"
#include "udar/contact/contact_compliance.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/petsc/handle.hpp"

namespace udar {

/// @brief 0 <= r, 0 <= q + W r, r' (q + W r) = 0 with the compliance W of the line between contact nodes never formed.
///
/// Supports on springs have theirs on the diagonal of W; q + W r then is the distance from a face that gives way.
/// It goes to `ActiveSet`, and where that does not settle, as the quadratic program min r'W r / 2 + q'r, r >= 0, to
/// TAO's interior point method (`TAOBQPIP`), which starts from one point always. Both ask for products with W and
/// solves with W plus a diagonal: `ContactCompliance`. Source: docs/theory.md, "Contact on the line"
/// @note Options: `-contact_tao_monitor`, `-contact_tao_max_it`, ... (prefix `contact_`); `-contact_tao_type bqpip`:
/// the interior point method alone.
class ObstacleForces {
 public:
  /// @param points of this rank @note Collective. Memory and cost O(local nodes).
  /// @throws InputError if the line is not one for the chain solver
  ObstacleForces(FilteredStructure& line, std::span<const LinePoint> points);
  ObstacleForces(const ObstacleForces&) = delete;
  ObstacleForces& operator=(const ObstacleForces&) = delete;
  ~ObstacleForces();

  /// Where the next solve starts: points that touch, ascending; on no rank any: from q alone.
  void assume(std::span<const std::size_t> active) { set_.assume(active); }
  /// Points of this rank that touch since the last solve, ascending.
  [[nodiscard]] std::vector<std::size_t> active() const { return set_.held(); }

  /// @brief Solves for the forces. @param[in] gap q of this rank's points [m]; infinite: a point that never touches
  /// @param[out] force r of these [N]
  /// @return whether there is a force on any rank
  /// @note Collective: one reduction if all gaps are open, else the iterations of `ActiveSet`, and rarely 15 to 40
  /// others (docs/theory.md).
  /// @throws SolveError if a gap is not a number, the iteration does not end, or the result violates the conditions
  bool solve(std::span<const double> gap, std::span<double> force);
  /// q + W r after the last solve [m], this rank's points.
  [[nodiscard]] std::span<const double> gaps() const noexcept { return gap_; }

 private:
  struct Callbacks;

  void create_optimizer();
  void test_convergence();
  [[nodiscard]] std::string solve_by_interior_point(std::span<const double> asked, std::span<double> force);
  [[nodiscard]] double penetration(std::span<const double> asked, std::span<const double> force);

  ContactCompliance line_;
  ActiveSet set_;
  bool interior_point_alone_ = false;
  double force_bound_;  // in units
  double unit_ = 1.0;   // largest penetration of the line without contact [m]
  std::vector<double> q_;
  std::vector<double> gap_;
  petsc::Matrix hessian_;
  petsc::Vector unknowns_;
  petsc::Vector lower_;
  petsc::Vector upper_;
  petsc::Vector multiplier_;
  petsc::Vector upper_multiplier_;
  petsc::Optimizer optimizer_;
  std::vector<double> history_;  // complementarity of the iterations so far
};

}  // namespace udar
