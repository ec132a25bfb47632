// ranks: 1 2; size: medium
/// @file
/// The Chebyshev series of the free motion against the exact solution by eigenvectors.

#include "udar/integrators/free_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>

#include "support/dense.hpp"
#include "support/steel_beam.hpp"

namespace udar {
namespace {

/// Exact motion of z'' = -A z + a0 + t j0, resting masses left out: A from solves of unit vectors, its eigenvectors
/// from LAPACK.
struct Exact {
  std::vector<std::size_t> free;
  std::vector<double> root_mass;
  test::Eigen modes{.values = {}, .vectors = test::Dense{0}};

  Exact(FilteredStructure& line, const std::vector<std::int32_t>& resting) {
    const BeamChain& beam = *line.structure().chain();
    const auto n = static_cast<std::size_t>(beam.nodes());
    const auto first = static_cast<std::size_t>(beam.begin());
    const auto count = static_cast<std::size_t>(beam.local_nodes());
    for (std::size_t i = 0; i < n; ++i) {
      root_mass.push_back(std::sqrt(beam.mass(static_cast<PetscInt>(i))));
      if (resting[i] == 0) {
        free.push_back(i);
      }
    }
    test::Dense all{n};
    for (std::size_t j = 0; j < n; ++j) {
      std::vector<double> unit(count);
      std::vector<double> stretch(count);
      if (j >= first && j < first + count) {
        unit[j - first] = 1.0;
      }
      line.solve(unit, {}, stretch, {});
      for (std::size_t i = 0; i < count; ++i) {
        all(first + i, j) = -line.filter_frequency() * line.filter_frequency() * stretch[i];
      }
    }
    MPI_Allreduce(MPI_IN_PLACE, all.values.data(), static_cast<int>(n * n), MPI_DOUBLE, MPI_SUM, beam.comm());
    test::Dense scaled{free.size()};
    for (std::size_t i = 0; i < free.size(); ++i) {
      for (std::size_t j = 0; j < free.size(); ++j) {
        const auto entry = [&](std::size_t a, std::size_t b) { return all(a, b) * root_mass[a] / root_mass[b]; };
        scaled(i, j) = 0.5 * (entry(free[i], free[j]) + entry(free[j], free[i]));
      }
    }
    modes = test::eigen(scaled);
  }

  /// What f(sqrt(A)) makes of x.
  [[nodiscard]] std::vector<double> apply(const std::function<double(double)>& f, const std::vector<double>& x) const {
    std::vector<double> result(x.size());
    for (std::size_t mode = 0; mode < free.size(); ++mode) {
      double share = 0.0;
      for (std::size_t i = 0; i < free.size(); ++i) {
        share += modes.vectors(i, mode) * root_mass[free[i]] * x[free[i]];
      }
      share *= f(std::sqrt(std::max(modes.values[mode], 0.0)));
      for (std::size_t i = 0; i < free.size(); ++i) {
        result[free[i]] += share * modes.vectors(i, mode) / root_mass[free[i]];
      }
    }
    return result;
  }
};

double sine(double w, double t) { return w * t < 1e-4 ? t : std::sin(w * t) / w; }
double versine(double w, double t) { return w * t < 1e-4 ? 0.5 * t * t : (1.0 - std::cos(w * t)) / (w * w); }
double cubic(double w, double t) {
  return w * t < 1e-2 ? t * t * t / 6.0 * (1.0 - w * w * t * t / 20.0) : (t - std::sin(w * t) / w) / (w * w);
}

std::size_t terms_for(const FreeMotion& motion, double duration, double tolerance) {
  std::size_t terms = 2;
  while (motion.reach(terms, tolerance) < duration) {
    ++terms;
  }
  return terms;
}

TEST(FreeMotion, IsTheExactMotionWithLoadsAndRests) {
  const double wf = 100.0;
  BeamParameters parameters = test::steel_beam(40);
  parameters.segments[0].foundation_stiffness = 3e4;
  parameters.right = test::kPinned;
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  FilteredStructure line{beam, {.filter_frequency = wf}};
  const auto n = static_cast<std::size_t>(beam.nodes());
  std::vector<double> velocity(n);
  std::vector<double> acceleration(n);
  std::vector<double> jerk(n);
  std::vector<std::int32_t> resting(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double x = static_cast<double>(i) / static_cast<double>(n);
    resting[i] = i == 7 || i == 8 || i + 1 == n ? 1 : 0;
    velocity[i] = resting[i] != 0 ? 0.0 : -4.0 + 3.0 * std::sin(9.0 * x);
    acceleration[i] = resting[i] != 0 ? 0.0 : -9.81 + 200.0 * std::cos(5.0 * x);
    jerk[i] = resting[i] != 0 ? 0.0 : 1e4 * x;
  }
  const Exact exact{line, resting};
  const auto local = [&](const auto& all) { return std::vector(all.begin() + beam.begin(), all.begin() + beam.end()); };
  const auto v = local(velocity);
  const auto a = local(acceleration);
  const auto j = local(jerk);
  const auto r = local(resting);
  FreeMotion motion{line};
  for (const double angle : {0.5, 4.0, 16.0}) {
    const double duration = angle / wf;
    const double tolerance = 1e-11;
    const auto terms = terms_for(motion, duration, tolerance);
    const PetscInt before = line.solves();
    motion.start({.velocity = v, .acceleration = a, .jerk = j, .resting = r});
    motion.extend(terms);
    EXPECT_EQ(line.solves() - before, static_cast<PetscInt>(3 * (terms - 1)));
    std::vector<double> moved(v.size());
    for (const double t : {0.0, 0.3 * duration, duration}) {
      const auto sum = [&](const auto& of_v, const auto& of_a, const auto& of_j) {
        std::vector<double> total = exact.apply(of_v, velocity);
        const std::vector<double> second = exact.apply(of_a, acceleration);
        const std::vector<double> third = exact.apply(of_j, jerk);
        for (std::size_t i = 0; i < n; ++i) {
          total[i] += second[i] + third[i];
        }
        return total;
      };
      const auto displacement = sum([t](double w) { return sine(w, t); }, [t](double w) { return versine(w, t); },
                                    [t](double w) { return cubic(w, t); });
      const auto speed = sum([t](double w) { return std::cos(w * t); }, [t](double w) { return sine(w, t); },
                             [t](double w) { return versine(w, t); });
      const auto pull = sum([t](double w) { return -w * std::sin(w * t); }, [t](double w) { return std::cos(w * t); },
                            [t](double w) { return sine(w, t); });
      // The tolerance, and the round-off of the reference: 1e-12 of 7 m/s times t and of 7 m/s, wf times that.
      const double bound = tolerance + 1e-12;
      const auto begin = static_cast<std::size_t>(beam.begin());
      const auto place = motion.weights(0, t);
      const auto rate = motion.weights(1, t);
      const auto second_rate = motion.weights(2, t);
      motion.at(place, moved);
      for (std::size_t i = 0; i < v.size(); ++i) {
        EXPECT_NEAR(moved[i], displacement[begin + i], bound * 10.0 * duration) << angle << ' ' << t;
        EXPECT_NEAR(motion.at(place, i), moved[i], 1e-15 * 10.0 * duration);
        EXPECT_NEAR(motion.at(rate, i), speed[begin + i], bound * 10.0 * std::max(1.0, angle)) << angle << ' ' << t;
        EXPECT_NEAR(motion.at(second_rate, i), pull[begin + i], bound * 10.0 * wf * std::max(1.0, angle));
      }
      // The integral of the motion against Simpson's rule on its halves: h^5 / 2880 times the fourth derivative.
      const std::size_t middle = v.size() / 2;
      const auto value = [&](double time) { return motion.at(motion.weights(0, time), middle); };
      double simpson = 0.0;
      constexpr int kParts = 64;
      for (int part = 0; part < kParts; ++part) {
        const double h = t / kParts;
        simpson += h / 6.0 * (value(part * h) + 4.0 * value((part + 0.5) * h) + value((part + 1) * h));
      }
      EXPECT_NEAR(motion.at(motion.weights(-1, t), middle), simpson, 1e-8 * 10.0 * duration * duration);
      // What resting masses feel: the line solve of the displacement.
      std::vector<double> stretch(v.size());
      line.solve(moved, {}, stretch, {});
      for (std::size_t i = 0; i < v.size(); ++i) {
        if (r[i] != 0) {
          EXPECT_NEAR(motion.stretch(place, i), stretch[i], 1e-9 * 10.0 * duration) << angle << ' ' << t;
        }
      }
    }
  }
}

/// Whether the series of a motion ends at its first terms.
/// @param time [s] @param negligible way that may be left out in it [m]
bool ends(FreeMotion& motion, const std::vector<double>& velocity, const std::vector<double>& acceleration,
          double time = 1.0, double negligible = 0.0) {
  motion.start({.velocity = velocity, .acceleration = acceleration, .jerk = {}, .resting = {}});
  motion.answer();
  FreeMotion::Sizes sizes = motion.first_sizes();
  MPI_Allreduce(MPI_IN_PLACE, sizes.data(), static_cast<int>(sizes.size()), MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  motion.end_if_rigid(sizes, time, negligible);
  motion.extend(8);
  return motion.rigid();
}

/// A beam that falls, at rest until a test gives it a velocity.
struct Falling {
  BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(40)};
  FilteredStructure line{beam, {.filter_frequency = 100.0}};
  FreeMotion motion{line};
  std::vector<double> velocity = std::vector<double>(static_cast<std::size_t>(beam.local_nodes()));
  std::vector<double> acceleration = std::vector<double>(velocity.size(), -test::kGravity);

  [[nodiscard]] double place(std::size_t i) const { return beam.position(beam.begin() + static_cast<PetscInt>(i)); }
};

TEST(FreeMotion, OfARigidBeamEndsAtItsFirstTerms) {
  Falling fall;
  auto& [beam, line, motion, velocity, acceleration] = fall;
  const std::size_t count = velocity.size();
  for (std::size_t i = 0; i < count; ++i) {
    velocity[i] = 2.0 - 0.3 * (fall.place(i) - 5.0);
  }
  const PetscInt before = line.solves();
  EXPECT_TRUE(ends(motion, velocity, acceleration));
  EXPECT_EQ(line.solves() - before, 2);
  const double t = 0.7;  // wf t = 70
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_NEAR(motion.at(motion.weights(0, t), i), velocity[i] * t - 0.5 * test::kGravity * t * t, 1e-14);
    EXPECT_NEAR(motion.at(motion.weights(-1, t), i), velocity[i] * t * t / 2.0 - test::kGravity * t * t * t / 6.0,
                1e-14);
    EXPECT_NEAR(motion.at(motion.weights(1, t), i), velocity[i] - test::kGravity * t, 1e-14);
    EXPECT_NEAR(motion.at(motion.weights(2, t), i), -test::kGravity, 1e-14);
  }
  // A vibration of a billionth of the motion goes on.
  std::vector<double> vibrating(velocity);
  for (std::size_t i = 0; i < count; ++i) {
    vibrating[i] += 2e-9 * std::cos(2.0 * M_PI * fall.place(i) / 10.0);
  }
  EXPECT_FALSE(ends(motion, vibrating, acceleration));
}

TEST(FreeMotion, IsRigidWhereItsVibrationGoesNoWay) {
  Falling fall;
  auto& [beam, line, motion, velocity, acceleration] = fall;
  const std::size_t count = velocity.size();
  for (std::size_t i = 0; i < count; ++i) {
    velocity[i] = 1e-6 * std::cos(2.0 * M_PI * fall.place(i) / 10.0);
  }
  const double t = 1.0 / line.filter_frequency();
  EXPECT_FALSE(ends(motion, velocity, acceleration, t));
  motion.extend(terms_for(motion, t, 1e-14));
  double way = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double rigid = velocity[i] * t - 0.5 * test::kGravity * t * t;
    way = std::max(way, std::abs(motion.at(motion.weights(0, t), i) - rigid));
  }
  MPI_Allreduce(MPI_IN_PLACE, &way, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
  EXPECT_GT(way, 1e-12);
  EXPECT_FALSE(ends(motion, velocity, acceleration, t, way));  // no bound of the way is less than it
  EXPECT_TRUE(ends(motion, velocity, acceleration, t, 1.1 * way));
  EXPECT_FALSE(ends(motion, velocity, acceleration, 2.0 * t, 4.0 * way));
}

TEST(FreeMotion, NeedsFewSolves) {
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(20)};
  FilteredStructure line{beam, {.filter_frequency = 50.0}};
  const FreeMotion motion{line};
  // Solves of the two sequences per unit wf t at 1e-9.
  EXPECT_LE(2.0 * static_cast<double>(terms_for(motion, 4.0 / 50.0, 1e-9) - 1) / 4.0, 4.0);
  EXPECT_LT(2.0 * static_cast<double>(terms_for(motion, 16.0 / 50.0, 1e-9) - 1) / 16.0, 2.5);
}

}  // namespace
}  // namespace udar
