#pragma once
/// @file
/// What the masses do on their supports: who rests on what, and the sums of all contact so far.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "udar/contact/line_contact.hpp"
#include "udar/contact/support.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/motion/contact_journal.hpp"
#include "udar/motion/contact_times.hpp"
#include "udar/motion/observer.hpp"

namespace udar {

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

/// @brief Counts and sums of contact over the whole run so far; equal on every rank.
struct ContactCounts {
  PetscInt impacts = 0;
  PetscInt rests = 0;
  PetscInt releases = 0;
  PetscInt resting = 0;              ///< masses at rest now
  PetscInt event_steps = 0;          ///< steps with any of these
  double first_contact_time = -1.0;  ///< [s]; negative: none yet
  double last_contact_time = -1.0;   ///< last impact, or last instant some mass rested [s]; negative: none yet
  double lost = 0.0;                 ///< energy lost in impacts and rests [J]
  double work = 0.0;                 ///< of moving supports on the masses [J]
  double damped = 0.0;               ///< energy lost in dampers [J]
  double radiated = 0.0;             ///< energy lost into motions that a reduced model leaves out [J]
  double yielded = 0.0;              ///< energy lost in plastic hinges [J]
};

/// @brief Smallest distance of the line from a support, over all contact points and steps.
struct LineGap {
  double gap = std::numeric_limits<double>::infinity();  ///< [m]; negative: the line sank through
  double x = 0.0;                                        ///< [m]
  double time = 0.0;                                     ///< [s]
  std::int64_t point = -1;                               ///< local; negative: one of another rank, or another run
};

/// @brief What contact has come to since the start of the run.
struct ContactTotals {
  ContactCounts counts{};
  std::vector<double> impulses;  ///< of every support on the masses up to the last `commit` [N s], y up, all ranks
  LineGap line_gap{};            ///< this rank's
};

/// @brief The masses at one instant of contact.
struct ContactInstant {
  double time = 0.0;  ///< [s]
  /// Per local node: index + 1 of the support whose gap closes or from which the mass lifts now; 0, or empty: none.
  std::span<const std::int32_t> due{};
  double acceleration = 0.0;  ///< over `stretch`: wf^2 [1/s^2]
  /// @name Of the local nodes, changed by contact.
  /// @{
  std::span<double> position;  ///< [m]
  std::span<double> velocity;  ///< [m/s]
  std::span<double> stretch;   ///< [m]
  /// @}
};

/// @brief The state of contact of this rank's nodes: who rests on what.
///
/// An integrator writes what else happens in a step into the `journal`; `commit` adds it up over the ranks and ends the
/// step, `undo` takes all of it back.
class ContactState {
 public:
  /// Masses have supports to touch (`sets`) on `ContactSurface::mass` only.
  /// @param points, contacts must outlive this object
  ContactState(const MassPoints& points, const Contacts& contacts, ContactParameters parameters);

  [[nodiscard]] const std::vector<Support>& supports() const noexcept { return contacts_->supports; }
  [[nodiscard]] std::span<const ContactSet> sets() const noexcept { return sets_; }
  /// @param set one of `sets`
  [[nodiscard]] std::size_t index_of(const ContactSet& set) const {
    return static_cast<std::size_t>(&set - sets_.data());
  }
  [[nodiscard]] const ContactParameters& parameters() const noexcept { return parameters_; }
  [[nodiscard]] bool on_line() const noexcept { return parameters_.surface == ContactSurface::line; }

  /// @name Tolerances that go by the size of the motion.
  /// @{
  /// @param length of the motion [m]: rounding of stretches goes by it
  void set_motion_length(double length) noexcept { length_ = length; }
  /// How far from its support a mass still counts as on it [m], positions of about `position` [m].
  [[nodiscard]] double touching_distance(double position, double height) const;
  /// How far a stretch that would pull a mass off a support of about `height` [m] is known [m].
  [[nodiscard]] double pull_resolution(double height) const;
  /// @}

  [[nodiscard]] bool resting(std::size_t node) const { return resting_[node] != 0; }
  [[nodiscard]] bool resting_on(std::size_t node, const ContactSet& set) const {
    return resting_[node] == set.support + 1;
  }
  /// Whether any mass of this rank rests now.
  [[nodiscard]] bool any_resting() const noexcept { return local_resting_ > 0; }
  /// Index of the support + 1 for each local node, 0 where the mass moves.
  [[nodiscard]] const std::vector<std::int32_t>& resting_supports() const noexcept { return resting_; }
  /// Energy in the springs of supports that give way to masses, this rank's share [J].
  [[nodiscard]] double spring_energy(double time, std::span<const double> position) const;

  /// @name What happens in a step. Not collective.
  /// @{
  [[nodiscard]] ContactJournal& journal() noexcept { return journal_; }
  [[nodiscard]] const ContactJournal& journal() const noexcept { return journal_; }
  /// Where what happens in a long step waits. @see ScratchFile
  void set_scratch_folder(const std::string& folder);
  /// @param loss of energy besides that of an impact [J]
  void bring_to_rest(std::size_t node, const ContactSet& set, double time, double loss = 0.0);
  void release(std::size_t node, const ContactSet& set, double time);
  /// Offers a distance of the line from a support. @param gap [m]
  void record_gap(double gap, std::size_t node, double time);
  /// Whether a gap would be the smallest so far.
  [[nodiscard]] bool smallest(double gap) const noexcept { return gap < totals_.line_gap.gap; }
  /// @brief Releases the masses that a line which has jumped pulls off their supports.
  /// @param acceleration over `stretch`: wf^2 [1/s^2]
  void release_pulled(double time, double acceleration, std::span<const double> stretch);
  /// Applies the law to every mass on its support at one instant, and releases those that are due to lift.
  void resolve(const ContactInstant& now);
  /// @brief Coulomb's friction on a mass that a support pushes: the node's velocity across the normal falls by the
  /// coefficient times the impulse [N s] over the mass, to 0 at most.
  /// @return energy lost [J]
  [[nodiscard]] double rub(const ContactSet& set, std::size_t node, double impulse, std::span<double> velocity) const;
  /// @brief The nodes of this rank that were hit, rested or pressed on by the line from `since` until just before
  /// `until`, a time in the step.
  /// @param resting nonzero for each local node that rests at `until`
  /// @param[out] touched 1 for each of them, 0 for others; of those that nothing can touch it stays
  [[nodiscard]] ContactZone zone(double since, double until, std::span<const std::uint8_t> resting,
                                 std::span<std::uint8_t> touched);
  /// @}

  /// @brief Ends the step: what `sums` holds besides is added up in the same reduction.
  /// @note Collective: one reduction, one more if there were events.
  void commit(double time, std::span<double> sums);
  /// Takes back everything since the last `begin_step`.
  void undo();
  /// Begins a new step.
  void begin_step();
  /// Events of the step that `commit` ended, of all ranks.
  [[nodiscard]] const EventCounts& all_events() const noexcept { return all_events_; }
  [[nodiscard]] bool any_events() const noexcept { return all_events_.impacts + all_events_.rests > 0; }

  [[nodiscard]] const ContactCounts& counts() const noexcept { return totals_.counts; }
  /// y-up impulse of every support on the masses up to the last `commit` [N s], equal on every rank.
  [[nodiscard]] const std::vector<double>& support_impulses() const noexcept { return totals_.impulses; }
  /// @note Collective; meaningless without supports.
  [[nodiscard]] LineGap smallest_line_gap() const;
  /// That of this rank.
  [[nodiscard]] const LineGap& local_line_gap() const noexcept { return totals_.line_gap; }
  /// When each local node was last in contact [s]; empty if no node of this rank can be.
  [[nodiscard]] const std::vector<double>& last_contact() const noexcept { return times_.last(); }
  /// For a restart. @param resting, last_contact as `resting_supports` and `last_contact`
  void restore(std::span<const std::int32_t> resting, ContactTotals totals, std::span<const double> last_contact);

 private:
  struct Change {
    std::size_t node = 0;
    std::int32_t before = 0;
  };

  void set_resting(std::size_t node, PetscInt support);
  void count_resting();
  void meet(const ContactInstant& now, const ContactSet& set, const SupportMotion::State& lift, std::size_t node,
            bool due);
  void add_up(std::span<double> sums);
  void find_contact_times(double time, bool rested);

  const MassPoints* points_;
  const Contacts* contacts_;
  ContactParameters parameters_;
  double length_ = 0.0;  // of the motion [m]
  std::span<const ContactSet> sets_;
  bool any_elastic_ = false;  // some support of the whole structure gives way to masses
  std::vector<std::int32_t> resting_;
  std::size_t local_resting_ = 0;
  StepRecords<Change> changes_;  // of the step
  ContactJournal journal_;
  ContactTimes times_;
  ContactTotals totals_;
  ContactTotals totals_before_;  // at the beginning of the step
  EventCounts all_events_;
};

}  // namespace udar
