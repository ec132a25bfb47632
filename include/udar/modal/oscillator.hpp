#pragma once
/// @file
/// One mode over a time in which its force is linear.

#include <cmath>

namespace udar {

/// @brief z'' + 2 zeta w z' + w^2 z = f + f' t after a time: what its start and its force are multiplied by.
///
///     z = c z0 + s v0 + f2 f + f3 f',      z' = -w^2 s z0 + ds v0 + s f + f2 f'
///
/// with f2, f3 and f4 the first, second and third integral of s. Source: docs/theory.md, "The modal integrator".
struct Oscillator {
  double c = 1.0;
  double s = 0.0;   ///< [s]
  double ds = 1.0;  ///< of s; c without damping
  double f2 = 0.0;  ///< [s^2]
  double f3 = 0.0;  ///< [s^3]
  double f4 = 0.0;  ///< [s^4]

  /// z and z' after the time. @param load at its start @param rate of the load
  [[nodiscard]] double place(double from, double speed, double load, double rate) const {
    return c * from + s * speed + f2 * load + f3 * rate;
  }
  [[nodiscard]] double speed(double w2, double from, double velocity, double load, double rate) const {
    return ds * velocity + s * (load - w2 * from) + f2 * rate;
  }

  /// @param frequency w [rad/s], >= 0 @param ratio zeta in [0, 1) @param time [s], >= 0
  [[nodiscard]] static Oscillator after(double time, double frequency, double ratio = 0.0) {
    constexpr double kSeries = 0.5;  // of w t: 16 terms leave 0.5^16 / 16!, nothing
    return frequency * time < kSeries ? by_series(time, frequency, ratio) : by_sines(time, frequency, ratio);
  }

 private:
  [[nodiscard]] static Oscillator by_sines(double time, double frequency, double ratio) {
    const double decay = ratio * frequency;
    const double damped = frequency * std::sqrt(1.0 - ratio * ratio);
    const double w2 = frequency * frequency;
    const double size = ratio > 0.0 ? std::exp(-decay * time) : 1.0;
    const double cosine = size * std::cos(damped * time);
    Oscillator at;
    at.s = size * std::sin(damped * time) / damped;
    at.ds = cosine - decay * at.s;
    at.c = cosine + decay * at.s;
    at.f2 = (1.0 - at.c) / w2;
    at.f3 = (time - at.s - 2.0 * decay * at.f2) / w2;
    at.f4 = (0.5 * time * time - at.f2 - 2.0 * decay * at.f3) / w2;
    return at;
  }

  /// f3 in powers of time by its own equation, and its derivatives; nothing cancels.
  [[nodiscard]] static Oscillator by_series(double time, double frequency, double ratio) {
    constexpr int kTerms = 20;
    const double double_decay = 2.0 * ratio * frequency;
    const double w2 = frequency * frequency;
    Oscillator at{.c = 0.0, .s = 0.0, .ds = 0.0, .f2 = 0.0, .f3 = 0.0, .f4 = 0.0};
    double before = 0.0;      // coefficient of t^(n - 1)
    double term = 1.0 / 6.0;  // of t^n
    double power = 1.0;       // t^(n - 3)
    for (int n = 3; n < kTerms; ++n) {
      at.ds += n * (n - 1) * (n - 2) * term * power;
      at.s += n * (n - 1) * term * power * time;
      at.f2 += n * term * power * time * time;
      at.f3 += term * power * time * time * time;
      at.f4 += term / (n + 1) * power * time * time * time * time;
      const double next = -(double_decay * n * term + w2 * before) / (n * (n + 1));
      before = term;
      term = next;
      power *= time;
    }
    at.c = at.ds + double_decay * at.s;
    return at;
  }
};

}  // namespace udar
