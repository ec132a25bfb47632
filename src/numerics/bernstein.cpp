#include "udar/numerics/bernstein.hpp"

namespace udar {

double bernstein_of_powers(const double* series, std::size_t degree, std::size_t i) {
  double sum = 0.0;
  double share = 1.0;  // binomial(i, k) / binomial(degree, k)
  for (std::size_t k = 0; k <= i; ++k) {
    sum += share * series[k];
    share *= k < degree ? static_cast<double>(i - k) / static_cast<double>(degree - k) : 0.0;
  }
  return sum;
}

std::array<double, 4> cubic_bernstein(double start, double start_rate, double end, double end_rate, double length) {
  return {start, start + length * start_rate / 3.0, end - length * end_rate / 3.0, end};
}

double bernstein_value(const std::array<double, 4>& c, double theta) {
  const double s = 1.0 - theta;
  return s * s * (s * c[0] + 3.0 * theta * c[1]) + theta * theta * (3.0 * s * c[2] + theta * c[3]);
}

double bernstein_slope(const std::array<double, 4>& c, double theta, double length) {
  const double s = 1.0 - theta;
  return 3.0 / length * (s * s * (c[1] - c[0]) + 2.0 * s * theta * (c[2] - c[1]) + theta * theta * (c[3] - c[2]));
}

}  // namespace udar
