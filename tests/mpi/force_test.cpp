// ranks: 1 2 3; size: medium
/// @file
/// Impulses and forces of supports, contact zone, moments and shear of whole runs, by every integrator on any number of
/// ranks, against closed forms and the balance of momentum.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>
#include <string_view>

#include "support/dense.hpp"
#include "support/steel_beam.hpp"
#include "udar/io/support_forces.hpp"

namespace udar {
namespace {

/// Every test runs with `-ts_type` rk, chebyshev and impact.
class Forces : public testing::TestWithParam<const char*> {
  test::Option type_{"-ts_type", GetParam()};
  test::Option tolerance_{"-ts_rtol", std::string_view{GetParam()} == "chebyshev" ? "1e-14" : "1e-10"};
};

INSTANTIATE_TEST_SUITE_P(All, Forces, testing::Values("rk", "chebyshev", "impact"),
                         [](const auto& tested) { return std::string{tested.param}; });

double sum_of(const std::vector<double>& values) { return std::reduce(values.begin(), values.end()); }

/// Two of the masses rest, the others hang on the line, and nothing moves. The lever gives the forces, their sums shear
/// and moment.
TEST_P(Forces, OfABeamAtRestFollowFromTheLever) {
  const test::Option end{"-ts_max_time", "0.2"};
  const double wf = 100.0;
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(20)};
  const std::vector<Support> supports{{.position = 2.0, .restitution = 0.0}, {.position = 6.0, .restitution = 0.0}};
  const auto n = static_cast<std::size_t>(beam.nodes());
  test::Dense matrix = test::line_stiffness(beam);
  std::vector<double> weight(n);
  for (std::size_t i = 0; i < n; ++i) {
    weight[i] = -test::kGravity * beam.mass(static_cast<PetscInt>(i));
  }
  for (const std::size_t i : {std::size_t{4}, std::size_t{12}}) {
    matrix(i, i) += wf * wf * beam.mass(static_cast<PetscInt>(i));
  }
  const std::vector<double> line = test::solve(matrix, weight);
  InitialState initial{.height = 0.0};
  for (std::size_t i = 0; i < n; ++i) {
    initial.shape.x.push_back(beam.position(static_cast<PetscInt>(i)));
    initial.shape.offset.push_back(i == 4 || i == 12 ? 0.0 : line[i]);
  }
  test::Fall fall{test::steel_beam(20), wf, test::kGravity, initial, supports};
  test::Recorder record{0.005};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();

  const double total = beam.total_mass() * test::kGravity;
  const std::array<double, 2> share{0.25 * total, 0.75 * total};  // the middle is 3 of 4 m away from the first
  std::vector<double> shear(n);
  std::vector<double> moment(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    shear[i] = (i > 0 ? shear[i - 1] : 0.0) + weight[i] + (i == 4 ? share[0] : 0.0) + (i == 12 ? share[1] : 0.0);
    if (i + 1 < n) {
      moment[i + 1] = moment[i] + 0.5 * shear[i];
    }
  }
  // Tolerances: what integrators leave of 1e-10 of the scale of motion in 0.2 s, and nine digits of the dense solve.
  io::SupportForces forces{2, 0.005, std::numbers::pi / wf};
  EXPECT_DOUBLE_EQ(forces.window(), 0.035);
  for (std::size_t k = 0; k < record.times.size(); ++k) {
    const double t = record.times[k];
    const std::vector<double> force = forces.add(t, record.support_impulses[k]);
    for (std::size_t s = 0; s < 2; ++s) {
      EXPECT_NEAR(record.support_impulses[k][s], share[s] * t, 1e-8 * total) << "t = " << t;
      EXPECT_NEAR(force[s], share[s] * std::min(t / 0.035, 1.0), 1e-7 * total) << "t = " << t;
    }
    for (std::size_t i = 0; i < record.moments[k].size(); ++i) {
      const std::size_t node = static_cast<std::size_t>(fall.beam.begin()) + i;
      EXPECT_NEAR(record.moments[k][i], moment[node], 1e-7 * total) << "node " << node << ", t = " << t;
      EXPECT_NEAR(record.shears[k][i], node + 1 < n ? shear[node] : 0.0, 1e-6 * total) << "node " << node;
    }
    std::array<double, 3> zone{-record.zones[k].x_min, record.zones[k].x_max,
                               static_cast<double>(record.zones[k].masses)};
    MPI_Allreduce(MPI_IN_PLACE, zone.data(), 2, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
    MPI_Allreduce(MPI_IN_PLACE, &zone[2], 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    if (k > 0) {  // they come to rest at the very start, after the first snapshot
      EXPECT_EQ(zone[2], 2.0) << "t = " << t;
      EXPECT_EQ(-zone[0], 2.0);
      EXPECT_EQ(zone[1], 6.0);
    }
  }
  EXPECT_NEAR(forces.peaks()[1], share[1], 1e-7 * total);
}

/// At every snapshot, wherever in a step, the impulses are the change of momentum and what gravity gave.
TEST_P(Forces, BalanceTheMomentumAtEverySnapshot) {
  const test::Option end{"-ts_max_time", "0.999"};
  const double wf = 100.0;
  for (const double e : {1.0, 0.5, 0.0}) {
    const std::vector<Support> supports{{.position = 2.0, .width = 1.0, .restitution = e},
                                        {.position = 8.0, .restitution = e}};
    test::Fall fall{test::steel_beam(20), wf, test::kGravity, {.height = 0.2}, supports};
    test::Recorder record{0.003};
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
    const double weight = fall.beam.total_mass() * test::kGravity;
    io::SupportForces forces{2, 0.003, std::numbers::pi / wf};
    double worst = 0.0;
    for (std::size_t k = 0; k < record.times.size(); ++k) {
      double momentum = 0.0;
      for (std::size_t i = 0; i < record.velocities[k].size(); ++i) {
        momentum += fall.beam.mass(fall.beam.begin() + static_cast<PetscInt>(i)) * record.velocities[k][i];
      }
      MPI_Allreduce(MPI_IN_PLACE, &momentum, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
      const double expected = momentum + weight * record.times[k];
      const double off = std::abs(sum_of(record.support_impulses[k]) - expected);
      worst = std::max(worst, off);
      [[maybe_unused]] const auto force = forces.add(record.times[k], record.support_impulses[k]);
      if (e == 1.0 || k + 1 == record.times.size()) {
        EXPECT_LT(off, 1e-6 * weight) << "e = " << e << ", t = " << record.times[k];
      }
    }
    EXPECT_GT(fall.dynamics.counts().impacts, 10);
    // Resting masses press evenly over a step, of length 1/wf at most, here: off by F' h^2 / 8 with F' up to wf F.
    const double peak = std::max(std::abs(forces.peaks()[0]), std::abs(forces.peaks()[1]));
    EXPECT_LT(worst, 2.0 * peak / (8.0 * wf)) << "e = " << e;
  }
}

/// Where forces hold the line there are no impacts: what it is held by is the same balance, and where it is held is the
/// zone.
TEST_P(Forces, OfContactOnTheLineBalanceTheMomentum) {
  const test::Option end{"-ts_max_time", "0.6"};
  const double wf = 100.0;
  test::Fall fall{test::steel_beam(20),
                  wf,
                  test::kGravity,
                  {.height = 0.2},
                  {{.position = 2.0, .width = 1.0}, {.position = 8.0}},
                  {.surface = ContactSurface::line}};
  test::Recorder record{0.003};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  const double weight = fall.beam.total_mass() * test::kGravity;
  double worst = 0.0;
  double steepest = 0.0;
  int in_contact = 0;
  for (std::size_t k = 0; k < record.times.size(); ++k) {
    std::array<double, 2> sums{0.0, static_cast<double>(record.zones[k].masses)};
    for (std::size_t i = 0; i < record.velocities[k].size(); ++i) {
      sums[0] += fall.beam.mass(fall.beam.begin() + static_cast<PetscInt>(i)) * record.velocities[k][i];
    }
    MPI_Allreduce(MPI_IN_PLACE, sums.data(), 2, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    const double given = sum_of(record.support_impulses[k]);
    worst = std::max(worst, std::abs(given - sums[0] - weight * record.times[k]));
    const double more = k > 0 ? given - sum_of(record.support_impulses[k - 1]) : 0.0;
    steepest = std::max(steepest, more / 0.003);
    EXPECT_GE(more, 0.0);
    EXPECT_TRUE(more == 0.0 || sums[1] > 0.0) << "t = " << record.times[k];
    in_contact += sums[1] > 0.0 ? 1 : 0;
  }
  EXPECT_GT(steepest, weight);
  EXPECT_GT(in_contact, 10);
  EXPECT_LT(in_contact, static_cast<int>(record.times.size()) / 2);
  EXPECT_LT(worst, 2.0 * steepest / (8.0 * wf));  // as above: even over steps of 1/wf
}

TEST(SupportForces, AreMeansOverWholeRowsNotShorterThanAsked) {
  EXPECT_DOUBLE_EQ((io::SupportForces{1, 0.01, 0.05}.window()), 0.05);
  EXPECT_DOUBLE_EQ((io::SupportForces{1, 0.01, 0.0501}.window()), 0.06);
  EXPECT_DOUBLE_EQ((io::SupportForces{1, 0.1, 0.05}.window()), 0.1);
  io::SupportForces forces{2, 0.25, 0.5};
  const std::vector<std::array<double, 2>> impulse{{0.0, 0.0}, {1.0, -1.0}, {1.0, -5.0}, {4.0, -5.0}, {4.0, -5.0}};
  const std::vector<std::array<double, 2>> force{{0.0, 0.0}, {2.0, -2.0}, {2.0, -10.0}, {6.0, -8.0}, {6.0, 0.0}};
  for (std::size_t k = 0; k < impulse.size(); ++k) {
    const std::vector<double> found = forces.add(0.25 * static_cast<double>(k), impulse[k]);
    EXPECT_EQ(found, (std::vector<double>{force[k][0], force[k][1]})) << "row " << k;
  }
  EXPECT_EQ(forces.peaks()[0], 6.0);
  EXPECT_EQ(forces.peaks()[1], -10.0);

  // Goes on with other rows: the last old one that is a window ago serves as the start of the mean.
  MotionState state;
  forces.save(state);
  io::SupportForces later{2, 0.125, 0.5};
  later.restore(state);
  const std::array<double, 2> more{7.0, -6.0};
  EXPECT_EQ(later.add(1.125, more), (std::vector<double>{(7.0 - 1.0) / 0.625, (-6.0 + 5.0) / 0.625}));
  EXPECT_EQ(later.peaks()[0], 9.6);
}

}  // namespace
}  // namespace udar
