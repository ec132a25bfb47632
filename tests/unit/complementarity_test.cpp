// ranks: 1; size: short
/// @file
/// The small complementarity problem against hand solutions and its own conditions.

#include "udar/numerics/complementarity.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

TEST(Complementarity, HoldsOnePointOff) {
  Complementarity problem{{2.0}, 1};
  std::vector<double> force(1);
  problem.solve(std::vector{-3.0}, force);
  EXPECT_DOUBLE_EQ(force[0], 1.5);
  problem.solve(std::vector{3.0}, force);
  EXPECT_EQ(force[0], 0.0);
}

TEST(Complementarity, PointLiftedByItsNeighbourIsLeftAlone) {
  // Holding the first point off lifts the second by 1.5: more than its own gap of -1.
  Complementarity problem{{2.0, 1.5, 1.5, 2.0}, 2};
  std::vector<double> force(2);
  problem.solve(std::vector{-2.0, -1.0}, force);
  EXPECT_DOUBLE_EQ(force[0], 1.0);
  EXPECT_EQ(force[1], 0.0);
  EXPECT_EQ(problem.active(), std::vector<std::size_t>{0});
}

TEST(Complementarity, RowsAtInfinityNeverTouch) {
  Complementarity problem{{1.0, -0.5, -0.5, 1.0}, 2};
  std::vector<double> force(2);
  problem.solve(std::vector{-1.0, std::numeric_limits<double>::infinity()}, force);
  EXPECT_DOUBLE_EQ(force[0], 1.0);
  EXPECT_EQ(force[1], 0.0);
}

TEST(Complementarity, RefusesWhatIsNotANumber) {
  Complementarity problem{{1.0}, 1};
  std::vector<double> force(1);
  EXPECT_THROW(problem.solve(std::vector{std::nan("")}, force), SolveError);
}

/// Compliance of a bending line under its points, as stiff problems have it: (1 + s D^2'D^2)^-1 by its eigenvectors.
std::vector<double> bending_compliance(std::size_t size, double stiffness) {
  std::vector<double> matrix(size * size, 0.0);
  const auto count = static_cast<double>(size);
  for (std::size_t k = 0; k < size; ++k) {
    const double angle = M_PI * static_cast<double>(k) / count;
    const double eigenvalue = 1.0 + stiffness * std::pow(2.0 - 2.0 * std::cos(angle), 2);
    for (std::size_t i = 0; i < size; ++i) {
      for (std::size_t j = 0; j < size; ++j) {
        const double weight = (k == 0 ? 1.0 : 2.0) / count;
        matrix[i * size + j] += weight * std::cos(angle * (static_cast<double>(i) + 0.5)) *
                                std::cos(angle * (static_cast<double>(j) + 0.5)) / eigenvalue;
      }
    }
  }
  return matrix;
}

TEST(Complementarity, MeetsItsConditionsForRandomGaps) {
  std::mt19937 random{20261123};  // NOLINT(cert-msc32-c,cert-msc51-cpp): the same in every run
  std::normal_distribution<double> normal{0.3, 1.0};
  for (const std::size_t size : {1U, 2U, 7U, 40U, 120U}) {
    for (const double stiffness : {0.0, 1.0, 1e3, 1e6}) {
      const std::vector<double> matrix = bending_compliance(size, stiffness);
      Complementarity problem{matrix, size};
      std::vector<double> force(size);
      std::vector<double> again(size);
      std::vector<double> result(size);
      for (int trial = 0; trial < 20; ++trial) {
        std::vector<double> gap(size);
        std::ranges::generate(gap, [&] { return normal(random); });
        problem.solve(gap, force);  // from the last active rows
        problem.gaps(gap, force, result);
        double largest = 0.0;
        for (std::size_t i = 0; i < size; ++i) {
          largest = std::max({largest, std::abs(gap[i]), force[i] * matrix[i * size + i]});
        }
        for (std::size_t i = 0; i < size; ++i) {
          EXPECT_GE(force[i], 0.0);
          // 1e-9: units in the last place times the condition of the active block, at most 16e6 here.
          EXPECT_GE(result[i], -1e-9 * largest) << size << ' ' << stiffness;
          EXPECT_LE(std::min(force[i] * matrix[i * size + i], std::abs(result[i])), 1e-9 * largest);
        }
        const std::vector<std::size_t> active = problem.active();
        problem.assume({});
        problem.solve(gap, again);  // from none
        EXPECT_EQ(problem.active(), active);
        EXPECT_EQ(again, force) << "the same rows give the same bits";
      }
    }
  }
}

TEST(Complementarity, ResponseIsTheDerivativeOfTheForces) {
  const std::size_t size = 12;
  Complementarity problem{bending_compliance(size, 10.0), size};
  std::vector<double> gap(size);
  std::vector<double> change(size);
  for (std::size_t i = 0; i < size; ++i) {
    gap[i] = std::cos(static_cast<double>(i));
    change[i] = 1e-6 * std::sin(3.0 * static_cast<double>(i));
  }
  std::vector<double> before(size);
  std::vector<double> after(size);
  std::vector<double> response(size);
  problem.solve(gap, before);
  problem.respond(change, response);
  for (std::size_t i = 0; i < size; ++i) {
    gap[i] += change[i];
  }
  const auto active = problem.active();
  problem.solve(gap, after);
  ASSERT_EQ(problem.active(), active) << "a change this small moves nobody";
  for (std::size_t i = 0; i < size; ++i) {
    EXPECT_NEAR(after[i] - before[i], response[i],
                1e-13);  // linear while nobody changes sides: round-off of forces near 10
  }
}

}  // namespace
}  // namespace udar
