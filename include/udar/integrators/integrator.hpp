#pragma once
/// @file
/// What a run asks of whatever advances the masses, and what that needs to know.

#include <petscts.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "udar/integrators/features.hpp"
#include "udar/motion/contact_state.hpp"
#include "udar/motion/dense_output.hpp"
#include "udar/motion/equations.hpp"
#include "udar/motion/kinks.hpp"
#include "udar/motion/motion_scale.hpp"
#include "udar/motion/motion_state.hpp"

namespace udar {

/// @brief What the integrators advance: the masses on their line, and who touches what.
struct ImpactProblem {
  Equations* equations = nullptr;
  ContactState* contact = nullptr;
  const Contacts* contacts = nullptr;
  MotionScale scale{};
  const Kinks* kinks = nullptr;  ///< of loads and supports; null: a step never looks beyond its wished length
};

/// @brief The last step, its dense output and its end; one implementation for each way to meet impacts.
class Integrator : public DenseOutput {
 public:
  /// What it knows of the things that not all integrators know.
  [[nodiscard]] virtual Features can() const = 0;

  /// @brief Before the first row: brings the state of the TS to what follows at once from where the masses are put.
  /// @note Collective.
  virtual void settle() {}
  /// @brief Takes up the motion at the state of the TS and of contact. @param line where the line stands there
  /// @note Collective.
  virtual void start(const LineState& line) = 0;
  /// @brief The same where another integrator has left it: whatever it keeps of its own is found anew.
  /// @note Collective.
  virtual void take_over(const LineState& line) { start(line); }
  /// @brief The next step starts from the state of the TS and of contact. @note Collective.
  virtual void begin_step() = 0;
  /// @brief Ends the step that the TS has taken, at its end or earlier. @return its end [s] @note Collective.
  virtual double end_step() = 0;
  /// @brief Brings the state of the TS and of contact past the events at the end, if that is not yet done.
  virtual void apply_events() = 0;
  /// @brief Loads have jumped at the end of the last step: what follows them at once is brought there in the state of
  /// the TS. @return what springs of supports, as in `flow`, gain by that [J], this rank's share @note Collective.
  virtual double follow_loads() { return 0.0; }
  /// Takes the whole step back.
  virtual void return_to_start() = 0;
  /// Step length to go on with [s], before limits from outside.
  [[nodiscard]] virtual double next_step() const = 0;
  /// Whether no other length will do.
  [[nodiscard]] virtual bool fixed_step() const { return false; }

  /// Ym [m], then Vm [m/s], of the local nodes at the start of the step.
  [[nodiscard]] virtual std::span<const double> start_of_step() const = 0;

  /// Steps taken again to end at an event.
  [[nodiscard]] virtual PetscInt repeated_steps() const { return 0; }
  /// Evaluations of the acceleration that a right-hand side asked for.
  [[nodiscard]] virtual PetscInt evaluations() const { return 0; }

  /// @brief Bytes that its steps so far had to move between memory and this rank, vectors read twice counted twice,
  /// line solves not counted; 0: it does not know. Source: docs/theory.md, the integrators' cost.
  [[nodiscard]] virtual double streamed_bytes() const { return 0.0; }

  /// What else it counts, by name.
  [[nodiscard]] virtual std::map<std::string, PetscInt> tally() const { return {}; }

  /// What must be kept, besides masses and contact, to go on bit for bit. Called between steps.
  virtual void save(MotionState& state) const = 0;
  virtual void restore(const MotionState& state) = 0;
};

/// @brief Keeps the stretch of a line state and what belongs to it, and reads it back.
/// @param size local points
/// @throws InputError naming -restart_file if something is missing or not of `size`, or not what the line has
void save_line(const LineState& line, MotionState& state);
[[nodiscard]] LineState saved_line(const MotionState& state, const Equations& equations, std::size_t size);

}  // namespace udar
