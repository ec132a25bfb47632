#pragma once
/// @file
/// What the masses do on their supports: who rests where, and what happened in the step in progress.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "udar/contact/line_contact.hpp"
#include "udar/contact/support.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/motion/observer.hpp"

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

/// @brief Who touches the supports.
enum class ContactSurface : std::uint8_t {
  mass,  ///< the masses, by the impact law
  line,  ///< the massless line, held off by contact forces; there is no restitution
};

/// @brief What shapes the treatment of contact.
struct ContactParameters {
  /// A mass whose next hop would stay below this rests instead [m]; 0: below `kHopShare` of the motion's scale.
  double hop_tolerance = 0.0;
  ContactSurface surface = ContactSurface::mass;
  PetscInt line_dense_max = static_cast<PetscInt>(LineContact::kDensePoints);  ///< see `LineContact`, >= 0
};

/// A hop this low, beside the motion's length, is none: it has 1e-5 of the motion's velocity and 1e-10 of its energy.
inline constexpr double kHopShare = 1e-10;

/// @brief Sums of contact over the whole run so far; equal on every rank.
struct ContactCounts {
  PetscInt impacts = 0;
  PetscInt rests = 0;
  PetscInt releases = 0;
  PetscInt resting = 0;              ///< masses at rest now
  PetscInt event_steps = 0;          ///< steps with any of these, in this run of the program
  double first_contact_time = -1.0;  ///< [s]; negative: none yet
  double last_contact_time = -1.0;   ///< last impact, or last instant some mass rested [s]; negative: none yet
  double lost = 0.0;                 ///< energy lost in impacts and rests [J]
  double work = 0.0;                 ///< of moving supports on the masses [J]
  double damped = 0.0;               ///< energy lost in dampers [J]
};

/// @brief What flows besides impacts [J].
struct EnergyFlow {
  double work = 0.0;    ///< in from moving supports
  double damped = 0.0;  ///< out by dampers
};

/// @brief Smallest distance of the line from a support, over all contact points and steps.
struct LineGap {
  double gap = 0.0;   ///< [m]; negative: the line sank through
  double x = 0.0;     ///< [m]
  double time = 0.0;  ///< [s]
};

/// @brief The state of contact of this rank's nodes, and a journal of the step in progress.
///
/// An integrator writes impacts, rests and releases into the journal as it finds them; `commit` adds them up over the
/// ranks and ends the step, `undo` takes them back.
class ContactState {
 public:
  /// Masses have supports to touch (`runs`) on `ContactSurface::mass` only.
  /// @param points, contacts must outlive this object
  ContactState(const MassPoints& points, const Contacts& contacts, ContactParameters parameters);

  [[nodiscard]] const std::vector<Support>& supports() const noexcept { return contacts_->supports; }
  [[nodiscard]] std::span<const ContactSet> runs() const noexcept { return runs_; }
  [[nodiscard]] const ContactParameters& parameters() const noexcept { return parameters_; }
  [[nodiscard]] bool runs_on_line() const noexcept { return parameters_.surface == ContactSurface::line; }
  [[nodiscard]] const ContactCounts& counts() const noexcept { return counts_; }

  [[nodiscard]] bool resting(std::size_t node) const { return resting_[node] != 0; }
  [[nodiscard]] bool resting_on(std::size_t node, const ContactSet& run) const {
    return resting_[node] == run.support + 1;
  }
  /// Energy in the springs of supports that give way to masses, this rank's share [J].
  [[nodiscard]] double spring_energy(double time, std::span<const double> position) const;
  /// Whether any mass of this rank rests now.
  [[nodiscard]] bool any_resting() const noexcept { return local_resting_ > 0; }
  /// How far from its support a mass still counts as on it [m], positions of about `position` [m].
  [[nodiscard]] double together(double position, double height) const;
  /// @param length of the motion [m]: rounding of stretches goes by it
  void measure(double length) noexcept { length_ = length; }
  /// How far a stretch that would pull a mass off a support of about `height` [m] is known [m].
  [[nodiscard]] double pull_resolution(double height) const;

  /// @name The journal of the step. Not collective.
  /// @{
  /// Makes room for so many impacts.
  void expect(std::size_t impacts) { impacts_.reserve(impacts); }
  /// @param before, after velocity of the mass [m/s], y up @param loss [J]
  void hit(const ContactSet& run, std::size_t node, double time, double before, double after, double loss);
  /// The same with an impulse that other masses share in [N s], y up.
  void strike(PetscInt support, std::size_t node, double time, double before, double after, double impulse,
              double loss);
  /// An impulse on a mass that does not move towards the support [N s], y up: no impact. @param loss [J]
  void push(PetscInt support, std::size_t node, double time, double impulse, double loss);
  /// @param loss of energy besides that of an impact [J]
  void rest(const ContactSet& run, std::size_t node, double time, double loss = 0.0);
  void release(const ContactSet& run, std::size_t node, double time);
  /// Adds what a support gave without an impact [N s], y up; counted as even over the step.
  void press(PetscInt support, double impulse) { pressed_[static_cast<std::size_t>(support)] += impulse; }
  /// The same, even over a part of the step only, `from` to `to` [s].
  void press(PetscInt support, double impulse, double from, double to) {
    parts_.push_back({.support = support, .impulse = impulse, .from = from, .to = to});
  }
  /// Adds what flowed in the step, this rank's share.
  void flow(const EnergyFlow& energy) {
    flow_.work += energy.work;
    flow_.damped += energy.damped;
  }
  /// A support held the line at a local node, or one that gives way its mass, between these times [s].
  void touch(std::size_t node, double from, double until) {
    touches_.push_back({.node = node, .from = from, .until = until});
  }
  /// Some support held the line between these times [s]; equal on every rank.
  void hold(double from, double until);
  /// Offers a distance of the line from a support. @param gap [m]
  void line_at(double gap, std::size_t node, double time);
  /// Energy that this rank's masses lost in the step before a time [J].
  [[nodiscard]] double lost_before(double time) const;
  /// @brief Adds to `sums` what each support gave to this rank's masses in the step before a time [N s], y up.
  /// @param passed share of the step that has passed by then
  void add_impulses(double time, double passed, std::span<double> sums) const;
  /// @brief The nodes of this rank that were hit, rested or held the line from `since` until just before `until`, a
  /// time in the step.
  /// @param resting nonzero for each local node that rests at `until`
  [[nodiscard]] ContactZone zone(double since, double until, std::span<const std::uint8_t> resting);
  /// Whether a gap would be the smallest so far.
  [[nodiscard]] bool smallest(double gap) const noexcept { return gap < line_gap_.gap; }
  /// @}

  /// @brief Releases the masses that a line which has jumped pulls off their supports.
  /// @param acceleration over `stretch`: wf^2 [1/s^2]
  void release_pulled(double time, double acceleration, std::span<const double> stretch);

  /// @brief Applies the law to every mass on its support at one instant, and releases those that are due to lift.
  /// @param due  per local node: index + 1 of the support whose gap closes or from which the mass lifts now; 0: none
  /// @param acceleration  over `stretch`: wf^2 [1/s^2]
  /// @param[in,out] position, velocity, stretch of the local nodes [m], [m/s], [m]
  void resolve(double time, std::span<const std::int32_t> due, double acceleration, std::span<double> position,
               std::span<double> velocity, std::span<double> stretch);

  /// @brief Ends the step: what `sums` holds besides is added up in the same reduction.
  /// @note Collective: one reduction, one more if there were events.
  void commit(double time, std::span<double> sums);
  /// Takes back everything since the last `begin_step`.
  void undo();
  /// Events of the step that `commit` ended, this rank's, those of a node in order of time.
  [[nodiscard]] std::span<const ImpactRecord> impacts() const noexcept { return impacts_; }
  [[nodiscard]] std::span<const RestRecord> rests() const noexcept { return rests_; }
  /// Those of all ranks.
  [[nodiscard]] const EventCounts& all_events() const noexcept { return all_events_; }
  [[nodiscard]] bool any_events() const noexcept { return all_events_.impacts + all_events_.rests > 0; }
  /// Begins a new step.
  void begin_step();

  /// y-up impulse of every support on the masses up to the last `commit` [N s], equal on every rank.
  [[nodiscard]] const std::vector<double>& support_impulses() const noexcept { return impulse_; }
  /// @note Collective; meaningless without supports.
  [[nodiscard]] LineGap smallest_line_gap() const;
  /// That of this rank.
  [[nodiscard]] const LineGap& local_line_gap() const noexcept { return line_gap_; }

  /// @name For a restart. Index of the support + 1 for each local node, 0 where the mass moves.
  /// @{
  [[nodiscard]] const std::vector<std::int32_t>& resting_supports() const noexcept { return resting_; }
  /// When each local node was last in contact [s]; empty if no node of this rank can be.
  [[nodiscard]] const std::vector<double>& last_contact() const noexcept { return last_contact_; }
  void restore(std::span<const std::int32_t> resting, const ContactCounts& counts, const LineGap& gap,
               std::span<const double> impulses, std::span<const double> last_contact);
  /// @}

 private:
  void set_resting(std::size_t node, PetscInt support);
  void count_resting();
  void note_contacts(double until);

  const MassPoints* points_;
  const Contacts* contacts_;
  ContactParameters parameters_;
  double length_ = 0.0;  // of the motion [m]
  std::span<const ContactSet> runs_;
  std::vector<std::int32_t> resting_;
  std::size_t local_resting_ = 0;
  std::vector<double> impulse_;                        // per support, up to the start of the step, all ranks
  std::vector<double> last_contact_;                   // per node: time of the last impact or release [s]
  std::vector<std::array<std::size_t, 2>> touchable_;  // ranges of nodes that may touch something
  LineGap line_gap_;                                   // local smallest
  ContactCounts counts_;

  struct Change {
    std::size_t node;
    std::int32_t before;
  };
  std::vector<Change> changes_;
  std::vector<ImpactRecord> impacts_;
  std::vector<RestRecord> rests_;
  struct Part {
    PetscInt support;
    double impulse;
    double from;
    double to;
  };
  std::vector<double> pressed_;  // per support, in the step
  std::vector<Part> parts_;      // of the step
  struct Touch {
    std::size_t node;
    double from;
    double until;
  };
  std::vector<Touch> touches_;
  LineGap line_gap_before_;
  ContactCounts counts_before_;
  std::vector<double> impulse_before_;
  struct Loss {
    double time;
    double energy;
  };
  std::vector<Loss> losses_;  // besides those of the impacts
  EventCounts all_events_;
  EnergyFlow flow_;          // of the step
  bool gives_way_ = false;   // to masses: some support of the whole structure
  double held_from_ = -1.0;  // negative: not held in this step
  double held_until_ = -1.0;
};

}  // namespace udar
