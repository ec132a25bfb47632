#include "udar/numerics/legendre.hpp"

#include <algorithm>
#include <cmath>

#include "udar/numerics/bernstein.hpp"
#include "udar/numerics/power_series.hpp"

namespace udar {
namespace {

/// 0, 1, 2, ... as numbers: turning an index into one takes as long as a division.
constexpr auto kNumbers = [] {
  std::array<double, kMostPowers + kMostTerms + 1> numbers{};
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    numbers[k] = static_cast<double>(k);
  }
  return numbers;
}();

}  // namespace

double legendre(std::size_t j, double tau) { return power_series::value(kLegendre[j].data(), j + 1, tau); }

double legendre_slope(std::size_t j, double tau) { return power_series::slope(kLegendre[j].data(), j + 1, tau); }

void add_legendre(const double* series, std::size_t count, double from, double length, std::size_t terms,
                  std::array<double, kMostTerms>& coefficients) {
  std::array<double, kMostTerms> integral{};  // of series times s^i, side by side: none waits for another
  for (std::size_t k = count; k-- > 0;) {
    for (std::size_t i = 0; i < terms; ++i) {
      integral[i] = integral[i] * length + series[k] / kNumbers[k + i + 1];
    }
  }
  double power = length;
  for (std::size_t i = 0; i < terms; ++i) {
    integral[i] *= power;
    power *= length;
  }
  for (std::size_t j = 0; j < terms; ++j) {
    std::array<double, kMostTerms> about = kLegendre[j];
    power_series::shift(about.data(), j + 1, from);
    double sum = 0.0;
    for (std::size_t i = 0; i <= j; ++i) {
      sum += about[i] * integral[i];
    }
    coefficients[j] += static_cast<double>(2 * j + 1) * sum;
  }
}

LegendreMatrix legendre_bernstein(std::size_t terms) {
  LegendreMatrix coefficients{};
  for (std::size_t j = 0; j < terms; ++j) {
    for (std::size_t i = 0; i < terms; ++i) {
      coefficients[i][j] = bernstein_of_powers(kLegendre[j].data(), terms - 1, i);
    }
  }
  return coefficients;
}

LegendreMatrix legendre_change(std::size_t terms, double offset, double ratio) {
  LegendreMatrix change{};
  for (std::size_t old = 0; old < terms; ++old) {
    // Legendre coefficients on [0, 1] of L_old(offset + ratio tau), by its powers.
    std::array<double, kMostTerms> powers = kLegendre[old];
    power_series::shift(powers.data(), terms, offset);
    double scale = 1.0;
    for (std::size_t k = 0; k < terms; ++k) {
      powers[k] *= scale;
      scale *= ratio;
    }
    for (std::size_t k = terms; k-- > 0;) {
      const double share = powers[k] / kLegendre[k][k];
      change[k][old] = share;
      for (std::size_t i = 0; i <= k; ++i) {
        powers[i] -= share * kLegendre[k][i];
      }
    }
  }
  return change;
}

double kink_miss(std::size_t terms, double at) {
  const double left = 1.0 - at;
  const std::array<double, 2> ramp{0.0, 1.0};
  const std::array<double, 1> one{1.0};
  std::array<double, kMostTerms> of_ramp{};
  std::array<double, kMostTerms> of_one{};
  add_legendre(ramp.data(), 2, at, left, terms, of_ramp);
  add_legendre(one.data(), 1, at, left, terms, of_one);
  double miss = 0.5 * left * left;
  for (std::size_t j = 0; j < terms; ++j) {
    miss -= of_ramp[j] * of_one[j] / static_cast<double>(2 * j + 1);
  }
  return std::abs(miss);
}

double jump_miss(std::size_t terms, double at) {
  const double left = 1.0 - at;
  const std::array<double, 1> one{1.0};
  std::array<double, kMostTerms> of_one{};
  add_legendre(one.data(), 1, at, left, terms, of_one);
  double miss = left;
  for (std::size_t j = 0; j < terms; ++j) {
    miss -= of_one[j] * of_one[j] / static_cast<double>(2 * j + 1);
  }
  return std::abs(miss);
}

namespace {

double largest_of(double (&miss)(std::size_t, double), std::size_t terms) {
  double largest = 0.0;
  for (int k = 1; k < 100; ++k) {
    largest = std::max(largest, miss(terms, 0.01 * k));
  }
  return largest;
}

}  // namespace

double kink_integral(std::size_t terms) { return largest_of(kink_miss, terms); }
double jump_integral(std::size_t terms) { return largest_of(jump_miss, terms); }

}  // namespace udar
