#pragma once
/// @file
/// The masses that touch supports, in the sweeps of the impact integrator.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "udar/contact/support.hpp"
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
  TouchingMasses(Sweep& sweep, ContactState& contact, const BeamChain& beam);

  /// Forgets who touches.
  void begin(Tally& tally);
  /// Lists the masses of a block that may touch something. @return 0 for each of them, else 1
  [[nodiscard]] const double* take_out(std::size_t from, std::size_t to, Largest& largest);
  /// Advances those of the block, at the latest in `finish`: moments and ends.
  void move(std::size_t from, Largest& largest);
  void finish(Largest& largest);

  /// Where they are at a share `tau` of the accepted step. @see Integrator::masses
  void at(double tau, std::span<double> position, std::span<double> velocity, std::span<std::uint8_t> resting) const;
  /// Tells contact what happened in the step: the touching masses once more, now that the line's motion is final.
  void write_journal();
  /// Offers the smallest distance of the line from the supports in this step.
  void track_line();
  /// What flowed besides impacts up to a share `tau` of the accepted step, this rank's share.
  [[nodiscard]] EnergyFlow flow(double tau) const;
  /// Calls `visit` with the local node of every mass that may have touched something in the accepted step.
  template <class Visit>
  void each(const Visit& visit) const {
    for (const Pressed& mass : pressed_) {
      visit(mass.node);
    }
    for (const Touching& mass : touching_) {
      visit(mass.node);
    }
  }
  /// Gives back what a rare step has made large.
  void release_memory() { release_if_large(touching_); }

 private:
  using Moments = std::array<double, kMostUnknowns>;

  /// A mass that may touch something in this step. One for every mass of a flat fall: kept small.
  struct Touching {
    std::uint32_t node = 0;
    std::int32_t resting = 0;  // support + 1 at the start of the step
    std::int32_t run = 0;      // of the following
    bool known = false;        // all it meets is one impact of the following, or none
    double impact = 2.0;       // tau; 2: none
    double before = 0.0;       // velocity [m per step]
  };

  struct Pressed {
    const ContactSet* run;
    std::size_t node;
  };

  /// A mass near its supports, and the support behind each stop: the first it meets, and the one it rests on.
  struct Meeting {
    local::Problem problem;
    std::array<const ContactSet*, 2> runs{};
  };

  class Teller;

  [[nodiscard]] Meeting meeting_of(const Touching& mass) const;
  /// How much of a mass's displacement the line takes on at once at its node: dx / 2 l on an even Winkler bed of decay
  /// length l = (4 EI / rhoA wf^2)^(1/4), four times that at an end.
  [[nodiscard]] double kink_share(std::size_t node) const;
  /// Lists the masses of a block that may touch something in this step, by bounds of their motion; takes them out of
  /// what is free.
  void find_touching(std::size_t from, std::size_t to, std::span<const std::size_t> runs, Largest& largest);
  /// The first marked mass from `i` on, `count` if there is none.
  [[nodiscard]] std::size_t next_near(std::size_t i, std::size_t count) const;
  /// Moments and end of a mass that stays at rest.
  void hold(const Pressed& mass);
  /// Runs that have nodes in the block of a node, by index.
  [[nodiscard]] std::span<const std::size_t> runs_at(std::size_t node) const;
  /// Moves a mass that may touch something: in the next batch if that may do, else at once.
  void move_touching(std::size_t index, const Moments& before, Largest& largest);
  void finish_batch(Largest& largest);
  void move_alone(const Touching& mass, const Moments& before, Largest& largest);
  [[nodiscard]] const ContactSet& run_of(const Touching& mass) const;
  /// @param before u before the sweep @param rests where it rests at the end; null: nowhere
  void take(const Touching& mass, const Moments& before, const local::Outcome& outcome, const ContactSet* rests,
            Largest& largest);
  [[nodiscard]] double energy(std::size_t node, double speed) const;
  /// @param tau of the step @param before, after velocities, and that of the support [m per step]
  void tell_impact(const ContactSet& run, std::size_t node, double tau, double before, double after,
                   double ground) const;
  /// @param push, work as in `local::Journal::pressed`
  void press(const ContactSet& run, std::size_t node, double push, double work) const;
  void track_nodes(std::size_t index, std::size_t first, std::size_t last);
  /// Lowest and highest bound of a run's lift in the step [m].
  [[nodiscard]] std::array<double, 2> reach_of_lift(std::size_t run) const;

  local::Batch batch_;
  Sweep* sweep_;
  ContactState* contact_;
  const BeamChain* beam_;
  Tally* tally_ = nullptr;
  std::vector<std::size_t> block_runs_;       // of every block, by index
  std::vector<std::size_t> first_run_;        // of a block, in `block_runs_`
  std::vector<float> kink_share_;             // of every node
  std::vector<std::array<double, 4>> lifts_;  // of every run in powers of tau [m]
  double lifted_at_ = -1.0;                   // begin and length of the step they belong to [s]
  double lifted_over_ = 0.0;
  std::vector<Touching> touching_;
  std::vector<Pressed> pressed_;    // at rest all along the step
  std::size_t first_touching_ = 0;  // of the block
  std::size_t first_pressed_ = 0;
  std::array<double, kBlock> free_{};
  std::array<double, kBlock> low_{};
  std::array<double, kBlock> high_{};
  std::array<double, kBlock> line_low_{};
  std::array<double, kBlock> line_high_{};
  std::array<std::uint8_t, kBlock> near_{};
  std::array<std::size_t, local::kLanes> batch_mass_{};
  std::array<Moments, local::kLanes> batch_before_{};  // u before the sweep
  std::array<Moments, kBlock> block_moments_{};        // the same of the touching masses of a block
  std::size_t listed_ = 0;
  std::size_t waiting_ = 0;  // masses in the batch
  Square line_bernstein_;    // [coefficient][Legendre term]
  std::vector<double> block_low_;
};

}  // namespace udar
