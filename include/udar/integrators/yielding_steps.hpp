#pragma once
/// @file
/// Plastic hinges in steps of fixed length of the unfiltered beam.

#include <cstddef>
#include <span>
#include <vector>

#include "udar/contact/hinged_line.hpp"
#include "udar/motion/equations.hpp"

namespace udar {

/// @brief The line in the middle of a step of the Moreau-Jean scheme, turned halfway between the rotations at both
/// ends; yield is demanded at the end. Contact and hinges are one complementarity problem.
///
/// Source: docs/theory.md, "A beam that yields"
class YieldingSteps {
 public:
  /// @note Collective: a line solve for each contact point and hinge.
  explicit YieldingSteps(Equations& equations);

  /// @brief The line in the middle of the step if no hinge turns and nothing is touched. @param[out] stretch [m]
  /// @note Collective: a line solve, two while no hinge has turned; one reduction.
  void predict(std::span<const double> displacement, std::span<const double> force, std::span<double> stretch);
  /// @brief Turns the hinges that yield. @param gaps of the contact points [m] @param[out] force on them [N]
  /// @param[in,out] stretch [m] @return whether anything is touched @note Collective: a line solve if anything changes.
  bool resolve(std::span<const double> gaps, std::span<double> force, std::span<double> stretch);
  void take_back();

  /// Lost in the step, this rank's share [J].
  [[nodiscard]] double lost() const noexcept { return lost_; }
  /// Rotations at the start of the step or at its end.
  [[nodiscard]] std::vector<double> rotations(bool at_start) const;

 private:
  [[nodiscard]] bool stays_elastic(std::span<const double> value, std::span<double> force, std::span<double> stretch,
                                   std::span<double> added);
  void end_step(std::span<const double> turns, std::span<const double> added);

  Equations* equations_;
  HingedLine* hinges_;
  std::vector<double> rotation_before_;
  std::vector<double> turned_before_;
  std::vector<double> middle_;  // moments in the middle of the step
  double lost_ = 0.0;
  std::vector<double> nodes_;  // work: moments at the local nodes
  std::vector<double> lower_;
  std::vector<double> upper_;
};

}  // namespace udar
