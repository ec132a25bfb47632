#include "udar/numerics/step_polynomial.hpp"

#include <cmath>

namespace udar {

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

double StepPolynomial::integral(double theta) const {
  const double offset = 0.5 * theta * std::sqrt(0.6);
  const double middle = 0.5 * theta;
  return length_ * theta / 18.0 *
         (5.0 * position(middle - offset) + 8.0 * position(middle) + 5.0 * position(middle + offset));
}

}  // namespace udar
