#pragma once
/// @file
/// The gap between a mass and its support over one step, and when it closes.

#include <array>
#include <optional>

namespace udar {

/// @brief Position, velocity and acceleration of one quantity at one end of a step.
struct Kinematics {
  double position = 0.0;      ///< [m]
  double velocity = 0.0;      ///< [m/s]
  double acceleration = 0.0;  ///< [m/s^2]
};

/// @brief Dense output of one step: the quintic Hermite polynomial through position, velocity and acceleration at both
/// ends, in Bernstein form over [0, 1].
///
/// Its error is O(h^6) for positions and O(h^5) for velocities, one order above the dense output that PETSc has for
/// 5dp, and it exists for every explicit integrator. Source: docs/theory.md, "Dense output".
class StepPolynomial {
 public:
  /// @param length of the step h [s]
  StepPolynomial(const Kinematics& start, const Kinematics& end, double length);

  /// @param theta (t - t0) / h in [0, 1]
  [[nodiscard]] double position(double theta) const;      ///< [m]
  [[nodiscard]] double velocity(double theta) const;      ///< [m/s]
  [[nodiscard]] double acceleration(double theta) const;  ///< [m/s^2]

  [[nodiscard]] const std::array<double, 6>& bernstein() const noexcept { return coefficients_; }

 private:
  std::array<double, 6> coefficients_{};
  double length_;
};

/// @brief Bernstein coefficients of the cubic Hermite polynomial through values and rates at both ends of a step.
[[nodiscard]] std::array<double, 4> cubic_bernstein(double start, double start_rate, double end, double end_rate,
                                                    double length);

/// @brief First theta in (0, 1] where a polynomial that starts at or above zero turns negative.
///
/// `touching` says how often theta = 0 is a root by construction (a mass that stands on the support: 1; at rest there:
/// 2); these roots are divided out exactly. Bernstein subdivision: no crossing is missed. A polynomial that is negative
/// from the start gives theta = 0.
/// @param coefficients Bernstein form over [0, 1], degree 3 or 5
template <std::size_t Count>
[[nodiscard]] std::optional<double> first_closing(std::array<double, Count> coefficients, int touching);

extern template std::optional<double> first_closing<4>(std::array<double, 4>, int);
extern template std::optional<double> first_closing<6>(std::array<double, 6>, int);

}  // namespace udar
