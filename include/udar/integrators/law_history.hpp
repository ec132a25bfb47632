#pragma once
/// @file
/// What laws of contact remember of every mass.

#include <cstddef>
#include <vector>

#include "udar/contact/support.hpp"
#include "udar/motion/contact_state.hpp"
#include "udar/motion/motion_state.hpp"

namespace udar {

/// @brief The largest compression so far of each local node of each support whose law remembers it.
///
/// Within an accepted step it is that of its start, so that the step can be gone through again; what is noted counts
/// from its end on. Not collective.
class LawHistory {
 public:
  /// @param contact outlives this object
  explicit LawHistory(const ContactState& contact);

  /// At the start of the step at hand [m]; 0 where nothing is remembered.
  [[nodiscard]] double largest(const ContactSet& set, std::size_t node) const {
    const std::vector<double>& of_set = largest_[contact_->index_of(set)];
    return of_set.empty() ? 0.0 : of_set[node - set.first];
  }
  /// At its end.
  void note(const ContactSet& set, std::size_t node, double largest);
  /// The step is over.
  void end_step();
  /// The step is taken back.
  void forget() { notes_.clear(); }

  /// Adds the fields of `count` local nodes, if anything is remembered.
  void save(std::size_t count, MotionState& state) const;
  void restore(std::size_t count, const MotionState& state);

 private:
  struct Note {
    std::size_t set;
    std::size_t node;
    double largest;
  };

  const ContactState* contact_;
  bool any_ = false;                          // on some rank
  std::vector<std::vector<double>> largest_;  // by contact set, then node; empty: nothing is remembered
  std::vector<Note> notes_;
};

}  // namespace udar
