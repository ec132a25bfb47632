#pragma once
/// @file
/// When the masses were last in contact.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "udar/contact/support.hpp"
#include "udar/motion/contact_journal.hpp"
#include "udar/motion/observer.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar {

/// @brief When each local node was last hit, came to rest, was released or pressed on by a support. Not collective.
class ContactTimes {
 public:
  /// @param points must outlive this object @param sets of nodes that can be in contact
  ContactTimes(const MassPoints& points, std::span<const ContactSet> sets);

  /// Takes what happened before a time from the journal of the step.
  void note(const ContactJournal& step, double until);
  /// @brief The nodes that were in contact since a time [s], or are at rest.
  /// @param resting nonzero for each local node that rests
  /// @param[out] touched 1 for each local node that was or is, 0 for others; of those that nothing can touch it stays
  [[nodiscard]] ContactZone zone(double since, std::span<const std::uint8_t> resting,
                                 std::span<std::uint8_t> touched) const;

  /// @name For a restart: [s], per local node; empty if no node of this rank can be in contact.
  /// @{
  [[nodiscard]] const std::vector<double>& last() const noexcept { return last_; }
  void restore(std::span<const double> last);
  /// @}

 private:
  const MassPoints* points_;
  std::vector<double> last_;
  std::vector<std::array<std::size_t, 2>> touchable_;  // ranges of nodes, each node in one
};

}  // namespace udar
