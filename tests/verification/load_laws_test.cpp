// ranks: 1 2; size: medium
/// @file
/// Forces by a formula - harmonic, random, a pressure pulse - as tables and on beams, against closed forms; a beam that
/// starts turning about its hinge.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include "support/steel_beam.hpp"
#include "support/world.hpp"

namespace udar {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kAll = std::numeric_limits<double>::infinity();

/// Of a table between two times, exactly.
double impulse_of(const TimeTable& table, double from, double to) {
  double sum = 0.0;
  table.each_piece(
      from, to, [&](double begin, double end) { sum += (end - begin) * table.at({0.5 * (begin + end), begin}).value; });
  return sum;
}

/// The largest difference to a formula within a time.
double largest_error(const TimeTable& table, const std::function<double(double)>& formula, double from, double to) {
  double largest = 0.0;
  for (int i = 1; i < 4000; ++i) {
    const double time = from + (to - from) * i / 4000.0;
    largest = std::max(largest, std::abs(table.at(time).value - formula(time)));
  }
  return largest;
}

TEST(LawTables, OfHarmonicsKeepTheirAccuracyAndTheirImpulse) {
  const double w = 2.0 * kPi * 7.0;
  for (const double accuracy : {1e-2, 1e-4, 1e-6}) {
    const TimeLaw law{.start = 0.02, .amplitude = 30.0, .frequency = 7.0, .phase = 0.4, .accuracy = accuracy};
    const auto table = law_table(law, 0.5);
    const auto formula = [&](double t) { return 30.0 * std::sin(w * (t - 0.02) + 0.4); };
    const double error = largest_error(*table, formula, 0.02, 0.5) / 30.0;
    EXPECT_LT(error, accuracy);
    EXPECT_GT(error, 0.9 * accuracy);  // rows are not wasted
    EXPECT_EQ(table->at(0.0199).value, 0.0);
    EXPECT_NEAR(table->at(0.02).value, formula(0.02), 30.0 * accuracy);  // at once
    // The mean over a piece is off by h^4 f'''' / 120, with (w h)^2 = 12 accuracy.
    const double last = table->time().back();
    const double exact = 30.0 / w * (std::cos(0.4) - std::cos(w * (last - 0.02) + 0.4));
    EXPECT_NEAR(impulse_of(*table, 0.02, last), exact, 1.3 * accuracy * accuracy * exact + 1e-14) << accuracy;
  }
}

TEST(LawTables, OfSweepsAndPulsesEndWhereTheyAreToldTo) {
  const TimeLaw sweep{.start = 0.1, .until = 1.1, .amplitude = 2.0, .frequency = 5.0, .last_frequency = 2.0};
  const auto formula = [](double t) {
    return 2.0 * std::sin(2.0 * kPi * ((t - 0.1) * 5.0 - 1.5 * (t - 0.1) * (t - 0.1)));
  };
  const auto swept = law_table(sweep, 2.0);
  EXPECT_LT(largest_error(*swept, formula, 0.1, 1.1), 2e-4);
  EXPECT_EQ(swept->at(1.2).value, 0.0);
  // A run that ends earlier has the same rows.
  const auto shorter = law_table(sweep, 0.4);
  ASSERT_LT(shorter->time().size(), swept->time().size() / 2);
  for (std::size_t row = 0; row < shorter->time().size(); ++row) {
    ASSERT_EQ(shorter->time()[row], swept->time()[row]);
    ASSERT_EQ(shorter->value()[row], swept->value()[row]);
  }
  for (const double b : {0.0, 1.3}) {
    for (const double until : {0.25, 0.7}) {  // the end of the positive phase, and later
      const TimeLaw pulse{
          .course = Course::friedlander, .start = 0.05, .until = until, .amplitude = -4e3, .duration = 0.2, .decay = b};
      const auto table = law_table(pulse, 5.0);
      const auto law = [&](double t) { return -4e3 * (1.0 - (t - 0.05) / 0.2) * std::exp(-b * (t - 0.05) / 0.2); };
      EXPECT_LT(largest_error(*table, law, 0.05, until), 4e3 * 1.0001e-4);
      const double s = (until - 0.05) / 0.2;
      const double exact = b == 0.0 ? s - 0.5 * s * s
                                    : (1.0 - std::exp(-b * s)) / b - (1.0 - std::exp(-b * s) * (1.0 + b * s)) / (b * b);
      EXPECT_NEAR(impulse_of(*table, 0.0, 1.0), -4e3 * 0.2 * exact, 4e3 * 0.2 * 1e-8);
      EXPECT_EQ(table->at(until + 1e-9).value, 0.0);
      EXPECT_TRUE(b > 0.0 || table->time().size() <= 4);  // two lines, and jumps at their ends
    }
  }
}

TEST(LawTables, OfRandomForcesHaveTheVarianceOfTheirSpectrum) {
  TimeLaw law{.course = Course::random, .at = {2.0, 10.0, 30.0}, .density = {0.0, 6.0, 1.0}, .seed = 5, .period = 10.0};
  const double variance = 0.5 * 8.0 * 6.0 + 20.0 * 3.5;
  const auto table = law_table(law, 10.0);
  // Over a period lines are orthogonal: what is left is the error of the table, all of whose rows are even.
  double sum = 0.0;
  double mean = 0.0;
  constexpr int kSamples = 100000;
  for (int i = 0; i < kSamples; ++i) {
    const double value = table->at(10.0 * (i + 0.5) / kSamples).value;
    sum += value * value / kSamples;
    mean += value / kSamples;
  }
  EXPECT_NEAR(sum, variance, 1e-4 * variance);
  EXPECT_NEAR(mean, 0.0, 1e-4);
  // In half of it the variance is one of a sample: the standard deviation of that of Gaussian noise of a bandwidth B
  // over a time T is about variance / sqrt(B T).
  double half = 0.0;
  for (int i = 0; i < kSamples / 2; ++i) {
    half += 2.0 * std::pow(table->at(10.0 * (i + 0.5) / kSamples).value, 2) / kSamples;
  }
  EXPECT_NEAR(half, variance, 3.0 * variance / std::sqrt(20.0 * 5.0));
  EXPECT_GT(std::abs(half - variance), 1e-3 * variance);
  // Another seed, another force; the same everywhere, up to the last digits of cosines.
  const auto again = law_table(law, 10.0);
  EXPECT_TRUE(std::ranges::equal(table->value(), again->value()));
  EXPECT_NEAR(table->value()[0], -1.4332753271135, 1e-9);
  EXPECT_NEAR(table->value()[1000], 16.0549597715369, 1e-9);
  std::array<double, 2> ends{table->value()[777], -table->value()[777]};
  MPI_Allreduce(MPI_IN_PLACE, ends.data(), 2, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  EXPECT_EQ(ends[0], -ends[1]);
  law.seed = 6;
  const auto other = law_table(law, 10.0);
  EXPECT_GT(std::abs(other->value()[0] - table->value()[0]), 1e-3);
  EXPECT_GT(std::abs(other->value()[1000] - table->value()[1000]), 1e-3);
}

TEST(LawTables, RefuseWhatIsNone) {
  const TimeLaw good{.until = 1.0, .amplitude = 1.0, .frequency = 5.0};
  const auto refused = [](const TimeLaw& law, double end = 1.0) {
    return test::failure_of<InputError>([&] { static_cast<void>(law_table(law, end)); });
  };
  EXPECT_EQ(refused(good), "");
  TimeLaw law = good;
  law.frequency = 0.0;
  EXPECT_NE(refused(law).find("load frequency: 0"), std::string::npos);
  law = good;
  law.start = 2.0;
  EXPECT_NE(refused(law).find("load until: 1"), std::string::npos);
  law = good;
  law.until = kAll;
  EXPECT_EQ(refused(law), "");
  EXPECT_NE(refused(law, 1e7).find("rows, "), std::string::npos);
  law.last_frequency = 3.0;
  EXPECT_NE(refused(law).find("load until: inf"), std::string::npos);
  law = {.course = Course::friedlander, .until = 1.0, .amplitude = 1.0};
  EXPECT_NE(refused(law).find("load duration: 0"), std::string::npos);
  law = {.course = Course::random, .at = {1.0, 1.0}, .density = {1.0, 1.0}, .period = 1.0};
  EXPECT_NE(refused(law).find("load spectrum"), std::string::npos);
  law.at = {0.1, 0.2};
  EXPECT_NE(refused(law).find("load period: 1"), std::string::npos);  // no line within
  law.at = {1.0, 1e9};
  EXPECT_NE(refused(law).find("load period: 1"), std::string::npos);  // too many
}

class Laws : public testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] static bool modal() { return std::string_view{GetParam()} == "modal"; }
  [[nodiscard]] static FilterParameters filter(double frequency) {
    return modal() ? test::unfiltered(1e-4) : FilterParameters{.filter_frequency = frequency};
  }

 private:
  test::Option type_{"-ts_type", GetParam()};
  test::Option modes_{"-modal_modes", "16"};
  test::Option tolerance_{"-ts_rtol", std::string_view{GetParam()} == "chebyshev" ? "1e-12" : "1e-10"};
};

INSTANTIATE_TEST_SUITE_P(All, Laws, testing::Values("chebyshev", "impact", "rk", "modal"),
                         [](const auto& tested) { return std::string{tested.param}; });

/// A load whose table is made of its law.
NodalLoad load_of(double position, const TimeLaw& law, double end) {
  return {.position = position, .table = law_table(law, end), .law = law};
}

/// Largest difference of the line to a formula, of the largest value of that; energy is kept.
double largest_off(const ModelParameters& parameters, double end,
                   const std::function<double(double, double)>& formula) {
  const std::string until = std::to_string(end);
  const test::Option option{"-ts_max_time", until.c_str()};
  test::Fall fall{parameters};
  test::Recorder record{end / 20.0};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  std::array<double, 2> most{};
  for (std::size_t k = 0; k < record.times.size(); ++k) {
    for (std::size_t i = 0; i < record.lines[k].size(); ++i) {
      const double x = fall.beam.position(fall.beam.begin() + static_cast<PetscInt>(i));
      const double expected = formula(x, record.times[k]);
      most[0] = std::max(most[0], std::abs(expected));
      most[1] = std::max(most[1], std::abs(record.lines[k][i] - expected));
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, most.data(), 2, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  EXPECT_GT(most[0], 1e-3);
  EXPECT_LT(record.largest_drift(), 1e-9);
  return most[1] / most[0];
}

BeamParameters simple_beam(PetscInt elements) {
  BeamParameters beam = test::steel_beam(elements);
  beam.left = test::kPinned;
  beam.right = test::kPinned;
  return beam;
}

/// Sum over the modes of a simply supported beam. @param answer of a mode: (number, its frequency [rad/s]) to
/// displacement, of a modal force of mass 1
double modal_sum(const BeamSegment& beam, double x, const std::function<double(int, double)>& answer) {
  double sum = 0.0;
  for (int n = 1; n < 60; ++n) {
    const double wave = n * kPi / beam.length;
    sum += std::sin(wave * x) * answer(n, wave * wave * std::sqrt(beam.bending_stiffness / beam.mass_per_length));
  }
  return 2.0 / (beam.mass_per_length * beam.length) * sum;
}

/// What starts under a harmonic force at rest swings steadily and freely: both closed.
TEST_P(Laws, HarmonicForceShakesASimplySupportedBeamAsTheSeriesSays) {
  constexpr double kForce = 2e3;
  constexpr double kAt = 3.0;
  constexpr double kFrequency = 9.0;
  const double w = 2.0 * kPi * kFrequency;
  const BeamParameters beam = simple_beam(40);
  const BeamSegment segment = beam.segments[0];
  const TimeLaw law{.amplitude = kForce, .frequency = kFrequency, .accuracy = 1e-3};
  const double off = largest_off(
      {.beam = beam, .filter = filter(2000.0), .gravity = 0.0, .loads = {load_of(kAt, law, 0.15)}, .initial = {}}, 0.15,
      [&](double x, double t) {
        return kForce * modal_sum(segment, x, [&](int n, double own) {
                 return std::sin(n * kPi * kAt / segment.length) / (own * own - w * w) *
                        (std::sin(w * t) - w / own * std::sin(own * t));
               });
      });
  // Found: 3.1e-6, and 2.1e-3 with the filter, which takes (w / wf)^2 / 2 of each mode.
  EXPECT_LT(off, modal() ? 1e-5 : 2.5e-3);
}

/// The filter's oscillator has one closed frequency: what is left is the table's, of the second order in its accuracy
/// where inertia answers, as its error has no mean.
TEST(LawsOnAMass, AreAnsweredToTheSquareOfTheirAccuracy) {
  if (test::world_size() > 1) {
    GTEST_SKIP() << "one element is for one rank";
  }
  const test::TipMass tip{.filter_frequency = 400.0};
  const double lambda = tip.lambda();
  const double stiffness = 3.0 * tip.beam.segments[0].bending_stiffness / 1000.0;
  const double w = 3.0 * lambda;
  constexpr double kForce = 1e4;
  const test::Option end{"-ts_max_time", "0.5"};
  std::array<double, 2> off{};
  for (const std::size_t fine : {0U, 1U}) {
    const TimeLaw law{.amplitude = kForce, .frequency = w / (2.0 * kPi), .accuracy = fine == 0 ? 1e-2 : 1e-4};
    test::Fall fall{tip.beam, tip.filter_frequency, 0.0, {}, {}, {}, {load_of(10.0, law, 0.5)}};
    test::Recorder record{0.01};
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
    for (std::size_t k = 0; k < record.times.size(); ++k) {
      const double t = record.times[k];
      const double expected = kForce / stiffness * lambda * lambda / (lambda * lambda - w * w) *
                              (std::sin(w * t) - w / lambda * std::sin(lambda * t));
      if (!record.positions[k].empty()) {
        off.at(fine) = std::max(off.at(fine), std::abs(record.positions[k].back() - expected) / (kForce / stiffness));
      }
    }
    MPI_Allreduce(MPI_IN_PLACE, &off.at(fine), 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
    EXPECT_LT(record.largest_drift(), 1e-9);
  }
  EXPECT_LT(off[0], 1e-4);
  EXPECT_LT(off[1], 1e-8);
  EXPECT_GT(off[0], 1e3 * off[1]);  // 1e4 but for what rounding adds
}

/// Even pressure on all of the beam: each mode by Duhamel's integral, closed for an exponential times a line.
TEST_P(Laws, PressurePulseBlowsASimplySupportedBeamAsTheIntegralSays) {
  constexpr double kPeak = -5e4;     // [Pa]
  constexpr double kBreadth = 0.2;   // [m]
  constexpr double kArrival = 0.01;  // [s]
  constexpr double kDuration = 0.03;
  constexpr double kDecay = 1.5;
  const BeamParameters beam = simple_beam(40);
  const BeamSegment segment = beam.segments[0];
  const TimeLaw law{.course = Course::friedlander,
                    .start = kArrival,
                    .until = kArrival + kDuration,
                    .amplitude = kPeak,
                    .duration = kDuration,
                    .decay = kDecay};
  NodalLoad load = load_of(5.0, law, 0.06);
  load.width = kAll;
  load.breadth = kBreadth;
  const double off =
      largest_off({.beam = beam, .filter = filter(2000.0), .gravity = 0.0, .loads = {load}, .initial = {}}, 0.06,
                  [&](double x, double t) {
                    const double until = std::min(t - kArrival, kDuration);
                    return kPeak * kBreadth * modal_sum(segment, x, [&](int n, double own) {
                             const double share = segment.length / (n * kPi) * (1.0 - std::cos(n * kPi));
                             if (until <= 0.0 || n % 2 == 0) {
                               return 0.0;
                             }
                             double sum = 0.0;  // Simpson
                             constexpr int kPieces = 400;
                             for (int i = 0; i <= kPieces; ++i) {
                               const double s = until * i / kPieces;
                               const double weight = i == 0 || i == kPieces ? 1.0 : i % 2 == 1 ? 4.0 : 2.0;
                               sum += weight * (1.0 - s / kDuration) * std::exp(-kDecay * s / kDuration) *
                                      std::sin(own * (t - kArrival - s));
                             }
                             return share * sum * until / (3.0 * kPieces) / own;
                           });
                  });
  // Found: 5.7e-4, the bending of elements under an even load, 0.8 / n^2 of the sag; 3.0e-3 with the filter, whose
  // line jumps with the pressure.
  EXPECT_LT(off, modal() ? 7e-4 : 3.5e-3);
}

/// A pinned beam that turns about its hinge goes on doing so, with the energy m L^2 w^2 / 6 of a rod but for its
/// lumping.
TEST(Pivot, AHingedBeamTurnsAboutItsEndAndStrikesWithItsTip) {
  const test::Option type{"-ts_type", "chebyshev"};
  const test::Option end{"-ts_max_time", "0.4"};
  constexpr double kTurning = -0.3;  // [rad/s]
  constexpr PetscInt kElements = 20;
  BeamParameters beam = test::steel_beam(kElements);
  beam.left = test::kPinned;
  const double inertia = beam.segments[0].mass_per_length * 1000.0 / 3.0 * (1.0 + 0.5 / (kElements * kElements));
  test::Fall fall{{.beam = beam,
                   .filter = {.filter_frequency = 300.0},
                   .gravity = 0.0,
                   .initial = {.angular_velocity = kTurning, .pivot = Place{}},
                   .supports = {{.position = 10.0, .height = -0.6, .restitution = 1.0}}}};
  test::Recorder record{0.05};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  EXPECT_NEAR(record.energies[0].kinetic, 0.5 * inertia * kTurning * kTurning, 1e-12 * inertia);
  const auto turning_of = [&](std::size_t row) {  // about the hinge
    double sum = 0.0;
    for (std::size_t i = 0; i < record.velocities[row].size(); ++i) {
      sum += fall.line.mass()[i] * record.velocities[row][i] *
             fall.beam.position(fall.beam.begin() + static_cast<PetscInt>(i));
    }
    MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    return sum;
  };
  for (std::size_t k = 0; record.times[k] < 0.19; ++k) {  // the tip is there at 0.2 s
    for (std::size_t i = 0; i < record.lines[k].size(); ++i) {
      const double x = fall.beam.position(fall.beam.begin() + static_cast<PetscInt>(i));
      EXPECT_NEAR(record.lines[k][i], kTurning * record.times[k] * x, 1e-12);
    }
    EXPECT_NEAR(turning_of(k), inertia * kTurning, 1e-11 * inertia);
  }
  const std::size_t last = record.times.size() - 1;
  const double impulse = record.support_impulses[last][0];
  EXPECT_GT(impulse, 10.0);
  EXPECT_LT(record.largest_drift(), 1e-9);
  // The line holds no turning of its own: all comes from the support, but for what is in the hinge's own mass, none.
  EXPECT_NEAR(turning_of(last), inertia * kTurning + 10.0 * impulse, 1e-9 * inertia);
}

TEST(Pivot, IsRefusedWhereSomethingHeldWouldMove) {
  BeamParameters beam = test::steel_beam(10);
  beam.left = test::kPinned;
  const auto refused = [&](double at) {
    return test::failure_of<InputError>([&] {
      const test::Fall fall{{.beam = beam,
                             .filter = {.filter_frequency = 300.0},
                             .initial = {.angular_velocity = 1.0, .pivot = Place{.x = at}}}};
    });
  };
  EXPECT_EQ(refused(0.0), "");
  EXPECT_NE(refused(5.0).find("initial pivot: a place that is held would start with 5 m/s"), std::string::npos);
}

}  // namespace
}  // namespace udar
