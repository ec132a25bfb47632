#pragma once
/// @file
/// The smallest distance of the line from the supports, in steps of the impact integrator.

#include <cstddef>
#include <vector>

#include "udar/integrators/step_supports.hpp"
#include "udar/integrators/sweep.hpp"
#include "udar/motion/contact_state.hpp"
#include "udar/numerics/legendre.hpp"

namespace udar {

/// @brief Offers contact the smallest distance of a step, going through the nodes of those blocks alone that bounds do
/// not exclude. @note Not collective.
class LineDistance {
 public:
  /// All outlive this object.
  LineDistance(Sweep& sweep, ContactState& contact, const StepSupports& supports);

  void track();

 private:
  [[nodiscard]] double lowest_of_block(const ContactSet& set, std::size_t first, std::size_t count) const;
  void track_nodes(std::size_t index, std::size_t first, std::size_t last);

  Sweep* sweep_;
  ContactState* contact_;
  const StepSupports* supports_;
  LegendreMatrix line_bernstein_;  // [coefficient][Legendre term]
  std::vector<double> block_low_;
};

}  // namespace udar
