#include "udar/numerics/gap.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace udar {
namespace {

constexpr std::size_t kMost = 6;
using Coefficients = std::array<double, kMost>;

/// De Casteljau at the middle: `left` and `right` receive the coefficients over the two halves.
void halve(std::span<const double> all, Coefficients& left, Coefficients& right) {
  const std::size_t count = all.size();
  Coefficients work{};
  std::ranges::copy(all, work.begin());
  for (std::size_t level = 0; level < count; ++level) {
    left[level] = work[0];
    right[count - 1 - level] = work[count - 1 - level];
    for (std::size_t i = 0; i + level + 1 < count; ++i) {
      work[i] = 0.5 * (work[i] + work[i + 1]);
    }
  }
}

/// First crossing from above in the open interval; `coefficients[0]` is not negative.
std::optional<double> search(std::span<const double> coefficients, double from, double to) {
  if (std::ranges::all_of(coefficients, [](double value) { return value >= 0.0; })) {
    return std::nullopt;
  }
  // 1e-20 of a step is below any time resolution: stops a root that sits at the very start.
  if (to - from <= std::max(2.0 * std::numeric_limits<double>::epsilon() * to, 1e-20)) {
    return to;
  }
  Coefficients left{};
  Coefficients right{};
  halve(coefficients, left, right);
  const double middle = 0.5 * (from + to);
  const std::span<const double> left_part{left.data(), coefficients.size()};
  const std::span<const double> right_part{right.data(), coefficients.size()};
  if (const auto found = search(left_part, from, middle)) {
    return found;
  }
  return right_part.front() < 0.0 ? std::optional{middle} : search(right_part, middle, to);
}

}  // namespace

StepPolynomial::StepPolynomial(const Kinematics& start, const Kinematics& end, double length) : length_{length} {
  const double h = length;
  coefficients_[0] = start.position;
  coefficients_[1] = start.position + h * start.velocity / 5.0;
  coefficients_[2] = start.position + 2.0 * h * start.velocity / 5.0 + h * h * start.acceleration / 20.0;
  coefficients_[5] = end.position;
  coefficients_[4] = end.position - h * end.velocity / 5.0;
  coefficients_[3] = end.position - 2.0 * h * end.velocity / 5.0 + h * h * end.acceleration / 20.0;
}

double StepPolynomial::position(double theta) const {
  const double s = 1.0 - theta;
  const auto& c = coefficients_;
  return s * s * s * (s * s * c[0] + 5.0 * s * theta * c[1] + 10.0 * theta * theta * c[2]) +
         theta * theta * theta * (10.0 * s * s * c[3] + 5.0 * s * theta * c[4] + theta * theta * c[5]);
}

double StepPolynomial::velocity(double theta) const {
  const double s = 1.0 - theta;
  const auto& c = coefficients_;
  return 5.0 / length_ *
         (s * s * s * s * (c[1] - c[0]) + 4.0 * s * s * s * theta * (c[2] - c[1]) +
          6.0 * s * s * theta * theta * (c[3] - c[2]) + 4.0 * s * theta * theta * theta * (c[4] - c[3]) +
          theta * theta * theta * theta * (c[5] - c[4]));
}

double StepPolynomial::acceleration(double theta) const {
  const double s = 1.0 - theta;
  const auto& c = coefficients_;
  const auto second = [&c](std::size_t i) { return c[i + 2] - 2.0 * c[i + 1] + c[i]; };
  return 20.0 / (length_ * length_) *
         (s * s * s * second(0) + 3.0 * s * s * theta * second(1) + 3.0 * s * theta * theta * second(2) +
          theta * theta * theta * second(3));
}

std::array<double, 4> cubic_bernstein(double start, double start_rate, double end, double end_rate, double length) {
  return {start, start + length * start_rate / 3.0, end - length * end_rate / 3.0, end};
}

template <std::size_t Count>
std::optional<double> first_closing(std::array<double, Count> coefficients, int touching) {
  std::size_t count = Count;
  for (int root = 0; root < touching; ++root) {
    const auto degree = static_cast<double>(count - 1);
    for (std::size_t i = 0; i + 1 < count; ++i) {
      coefficients[i] = coefficients[i + 1] * degree / static_cast<double>(i + 1);
    }
    --count;
  }
  if (coefficients[0] < 0.0) {
    return 0.0;
  }
  return search(std::span<const double>{coefficients.data(), count}, 0.0, 1.0);
}

template std::optional<double> first_closing<4>(std::array<double, 4>, int);
template std::optional<double> first_closing<6>(std::array<double, 6>, int);

}  // namespace udar
