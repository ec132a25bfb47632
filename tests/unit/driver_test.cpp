// ranks: 1; size: short
/// @file
/// The parts of the driver, each alone.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "support/steel_beam.hpp"
#include "support/world.hpp"
#include "udar/dynamics/run_checks.hpp"
#include "udar/dynamics/snapshot_schedule.hpp"
#include "udar/integrators/configure.hpp"
#include "udar/motion/energy_balance.hpp"
#include "udar/motion/kinks.hpp"

namespace udar {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Notes when it gets rows.
class Clock final : public Observer {
 public:
  explicit Clock(double interval) : interval_{interval} {}
  [[nodiscard]] double interval() const override { return interval_; }
  void snapshot(const Snapshot& state) override {
    times.push_back(state.time);
    zones.push_back(state.zone);
  }
  std::vector<double> times;
  std::vector<ContactZone> zones;

 private:
  double interval_;
};

/// Rows up to a time, as the driver takes them.
void take_rows(SnapshotSchedule& schedule, double until) {
  while (schedule.is_due(until)) {
    Snapshot row{};
    row.time = schedule.next();
    schedule.tell(row, [](double since) { return ContactZone{.masses = 1, .x_min = since, .x_max = since}; });
  }
}

TEST(SnapshotSchedule, GivesRowsAtExactMultiplesAndAtTheEnd) {
  Clock tenths{0.1};
  Clock quarters{0.25};
  Clock silent{0.0};
  SnapshotSchedule schedule{0.6};
  for (Observer* observer : std::initializer_list<Observer*>{&tenths, &quarters, &silent}) {
    schedule.add(*observer);
  }
  take_rows(schedule, 0.29);
  EXPECT_EQ(tenths.times, (std::vector{0.0, 0.1, 0.2}));
  EXPECT_EQ(schedule.next(), 0.3) << "not three times the rounded 0.1";
  take_rows(schedule, 0.6);
  EXPECT_EQ(tenths.times, (std::vector{0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6}));
  EXPECT_EQ(quarters.times, (std::vector{0.0, 0.25, 0.5, 0.6}));
  EXPECT_TRUE(silent.times.empty());
  EXPECT_EQ(schedule.next(), kInfinity);
}

TEST(SnapshotSchedule, TellsTheZoneSinceTheListenersOwnLastRow) {
  Clock tenths{0.1};
  Clock fifths{0.2};
  SnapshotSchedule schedule{1.0};
  schedule.add(tenths);
  schedule.add(fifths);
  take_rows(schedule, 0.2);
  ASSERT_EQ(tenths.zones.size(), 3U);
  EXPECT_EQ(tenths.zones.front().masses, 0) << "nothing was before the first row";
  EXPECT_EQ(tenths.zones.back().x_min, 0.1);
  EXPECT_EQ(fifths.zones.back().x_min, 0.0);
}

TEST(SnapshotSchedule, GoesOnBehindTheRowsThatWereTaken) {
  Clock tenths{0.1};
  SnapshotSchedule schedule{1.0};
  schedule.add(tenths);
  schedule.resume(0.3);
  EXPECT_EQ(schedule.next(), 0.4);
  schedule.resume(0.35);
  EXPECT_EQ(schedule.next(), 0.4);
}

TEST(Kinks, SayWhereThePiecesOfAStepBegin) {
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(2)};
  const Loads loads{beam.points(), 0.0, {{.position = 0.0, .table = time_table({0.1, 0.5}, {0.0, 1.0})}}};
  const Kinks kinks{loads, {}};
  EXPECT_EQ(kinks.after(0.0), 0.1);
  EXPECT_EQ(kinks.after(0.1), 0.5);
  EXPECT_EQ(kinks.after(0.5), kInfinity);
  EXPECT_EQ(kinks.piece_begin(0.05, 0.3), 0.1);
  EXPECT_EQ(kinks.piece_begin(0.2, 0.3), 0.2) << "no piece is longer than the step";
  EXPECT_EQ(kinks.piece_begin(0.05, 0.1), 0.05) << "before the kink at that very time";
}

TEST(StandstillGuard, EndsWhatTakesStepsWithoutLength) {
  const auto steps_until_end = [](bool events, bool cut) {
    StandstillGuard guard{100.0};
    for (int step = 1; step <= 20000; ++step) {
      try {
        guard.see(1.0, 1.0, events, cut);
      } catch (const SolveError&) {
        return step;
      }
    }
    return 0;
  };
  EXPECT_EQ(steps_until_end(false, false), 1001);
  EXPECT_EQ(steps_until_end(true, false), 10001);
  EXPECT_EQ(steps_until_end(false, true), 0) << "short on purpose";
}

/// A line that stays at one height [m].
class Still final : public DenseOutput {
 public:
  explicit Still(double height) : height_{height} {}
  void masses(double /*time*/, std::span<double> /*position*/, std::span<double> /*velocity*/,
              std::span<std::uint8_t> /*resting*/) const override {}
  void line_integrals(std::span<const std::size_t> /*nodes*/, double until,
                      std::span<double> integrals) const override {
    std::ranges::fill(integrals, height_ * until);
  }

 private:
  double height_;
};

/// A free bar of one element at a height of 2 m, and a force of 3 N/s on its left end.
struct Balanced {
  test::Fall fall{{.beam = test::steel_beam(1),
                   .filter = {.filter_frequency = 100.0},
                   .gravity = 0.0,
                   .loads = {{.position = 0.0, .table = time_table({0.0, 10.0}, {0.0, 30.0})}},
                   .initial = {.height = 2.0, .velocity = 1.0}}};
  Kinks kinks{fall.loads, {}};
  EnergyBalance balance{fall.equations, fall.dynamics.contact(), kinks};
  MassState masses = initial_masses(fall.beam.points(), fall.initial);
  LineState line;

  Balanced() {
    fall.equations.evaluate(0.0, masses.position, line, true);
    balance.start({.time = 0.0, .step_begin = 0.0, .line = line, .masses = masses}, Still{2.0});
  }
  void row(double time) {
    fall.equations.evaluate({time, 0.0}, masses.position, line, true);
    balance.update({.time = time, .step_begin = 0.0, .line = line, .masses = masses}, Still{2.0}, {}, 0.0);
  }
};

TEST(EnergyBalance, CountsTheWorkOfLoadsThatChange) {
  Balanced bar;
  const double kinetic = 0.5 * bar.fall.beam.total_mass();
  EXPECT_NEAR(bar.balance.ledger().initial, kinetic, 1e-12 * kinetic);
  // Minus the integral of dF/dt y, on a line that is still: -3 N/s * 2 m * 0.5 s. It makes up for the load's potential.
  EXPECT_NEAR(bar.balance.load_work(Still{2.0}, 0.0, 0.5).loads, -3.0, 1e-15);
  bar.row(1e-4);
  EXPECT_NEAR(bar.balance.ledger().load_work, -6e-4, 1e-15);
  EXPECT_NEAR(bar.balance.ledger().drift(), 0.0, 1e-12) << "the line yields by 3e-4 N / (wf^2 m), some 1e-11 m";
  bar.balance.end_step({.loads = -3.0});
  MotionState saved;
  bar.balance.save(saved);
  EXPECT_EQ(saved.table("load_work"), std::vector<double>{-3.0});
  Balanced other;
  other.balance.restore(saved);
  EXPECT_EQ(other.balance.ledger().initial, bar.balance.ledger().initial);
  EXPECT_EQ(other.balance.ledger().drift(), bar.balance.ledger().drift());
}

TEST(EnergyBalance, KeepsNoLedgerThatIsNotFinite) {
  Balanced bar;
  const auto row = [&bar] {
    return bar.balance.update({.time = 0.0, .step_begin = 0.0, .line = bar.line, .masses = bar.masses}, Still{2.0}, {},
                              0.0);
  };
  for (double& velocity : bar.masses.velocity) {
    velocity *= 2.0;  // four times the energy
  }
  EXPECT_NEAR(row().drift(), 0.75, 1e-12);
  EXPECT_NEAR(bar.balance.ledger().drift(), 0.75, 1e-12);
  bar.masses.velocity.front() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(row().drift()));
  EXPECT_NEAR(bar.balance.ledger().drift(), 0.75, 1e-12) << "that of the row before";
}

TEST(Features, OfAProblemDecideWhichIntegratorIsTheDefault) {
  const auto type = [](const ModelParameters& parameters) {
    const test::Fall fall{parameters};
    TSType name = nullptr;
    UDAR_CALL(TSGetType(fall.dynamics.stepper(), &name));
    return std::string{name};
  };
  ModelParameters parameters{.beam = test::steel_beam(20), .filter = {.filter_frequency = 100.0}};
  parameters.initial.height = 1.0;
  EXPECT_EQ(type(parameters), "chebyshev");
  parameters.damping.mass = 1.0;
  EXPECT_EQ(type(parameters), "impact");
  parameters.damping = {};
  parameters.supports = {Support::floor(0.0, 0.0)};
  EXPECT_EQ(type(parameters), "impact") << "many nodes touch";
  parameters.supports = {{.position = 5.0}};
  EXPECT_EQ(type(parameters), "chebyshev");
  parameters.contact.surface = ContactSurface::line;
  EXPECT_EQ(type(parameters), "impact");
  parameters.filter = test::unfiltered(1e-3);
  EXPECT_EQ(type(parameters), "moreau");
  const auto refusal = [&] { return test::failure_of<InputError>([&] { test::Fall{parameters}; }); };
  parameters.damping.mass = 1.0;
  EXPECT_NE(refusal().find("no integrator knows both"), std::string::npos) << refusal();
  parameters.damping = {};
  parameters.supports[0].stiffness = 1e6;
  parameters.supports[0].damping = 1e3;
  EXPECT_EQ(type(parameters), "moreau");
}

}  // namespace
}  // namespace udar
