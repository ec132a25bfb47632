#pragma once
/// @file
/// What a run is refused for, and what ends it.

#include <petscsys.h>

#include <span>
#include <string>
#include <vector>

#include "udar/contact/support.hpp"
#include "udar/motion/contact_state.hpp"
#include "udar/motion/equations.hpp"
#include "udar/motion/motion_scale.hpp"
#include "udar/structure/initial_state.hpp"

namespace udar {

/// @brief Refuses masses that start beyond a support, but for springs that hold the line: they are pressed then.
/// @param sets nodes under supports, whoever touches
/// @note Collective. @throws InputError naming support, place and depth
void refuse_overlap(const MassPoints& points, const ContactState& contact, std::span<const ContactSet> sets,
                    const MassState& masses);

/// @brief Refuses hops that are over within the last digits of the time at the end of the run [s].
/// @throws InputError naming the tolerance and the least that will do
void refuse_hops_without_length(const ContactParameters& parameters, const MotionScale& scale, double fastest,
                                double end_time);

/// @brief Ends a run whose time no longer moves on.
class StandstillGuard {
 public:
  /// @param fastest no frequency of the masses is higher [rad/s]
  explicit StandstillGuard(double fastest);
  /// @brief Sees a step. @param events whether it had any @param cut whether it was shorter than wanted on purpose
  /// @throws SolveError after too many events at one instant, or steps without length
  void see(double begin, double time, bool events, bool cut);

 private:
  double least_;  // step that counts as one [s]
  PetscInt events_at_once_ = 0;
  PetscInt short_steps_ = 0;
};

}  // namespace udar
