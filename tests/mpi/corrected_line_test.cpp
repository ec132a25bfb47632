// ranks: 1 2 3; size: medium
/// @file
/// Corrected modes where supports hold the line: the tied line against its modes, energy, and how fast it gets right.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "support/dense.hpp"
#include "support/line_ways.hpp"
#include "support/steel_beam.hpp"
#include "support/world.hpp"
#include "udar/filter/modes.hpp"
#include "udar/filter/rigid_shapes.hpp"

namespace udar {
namespace {

constexpr double kRigidSpring = std::numeric_limits<double>::infinity();

/// Corrects flexible modes by their numbers from 1 on, and ties rigid ones.
std::function<void(FilteredStructure&)> correcting(std::vector<std::size_t> numbers, bool rigid = true) {
  return [numbers = std::move(numbers), rigid](FilteredStructure& line) {
    std::vector<Mode> modes =
        exact_modes(line.structure(), line.parameters(), static_cast<PetscInt>(std::ranges::max(numbers)) + 1);
    std::vector<CorrectedMode> chosen;
    for (const std::size_t number : numbers) {
      chosen.push_back({.frequency = modes[number - 1].frequency, .shape = std::move(modes[number - 1].shape)});
    }
    for (auto& shape : rigid ? rigid_shapes(line) : std::vector<std::vector<double>>{}) {
      chosen.push_back({.frequency = 0.0, .shape = std::move(shape)});
    }
    line.correct(std::move(chosen));
  };
}

/// Every mode of the lumped beam by itself: q of the masses, y of the line, b at the contact points.
struct TiedModes {
  test::Eigen exact;
  std::vector<bool> corrected;
  std::vector<std::size_t> node;  // of contact points
  double wf2;
  double give;  // of each support [m/N]

  [[nodiscard]] double w2(std::size_t mode) const { return std::max(exact.values[mode], 0.0); }
  [[nodiscard]] double b(std::size_t point, std::size_t mode) const { return exact.vectors(node[point], mode); }
  /// How much of a mass's way the line takes on.
  [[nodiscard]] double share(std::size_t mode) const { return corrected[mode] ? 1.0 : wf2 / (wf2 + w2(mode)); }
  [[nodiscard]] std::size_t modes() const { return corrected.size(); }
  /// W + 1/K.
  [[nodiscard]] test::Dense compliance() const {
    test::Dense sum{node.size()};
    for (std::size_t i = 0; i < node.size(); ++i) {
      for (std::size_t j = 0; j < node.size(); ++j) {
        for (std::size_t mode = 0; mode < modes(); ++mode) {
          sum(i, j) += corrected[mode] ? 0.0 : b(i, mode) * b(j, mode) / (wf2 + w2(mode));
        }
        sum(i, j) += i == j ? give : 0.0;
      }
    }
    return sum;
  }
  /// Highest frequency while all points touch.
  [[nodiscard]] double highest() const {
    test::Dense hessian{modes()};
    for (std::size_t mode = 0; mode < modes(); ++mode) {
      hessian(mode, mode) = corrected[mode] ? w2(mode) : wf2 * (1.0 - share(mode));
      std::vector<double> row(node.size());
      for (std::size_t i = 0; i < node.size(); ++i) {
        row[i] = b(i, mode) * share(mode);
      }
      const std::vector<double> force = test::solve(compliance(), row);
      for (std::size_t other = 0; other < modes(); ++other) {
        for (std::size_t i = 0; i < node.size(); ++i) {
          hessian(mode, other) += force[i] * b(i, other) * share(other);
        }
      }
    }
    return std::sqrt(test::eigen(hessian).values.back());
  }
};

struct Tied {
  const char* name;
  std::vector<std::size_t> numbers;
  double stiffness;  // of each support
  std::vector<double> places;
  bool rigid = true;
};

class TiedLine : public testing::TestWithParam<Tied> {};
INSTANTIATE_TEST_SUITE_P(All, TiedLine,
                         testing::Values(Tied{"one_below_wf", {1}, kRigidSpring, {2.0, 8.0}},
                                         Tied{"one_above_wf", {1, 3}, 1e7, {2.0, 8.0}},
                                         Tied{"without_rigid_ones", {1, 2}, kRigidSpring, {2.0, 8.0}, false},
                                         Tied{"on_springs", {1, 2, 3, 4}, 1e7, {2.0, 5.0, 8.0}},
                                         Tied{"a_pad", {1}, 1e6, {2.0, 7.0, 8.0, 9.0}}),
                         [](const auto& tested) { return std::string{tested.param.name}; });

/// Force, line, acceleration and the bound of frequencies, mode by mode.
TEST_P(TiedLine, IsThatOfItsModes) {
  constexpr double kWf = 100.0;
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(20)};
  FilteredStructure line{beam, {.filter_frequency = kWf}};
  correcting(GetParam().numbers, GetParam().rigid)(line);
  std::vector<Support> supports;
  for (const double x : GetParam().places) {
    supports.push_back({.position = x, .stiffness = GetParam().stiffness});
  }
  const Loads loads{beam.points(), test::kGravity, {}};
  const InitialState initial{.height = 0.0};
  Equations equations{
      line, loads, initial, {}, std::make_unique<LineContact>(line, find_contacts(beam.points(), supports))};

  TiedModes modes{test::lumped_modes(beam), {}, {}, kWf * kWf, 1.0 / GetParam().stiffness};
  modes.corrected.assign(modes.exact.values.size(), false);
  modes.corrected[0] = modes.corrected[1] = GetParam().rigid;
  for (const std::size_t number : GetParam().numbers) {
    modes.corrected[1 + number] = true;  // two rigid ones before
  }
  for (const double x : GetParam().places) {
    modes.node.push_back(static_cast<std::size_t>(std::lround(2.0 * x)));
  }
  // Masses below all supports by so much that each is pressed, bent and tilted.
  const auto place_of = [](std::size_t node) {
    const double x = 0.5 * static_cast<double>(node);
    return -0.1 - 0.002 * x - 0.001 * x * x * (10.0 - x) / 100.0 + 0.002 * std::cos(2.0 * x);
  };
  const std::size_t count = modes.modes();
  std::vector<double> q(count);
  std::vector<double> f(count);
  for (std::size_t mode = 0; mode < count; ++mode) {
    for (std::size_t i = 0; i < count; ++i) {
      const double mass = beam.mass(static_cast<PetscInt>(i));
      q[mode] += mass * modes.exact.vectors(i, mode) * place_of(i);
      f[mode] -= mass * modes.exact.vectors(i, mode) * test::kGravity;
    }
  }
  const auto line_in = [&](std::size_t mode, double force) {
    return modes.corrected[mode] ? q[mode] : modes.share(mode) * q[mode] + force / (modes.wf2 + modes.w2(mode));
  };
  std::vector<double> gap(modes.node.size());
  for (std::size_t i = 0; i < gap.size(); ++i) {
    for (std::size_t mode = 0; mode < count; ++mode) {
      gap[i] -= modes.b(i, mode) * line_in(mode, f[mode]);
    }
  }
  const std::vector<double> force = test::solve(modes.compliance(), gap);
  for (std::size_t mode = 0; mode < count; ++mode) {
    for (std::size_t i = 0; i < force.size(); ++i) {
      f[mode] += modes.b(i, mode) * force[i];
    }
  }

  std::vector<double> masses;
  for (PetscInt i = beam.begin(); i < beam.end(); ++i) {
    masses.push_back(place_of(static_cast<std::size_t>(i)));
  }
  LineState state;
  equations.evaluate(0.0, masses, state);
  const std::vector<double> stretch = equations.line_stretch(state);
  ASSERT_EQ(state.contact_force.size(), force.size());
  for (std::size_t i = 0; i < force.size(); ++i) {
    EXPECT_GT(force[i], 0.0) << "the test means all points to be pressed";
    EXPECT_NEAR(state.contact_force[i] / force[i], 1.0, 1e-9) << i;  // shapes are right to 1e-11
  }
  for (std::size_t i = 0; i < masses.size(); ++i) {
    const auto node = static_cast<std::size_t>(beam.begin()) + i;
    double at = 0.0;
    double acceleration = 0.0;
    for (std::size_t mode = 0; mode < count; ++mode) {
      const double phi = modes.exact.vectors(node, mode);
      at += phi * line_in(mode, f[mode]);
      acceleration += phi * (modes.corrected[mode] ? f[mode] - modes.w2(mode) * q[mode]
                                                   : modes.wf2 * (line_in(mode, f[mode]) - q[mode]));
    }
    EXPECT_NEAR(masses[i] + stretch[i], at, 1e-11) << node;
    EXPECT_NEAR(modes.wf2 * state.stretch[i], acceleration, 1e-9 * modes.wf2 * 0.1) << node;
  }
  const double highest = modes.highest();
  RecordProperty("bound", std::to_string(equations.frequency_bound() / highest));
  EXPECT_GE(equations.frequency_bound(), highest * (1.0 - 1e-9));
  EXPECT_LE(equations.frequency_bound(), 1.5 * highest);
}

struct Course {
  std::vector<double> times;
  std::vector<std::vector<double>> lines;
  std::vector<double> impulses;
  double drift = 0.0;
  double work = 0.0;
  PetscInt solves = 0;
};

Course course_of(const char* integrator, const char* rtol, const char* until, ModelParameters parameters,
                 const std::function<void(FilteredStructure&)>& prepare) {
  const test::Option type{"-ts_type", integrator};
  const test::Option tolerance{"-ts_rtol", rtol};
  const test::Option end{"-ts_max_time", until};
  parameters.contact = test::kOnLine;
  test::Fall fall{parameters, prepare};
  const PetscInt before = fall.line.solves();
  test::Recorder record{1e-3};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  return {.times = record.times,
          .lines = record.lines,
          .impulses = fall.dynamics.support_impulses(),
          .drift = record.largest_drift(),
          .work = record.energies.back().load_work / record.energies.back().scale,
          .solves = fall.line.solves() - before - fall.dynamics.counts().row_line_solves};
}

/// Largest distance of two lines at the same times, up to one of them [m].
double distance(const Course& one, const Course& other, double until = kRigidSpring) {
  double largest = 0.0;
  EXPECT_EQ(one.lines.size(), other.lines.size());
  for (std::size_t k = 0; k < std::min(one.lines.size(), other.lines.size()) && one.times[k] <= until; ++k) {
    for (std::size_t i = 0; i < one.lines[k].size(); ++i) {
      largest = std::max(largest, std::abs(one.lines[k][i] - other.lines[k][i]));
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  return largest;
}

ModelParameters fall_on(const std::vector<double>& places, double stiffness, double slope) {
  ModelParameters parameters{.beam = test::steel_beam(20),
                             .filter = {.filter_frequency = 100.0},
                             .gravity = test::kGravity,
                             .initial = {.height = 0.05 + 10.0 * slope, .slope = slope, .velocity = -3.0}};
  for (const double x : places) {
    parameters.supports.push_back({.position = x, .stiffness = stiffness});
  }
  return parameters;
}

/// As the beam on supports with a stiffness: modes by chebyshev with and without correction, against -ts_type modal.
TEST(CorrectedLine, NeedsALowerFilterFrequencyForTheSameError) {
  if (test::world_size() > 1) {
    GTEST_SKIP() << "verification.ranks compares ranks";
  }
  ModelParameters parameters = fall_on({2.0, 8.0}, 2e8, 0.0);
  parameters.beam = test::steel_beam(40);
  parameters.initial = {.height = 0.02, .velocity = -4.4};
  ModelParameters of_modes = parameters;
  of_modes.filter = test::unfiltered(1e-4);
  const test::Option count{"-modal_modes", "30"};
  const Course exact = course_of("modal", "1e-8", "0.06", of_modes, {});
  parameters.filter.filter_frequency = 2400.0;
  const Course corrected = course_of("chebyshev", "1e-10", "0.06", parameters, correcting({1, 2, 3, 4, 5, 6, 7, 8, 9}));
  const Course plain = course_of("chebyshev", "1e-10", "0.06", parameters, {});
  EXPECT_LT(distance(corrected, exact), 2e-4);
  EXPECT_GT(distance(plain, exact), 20.0 * distance(corrected, exact));
}

/// Contact, flight, contact; a table of loads; a mode above wf; by all integrators alike, and none of the energy lost.
TEST(CorrectedLine, KeepsItsEnergyByAllIntegratorsAlike) {
  if (test::world_size() > 1) {
    GTEST_SKIP() << "verification.ranks compares ranks";
  }
  const NodalLoad load{.position = 3.0, .table = time_table({0.0, 0.05, 0.123, 0.3}, {0.0, 0.0, 40000.0, -10000.0})};
  struct Try {
    std::vector<std::size_t> numbers;
    double stiffness;
    double slope;
    bool loaded;
  };
  for (const auto& [numbers, stiffness, slope, loaded] :
       {Try{{1}, kRigidSpring, 0.01, false}, Try{{1, 3}, 1e7, 0.0, true}, Try{{1, 2}, 2e6, 0.01, true}}) {
    ModelParameters parameters = fall_on({2.0, 8.0}, stiffness, slope);
    if (loaded) {
      parameters.loads = {load};
    }
    const Course exact = course_of("chebyshev", "1e-14", "0.25", parameters, correcting(numbers));
    const Course impact = course_of("impact", "1e-10", "0.25", parameters, correcting(numbers));
    const Course rk = course_of("rk", "1e-11", "0.25", parameters, correcting(numbers));
    const std::string which = std::to_string(numbers.size()) + (loaded ? " loaded" : "");
    EXPECT_GT(exact.impulses[0] + exact.impulses[1], 1e3) << which;
    EXPECT_EQ(std::abs(exact.work) > 1e-3, loaded) << which << ' ' << exact.work;
    EXPECT_LT(exact.drift, 1e-11) << which;
    EXPECT_LT(impact.drift, 2e-7) << which << ": in rows within steps, whose line is a polynomial";
    EXPECT_LT(rk.drift, 1e-8) << which;
    EXPECT_LT(distance(impact, exact), 1e-8) << which;
    EXPECT_LT(distance(rk, exact), 1e-8) << which;
    for (std::size_t k = 0; k < exact.impulses.size(); ++k) {
      EXPECT_NEAR(impact.impulses[k], exact.impulses[k], 1e-3) << which;
      EXPECT_NEAR(rk.impulses[k], exact.impulses[k], 1e-1) << which << ": Simpson's rule";
    }
  }
}

}  // namespace
}  // namespace udar
