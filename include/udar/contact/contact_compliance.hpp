#pragma once
/// @file
/// How far forces at contact nodes move the line there.

#include <mpi.h>

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "udar/contact/support.hpp"
#include "udar/filter/filtered_structure.hpp"

namespace udar {

/// @brief A node of the line and a support that may hold it.
struct LinePoint {
  PetscInt node = 0;                                      ///< global
  PetscInt support = 0;                                   ///< index
  double side = 1.0;                                      ///< +1 support below, -1 above: gap = side (y - height)
  double height = 0.0;                                    ///< of its face, without its motion and without a force [m]
  std::shared_ptr<const SupportMotion> motion = nullptr;  ///< null: none
  double compliance = 0.0;                                ///< 1 / k of its spring [m/N]; 0: rigid
  double damping = 0.0;                                   ///< c of the damper beside it [N s/m]

  /// By which the face gives way [m/N]; without filter to a force in the middle of a step: 1 / (k + 2 c / step).
  [[nodiscard]] double yield(const FilterParameters& filter) const {
    return damping > 0.0 && !filter.filtered() ? compliance / (1.0 + 2.0 * damping * compliance / filter.step)
                                               : compliance;
  }
  /// What its motion adds just after a time [s].
  [[nodiscard]] SupportMotion::State lift(double time) const {
    return motion ? motion->at(time) : SupportMotion::State{};
  }
};

/// @brief The compliance W of the line between contact points, and W plus a diagonal D, neither of them ever formed.
///
/// A product with W is a line solve. So is a solve with W + D: with a spring of stiffness 1 / D beside that of the
/// filter at each contact node. Supports on springs have theirs on the diagonal of W. Forces are in units of
/// `force_unit`, gaps in metres. Source: docs/theory.md, "Contact on the line"
class ContactCompliance {
 public:
  /// @param line must outlive this object @param points of this rank
  /// @note Collective. Memory and cost O(local nodes).
  /// @throws InputError if the line is not one for the chain solver
  ContactCompliance(FilteredStructure& line, std::span<const LinePoint> points);

  [[nodiscard]] MPI_Comm comm() const { return line_->points().comm(); }
  /// Points of this rank.
  [[nodiscard]] std::size_t points() const noexcept { return node_.size(); }
  /// Its node, global.
  [[nodiscard]] PetscInt node(std::size_t point) const { return line_->points().begin() + node_[point]; }
  /// Mean stiffness of the filter's springs at contact nodes, over one metre [N].
  [[nodiscard]] double force_unit() const noexcept { return force_unit_; }
  /// As many points as move with one that is pushed alone; the most, over all of them.
  [[nodiscard]] double moved_together() const noexcept { return moved_together_; }
  /// D, one for each point, infinite: no force; whoever changes it calls `factor` before the next `solve`.
  [[nodiscard]] std::span<double> diagonal() noexcept { return diagonal_; }

  /// W r. @note Collective: a line solve.
  void apply(std::span<const double> force, std::span<double> gap);
  /// @note Collective: a factorisation of the line if D has changed on any rank.
  void factor();
  /// x of (W + D) x = y. @param[out] product W x where D is infinite, nothing elsewhere; empty: not wanted
  /// @note Collective: a line solve.
  void solve(std::span<const double> right, std::span<double> solution, std::span<double> product = {});

 private:
  [[nodiscard]] double beside(std::size_t point) const;

  FilteredStructure* line_;
  std::vector<PetscInt> node_;  // of each point, local
  std::vector<double> side_;
  std::vector<double> yield_;              // compliance of the support, per unit of force
  std::vector<std::size_t> by_node_;       // points in the order of their nodes
  std::unique_ptr<ColumnSolver> free_;     // the filter's springs alone
  std::unique_ptr<ColumnSolver> shifted_;  // springs 1 / D
  double force_unit_ = 1.0;
  double moved_together_ = 1.0;
  std::vector<double> diagonal_;
  std::vector<double> factored_;  // D of `shifted_`
  std::vector<double> spring_;
  std::vector<double> zero_;    // work, by node
  std::vector<double> load_;    // work, by node
  std::vector<double> target_;  // work, by node
  std::vector<double> stretch_;
};

}  // namespace udar
