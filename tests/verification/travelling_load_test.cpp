// ranks: 1 2; size: medium
/// @file
/// Forces that travel along a beam: the closed series of a simply supported one, impulse, work and turning of a free
/// one.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "support/steel_beam.hpp"
#include "support/world.hpp"

namespace udar {
namespace {

class Travelling : public testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] static bool modal() { return std::string_view{GetParam()} == "modal"; }
  [[nodiscard]] static FilterParameters filter() {
    return modal() ? test::unfiltered(1e-4) : FilterParameters{.filter_frequency = 2000.0};
  }

 private:
  test::Option type_{"-ts_type", GetParam()};
  test::Option modes_{"-modal_modes", "16"};
};

INSTANTIATE_TEST_SUITE_P(All, Travelling, testing::Values("chebyshev", "impact", "rk", "modal"),
                         [](const auto& tested) { return std::string{tested.param}; });

/// The deflection of a simply supported beam under a force F that entered at t = 0 (Fryba, Vibration of Solids and
/// Structures under Moving Loads, ch. 1).
double series(const BeamSegment& beam, double force, double speed, double x, double t) {
  double sum = 0.0;
  for (int n = 1; n < 200; ++n) {
    const double wave = n * std::numbers::pi / beam.length;
    const double w = wave * wave * std::sqrt(beam.bending_stiffness / beam.mass_per_length);
    const double passing = wave * speed;
    sum += std::sin(wave * x) / (w * w - passing * passing) * (std::sin(passing * t) - passing / w * std::sin(w * t));
  }
  return 2.0 * force / (beam.mass_per_length * beam.length) * sum;
}

TEST_P(Travelling, ForcesBendASimplySupportedBeamAsTheSeriesSays) {
  const test::Option end{"-ts_max_time", "0.36"};
  constexpr double kForce = -2e4;
  constexpr double kSpeed = 25.0;
  constexpr double kStart = 0.02;
  constexpr double kBehind = 2.6;  // [m]
  std::array<double, 2> off{};
  for (const std::size_t fine : {0U, 1U}) {
    BeamParameters beam = test::steel_beam(fine == 0 ? 20 : 40);
    beam.left = test::kPinned;
    beam.right = test::kPinned;
    const BeamSegment& segment = beam.segments[0];
    test::Fall fall{
        {.beam = beam,
         .filter = filter(),
         .gravity = 0.0,
         .travelling_loads =
             {{.offset = {0.0, kBehind}, .force = {kForce, 0.5 * kForce}, .speed = kSpeed, .start = kStart}},
         .initial = {.height = 0.0}}};
    test::Recorder record{0.02};
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
    double largest = 0.0;
    for (std::size_t k = 0; k < record.times.size(); ++k) {
      const double first = record.times[k] - kStart;
      const double second = first - kBehind / kSpeed;
      for (std::size_t i = 0; i < record.lines[k].size(); ++i) {
        const double x = fall.beam.position(fall.beam.begin() + static_cast<PetscInt>(i));
        const double expected = (first > 0.0 ? series(segment, kForce, kSpeed, x, first) : 0.0) +
                                (second > 0.0 ? series(segment, 0.5 * kForce, kSpeed, x, second) : 0.0);
        largest = std::max(largest, std::abs(expected));
        off[fine] = std::max(off[fine], std::abs(record.lines[k][i] - expected));
      }
    }
    std::array<double, 2> both{largest, off[fine]};
    MPI_Allreduce(MPI_IN_PLACE, both.data(), 2, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
    EXPECT_GT(both[0], 0.02);
    off[fine] = both[1] / both[0];
    EXPECT_LT(record.largest_drift(), 1e-4);
  }
  // The share of an element's own bending under the force, of second order; the filter takes (w / wf)^2 / 2 besides.
  EXPECT_LT(off[0], 4e-3);
  EXPECT_LT(off[1], 1e-3 + (modal() ? 0.0 : 1e-3));
}

/// Each gives its force over the time that it is on the beam; one runs against the other.
TEST_P(Travelling, ForcesGiveAFreeBeamTheirImpulse) {
  const test::Option end{"-ts_max_time", "0.9"};
  const test::Option tolerance{"-ts_rtol", "1e-10"};
  test::Fall fall{{.beam = test::steel_beam(20),
                   .filter = modal() ? filter() : FilterParameters{.filter_frequency = 100.0},
                   .gravity = 0.0,
                   .travelling_loads = {{.offset = {0.0, 1.7}, .force = {900.0, -300.0}, .speed = 20.0, .start = 0.03},
                                        {.offset = {0.4}, .force = {200.0}, .speed = -16.0, .start = 0.1}},
                   .initial = {.height = 0.0}}};
  test::Recorder record{0.05};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  double turning = 0.0;  // about the left end
  const MassState masses = fall.dynamics.masses();
  for (std::size_t i = 0; i < masses.velocity.size(); ++i) {
    turning +=
        fall.line.mass()[i] * masses.velocity[i] * fall.beam.position(fall.beam.begin() + static_cast<PetscInt>(i));
  }
  MPI_Allreduce(MPI_IN_PLACE, &turning, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  const double impulse = 600.0 * 10.0 / 20.0 + 200.0 * 10.0 / 16.0;
  EXPECT_NEAR(test::momentum_of(fall.line, fall.dynamics), impulse, 1e-7 * impulse);
  EXPECT_NEAR(turning, 5.0 * impulse, 1e-6 * impulse);
  EXPECT_LT(record.largest_drift(), 1e-6);
}

TEST(TravellingTables, AddUpToTheForcesAndRefuseWhatIsNone) {
  const std::vector<double> x{0.0, 0.5, 2.0, 2.5, 4.0};
  const auto tables =
      node_tables({.offset = {0.0, 0.5, 3.0}, .force = {10.0, 20.0, -5.0}, .speed = -2.0, .start = 1.0}, x);
  ASSERT_EQ(tables.size(), x.size());
  for (const double time : {0.9, 1.0, 1.1, 1.25, 1.5, 2.4, 2.55, 3.0, 3.1, 3.3, 4.4, 4.6}) {
    double sum = 0.0;
    double moment = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      sum += tables[i]->at(time).value;
      moment += tables[i]->at(time).value * x[i];
    }
    double expected = 0.0;
    double expected_moment = 0.0;
    for (const auto& [offset, force] : {std::pair{0.0, 10.0}, {0.5, 20.0}, {3.0, -5.0}}) {
      const double place = 4.0 - 2.0 * (time - 1.0) + offset;
      const bool on = place > 0.0 && place <= 4.0;
      expected += on ? force : 0.0;
      expected_moment += on ? force * place : 0.0;
    }
    EXPECT_NEAR(sum, expected, 1e-12) << time;
    EXPECT_NEAR(moment, expected_moment, 1e-12) << time;
  }
  EXPECT_THROW(static_cast<void>(node_tables({.offset = {0.0}, .force = {1.0}, .speed = 0.0}, x)), InputError);
  EXPECT_THROW(static_cast<void>(node_tables({.offset = {-1.0}, .force = {1.0}, .speed = 1.0}, x)), InputError);
  EXPECT_THROW(static_cast<void>(node_tables({.offset = {}, .force = {}, .speed = 1.0}, x)), InputError);
  BeamParameters gap = test::steel_beam(12);
  gap.segments.push_back(gap.segments.front());
  gap.segments.insert(gap.segments.begin() + 1, BeamSegment{.length = 0.5, .elements = 1});
  const BeamChain beam{PETSC_COMM_WORLD, gap};
  const TravellingLoad load{.offset = {0.0}, .force = {1.0}, .speed = 1.0};
  EXPECT_THROW((Loads{beam.points(), 9.81, {}, {}, {&load, 1}}), InputError);
}

}  // namespace
}  // namespace udar
