#pragma once
/// @file
/// One mass on its filter spring over one step, the line's motion given: exact through any number of impacts.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "udar/contact/impact_law.hpp"

namespace udar::local {

/// Most Legendre terms of the line's motion over a step.
inline constexpr std::size_t kMostTerms = 5;
/// Most powers of time in an arc's series: (wf h)^k / k! is below round-off there for wf h <= 2.
inline constexpr std::size_t kMostPowers = 30;

/// Power coefficients of the Legendre polynomials on [0, 1].
inline constexpr std::array<std::array<double, kMostTerms>, kMostTerms> kLegendre{
    {{1, 0, 0, 0, 0}, {-1, 2, 0, 0, 0}, {1, -6, 6, 0, 0}, {-1, 12, -30, 20, 0}, {1, -20, 90, -140, 70}}};

/// Powers that reach round-off for a step of `angle` = wf h.
[[nodiscard]] std::size_t powers_for(double angle);

/// @brief What a mass meets. Displacements [m] count from its position at the start of the step, velocities [m per
/// step].
struct Stop {
  double at = 0.0;                                               ///< displacement at which it touches [m]
  double restitution = 1.0;                                      ///< e
  double yield_speed = std::numeric_limits<double>::infinity();  ///< where e begins to fall [m per step]
  bool present = false;
};

/// @brief The problem: z'' = angle^2 (P(tau) - z), z(0) = 0, z'(0) = velocity, tau from 0 to 1; lower and upper stop.
struct Problem {
  double angle = 0.0;                     ///< wf h [rad]
  std::size_t terms = 0;                  ///< of P
  std::size_t powers = 0;                 ///< `powers_for(angle)`
  std::array<double, kMostTerms> line{};  ///< P in powers of tau [m]
  double velocity = 0.0;                  ///< [m per step]
  std::array<Stop, 2> stops{};            ///< below, above
  int resting = -1;                       ///< index of the stop it rests on at the start; -1: moves
  double hop_tolerance = 0.0;             ///< [m]
  double together = 0.0;                  ///< nearer than this it is on the stop [m]
  double until = 1.0;                     ///< tau at which to end
};

/// @brief The end of it.
struct Outcome {
  std::array<double, kMostTerms> moments{};  ///< Legendre coefficients of z over [0, 1], if `until` is 1 [m]
  double displacement = 0.0;                 ///< [m]
  double velocity = 0.0;                     ///< [m per step]
  int resting = -1;                          ///< stop it rests on
  int impacts = 0;
  double first_impact = 2.0;  ///< tau; above 1: none
  double kick = 0.0;          ///< sum of |velocity jumps| [m per step]
};

/// More impacts of one mass in one step than this end in rest, with the energy booked as lost.
inline constexpr int kMostImpacts = 20000;

/// @brief First zero in [0, end] of sum_k c_k s^k, which is not negative at 0; negative: none, or not finite.
///
/// Advances by the zero of the parabola that the bound of the second derivative puts under the function: it cannot pass
/// a zero, and converges quadratically to one.
[[nodiscard]] double first_zero(const double* coefficients, std::size_t count, double end);

/// Listens to nothing.
struct Silent {
  void impact(int /*stop*/, double /*tau*/, double /*before*/, double /*after*/) const {}
  void rest(int /*stop*/, double /*tau*/, double /*speed*/) const {}
  void release(int /*stop*/, double /*tau*/) const {}
  /// @param stretch integral of P - z over the rest [m]
  void pressed(int /*stop*/, double /*stretch*/) const {}
};

namespace detail {

/// Coefficients about `tau` instead of 0.
inline void shift(std::array<double, kMostTerms>& c, std::size_t terms, double tau) {
  for (std::size_t from = 0; from + 1 < terms; ++from) {
    for (std::size_t k = terms - 1; k-- > from;) {
      c[k] += tau * c[k + 1];
    }
  }
}

/// Adds the integral over an arc of length `length` from `tau` on of its series times every Legendre polynomial.
inline void add_moments(const double* series, std::size_t count, double tau, double length, std::size_t terms,
                        std::array<double, kMostTerms>& moments) {
  std::array<double, kMostTerms> integral{};  // of series times s^i
  double power = length;
  for (std::size_t i = 0; i < terms; ++i) {
    double sum = 0.0;
    for (std::size_t k = count; k-- > 0;) {
      sum = sum * length + series[k] / static_cast<double>(k + i + 1);
    }
    integral[i] = sum * power;
    power *= length;
  }
  for (std::size_t j = 0; j < terms; ++j) {
    std::array<double, kMostTerms> about = kLegendre[j];
    shift(about, j + 1, tau);
    double sum = 0.0;
    for (std::size_t i = 0; i <= j; ++i) {
      sum += about[i] * integral[i];
    }
    moments[j] += static_cast<double>(2 * j + 1) * sum;
  }
}

inline double value(const double* c, std::size_t count, double s) {
  double sum = 0.0;
  for (std::size_t k = count; k-- > 0;) {
    sum = sum * s + c[k];
  }
  return sum;
}

inline double slope(const double* c, std::size_t count, double s) {
  double sum = 0.0;
  for (std::size_t k = count; k-- > 1;) {
    sum = sum * s + static_cast<double>(k) * c[k];
  }
  return sum;
}

}  // namespace detail

/// @brief Moves the mass from 0 to `until`, telling `journal` what happens, in order.
/// Source: docs/theory.md, "The impact integrator"
template <class Journal = Silent>
Outcome advance(const Problem& problem, const Journal& journal = {}) {
  using detail::slope;
  using detail::value;
  Outcome outcome;
  const double z2 = problem.angle * problem.angle;
  const std::size_t powers = problem.powers;
  double tau = 0.0;
  double place = 0.0;
  double velocity = problem.velocity;
  int resting = problem.resting;
  int on = -1;  // the stop it stands on exactly, at the start of an arc
  if (resting >= 0) {
    place = problem.stops[static_cast<std::size_t>(resting)].at;
    velocity = 0.0;
  }
  std::array<double, kMostPowers> series{};
  std::array<double, kMostPowers> gap{};
  bool stuck = false;  // rests again where it was released
  constexpr double kHold = 1e-8;
  constexpr int kMostArcs = 4 * kMostImpacts;
  for (int arc = 0;; ++arc) {
    const double left = problem.until - tau;
    std::array<double, kMostTerms> line = problem.line;
    detail::shift(line, problem.terms, tau);
    if (resting >= 0) {
      // It presses with -side (P - z) >= 0 until that turns negative.
      const auto index = static_cast<std::size_t>(resting);
      const double side = resting == 0 ? 1.0 : -1.0;
      std::array<double, kMostTerms> pressing{};
      for (std::size_t k = 0; k < problem.terms; ++k) {
        pressing[k] = -side * line[k];
      }
      pressing[0] += side * problem.stops[index].at;
      double end = pressing[0] < 0.0 ? 0.0 : first_zero(pressing.data(), problem.terms, left);
      bool released = end >= 0.0 && end < left;
      end = released ? end : left;
      // Round-off lifts what it has just put back: it stays for the time in which the pull is but round-off.
      const bool held = released && stuck && tau + end == tau && left > kHold;
      if (held) {
        released = false;
        end = kHold;
      }
      stuck = false;
      series[0] = place;
      detail::add_moments(series.data(), 1, tau, end, problem.terms, outcome.moments);
      double stretch = 0.0;
      for (std::size_t k = problem.terms; k-- > 0;) {
        stretch = stretch * end - side * pressing[k] / static_cast<double>(k + 1);
      }
      journal.pressed(resting, stretch * end);
      tau += end;
      if (held) {
        continue;
      }
      if (!released) {
        break;
      }
      journal.release(resting, tau);
      on = resting;
      resting = -1;
      velocity = 0.0;
      if (end == 0.0 && tau >= problem.until) {
        break;
      }
      continue;
    }

    series[0] = place;
    series[1] = velocity;
    for (std::size_t k = 0; k + 2 < powers; ++k) {
      series[k + 2] = z2 * ((k < problem.terms ? line[k] : 0.0) - series[k]) / static_cast<double>((k + 1) * (k + 2));
    }
    double end = left;
    int met = -1;
    for (int stop = 0; stop < 2; ++stop) {
      const Stop& support = problem.stops[static_cast<std::size_t>(stop)];
      if (!support.present) {
        continue;
      }
      const double side = stop == 0 ? 1.0 : -1.0;
      const double distance = side * (place - support.at);
      double root = -1.0;
      if (on == stop || distance <= problem.together) {
        // On the stop: the zero at the start, double where it starts without speed, is divided out.
        std::size_t skip = 1;
        if (side * velocity < 0.0) {
          root = 0.0;
          skip = 0;
        } else if (velocity == 0.0) {
          skip = side * series[2] == 0.0 || (on == stop && side * series[2] < 0.0 && side * series[3] > 0.0) ? 3 : 2;
        }
        if (skip > 0) {
          for (std::size_t k = skip; k < powers; ++k) {
            gap[k - skip] = side * series[k];
          }
          root = gap[0] < 0.0 ? 0.0 : first_zero(gap.data(), powers - skip, end);
        }
      } else {
        for (std::size_t k = 0; k < powers; ++k) {
          gap[k] = side * series[k];
        }
        gap[0] = distance;
        root = first_zero(gap.data(), powers, end);
      }
      if (root >= 0.0 && root <= end) {
        end = root;
        met = stop;
      }
    }
    detail::add_moments(series.data(), powers, tau, end, problem.terms, outcome.moments);
    const double arrived = slope(series.data(), powers, end);
    place = value(series.data(), powers, end);
    velocity = arrived;
    tau += end;
    const int stood = on;
    on = -1;
    if (met < 0) {
      for (int stop = 0; stop < 2; ++stop) {  // round-off may leave it below by its last bits
        const Stop& support = problem.stops[static_cast<std::size_t>(stop)];
        const double side = stop == 0 ? 1.0 : -1.0;
        if (support.present && side * (place - support.at) < 0.0) {
          place = support.at;
        }
      }
      break;
    }

    const Stop& support = problem.stops[static_cast<std::size_t>(met)];
    const double side = met == 0 ? 1.0 : -1.0;
    place = support.at;
    const double before = side * velocity;
    const double after =
        before < 0.0 ? -falling_restitution(support.restitution, support.yield_speed, -before) * before : before;
    const double pull = side * z2 * (value(problem.line.data(), problem.terms, tau) - place);
    if (before < 0.0) {
      journal.impact(met, tau, velocity, side * after);
      outcome.first_impact = std::min(outcome.first_impact, tau);
      outcome.kick += after - before;
      ++outcome.impacts;
    }
    // Where it hits too often, or does not get off, the arc of rest tells whether the line lifts it at once.
    const bool tired = outcome.impacts >= kMostImpacts || arc >= kMostArcs || (before == 0.0 && end == 0.0);
    if (tired || (pull < 0.0 && after * after <= -2.0 * pull * problem.hop_tolerance)) {
      journal.rest(met, tau, after);
      stuck = stood == met && before == 0.0 && end == 0.0;
      resting = met;
      velocity = 0.0;
    } else {
      velocity = side * after;
      on = met;
    }
  }
  outcome.displacement = place;
  outcome.velocity = velocity;
  outcome.resting = resting;
  return outcome;
}

}  // namespace udar::local
