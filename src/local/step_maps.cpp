#include "udar/local/step_maps.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "udar/local/local_motion.hpp"
#include "udar/numerics/bernstein.hpp"
#include "udar/numerics/power_series.hpp"

namespace udar {
namespace {

/// Bernstein coefficients and what is beyond, of the power series of a mass on the line's motion P [m].
void bound_series(const StepScale& scale, const std::array<double, kMostTerms>& line, double velocity,
                  std::array<double, kBounds>& bounds, double& rest) {
  std::array<double, kMostPowers> series{};
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
    bounds[i] = bernstein_of_powers(series.data(), kBounds - 1, i);
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
    problem.line = kLegendre[j];
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

ResponseBounds response_bounds(const StepScale& scale, std::size_t terms) {
  ResponseBounds reach;
  bound_series(scale, {}, 1.0, reach.start, reach.rest_of_start);
  for (std::size_t j = 0; j < terms; ++j) {
    bound_series(scale, kLegendre[j], 0.0, reach.line[j], reach.rest_of_line[j]);
  }
  return reach;
}

}  // namespace udar
