#include "udar/local/step_maps.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "udar/local/local_motion.hpp"

namespace udar {
namespace {

/// Bernstein coefficient `i` of a power series on [0, 1] up to `degree`.
double bernstein(const double* series, std::size_t degree, std::size_t i) {
  double sum = 0.0;
  double share = 1.0;  // binomial(i, k) / binomial(degree, k)
  for (std::size_t k = 0; k <= i; ++k) {
    sum += share * series[k];
    share *= k < degree ? static_cast<double>(i - k) / static_cast<double>(degree - k) : 0.0;
  }
  return sum;
}

/// Bernstein coefficients and what is beyond, of the power series of a mass on the line's motion P [m].
void bound_series(const StepScale& scale, const std::array<double, kMostTerms>& line, double velocity,
                  std::array<double, kBounds>& bounds, double& rest) {
  std::array<double, local::kMostPowers> series{};
  series[1] = velocity;
  for (std::size_t k = 0; k + 2 < series.size(); ++k) {
    const double pull = scale.angle * scale.angle * ((k < kMostTerms ? line[k] : 0.0) - series[k]) -
                        static_cast<double>(k + 1) * scale.drag * series[k + 1];
    series[k + 2] = pull / static_cast<double>((k + 1) * (k + 2));
  }
  rest = 0.0;
  for (std::size_t k = kBounds; k < series.size(); ++k) {
    rest += std::abs(series[k]);
  }
  for (std::size_t i = 0; i < kBounds; ++i) {
    bounds[i] = bernstein(series.data(), kBounds - 1, i);
  }
}

}  // namespace

DenseMap dense_map(const StepScale& scale, std::size_t terms, double until) {
  DenseMap map;
  local::Problem problem;
  problem.angle = scale.angle;
  problem.drag = scale.drag;
  problem.terms = terms;
  problem.powers = local::powers_for(scale.angle + scale.drag);
  problem.until = until;
  problem.velocity = 1.0;
  local::Outcome outcome = local::advance(problem);
  map.start = outcome.moments;
  map.place_of_start = outcome.displacement;
  map.speed_of_start = outcome.velocity;
  problem.velocity = 0.0;
  for (std::size_t j = 0; j < terms; ++j) {
    problem.line = local::kLegendre[j];
    outcome = local::advance(problem);
    for (std::size_t i = 0; i < terms; ++i) {
      map.line[i][j] = outcome.moments[i];
    }
    map.place[j] = outcome.displacement;
    map.speed[j] = outcome.velocity;
  }
  return map;
}

void set_gain(DenseMap& map, const StepScale& scale, std::size_t terms, const LineAnswer& answer) {
  const std::size_t unknowns = terms + (scale.damping != 0.0 ? 1 : 0);
  const auto product = [unknowns](const Gain& a, const Gain& b) {
    Gain c{};
    for (std::size_t i = 0; i < unknowns; ++i) {
      for (std::size_t j = 0; j < unknowns; ++j) {
        for (std::size_t k = 0; k < unknowns; ++k) {
          c[i][j] += a[i][k] * b[k][j];
        }
      }
    }
    return c;
  };
  Gain w{};  // drive by unknowns, then unknowns by drive
  for (std::size_t k = 0; k < unknowns; ++k) {
    std::array<double, kMostUnknowns> one{};
    one[k] = 1.0;
    for (std::size_t j = 0; j < terms; ++j) {
      const double drive = one[j] + (unknowns > terms ? scale.damping * rate_term(j, one, one[terms]) : 0.0);
      for (std::size_t i = 0; i < unknowns; ++i) {
        w[i][k] += (i < terms ? map.line[i][j] : map.place[j]) * drive;
      }
    }
  }
  Gain power = w;
  map.gain = {};
  for (std::size_t i = 0; i < unknowns; ++i) {
    map.gain[i][i] = 1.0;
    for (double& value : power[i]) {
      value *= answer.share;
    }
  }
  constexpr int kDoublings = 12;  // of Neumann's series, as (1 + X)(1 + X^2)(1 + X^4)...
  for (int k = 0; k < kDoublings; ++k) {
    const Gain more = product(map.gain, power);
    for (std::size_t i = 0; i < unknowns; ++i) {
      for (std::size_t j = 0; j < unknowns; ++j) {
        map.gain[i][j] += more[i][j];
      }
    }
    power = product(power, power);
  }
  // Spectral radius by the norm of a power.
  constexpr int kSquarings = 4;
  Gain left = product(w, map.gain);
  for (int k = 0; k < kSquarings; ++k) {
    left = product(left, left);
  }
  double norm = 0.0;
  for (const auto& row : left) {
    double sum = 0.0;
    for (const double value : row) {
      sum += std::abs(value);
    }
    norm = std::max(norm, sum);
  }
  map.contraction = std::max(1.0 - answer.share, answer.share - answer.least) * std::pow(norm, 1.0 / (1 << kSquarings));
}

Reach reach_of(const StepScale& scale, std::size_t terms) {
  Reach reach;
  bound_series(scale, {}, 1.0, reach.start, reach.rest_of_start);
  for (std::size_t j = 0; j < terms; ++j) {
    bound_series(scale, local::kLegendre[j], 0.0, reach.line[j], reach.rest_of_line[j]);
  }
  return reach;
}

Square legendre_bernstein(std::size_t terms) {
  Square coefficients{};
  for (std::size_t j = 0; j < terms; ++j) {
    for (std::size_t i = 0; i < terms; ++i) {
      coefficients[i][j] = bernstein(local::kLegendre[j].data(), terms - 1, i);
    }
  }
  return coefficients;
}

Square legendre_change(std::size_t terms, double offset, double ratio) {
  Square change{};
  for (std::size_t old = 0; old < terms; ++old) {
    // Legendre coefficients on [0, 1] of L_old(offset + ratio tau), by its powers.
    std::array<double, kMostTerms> powers = local::kLegendre[old];
    local::detail::shift(powers, terms, offset);
    double scale = 1.0;
    for (std::size_t k = 0; k < terms; ++k) {
      powers[k] *= scale;
      scale *= ratio;
    }
    for (std::size_t k = terms; k-- > 0;) {
      const double share = powers[k] / local::kLegendre[k][k];
      change[k][old] = share;
      for (std::size_t i = 0; i <= k; ++i) {
        powers[i] -= share * local::kLegendre[k][i];
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
  local::detail::add_moments(ramp.data(), 2, at, left, terms, of_ramp);
  local::detail::add_moments(one.data(), 1, at, left, terms, of_one);
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
  local::detail::add_moments(one.data(), 1, at, left, terms, of_one);
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
