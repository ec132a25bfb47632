// ranks: 1; size: short
/// @file
/// Polynomials against closed forms.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>

#include "udar/numerics/bernstein.hpp"
#include "udar/numerics/gauss.hpp"
#include "udar/numerics/legendre.hpp"
#include "udar/numerics/power_series.hpp"
#include "udar/numerics/roots.hpp"
#include "udar/numerics/step_polynomial.hpp"

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

TEST(StepPolynomial, IsIntegratedExactly) {
  const StepPolynomial step{
      {.position = 1.0}, {.position = 2.0, .velocity = 5.0, .acceleration = 20.0}, 1.0};  // 1 + t^5
  for (const double theta : {0.3, 1.0}) {
    EXPECT_NEAR(step.integral(theta), theta + std::pow(theta, 6) / 6.0, 4e-16);  // rounding of the sums
  }
}

TEST(PowerSeries, KeepsItsValuesAboutAnotherPoint) {
  const std::array<double, 4> c{1.0, -2.0, 0.5, 3.0};
  std::array<double, 4> about = c;
  power_series::shift(about.data(), about.size(), 0.75);
  EXPECT_NEAR(power_series::value(about.data(), 4, 0.5), power_series::value(c.data(), 4, 1.25), 4e-15);
  EXPECT_NEAR(power_series::slope(about.data(), 4, 0.5), -2.0 + 1.25 + 9.0 * 1.5625, 1e-14);
}

TEST(Gauss, IsExactToDegreeFifteen) {
  const auto error = [](int degree) {
    double sum = 0.0;
    for (const auto& [at, weight] : kGauss) {
      sum += weight * std::pow(at, degree);
    }
    return std::abs(sum - 1.0 / (degree + 1));
  };
  for (int degree = 0; degree <= 15; ++degree) {
    EXPECT_LT(error(degree), 1e-15) << degree;  // rounding of eight terms below one
  }
  EXPECT_GT(error(16), 1e-10);  // (8!)^4 / (17 (16!)^2) = 3.6e-10
}

TEST(Legendre, SeriesOfAPartIsThatOfItsIntegrals) {
  // A unit jump at 1/2: (2 j + 1) times the integrals of the polynomials over the second half.
  const double one = 1.0;
  std::array<double, kMostTerms> found{};
  add_legendre(&one, 1, 0.5, 0.5, kMostTerms, found);
  const std::array<double, kMostTerms> expected{0.5, 0.75, 0.0, -0.4375, 0.0};
  for (std::size_t j = 0; j < kMostTerms; ++j) {
    EXPECT_NEAR(found[j], expected[j], 2e-14) << j;  // the powers' coefficients, up to 140, take that of rounding
  }
}

TEST(Legendre, ContinuesBeyondTheStep) {
  const LegendreMatrix change = legendre_change(kMostTerms, 1.0, 0.5);
  for (std::size_t old = 0; old < kMostTerms; ++old) {
    double sum = 0.0;
    for (std::size_t j = 0; j < kMostTerms; ++j) {
      sum += change[j][old] * legendre(j, 0.6);
    }
    EXPECT_NEAR(sum, legendre(old, 1.3), 1e-13 * std::abs(legendre(old, 1.3)) + 1e-15) << old;
  }
}

TEST(FirstZero, FindsTheFirstOfTwoAndNoneBeyondTheEnd) {
  const std::array<double, 3> c{0.06, -0.5, 1.0};  // (s - 0.2)(s - 0.3)
  EXPECT_NEAR(first_zero(c.data(), 3, 1.0), 0.2, 1e-15);
  EXPECT_LT(first_zero(c.data(), 3, 0.19), 0.0);
}

TEST(FirstZero, SeesADipAndNoTouch) {
  const std::array<double, 3> dips{0.36 - 1e-10, -1.2, 1.0};  // (s - 0.6)^2 - 1e-10
  EXPECT_NEAR(first_zero(dips.data(), 3, 1.0), 0.6 - 1e-5, 1e-10);
  const std::array<double, 3> touches{0.36 + 1e-10, -1.2, 1.0};
  EXPECT_LT(first_zero(touches.data(), 3, 1.0), 0.0);
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
