// ranks: 1 2 3; size: medium
/// @file
/// The filter frequency by accuracy, and modes without filter: their frequencies, the cap on all others, their energy.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "support/dense.hpp"
#include "support/steel_beam.hpp"
#include "udar/app/filter_choice.hpp"
#include "udar/filter/modes.hpp"

namespace udar {
namespace {

struct Ends {
  const char* name;
  BeamEnd end;                 // both
  std::array<double, 3> root;  // beta L of the lowest flexible modes of the continuous beam (Blevins 1979, table 8-1)
};
const std::array kEnds{Ends{"free", {}, {4.730040744862704, 7.853204624095838, 10.995607838001671}},
                       Ends{"pinned", test::kPinned, {std::numbers::pi, 2 * std::numbers::pi, 3 * std::numbers::pi}},
                       Ends{"clamped", test::kClamped, {4.730040744862704, 7.853204624095838, 10.995607838001671}}};

BeamParameters held_beam(const Ends& ends, PetscInt elements) {
  BeamParameters beam = test::steel_beam(elements);
  beam.left = ends.end;
  beam.right = ends.end;
  return beam;
}

std::vector<CorrectedMode> corrected(std::vector<Mode> modes, const std::vector<std::size_t>& numbers) {
  std::vector<CorrectedMode> chosen;
  for (const std::size_t number : numbers) {
    Mode& mode = modes.at(number - 1);
    chosen.push_back({.frequency = mode.frequency, .shape = std::move(mode.shape)});
  }
  return chosen;
}

class Held : public testing::TestWithParam<Ends> {};
INSTANTIATE_TEST_SUITE_P(Ends, Held, testing::ValuesIn(kEnds),
                         [](const auto& tested) { return std::string{tested.param.name}; });

TEST_P(Held, LowestModesConvergeToThoseOfTheContinuousBeam) {
  std::array<std::array<double, 3>, 2> error{};
  for (const std::size_t level : {0U, 1U}) {
    const BeamChain beam{PETSC_COMM_WORLD, held_beam(GetParam(), level == 0 ? 200 : 400)};
    const std::vector<Mode> modes = exact_modes(beam, {}, 3);
    ASSERT_EQ(modes.size(), 3U);
    const BeamSegment& segment = beam.parameters().segments[0];
    for (std::size_t k = 0; k < 3; ++k) {
      const double exact =
          std::pow(GetParam().root[k] / 10.0, 2) * std::sqrt(segment.bending_stiffness / segment.mass_per_length);
      error[level][k] = std::abs(modes[k].frequency / exact - 1.0);
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    // Half a mass too many at either end of a free beam: order 2, a relative error of (beta h)^2 / 8 or less, 1e-4 for
    // the third mode at N = 400; held ends are of order 4.
    EXPECT_LT(error[1][k], std::pow(GetParam().root[k] / 400.0, 2) / 4.0);
    // Round-off of the frequencies hides the order of the held beams' lowest modes.
    EXPECT_GT(error[0][k] / error[1][k], error[0][k] > 1e-8 ? 3.8 : 0.0);
  }
}

TEST_P(Held, AreTheModesOfTheLumpedBeamToRoundOff) {
  const BeamChain beam{PETSC_COMM_WORLD, held_beam(GetParam(), 20)};
  const test::Eigen exact = test::lumped_modes(beam);
  const std::size_t rigid = beam.parameters().left.fixed() ? 0 : 2;
  const std::vector<Mode> modes = exact_modes(beam, {}, 10);
  ASSERT_EQ(modes.size(), 10U);
  for (std::size_t k = 0; k < modes.size(); ++k) {
    // LAPACK's absolute error is round-off of the highest w^2, up to 6e5 times the lowest (pinned): 1e-10.
    EXPECT_NEAR(modes[k].frequency / std::sqrt(exact.values[k + rigid]), 1.0, 1e-9) << k;
    double norm = 0.0;
    for (PetscInt i = 0; i < beam.local_nodes(); ++i) {
      norm += beam.mass(beam.begin() + i) * std::pow(modes[k].shape[static_cast<std::size_t>(i)], 2);
    }
    MPI_Allreduce(MPI_IN_PLACE, &norm, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    EXPECT_NEAR(norm, 1.0, 1e-12) << k;
  }
}

TEST_P(Held, AutomaticFrequencyIsTheLeastThatReachesTheAccuracy) {
  for (const PetscInt elements : {20, 4500}) {  // the latter's modes are those of a coarser mesh
    const BeamParameters parameters = held_beam(GetParam(), elements);
    const BeamChain beam{PETSC_COMM_WORLD, parameters};
    for (const double accuracy : {0.01, 0.001, 0.3}) {
      for (const PetscInt count : {1, 3}) {
        app::FilterInput filter;
        filter.automatic = true;
        filter.accuracy = accuracy;
        filter.modes = count;
        const FilterParameters chosen = app::choose_filter(PETSC_COMM_WORLD, {.beam = parameters}, filter);
        std::vector<Mode> modes = exact_modes(beam, chosen, count);
        // The mesh of the choice and its own differ by 1e-5, the frequency is rounded up to six digits.
        EXPECT_LT(-modes.back().distortion(), accuracy * (1.0 + (elements > 20 ? 2e-5 : 0.0)));
        EXPECT_GT(-modes.back().distortion(), accuracy * (1.0 - 5e-5));
        // What the filter at this frequency does, by its own operator.
        FilteredStructure line{beam, chosen};
        line.correct(corrected(std::move(modes), {}));
        const std::vector<Mode> seen = lowest_modes(line, count);
        ASSERT_EQ(seen.size(), static_cast<std::size_t>(count));
        for (const Mode& mode : seen) {
          EXPECT_LT(-mode.distortion(), accuracy * (1.0 + 2e-5));
        }
      }
    }
  }
}

TEST(AutomaticFrequency, OfABandKeepsItsEdge) {
  app::FilterInput filter;
  filter.automatic = true;
  filter.band = 160.0;
  const FilterParameters chosen = app::choose_filter(PETSC_COMM_WORLD, {.beam = test::steel_beam(20)}, filter);
  EXPECT_NEAR(1.0 - filtered_frequency(160.0, chosen.filter_frequency) / 160.0, 0.01, 1e-7);
}

/// Every mode of the lumped beam is one of the corrected operator: named ones at their own frequency, the others at the
/// filtered one. The named put nothing into the line's stretch and their whole moment into it.
void expect_corrected_spectrum(const BeamParameters& parameters, double wf, const std::vector<std::size_t>& named,
                               Formulation formulation = Formulation::mixed) {
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  FilteredStructure line{beam, {.filter_frequency = wf, .formulation = formulation}};
  const test::Eigen exact = test::lumped_modes(beam);
  const double before = largest_frequency(line).value();
  line.correct(corrected(exact_modes(beam, line.parameters(), 5), named));
  const auto count = static_cast<std::size_t>(beam.local_nodes());
  std::size_t flexible = 0;
  double largest = 0.0;
  for (std::size_t mode = 0; mode < exact.values.size(); ++mode) {
    const double w = std::sqrt(std::max(exact.values[mode], 0.0));
    if (w < 1.0) {
      continue;  // rigid motion
    }
    const bool is_named = std::ranges::find(named, ++flexible) != named.end();
    const double expected = is_named ? w : filtered_frequency(w, wf);
    largest = std::max(largest, expected);
    std::vector<double> shape(count);
    for (std::size_t i = 0; i < count; ++i) {
      shape[i] = exact.vectors(static_cast<std::size_t>(beam.begin()) + i, mode);
    }
    std::vector<double> stretch(count);
    std::vector<double> moment(count);
    line.solve(shape, {}, stretch, moment);
    std::vector<double> line_at = stretch;
    line.line_stretch(line.amplitudes(), line_at);
    std::array<double, 4> worst{};
    for (std::size_t i = 0; i < count; ++i) {
      worst[0] = std::max(worst[0], std::abs(-wf * wf * stretch[i] - expected * expected * shape[i]));
      worst[1] = std::max(worst[1], std::abs(expected * expected * shape[i]));
      worst[2] = std::max(worst[2], std::abs(line_at[i]));
      worst[3] = std::max(worst[3], std::abs(shape[i]));
      line_at[i] += shape[i];
    }
    MPI_Allreduce(MPI_IN_PLACE, worst.data(), 4, MPI_DOUBLE, MPI_MAX, beam.comm());
    // 1e-9: what LAPACK's vectors carry (verification.filter) and what 1e-11 in the shapes makes of it.
    EXPECT_LT(worst[0] / worst[1], 1e-9) << "mode " << flexible << ", w = " << w;
    if (is_named) {
      EXPECT_LT(worst[2] / worst[3], 1e-9) << "mode " << flexible;
    }
    // Line and moment belong together: 1/2 w^2 of strain energy in a mode that the line takes on as it is.
    double strain = line.filter_operator().strain_energy(line_at, moment);
    MPI_Allreduce(MPI_IN_PLACE, &strain, 1, MPI_DOUBLE, MPI_SUM, beam.comm());
    const double share = is_named ? 1.0 : wf * wf / (wf * wf + w * w);
    EXPECT_NEAR(strain / (0.5 * share * share * w * w), 1.0, 1e-8) << "mode " << flexible;
  }
  const double after = largest_frequency(line).value();
  EXPECT_LT(before, wf);
  EXPECT_LE(after, line.frequency_bound() * (1.0 + 1e-10));  // SLEPc's value is a Rayleigh quotient: round-off
  EXPECT_NEAR(after / largest, 1.0, 1e-5);
}

TEST(CorrectedModes, HaveTheirOwnFrequenciesAndTheOthersTheFilteredOnes) {
  expect_corrected_spectrum(test::steel_beam(20), 100.0, {1});
  expect_corrected_spectrum(test::steel_beam(20), 400.0, {1, 2, 3});
  expect_corrected_spectrum(test::steel_beam(20), 100.0, {1, 4});  // the fourth above wf
  expect_corrected_spectrum(held_beam(kEnds[1], 24), 60.0, {2});
  BeamParameters sprung = test::steel_beam(21);
  sprung.left = {.translational_stiffness = 1e6, .rotational_stiffness = 1e6};
  sprung.tension = 2e5;
  expect_corrected_spectrum(sprung, 100.0, {1, 2, 3});
  expect_corrected_spectrum(held_beam(kEnds[2], 20), 100.0, {1}, Formulation::hermite);
}

/// A run with corrected modes.
struct CorrectedFall : test::Fall {
  CorrectedFall(const std::vector<std::size_t>& named, double gravity, const InitialState& at_start,
                std::vector<Support> under, const std::vector<NodalLoad>& nodal = {})
      : Fall{{.beam = test::steel_beam(20),
              .filter = {.filter_frequency = 100.0},
              .gravity = gravity,
              .loads = nodal,
              .initial = at_start,
              .supports = std::move(under)},
             [&](FilteredStructure& made) {
               made.correct(corrected(exact_modes(made.structure(), made.parameters(), 4), named));
             }} {}
};

class MotionOfModes : public testing::TestWithParam<const char*> {
 private:
  test::Option type_{"-ts_type", GetParam()};
};
INSTANTIATE_TEST_SUITE_P(All, MotionOfModes, testing::Values("rk", "chebyshev", "impact"),
                         [](const auto& tested) { return std::string{tested.param}; });

TEST_P(MotionOfModes, FirstBendingModeVibratesAtItsUnfilteredFrequency) {
  const test::Option tolerance{"-ts_rtol", "1e-12"};
  const BeamParameters parameters = test::steel_beam(20);
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  const test::Eigen exact = test::lumped_modes(beam);
  const double w = std::sqrt(exact.values[2]);
  EXPECT_NEAR(w, 57.4155, 1e-4);
  InitialState initial;
  for (std::size_t i = 0; i < 21; ++i) {
    initial.shape.x.push_back(beam.position(static_cast<PetscInt>(i)));
    initial.shape.offset.push_back(exact.vectors(i, 2));
  }
  const double periods = 40.25;  // ends where the phase is seen best
  const double end = periods * 2.0 * std::numbers::pi / w;
  const test::Option until{"-ts_max_time", std::to_string(end).c_str()};
  CorrectedFall fall{{1}, 0.0, initial, {}};
  EXPECT_EQ(fall.line.frequency_bound(), 100.0);
  test::Recorder record{0.1};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  const MassState masses = fall.dynamics.masses();
  double off = 0.0;
  double largest = 0.0;
  for (std::size_t i = 0; i < masses.position.size(); ++i) {
    const double shape = exact.vectors(static_cast<std::size_t>(fall.beam.begin()) + i, 2);
    off = std::max(off, std::abs(masses.position[i] - shape * std::cos(w * fall.dynamics.time())));
    largest = std::max(largest, std::abs(shape));
  }
  MPI_Allreduce(MPI_IN_PLACE, &off, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  EXPECT_LT(off / largest / (w * end), 1e-8);  // phase over what it has turned: relative error of the frequency
  EXPECT_LT(std::abs(record.energies.back().drift()), 1e-9);
  for (std::size_t i = 0; i < record.lines.back().size(); ++i) {  // the line is where the masses are
    EXPECT_NEAR(record.lines.back()[i], record.positions.back()[i], 1e-8 * largest);
  }
}

/// Impacts, a table of loads with kinks, a mode below wf and one above, gravity: nothing of the energy may be lost.
TEST_P(MotionOfModes, KeepsItsEnergyWithCorrectedModes) {
  const bool impact = std::string{GetParam()} == "impact";
  const test::Option tolerance{"-ts_rtol", impact ? "1e-10" : "1e-11"};
  const test::Option end{"-ts_max_time", "0.5"};
  const NodalLoad load{.position = 3.0, .table = time_table({0.05, 0.123, 0.3}, {0.0, 40000.0, -10000.0})};
  const InitialState initial{.height = 0.2, .slope = 0.02};
  struct Try {
    std::vector<std::size_t> named;
    double restitution;
  };
  for (const auto& [named, e] : {Try{{1}, 1.0}, Try{{1, 3}, 1.0}, Try{{1, 3}, 0.2}}) {
    const std::vector<Support> supports{{.position = 2.0, .restitution = e},
                                        {.position = 8.0, .width = 1.0, .restitution = e}};
    CorrectedFall fall{named, 9.81, initial, supports, {load}};
    test::Recorder record{0.0123};
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
    EXPECT_GT(fall.dynamics.counts().impacts, 5);
    EXPECT_GT(std::abs(record.energies.back().load_work), 0.01 * record.energies.back().scale);
    double worst = 0.0;
    for (const EnergyLedger& ledger : record.energies) {
      worst = std::max(worst, std::abs(ledger.drift()));
    }
    // The integrators' own, as without corrected modes (verification.motion): 1e-9 of exact impacts; of the impact
    // integrator the step error through impacts adds up. Between steps its line is a polynomial, which an impact
    // kinks: the worst row is one beside an impact, and at rtol 1e-9, 1e-10, 5e-11, 2e-11 it scatters by where the rows
    // fall, 7e-7, 1.1e-6, 2e-7, 1.0e-6; it does not follow the tolerance, as the ends of steps do.
    EXPECT_EQ(e < 1.0, fall.dynamics.counts().rests > 0);
    EXPECT_LT(worst, impact ? 2e-6 : 1e-9) << named.size();
    EXPECT_LT(std::abs(record.energies.back().drift()), impact ? 1e-7 : 1e-9) << named.size();
  }
}

}  // namespace
}  // namespace udar
