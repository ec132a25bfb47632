// ranks: 1 2; size: short
/// @file
/// What a run is watched for: every guard by a violation that is forced on it.

#include "udar/dynamics/guards.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "support/steel_beam.hpp"
#include "support/world.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/warnings.hpp"

namespace udar {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Changes the state of the TS at the end of the first step that ends after some time, in place of an integrator that
/// is wrong: rows of a step come before it is judged.
class Saboteur final : public Observer {
 public:
  /// @param change of Ym and Vm of the local nodes
  Saboteur(TS stepper, double from, std::function<void(std::span<double>)> change)
      : stepper_{stepper}, from_{from}, change_{std::move(change)} {}
  [[nodiscard]] double interval() const override { return 0.01; }
  void snapshot(const Snapshot& row) override {
    if (!done_ && row.time >= from_) {
      Vec state = nullptr;
      UDAR_CALL(TSGetSolution(stepper_, &state));
      PetscInt size = 0;
      UDAR_CALL(VecGetLocalSize(state, &size));
      const petsc::WriteArray values{state};
      change_({values.values(), static_cast<std::size_t>(size)});
      done_ = true;
    }
  }

 private:
  TS stepper_;
  double from_;
  std::function<void(std::span<double>)> change_;
  bool done_ = false;
};

/// The beam of 20 elements falls from 1 m on a floor for 0.1 s, which it does not reach; its last node is the last
/// rank's.
struct Falling {
  test::Option end{"-ts_max_time", "0.1"};
  test::Option steps{"-ts_max_steps", "100"};
  test::Option type;
  test::Option step{"-ts_dt", "0.005"};
  test::Fall fall{test::steel_beam(20), 100.0, test::kGravity, {.height = 1.0}, {Support::floor(0.0, 0.5)}};

  explicit Falling(const char* integrator, GuardMode mode) : type{"-ts_type", integrator} {
    static_cast<void>(petsc::take_warnings());
    fall.dynamics.set_guard(mode);
  }
  /// @param change of position and velocity of the node at the right end @return the failure; empty: none
  std::string sabotage(const std::function<void(double& position, double& velocity)>& change) {
    Saboteur saboteur{fall.dynamics.stepper(), 0.035, [&](std::span<double> state) {
                        if (fall.beam.points().owns(20)) {
                          change(state[state.size() / 2 - 1], state.back());
                        }
                      }};
    fall.dynamics.add_observer(saboteur);
    return test::failure_of<SolveError>([&] { fall.dynamics.solve(); });
  }
  [[nodiscard]] static std::string place() {
    return "at x = 10 m, node 20 on rank " + std::to_string(test::world_size() - 1) + ", t = 0.";
  }
};

class Guarded : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, Guarded, testing::Values("rk", "chebyshev", "impact"),
                         [](const auto& tested) { return std::string{tested.param}; });

TEST_P(Guarded, StateThatIsNotFiniteEndsARunAfterItsLastGoodStep) {
  for (const GuardMode mode : {GuardMode::warn, GuardMode::stop}) {
    for (const double wrong : {kNaN, std::numeric_limits<double>::infinity()}) {
      Falling run{GetParam(), mode};
      const std::string failure = run.sabotage([wrong](double& /*position*/, double& velocity) { velocity = wrong; });
      EXPECT_TRUE(failure.starts_with("the motion is no longer finite " + Falling::place())) << failure;
      for (const double value : run.fall.dynamics.masses().velocity) {
        EXPECT_TRUE(std::isfinite(value)) << "the state is that of the last good step";
      }
      EXPECT_FALSE(run.fall.dynamics.completed());
    }
  }
}

TEST_P(Guarded, MassBelowItsSupportIsAWarningOrTheEnd) {
  const auto sink = [](double& position, double& /*velocity*/) { position = -1e-3; };
  Falling stopped{GetParam(), GuardMode::stop};
  const std::string failure = stopped.sabotage(sink);
  EXPECT_TRUE(failure.starts_with("the beam is below a rigid support by 0.001 m " + Falling::place())) << failure;
  EXPECT_NE(failure.find(", allowed "), std::string::npos) << failure;
  EXPECT_TRUE(petsc::take_warnings().empty());
  const double stopped_at = stopped.fall.dynamics.time();
  EXPECT_LT(stopped_at, 0.1);

  Falling warned{GetParam(), GuardMode::warn};
  static_cast<void>(warned.sabotage(sink));
  EXPECT_EQ(petsc::take_warnings().front(), failure) << "the same finding";
  EXPECT_GT(warned.fall.dynamics.time(), stopped_at) << "it went on";

  Falling silent{GetParam(), GuardMode::silent};
  static_cast<void>(silent.sabotage(sink));
  EXPECT_TRUE(petsc::take_warnings().empty());
  EXPECT_GT(silent.fall.dynamics.time(), stopped_at) << "it went on";
}

TEST_P(Guarded, MassFarBelowItsSupportEndsEveryRun) {
  for (const GuardMode mode : {GuardMode::silent, GuardMode::warn, GuardMode::stop}) {
    Falling run{GetParam(), mode};
    const std::string failure = run.sabotage([](double& position, double& /*velocity*/) { position = -0.5; });
    EXPECT_TRUE(failure.starts_with("the beam has fallen through a rigid support by 0.5 m " + Falling::place()))
        << failure;
  }
}

TEST(Guards, EnergyBalanceThatIsOffIsSaidOnce) {
  const test::Option adapt{"-ts_adapt_type", "none"};
  const auto coarse = [](GuardMode mode) {
    static_cast<void>(petsc::take_warnings());
    const test::Option end{"-ts_max_time", "0.8"};
    const test::Option step{"-ts_dt", "0.04"};
    const test::Option type{"-ts_type", "rk"};
    const std::vector<Support> supports{{.position = 2.0}, {.position = 8.0}};
    test::Fall fall{test::steel_beam(20), 50.0, test::kGravity, {.height = 1.0}, supports};
    fall.dynamics.set_guard(mode);
    test::Recorder record{0.01};
    fall.dynamics.add_observer(record);
    const std::string failure = test::failure_of<SolveError>([&] { fall.dynamics.solve(); });
    return std::pair{failure, fall.dynamics.time()};
  };
  const auto [silent, end] = coarse(GuardMode::silent);
  EXPECT_TRUE(silent.empty()) << silent;
  EXPECT_DOUBLE_EQ(end, 0.8);
  EXPECT_TRUE(petsc::take_warnings().empty());

  EXPECT_TRUE(coarse(GuardMode::warn).first.empty());
  const std::vector<std::string> warned = petsc::take_warnings();
  ASSERT_EQ(warned.size(), 1U) << "once, whatever the rest is like";
  EXPECT_TRUE(warned.front().starts_with("the energy balance is off by ")) << warned.front();
  EXPECT_NE(warned.front().find(" of the energy at t = 0."), std::string::npos) << warned.front();
  EXPECT_NE(warned.front().find(", allowed 0.001 of the energy; "), std::string::npos) << warned.front();

  const auto [failure, stopped] = coarse(GuardMode::stop);
  EXPECT_EQ(failure, warned.front()) << "the same finding";
  EXPECT_LT(stopped, 0.8);
}

/// The check of the line solve, where one rank alone has something that is not a number.
TEST(Guards, ResidualOfALineSolveThatIsNotFinite) {
  const test::Fall fall{test::steel_beam(20), 100.0, test::kGravity, {.height = 1.0}, {}};
  FilterParameters parameters{.filter_frequency = 100.0};
  parameters.check_interval = 1;
  for (const PetscInt node : {PetscInt{0}, PetscInt{20}}) {
    FilteredStructure line{*fall.structure, parameters};
    std::vector<double> displacement(line.mass().size(), 1e-3);
    std::vector<double> stretch(displacement.size());
    if (line.points().owns(node)) {
      displacement[static_cast<std::size_t>(node - line.points().begin())] = kNaN;
    }
    const std::string failure = test::failure_of<SolveError>([&] { line.solve(displacement, {}, stretch, {}); });
    EXPECT_TRUE(failure.starts_with("the line solve is wrong: backward error ")) << failure;
  }
}

/// Judged by hand.
class Judged : public testing::Test {
 protected:
  std::string tell(GuardMode mode, const std::function<void(Guards&)>& see) {
    static_cast<void>(petsc::take_warnings());
    Guards guards{fall_.equations, contact_, fall_.contacts.sets, {.length = 1.0, .velocity = 0.5}};
    guards.set_mode(mode);
    see(guards);
    double ranks = guards.waiting();
    MPI_Allreduce(MPI_IN_PLACE, &ranks, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    return test::failure_of<SolveError>([&] { guards.tell(ranks); });
  }
  [[nodiscard]] static EnergyLedger energies(double kinetic, double initial = 1.0) {
    return {.kinetic = kinetic, .initial = initial, .scale = 1.0};
  }
  [[nodiscard]] std::string row(GuardMode mode, const EnergyLedger& before, const EnergyLedger& now) {
    return tell(mode, [&](Guards& guards) {
      guards.see({.time = 0.5, .before = before, .now = now, .masses = masses_, .tolerance = 0.0});
    });
  }

  test::Fall fall_{test::steel_beam(20), 100.0, test::kGravity, {.height = 1.0}, {Support::floor(0.0, 0.5)}};
  ContactState contact_{fall_.beam.points(), fall_.contacts, {.hop_tolerance = 1e-9}};
  MassState masses_ = fall_.dynamics.masses();
};

TEST_F(Judged, BalanceByItsLimits) {
  for (const GuardMode mode : {GuardMode::silent, GuardMode::warn, GuardMode::stop}) {
    EXPECT_TRUE(row(mode, energies(1.0), energies(1.0009)).empty());
    EXPECT_TRUE(petsc::take_warnings().empty());
    const std::string failure = row(mode, energies(1.0), energies(1.75));
    EXPECT_TRUE(
        failure.starts_with("the integration is unstable: the energy balance is off by 0.75 of the energy at "
                            "t = 0.5 s, allowed 0.5"))
        << failure;
    for (const double wrong : {kNaN, std::numeric_limits<double>::infinity()}) {
      const std::string infinite = row(mode, energies(1.0), energies(wrong));
      EXPECT_TRUE(infinite.starts_with("the energy is no longer finite at t = 0.5 s; ")) << infinite;
    }
  }
  EXPECT_TRUE(row(GuardMode::silent, energies(1.0), energies(1.01)).empty());
  EXPECT_TRUE(row(GuardMode::warn, energies(1.0), energies(0.99)).empty());
  EXPECT_EQ(petsc::take_warnings().size(), 1U);
  EXPECT_TRUE(row(GuardMode::stop, energies(1.0), energies(0.99)).starts_with("the energy balance is off by -0.01 "));
}

TEST_F(Judged, WhatCanButTakeEnergy) {
  EnergyLedger damped = energies(2.0);
  damped.lost_in_dampers = -1.0;
  for (const GuardMode mode : {GuardMode::silent, GuardMode::warn, GuardMode::stop}) {
    const std::string failure = row(mode, energies(1.0), damped);
    EXPECT_TRUE(failure.starts_with("dampers, which can but take energy, have given 1 J at t = 0.5 s, allowed 1e-09 J"))
        << failure;
  }
  EnergyLedger lost = energies(1.5);
  lost.lost_in_impacts = -0.5;
  EXPECT_TRUE(row(GuardMode::silent, energies(1.0), lost).empty());
  EXPECT_TRUE(row(GuardMode::warn, energies(1.0), lost).empty());
  EXPECT_EQ(petsc::take_warnings().size(), 1U);
  EXPECT_TRUE(row(GuardMode::stop, energies(1.0), lost)
                  .starts_with("impacts and rests, which can but take energy, have given 0.5 J at t = 0.5 s"));
}

TEST_F(Judged, ImpactThatGivesEnergyIsNamed) {
  std::vector<double> state = masses_.position;
  state.insert(state.end(), masses_.velocity.begin(), masses_.velocity.end());
  for (const double loss : {-0.25, kNaN}) {
    const auto see = [&](Guards& guards) {
      if (fall_.beam.points().owns(20)) {
        contact_.journal().record_impact(masses_.position.size() - 1,
                                         {.time = 0.3, .velocity_before = -1.0, .impulse = 1.0, .energy_loss = loss});
      }
      guards.see({.begin = 0.2, .time = 0.4, .before = state, .after = state, .tolerance = 0.0, .late = false});
      contact_.journal().clear();
    };
    EXPECT_TRUE(tell(GuardMode::silent, see).empty());
    EXPECT_TRUE(tell(GuardMode::warn, see).empty());
    EXPECT_EQ(petsc::take_warnings().size(), 1U) << "on every rank";
    const std::string failure = tell(GuardMode::stop, see);
    EXPECT_TRUE(failure.starts_with("an impact, which can but take energy, has given ")) << failure;
    EXPECT_NE(failure.find(" J at x = 10 m, node 20 on rank " + std::to_string(test::world_size() - 1) + ", t = 0.3 s"),
              std::string::npos)
        << failure;
  }
}

TEST_F(Judged, TheGravestComesFirstAndTheRestIsSaid) {
  std::vector<double> state = masses_.position;
  state.insert(state.end(), masses_.velocity.begin(), masses_.velocity.end());
  if (fall_.beam.points().owns(0)) {
    state.front() = -1e-2;
  }
  const auto see = [&](Guards& guards) {
    guards.see({.begin = 0.2, .time = 0.4, .before = state, .after = state, .tolerance = 0.0, .late = false});
    guards.see({.time = 0.4, .before = energies(1.0), .now = energies(1.1), .masses = masses_, .tolerance = 0.0});
  };
  EXPECT_TRUE(tell(GuardMode::warn, see).empty());
  const std::vector<std::string> warned = petsc::take_warnings();
  ASSERT_EQ(warned.size(), 2U);
  EXPECT_TRUE(warned[0].starts_with("the beam is below a rigid support by 0.01 m at x = 0 m, node 0 on rank 0, "))
      << warned[0];
  EXPECT_TRUE(warned[1].starts_with("the energy balance is off by 0.1 of the energy")) << warned[1];
}

TEST_F(Judged, StepsThatSeeASupportLateMayPassIt) {
  std::vector<double> state(2 * masses_.position.size(), 0.0);
  std::ranges::fill(std::span{state}.first(masses_.position.size()), -1e-2);
  std::ranges::fill(std::span{state}.last(masses_.position.size()), -1.0);
  const auto see = [&](bool late) {
    return tell(GuardMode::stop, [&](Guards& guards) {
      guards.see({.begin = 0.2, .time = 0.22, .before = state, .after = state, .tolerance = 0.0, .late = late});
    });
  };
  EXPECT_TRUE(see(true).empty());
  EXPECT_FALSE(see(false).empty());
}

}  // namespace
}  // namespace udar
