#pragma once
/// @file
/// The motion of one quantity over one step.

#include <array>

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

  /// @brief Over the part of the step up to theta: three Gauss points, exact of this degree.
  [[nodiscard]] double integral(double theta) const;  ///< [m s]

  [[nodiscard]] const std::array<double, 6>& bernstein() const noexcept { return coefficients_; }

 private:
  std::array<double, 6> coefficients_{};
  double length_;
};

}  // namespace udar
