#pragma once
/// @file
/// The masses that touch supports, in the sweeps of the impact integrator.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "udar/contact/support.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/integrators/law_history.hpp"
#include "udar/integrators/line_distance.hpp"
#include "udar/integrators/step_supports.hpp"
#include "udar/integrators/sweep.hpp"
#include "udar/integrators/sweep_tally.hpp"
#include "udar/local/local_batch.hpp"
#include "udar/motion/contact_state.hpp"

namespace udar {

/// @brief Tells by bounds which masses may touch a support in the step at hand, and advances these exactly: eight at
/// once where one impact is all they meet, alone through everything else. Source: docs/theory.md, "The impact
/// integrator"
/// @note Not collective.
class TouchingMasses {
 public:
  /// All outlive this object.
  TouchingMasses(Sweep& sweep, ContactState& contact, FilteredStructure& structure);
  TouchingMasses(const TouchingMasses&) = delete;
  TouchingMasses& operator=(const TouchingMasses&) = delete;
  ~TouchingMasses() = default;

  /// A new sweep: no mass is listed.
  void begin(Tally& tally);
  /// Lists the masses of a block that may touch something. @return 0 for each of them, else 1
  [[nodiscard]] const double* take_out(std::size_t from, std::size_t to, SweepMaxima& largest);
  /// Advances those of the block, at the latest in `finish`: moments and ends.
  void move(std::size_t from, SweepMaxima& largest);
  void finish(SweepMaxima& largest);

  /// Where they are at a share `tau` of the accepted step. @see Integrator::masses
  void at(double tau, std::span<double> position, std::span<double> velocity, std::span<std::uint8_t> resting) const;
  /// Integrals of where all masses are, touching or not, up to a share `tau` of the accepted step [m s].
  void integrals(double tau, std::span<double> sums) const;
  /// Tells contact what happened in the step: the touching masses once more, now that the line's motion is final.
  void write_journal();
  /// Offers the smallest distance of the line from the supports in this step.
  void track_line() { line_distance_.track(); }
  /// What flowed besides impacts up to a share `tau` of the accepted step, and is in laws of contact then, this rank's
  /// share.
  [[nodiscard]] EnergyFlow flow(double tau) const;
  /// What is in laws of contact between steps [J], this rank's share. @param time [s] @param position [m]
  [[nodiscard]] double stored(double time, std::span<const double> position) const;
  /// What laws of contact remember: of the start of the step at hand, and of its end.
  [[nodiscard]] LawHistory& history() noexcept { return history_; }
  [[nodiscard]] const LawHistory& history() const noexcept { return history_; }
  /// Calls `visit` with the local node of every mass that may have touched something in the accepted step.
  template <class Visit>
  void each(const Visit& visit) const {
    for (const RestingMass& mass : resting_) {
      visit(mass.node);
    }
    for (const MovingMass& mass : touching_) {
      visit(mass.node);
    }
  }
  /// Gives back what a rare step has made large.
  void release_memory() { release_if_large(touching_); }

 private:
  using Moments = std::array<double, kMostUnknowns>;

  /// A mass that may touch something in this step. One for every mass of a flat fall: kept small.
  struct MovingMass {
    std::uint32_t node = 0;
    std::int32_t resting = 0;  // support + 1 at the start of the step
    std::int32_t set = 0;      // of the following
    bool known = false;        // all it meets is one impact of the following, or none
    double impact = 2.0;       // tau; 2: none
    double before = 0.0;       // velocity [m per step]
  };
  /// A mass that stays at rest.
  struct RestingMass {
    const ContactSet* set;
    std::size_t node;
  };
  /// Of the masses of a block.
  struct BlockReach {
    std::array<double, kBlock> low{};
    std::array<double, kBlock> high{};
    std::array<double, kBlock> line_low{};
    std::array<double, kBlock> line_high{};
    std::array<std::uint8_t, kBlock> near{};
  };
  /// Masses that will be advanced side by side.
  struct Waiting {
    local::Batch batch;
    std::array<std::size_t, local::kLanes> mass{};
    std::array<Moments, local::kLanes> before{};  // u before the sweep
    std::size_t count = 0;
  };
  class Recorder;

  /// Lists the masses of a block that may touch something in this step, by bounds of their motion; what is free
  /// are the others.
  void find_touching(std::size_t from, std::size_t to, std::span<const std::size_t> sets, SweepMaxima& largest);
  /// The first marked mass from `i` on, `count` if there is none.
  [[nodiscard]] std::size_t next_near(std::size_t i, std::size_t count) const;
  /// Moments and end.
  void keep_at_rest(const RestingMass& mass);
  /// Moves a mass that may touch something: in the next batch if that may do, else at once.
  void move_touching(std::size_t index, const Moments& before, SweepMaxima& largest);
  void finish_batch(SweepMaxima& largest);
  void move_alone(const MovingMass& mass, const Moments& before, SweepMaxima& largest);
  [[nodiscard]] const ContactSet& set_of(const MovingMass& mass) const;
  /// @param before u before the sweep @param rests where it rests at the end; null: nowhere
  void take(const MovingMass& mass, const Moments& before, const local::Outcome& outcome, const ContactSet* rests,
            SweepMaxima& largest);
  [[nodiscard]] double energy(std::size_t node, double speed) const;
  /// @param tau of the step @param before, after velocities, and that of the support [m per step]
  void record_impact(const ContactSet& set, std::size_t node, double tau, double before, double after,
                     double ground) const;
  /// @param push, work as in `local::Journal::pressed`
  void record_force(const ContactSet& set, std::size_t node, double push, double work) const;

  Sweep* sweep_;
  ContactState* contact_;
  LawHistory history_;
  StepSupports supports_;
  LineDistance line_distance_;
  Tally* tally_ = nullptr;
  std::vector<float> kink_share_;  // of every node
  std::vector<MovingMass> touching_;
  std::vector<RestingMass> resting_;  // all along the step
  std::size_t first_touching_ = 0;    // of the block
  std::size_t first_resting_ = 0;
  std::array<double, kBlock> free_{};
  BlockReach bounds_;
  std::array<Moments, kBlock> block_moments_{};  // u before the sweep of the touching masses of a block
  std::size_t listed_ = 0;
  Waiting waiting_;
};

}  // namespace udar
