#include "udar/dynamics/free_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace udar {
namespace {

/// phi_0 = cos(x t), phi_(n+1) = integral of phi_n from 0 to t; phi_(-1) its derivative.
double phi(int order, double x, double t) {
  const double angle = x * t;
  if (order <= 0) {
    return order == 0 ? std::cos(angle) : -x * std::sin(angle);
  }
  // t^n sum_k (-angle^2)^k / (2k + n)!: closed forms cancel for small angles.
  constexpr double kSmall = 1.0;
  if (angle < kSmall) {
    double term = 1.0;
    for (int n = 1; n <= order; ++n) {
      term *= t / n;
    }
    double sum = 0.0;
    for (int k = 0; std::abs(term) > 1e-18 * std::abs(sum); ++k) {
      sum += term;
      term *= -angle * angle / ((2 * k + order + 1) * (2 * k + order + 2));
    }
    return sum;
  }
  switch (order) {
    case 1:
      return std::sin(angle) / x;
    case 2:
      return (1.0 - std::cos(angle)) / (x * x);
    default:
      return (t - std::sin(angle) / x) / (x * x);
  }
}

double chebyshev_angle(std::size_t j, std::size_t points) {
  return std::numbers::pi * (static_cast<double>(j) + 0.5) / static_cast<double>(points);
}

}  // namespace

FreeMotion::FreeMotion(FilteredLine& line) : line_{&line} {}

std::size_t FreeMotion::terms(double duration, double tolerance) const {
  // cos(t sqrt(A)) = J_0 + 2 sum (-1)^k J_2k(wf t) T_k; the others are integrals of it over time, whose tails are
  // smaller relative to t, t^2 / 2 and t^3 / 6. Beyond 2k = wf t the coefficients fall faster than geometrically by
  // 1/2.
  const double angle = line_->filter_frequency() * duration;
  std::size_t count = static_cast<std::size_t>(0.5 * angle) + 1;
  while (4.0 * std::abs(std::cyl_bessel_j(2.0 * static_cast<double>(count), angle)) > tolerance) {
    ++count;
  }
  return count;
}

/// Chebyshev coefficients of phi_(sequence + derivative) for all sequences in turn, by interpolation in the Chebyshev
/// points: what is left out is of the size of the first term left out.
FreeMotion::Coefficients FreeMotion::coefficients(int derivative, double time) const {
  const double wf = line_->filter_frequency();
  Coefficients result(sequences_ * terms_);
  for (std::size_t j = 0; j < terms_; ++j) {
    const double x = wf * std::cos(0.5 * chebyshev_angle(j, terms_));  // sqrt(A) where 2A/wf^2 - 1 = cos(angle)
    for (std::size_t sequence = 0; sequence < sequences_; ++sequence) {
      const double value = phi(static_cast<int>(sequence) + 1 - derivative, x, time);
      for (std::size_t k = 0; k < terms_; ++k) {
        result[sequence * terms_ + k] += value * polynomials_[j * terms_ + k];
      }
    }
  }
  return result;
}

void FreeMotion::propagate(const Start& start, double duration, double tolerance, std::span<const Field> fields,
                           std::span<const std::size_t> watched) {
  const std::size_t count = start.velocity.size();
  sequences_ = start.jerk.empty() ? 2 : 3;
  terms_ = terms(duration, tolerance);
  polynomials_.resize(terms_ * terms_);
  for (std::size_t j = 0; j < terms_; ++j) {
    for (std::size_t k = 0; k < terms_; ++k) {
      polynomials_[j * terms_ + k] = (k == 0 ? 1.0 : 2.0) / static_cast<double>(terms_) *
                                     std::cos(static_cast<double>(k) * chebyshev_angle(j, terms_));
    }
  }
  const std::array<std::span<const double>, 3> first{start.velocity, start.acceleration, start.jerk};
  last_.assign(sequences_, std::vector<double>(count));
  current_.assign(sequences_, std::vector<double>(count));
  stretch_.assign(sequences_, std::vector<double>(count));
  watched_.assign(watched.size() * sequences_ * terms_, 0.0);
  std::vector<std::array<Coefficients, 2>> weights;
  weights.reserve(fields.size());
  for (const Field& field : fields) {
    weights.push_back({coefficients(0, field.time), coefficients(1, field.time)});
    std::ranges::fill(field.displacement, 0.0);
    std::ranges::fill(field.velocity, 0.0);
  }
  const auto rests = [&](std::size_t i) { return !start.resting.empty() && start.resting[i] != 0; };
  std::vector<chain::Column> columns;
  for (std::size_t s = 0; s < sequences_; ++s) {
    for (std::size_t i = 0; i < count; ++i) {
      current_[s][i] = rests(i) ? 0.0 : first[s][i];
    }
  }
  for (std::size_t k = 0; k < terms_; ++k) {
    if (k > 0) {
      // X p = -p - 2 d(p), then T_(k+1) = 2 X T_k - T_(k-1).
      columns.clear();
      for (std::size_t s = 0; s < sequences_; ++s) {
        columns.push_back({.displacement = current_[s].data(), .stretch = stretch_[s].data()});
      }
      line_->solve(columns);
      const double factor = k == 1 ? -1.0 : -2.0;
      for (std::size_t s = 0; s < sequences_; ++s) {
        for (std::size_t i = 0; i < count; ++i) {
          const double next =
              rests(i) ? 0.0 : factor * (current_[s][i] + 2.0 * stretch_[s][i]) - (k == 1 ? 0.0 : last_[s][i]);
          last_[s][i] = current_[s][i];
          current_[s][i] = next;
        }
      }
    }
    for (std::size_t s = 0; s < sequences_; ++s) {
      for (std::size_t f = 0; f < fields.size(); ++f) {
        const double move = weights[f][0][s * terms_ + k];
        const double speed = weights[f][1][s * terms_ + k];
        for (std::size_t i = 0; i < count; ++i) {
          fields[f].displacement[i] += move * current_[s][i];
          fields[f].velocity[i] += speed * current_[s][i];
        }
      }
      for (std::size_t w = 0; w < watched.size(); ++w) {
        watched_[(w * sequences_ + s) * terms_ + k] = current_[s][watched[w]];
      }
    }
  }
}

FreeMotion::Point FreeMotion::point(std::size_t index, double time) const {
  std::array<double, 3> result{};
  for (int derivative = 0; derivative < 3; ++derivative) {
    const Coefficients weights = coefficients(derivative, time);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      result[static_cast<std::size_t>(derivative)] += weights[i] * watched_[index * weights.size() + i];
    }
  }
  return {.displacement = result[0], .velocity = result[1], .acceleration = result[2]};
}

}  // namespace udar
