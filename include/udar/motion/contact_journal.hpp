#pragma once
/// @file
/// What happened on the supports in the step in progress.

#include <petscsys.h>

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "udar/motion/observer.hpp"
#include "udar/motion/step_records.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar {

/// @brief Empties a list, and gives its memory back if a rare step has made it large.
template <class Value>
void release_if_large(std::vector<Value>& list) {
  constexpr std::size_t kKept = std::size_t{1} << 16;
  if (list.capacity() > kKept) {
    std::vector<Value>{}.swap(list);
  }
  list.clear();
}

/// @brief What flows besides impacts [J].
struct EnergyFlow {
  double work = 0.0;      ///< in from moving supports
  double damped = 0.0;    ///< out by dampers
  double radiated = 0.0;  ///< out into motions that a reduced model leaves out
  double yielded = 0.0;   ///< out by plastic hinges
  double stored = 0.0;    ///< at its end, in springs of supports that the integrator alone knows the force of
};

/// @brief Impacts, rests, forces and energy of one step, of this rank's masses. Not collective.
///
/// An integrator records what it finds as it finds it; `ContactState::commit` adds it up over the ranks. Rests and
/// releases are written by `ContactState`, whose state they change. However much happens in a step, a rank holds some
/// blocks of it (`StepRecords`).
class ContactJournal {
 public:
  /// From one time to another [s].
  struct Interval {
    double from = 0.0;
    double until = 0.0;
  };
  /// A local node in contact.
  struct Contact {
    std::size_t node = 0;
    Interval time{};
  };

  /// @param points must outlive this object @param supports how many there are
  ContactJournal(const MassPoints& points, std::size_t supports) : points_{&points}, even_impulses_(supports, 0.0) {}

  /// Where records of long steps wait. @see ScratchFile
  void set_scratch_folder(const std::string& folder);
  /// @param node local @param impact whose node and place are still to be filled in
  void record_impact(std::size_t node, ImpactRecord impact);
  void record_rest(std::size_t node, PetscInt support, double time);
  void record_release(std::size_t node, PetscInt support, double time);
  /// Energy lost besides that of impacts [J].
  void record_loss(double time, double energy) { losses_.push_back({.time = time, .energy = energy}); }
  /// What a support gave at once, without an impact [N s], y up.
  void record_impulse(PetscInt support, double impulse, double time) { record_force(support, impulse, {time, time}); }
  /// What a force of a support, even over the step, gave in it [N s], y up.
  void record_force(PetscInt support, double impulse) { even_impulses_[static_cast<std::size_t>(support)] += impulse; }
  /// The same, even over a part of the step only.
  void record_force(PetscInt support, double impulse, Interval time) {
    forces_.push_back({.support = support, .impulse = impulse, .time = time});
  }
  /// A support pressed on the line at a local node, or an elastic one on its mass.
  void record_contact_time(std::size_t node, Interval time) { contacts_.push_back({.node = node, .time = time}); }
  /// Some support pressed on the line; equal on every rank.
  void record_line_contact(Interval time);
  /// Adds what flowed in the step.
  void record_flow(const EnergyFlow& energy) {
    flow_.work += energy.work;
    flow_.damped += energy.damped;
    flow_.radiated += energy.radiated;
    flow_.yielded += energy.yielded;
  }

  /// Those of a node in order of time.
  [[nodiscard]] const StepRecords<ImpactRecord>& impacts() const noexcept { return impacts_; }
  [[nodiscard]] const StepRecords<RestRecord>& rests() const noexcept { return rests_; }
  [[nodiscard]] const StepRecords<Contact>& contacts() const noexcept { return contacts_; }
  /// Empty: no support pressed on the line.
  [[nodiscard]] const std::optional<Interval>& line_contact() const noexcept { return line_contact_; }
  [[nodiscard]] const EnergyFlow& flow() const noexcept { return flow_; }
  /// Energy that this rank's masses lost in the step before a time [J].
  [[nodiscard]] double lost_before(double time) const;
  /// @brief Adds to `sums`, which begin at 0, what each support gave to this rank's masses in the step before a time [N
  /// s], y up.
  /// @param passed share of the step that has passed by then
  void add_impulses(double time, double passed, std::span<double> sums) const;

  /// Begins a new step.
  void clear();

 private:
  struct Force {
    PetscInt support = 0;
    double impulse = 0.0;
    Interval time{};
  };
  struct Loss {
    double time = 0.0;
    double energy = 0.0;
  };

  /// What impacts before a time came to.
  struct Sums {
    double time = std::numeric_limits<double>::quiet_NaN();  // not a number: not known
    double lost = 0.0;
    std::vector<double> impulses{};  // by support
  };

  [[nodiscard]] const Sums& impacts_before(double time) const;

  const MassPoints* points_;
  StepRecords<ImpactRecord> impacts_;
  mutable Sums before_;  // the same of the latest time that was asked for: one reading for all that ask
  StepRecords<RestRecord> rests_;
  std::vector<double> even_impulses_;  // per support, of forces that are even over the step
  StepRecords<Force> forces_;          // of parts of the step
  StepRecords<Contact> contacts_;
  StepRecords<Loss> losses_;  // besides those of the impacts
  std::optional<Interval> line_contact_;
  EnergyFlow flow_;
};

}  // namespace udar
