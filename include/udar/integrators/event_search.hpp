#pragma once
/// @file
/// The events of contact within a step of PETSc's explicit integrators.

#include <cstddef>
#include <span>
#include <vector>

#include "udar/integrators/step_motion.hpp"

namespace udar {

/// @brief Something that may happen to a mass at a support: a gap closes or opens, a force ends, a mass lifts.
struct ContactEvent {
  const ContactSet* set = nullptr;
  std::size_t node = 0;
  double time = 0.0;   ///< on the dense output [s]
  double slope = 0.0;  ///< of the stretch at a release [m/s]
  bool opens = false;  ///< a closed gap
  double met = 0.0;    ///< as the last repeated step corrected its time [s]
};

/// @brief Finds the first event of every mass on the dense output of a step, and corrects its time by repeated steps.
/// Source: docs/theory.md, "Contact in the post-step"
/// @note Not collective.
class EventSearch {
 public:
  /// All outlive this object.
  EventSearch(const StepMotion& motion, const ContactState& contact) : motion_{&motion}, contact_{&contact} {}

  /// @brief Finds the events of the step. @return the earliest time on this rank [s]; infinite: none
  double survey();
  /// @brief Corrects, by the state at the end of the step, the times of all events that may be the first.
  /// @param latest where the dense output has them at the latest [s] @param window of a correction [s]
  /// @param limit end of the step as first taken [s] @return the earliest time on this rank [s]
  double correct(double latest, double window, double limit);

  [[nodiscard]] std::span<const ContactEvent> events() const noexcept { return events_; }
  /// Whether it is at the end of the step.
  [[nodiscard]] bool is_due(const ContactEvent& event) const;

 private:
  void add(ContactEvent event);
  void survey(const ContactSet& set, std::size_t node);
  void survey_rest(const ContactSet& set, std::size_t node);
  void survey_touch(const ContactSet& set, std::size_t node);
  void survey_gap(const ContactSet& set, std::size_t node);
  [[nodiscard]] double corrected_time(const ContactEvent& event) const;

  const StepMotion* motion_;
  const ContactState* contact_;
  std::vector<ContactEvent> events_;
};

}  // namespace udar
