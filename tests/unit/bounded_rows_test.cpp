// ranks: 1; size: short
/// @file
/// Complementarity problems with bounds on both sides against hand solutions and their own conditions.

#include "udar/numerics/bounded_rows.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

TEST(BoundedRows, BringsAValueBackToTheBoundThatItPasses) {
  BoundedRows rows{{2.0}, 1};
  std::vector<double> x(1);
  EXPECT_TRUE(rows.solve({.value = std::vector{-5.0}, .lower = std::vector{-1.0}, .upper = std::vector{1.0}}, x));
  EXPECT_DOUBLE_EQ(x[0], 2.0);
  EXPECT_TRUE(rows.solve({.value = std::vector{5.0}, .lower = std::vector{-1.0}, .upper = std::vector{1.0}}, x));
  EXPECT_DOUBLE_EQ(x[0], -2.0);
  EXPECT_FALSE(rows.solve({.value = std::vector{0.9}, .lower = std::vector{-1.0}, .upper = std::vector{1.0}}, x));
  EXPECT_EQ(x[0], 0.0);
}

TEST(BoundedRows, RowsAtInfinityAreLeftAlone) {
  BoundedRows rows{{1.0, 0.5, -0.5, 1.0}, 2};
  std::vector<double> x(2);
  rows.solve({.value = std::vector{kNone, -3.0}, .lower = std::vector{0.0, -1.0}, .upper = std::vector{kNone, 1.0}}, x);
  EXPECT_EQ(x[0], 0.0);
  EXPECT_DOUBLE_EQ(x[1], 2.0);
}

TEST(BoundedRows, RefusesWhatIsNotANumber) {
  BoundedRows rows{{1.0}, 1};
  std::vector<double> x(1);
  EXPECT_THROW(
      rows.solve({.value = std::vector{std::nan("")}, .lower = std::vector{0.0}, .upper = std::vector{1.0}}, x),
      SolveError);
}

/// Forces and rotations: symmetric blocks on the diagonal, one skew beside them.
std::vector<double> skew_matrix(std::mt19937& random, std::size_t size, std::size_t forces) {
  std::normal_distribution<double> number;
  std::vector<double> factor(size * size);
  std::ranges::generate(factor, [&] { return number(random); });
  std::vector<double> matrix(size * size, 0.0);
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = 0; j < size; ++j) {
      for (std::size_t k = 0; k < size; ++k) {
        matrix[i * size + j] += factor[i * size + k] * factor[j * size + k];
      }
      matrix[i * size + j] *= i < forces && j >= forces ? -1.0 : 1.0;
    }
    matrix[i * size + i] += 0.1;
  }
  return matrix;
}

TEST(BoundedRows, FindsTheAnswerOfRandomProblems) {
  std::mt19937 random{7};
  std::normal_distribution<double> number{0.0, 3.0};
  std::size_t active = 0;
  std::size_t rows_of_all = 0;
  for (int problem = 0; problem < 20000; ++problem) {
    const std::size_t size = 1 + static_cast<std::size_t>(problem) % 9;
    const std::size_t forces = size / 2;
    const std::vector<double> matrix = skew_matrix(random, size, forces);
    BoundedRows rows{matrix, size};
    std::vector<double> value(size);
    std::vector<double> lower(size, 0.0);
    std::vector<double> upper(size, kNone);
    for (std::size_t i = 0; i < size; ++i) {
      value[i] = number(random);
      if (i >= forces) {
        upper[i] = std::abs(number(random));
        lower[i] = -upper[i];
      }
    }
    std::vector<double> x(size);
    rows.solve({.value = value, .lower = lower, .upper = upper}, x);
    for (std::size_t i = 0; i < size; ++i) {
      double now = value[i];
      double scale = std::abs(value[i]);
      for (std::size_t j = 0; j < size; ++j) {
        now += matrix[i * size + j] * x[j];
        scale = std::max(scale, std::abs(matrix[i * size + j] * x[j]));
      }
      const double rounding = 1e-9 * scale;  // matrices of a condition up to 1e4 and more
      EXPECT_GE(now, lower[i] - rounding);
      EXPECT_LE(now, upper[i] + rounding);
      if (x[i] != 0.0) {
        EXPECT_NEAR(now, x[i] > 0.0 ? lower[i] : upper[i], rounding);
        ++active;
      }
    }
    rows_of_all += size;
  }
  EXPECT_GT(active, rows_of_all / 4) << "these problems must have something to find";
}

}  // namespace
}  // namespace udar
