#include "udar/numerics/gap.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace udar {
namespace {

/// Bernstein coefficients of degree 5 of a polynomial given by its monomial coefficients.
std::array<double, 6> bernstein(const std::array<double, 6>& monomial) {
  const std::array<double, 6> choose{1, 5, 10, 10, 5, 1};
  std::array<double, 6> result{};
  for (std::size_t j = 0; j < 6; ++j) {
    double ratio = 1.0;
    for (std::size_t i = 0; i <= j; ++i) {
      result[j] += ratio / choose[i] * monomial[i];
      ratio *= static_cast<double>(j - i) / static_cast<double>(i + 1);
    }
  }
  return result;
}

TEST(StepPolynomial, ReproducesADegreeFiveMotionAndItsDerivatives) {
  const auto motion = [](double t) {
    return Kinematics{.position = 1.0 + t * (2.0 + t * (-3.0 + t * (0.5 + t * (0.25 - 0.125 * t)))),
                      .velocity = 2.0 + t * (-6.0 + t * (1.5 + t * (1.0 - 0.625 * t))),
                      .acceleration = -6.0 + t * (3.0 + t * (3.0 - 2.5 * t))};
  };
  const double h = 0.7;
  const StepPolynomial step{motion(0.0), motion(h), h};
  for (const double theta : {0.0, 0.21, 0.5, 0.83, 1.0}) {
    EXPECT_NEAR(step.position(theta), motion(theta * h).position, 1e-14);
    EXPECT_NEAR(step.velocity(theta), motion(theta * h).velocity, 1e-13);
    EXPECT_NEAR(step.acceleration(theta), motion(theta * h).acceleration, 1e-12);
  }
}

TEST(FirstClosing, FindsTheFirstOfSeveralCrossings) {
  // -(t - 0.2)(t - 0.5)(t - 0.9) starts positive, crosses at 0.2.
  const auto root = first_closing(bernstein({0.09, -0.73, 1.6, -1.0, 0.0, 0.0}), 0);
  ASSERT_TRUE(root.has_value());
  EXPECT_NEAR(*root, 0.2, 1e-15);
}

TEST(FirstClosing, SeesADipThatReturnsWithinTheStep) {
  // (t - 0.6)^2 - 1e-10 dips below zero for 2e-5 of the step.
  const auto root = first_closing(bernstein({0.36 - 1e-10, -1.2, 1.0, 0.0, 0.0, 0.0}), 0);
  ASSERT_TRUE(root.has_value());
  EXPECT_NEAR(*root, 0.6 - 1e-5, 1e-9);
}

TEST(FirstClosing, SeesNoCrossingWhereTheGapOnlyTouches) {
  EXPECT_FALSE(first_closing(bernstein({0.36 + 1e-10, -1.2, 1.0, 0.0, 0.0, 0.0}), 0).has_value());
  EXPECT_FALSE(first_closing(std::array<double, 4>{0.0, 0.1, 0.2, 0.3}, 0).has_value());
}

TEST(FirstClosing, LeavesOutTheContactItStartsFrom) {
  // A hop: t (0.001 - t) returns to the support after a thousandth of the step.
  const auto hop = first_closing(bernstein({0.0, 0.001, -1.0, 0.0, 0.0, 0.0}), 1);
  ASSERT_TRUE(hop.has_value());
  EXPECT_NEAR(*hop, 0.001, 1e-15);
  // Lifting from rest: t^2 (t - 0) never returns.
  EXPECT_FALSE(first_closing(bernstein({0.0, 0.0, 0.0, 1.0, 0.0, 0.0}), 2).has_value());
  EXPECT_FALSE(first_closing(bernstein({0.0, 1.0, -0.5, 0.0, 0.0, 0.0}), 1).has_value());
}

TEST(FirstClosing, IsAtOnceWhenItStartsBelow) {
  EXPECT_EQ(first_closing(std::array<double, 4>{-1e-3, 1.0, 1.0, 1.0}, 0), 0.0);
  EXPECT_EQ(first_closing(bernstein({0.0, -1.0, 0.0, 0.0, 0.0, 0.0}), 1), 0.0);
}

TEST(FirstClosing, EndsWithARootAtTheVeryStart) {
  const auto root = first_closing(std::array<double, 4>{0.0, -0.1, -0.2, -0.3}, 0);
  ASSERT_TRUE(root.has_value());
  EXPECT_LT(*root, 1e-15);
}

TEST(CubicBernstein, TakesValuesAndRatesAtBothEnds) {
  const std::array<double, 4> c = cubic_bernstein(1.0, 2.0, 3.0, -4.0, 0.5);
  EXPECT_DOUBLE_EQ(c[0], 1.0);
  EXPECT_DOUBLE_EQ(3.0 * (c[1] - c[0]) / 0.5, 2.0);
  EXPECT_DOUBLE_EQ(3.0 * (c[3] - c[2]) / 0.5, -4.0);
  EXPECT_DOUBLE_EQ(c[3], 3.0);
}

}  // namespace
}  // namespace udar
