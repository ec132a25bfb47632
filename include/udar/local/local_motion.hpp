#pragma once
/// @file
/// One mass on its filter spring over one step, the line's motion given: exact through any number of impacts.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "udar/contact/impact_law.hpp"
#include "udar/numerics/gauss.hpp"
#include "udar/numerics/legendre.hpp"
#include "udar/numerics/power_series.hpp"
#include "udar/numerics/roots.hpp"

namespace udar::local {

/// Powers that reach round-off for a step of `angle` = wf h.
[[nodiscard]] std::size_t powers_for(double angle);

/// @brief What a mass meets. Displacements [m] count from its position at the start of the step, velocities [m per
/// step].
struct Stop {
  double at = 0.0;                                               ///< displacement at which it touches at the start [m]
  double restitution = 1.0;                                      ///< e
  double yield_speed = std::numeric_limits<double>::infinity();  ///< where e begins to fall [m per step]
  bool present = false;
  bool moves = false;            ///< by `path`
  std::array<double, 3> path{};  ///< its way since the start, in tau, tau^2 and tau^3 [m]
  double stiffness = 0.0;        ///< k/m [1/step^2]; 0: rigid, > 0: no restitution
  double damping = 0.0;          ///< c/m of one that is not rigid [1/step]

  [[nodiscard]] bool elastic() const noexcept { return stiffness > 0.0; }
  [[nodiscard]] double place(double tau) const noexcept {
    return moves ? at + tau * (path[0] + tau * (path[1] + tau * path[2])) : at;
  }
  [[nodiscard]] double speed(double tau) const noexcept {
    return moves ? path[0] + tau * (2.0 * path[1] + 3.0 * tau * path[2]) : 0.0;
  }
};

/// @brief The problem: z'' = angle^2 (P(tau) - z) - drag z', z(0) = 0, z'(0) = velocity, tau from 0 to 1; lower and
/// upper stop. A stop that is not rigid adds -(k/m) g - (c/m) g' while its gap g is negative and that is not an
/// attraction.
struct Problem {
  double angle = 0.0;                     ///< wf h [rad]
  std::size_t terms = 0;                  ///< of P
  std::size_t powers = 0;                 ///< `powers_for(angle + drag)`
  std::array<double, kMostTerms> line{};  ///< P in powers of tau [m]
  double velocity = 0.0;                  ///< [m per step]
  std::array<Stop, 2> stops{};            ///< below, above
  int resting = -1;                       ///< index of the stop it rests on at the start; -1: moves
  double hop_tolerance = 0.0;             ///< [m]
  double together = 0.0;                  ///< nearer than this it is on the stop [m]
  double pull_resolution = 0.0;           ///< P - z that is not larger does not pull it off a stop [m]
  double until = 1.0;                     ///< tau at which to end
  double drag = 0.0;                      ///< [1/step]
  std::array<double, kMostTerms> turn{};  ///< in powers of tau, a part of angle^2 P: dampers take z' (drag z' - turn)
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

/// Listens to nothing.
struct Silent {
  void impact(int /*stop*/, double /*tau*/, double /*before*/, double /*after*/) const {}
  void rest(int /*stop*/, double /*tau*/, double /*speed*/) const {}
  void release(int /*stop*/, double /*tau*/) const {}
  /// What a stop gave without an impact, per mass.
  /// @param push integral of the acceleration it gives, up [m per step] @param work that of this and its own speed
  void pressed(int /*stop*/, double /*push*/, double /*work*/) const {}
  /// What dampers took, per mass: those of stops, and drags [m^2 per step^2].
  void damped(double /*loss*/) const {}
  /// It was in contact with a stop that is not rigid.
  void touched(double /*from*/, double /*until*/) const {}
};

namespace detail {

/// Place of a stop in powers of the time since tau.
inline std::array<double, kMostTerms> path_from(const Stop& stop, double tau) {
  std::array<double, kMostTerms> path{stop.at};
  if (stop.moves) {
    std::ranges::copy(stop.path, path.begin() + 1);
    power_series::shift(path.data(), 4, tau);
  }
  return path;
}

}  // namespace detail

/// How a mass stands to a stop that is not rigid.
enum class Touch : std::uint8_t {
  off,    ///< the gap is open
  press,  ///< it is closed, and spring and damper press
  slack,  ///< it is closed, but opens so fast that the damper would pull
};

/// @brief Moves the mass from 0 to `until`, telling `journal` what happens, in order.
/// Source: docs/theory.md, "The impact integrator"
template <class Journal = Silent>
Outcome advance(const Problem& problem, const Journal& journal = {}) {
  using power_series::slope;
  using power_series::value;
  Outcome outcome;
  const double z2 = problem.angle * problem.angle;
  double tau = 0.0;
  double place = 0.0;
  double velocity = problem.velocity;
  int resting = problem.resting;
  int on = -1;  // the stop it stands on exactly, at the start of an arc
  std::array<Touch, 2> touch{};
  std::array<bool, 2> fresh{};  // what would end it is zero at the start of an arc, by construction
  for (std::size_t index = 0; index < 2; ++index) {
    const Stop& stop = problem.stops[index];
    const double side = index == 0 ? 1.0 : -1.0;
    const double gap = -side * stop.at;
    if (stop.present && stop.elastic() && gap < 0.0) {
      touch[index] =
          stop.stiffness * gap + stop.damping * side * (velocity - stop.speed(0.0)) < 0.0 ? Touch::press : Touch::slack;
    }
  }
  if (resting >= 0) {
    const Stop& stop = problem.stops[static_cast<std::size_t>(resting)];
    place = stop.at;
    velocity = stop.speed(0.0);
  }
  std::array<double, kMostPowers> series{};
  std::array<double, kMostPowers> gap{};
  const auto dragged = [&](const double* motion, std::size_t count, double start, double length) {
    double sum = 0.0;
    for (const auto& [at, weight] : kGauss) {
      const double speed = slope(motion, count, at * length);
      const double turn = value(problem.turn.data(), problem.terms, start + at * length);
      sum += weight * length * speed * (problem.drag * speed - turn);
    }
    return sum;
  };
  // Slower than this it stands on the stop, but for rounding.
  const auto stands = [&](double speed) { return std::abs(speed) <= problem.angle * problem.pull_resolution; };
  bool stuck = false;  // rests again where it was released
  int stalls = 0;      // arcs without length, one after the other
  constexpr double kHold = 1e-8;
  constexpr int kMostArcs = 4 * kMostImpacts;
  constexpr int kMostStalls = 8;
  for (int arc = 0;; ++arc) {
    const double left = problem.until - tau;
    std::array<double, kMostTerms> line = problem.line;
    power_series::shift(line.data(), problem.terms, tau);
    if (resting >= 0) {
      // It presses with -side (P - z - ...) >= 0 until that turns negative.
      const auto index = static_cast<std::size_t>(resting);
      const Stop& stop = problem.stops[index];
      const double side = resting == 0 ? 1.0 : -1.0;
      const auto path = detail::path_from(stop, tau);
      std::array<double, kMostTerms> pressing{};
      for (std::size_t k = 0; k < problem.terms; ++k) {
        pressing[k] = -side * line[k];
      }
      pressing[0] += side * path[0];
      std::size_t terms = problem.terms;
      if (stop.moves) {
        terms = std::max<std::size_t>(terms, 4);
        for (std::size_t k = 1; k < 4; ++k) {
          pressing[k] += side * path[k];
        }
        for (std::size_t k = 0; k + 1 < kMostTerms; ++k) {
          const auto next = static_cast<double>(k + 1);
          const double bend = k < 2 ? next * static_cast<double>(k + 2) * path[k + 2] : 0.0;
          pressing[k] += side / z2 * (bend + next * problem.drag * path[k + 1]);
        }
      }
      std::array<double, kMostTerms> holding = pressing;
      holding[0] += problem.pull_resolution;
      double end = holding[0] < 0.0 ? 0.0 : first_zero(holding.data(), terms, left);
      bool released = end >= 0.0 && end < left;
      end = released ? end : left;
      // Round-off lifts what it has just put back: it stays for the time in which the pull is but round-off.
      const bool held = released && stuck && tau + end == tau && left > kHold;
      if (held) {
        released = false;
        end = kHold;
      }
      stuck = false;
      add_legendre(path.data(), stop.moves ? 4 : 1, tau, end, problem.terms, outcome.moments);
      if constexpr (!std::is_same_v<Journal, Silent>) {
        double push = 0.0;
        for (std::size_t k = terms; k-- > 0;) {
          push = push * end + side * z2 * pressing[k] / static_cast<double>(k + 1);
        }
        double work = 0.0;
        for (std::size_t i = 0; i < kGauss.size() && stop.moves; ++i) {
          const auto& [at, weight] = kGauss[i];
          work += side * z2 * value(pressing.data(), terms, at * end) * weight * end * slope(path.data(), 4, at * end);
        }
        journal.pressed(resting, push * end, work);
        if (problem.drag != 0.0) {
          journal.damped(dragged(path.data(), 4, tau, end));
        }
      }
      tau += end;
      place = stop.moves ? value(path.data(), 4, end) : stop.at;
      velocity = stop.moves ? slope(path.data(), 4, end) : 0.0;
      if (held) {
        continue;
      }
      if (!released) {
        break;
      }
      journal.release(resting, tau);
      on = resting;
      resting = -1;
      if (end == 0.0 && tau >= problem.until) {
        break;
      }
      continue;
    }

    double end = left;
    std::size_t powers = problem.powers;
    bool presses = false;
    double stiffness = 0.0;
    double damping = 0.0;
    std::array<double, kMostTerms> target{};  // k q + c q' of the stops it presses
    for (std::size_t index = 0; index < 2; ++index) {
      if (touch[index] == Touch::press) {
        const Stop& stop = problem.stops[index];
        const auto path = detail::path_from(stop, tau);
        presses = true;
        stiffness += stop.stiffness;
        damping += stop.damping;
        for (std::size_t k = 0; k < 4; ++k) {
          target[k] += stop.stiffness * path[k] + stop.damping * static_cast<double>(k + 1) * path[k + 1];
        }
      }
    }
    if (presses) {
      // Arcs in which the series decays as for an angle of one: its powers are bounded by those of 1.62^k / k!.
      constexpr double kGrowth = 1.62;
      powers = std::max(powers, powers_for(kGrowth));
      end = std::min(left, 1.0 / std::max(std::sqrt(z2 + stiffness), damping + problem.drag));
    }
    series[0] = place;
    series[1] = velocity;
    for (std::size_t k = 0; k + 2 < powers && !presses && problem.drag == 0.0; ++k) {
      series[k + 2] = z2 * ((k < problem.terms ? line[k] : 0.0) - series[k]) / static_cast<double>((k + 1) * (k + 2));
    }
    for (std::size_t k = 0; k + 2 < powers && (presses || problem.drag != 0.0); ++k) {
      double pull = z2 * ((k < problem.terms ? line[k] : 0.0) - series[k]);
      pull -= static_cast<double>(k + 1) * problem.drag * series[k + 1];
      if (presses) {
        pull += (k < kMostTerms ? target[k] : 0.0) - stiffness * series[k] -
                damping * static_cast<double>(k + 1) * series[k + 1];
      }
      series[k + 2] = pull / static_cast<double>((k + 1) * (k + 2));
    }
    const double longest = end;
    int met = -1;
    bool opens = false;  // what is met is the end of a closed gap
    const bool stalled = stalls > kMostStalls;
    for (int stop = 0; stop < 2; ++stop) {
      const auto index = static_cast<std::size_t>(stop);
      const Stop& support = problem.stops[index];
      if (!support.present) {
        continue;
      }
      const double side = stop == 0 ? 1.0 : -1.0;
      const auto fill = [&] {
        for (std::size_t k = 0; k < powers; ++k) {
          gap[k] = side * series[k];
        }
        gap[0] = side * (place - support.at);
        if (support.moves) {
          const auto path = detail::path_from(support, tau);
          for (std::size_t k = 0; k < 4; ++k) {
            gap[k] = side * (series[k] - path[k]);
          }
        }
      };
      fill();
      double root = -1.0;
      bool root_opens = false;
      if (touch[index] != Touch::off) {
        const bool slack = touch[index] == Touch::slack;
        if (slack) {
          for (std::size_t k = 0; k < powers; ++k) {
            gap[k] = -gap[k];
          }
          root = first_zero(gap.data(), powers, end);
          root_opens = root >= 0.0;
          fill();
        }
        const std::size_t count = powers - (support.damping > 0.0 ? 1 : 0);
        for (std::size_t k = 0; k < count; ++k) {
          const double rate = k + 1 < powers ? static_cast<double>(k + 1) * gap[k + 1] : 0.0;
          gap[k] = (slack ? 1.0 : -1.0) * (support.stiffness * gap[k] + support.damping * rate);
        }
        std::size_t skip = fresh[index] ? 1 : 0;
        while (skip > 0 && skip < 3 && gap[skip] == 0.0) {
          ++skip;
        }
        const double* from = gap.data() + skip;
        const double until = root >= 0.0 ? root : end;
        const double other = *from < 0.0 ? 0.0 : first_zero(from, count - skip, until);
        if (other >= 0.0 && other <= until) {
          root = other;
          root_opens = !slack && support.damping == 0.0;
        }
        root = stalled ? -1.0 : root;
      } else if (on == stop || gap[0] <= problem.together) {
        // On the stop: the zero at the start, double where it starts without speed, is divided out.
        std::size_t skip = 1;
        gap[1] = stands(gap[1]) ? 0.0 : gap[1];
        if (gap[1] < 0.0) {
          root = 0.0;
          skip = 0;
        } else if (gap[1] == 0.0) {
          skip = gap[2] == 0.0 || (on == stop && gap[2] < 0.0 && gap[3] > 0.0) ? 3 : 2;
        }
        if (skip > 0) {
          const double* from = gap.data() + skip;
          root = *from < 0.0 ? 0.0 : first_zero(from, powers - skip, end);
        }
        root = stalled && support.elastic() ? -1.0 : root;
      } else {
        root = first_zero(gap.data(), powers, end);
      }
      if (root >= 0.0 && root <= end) {
        end = root;
        met = stop;
        opens = root_opens;
      }
    }
    if (stalled && met < 0) {
      end = std::min({end, left, kHold});
    }
    stalls = end == 0.0 ? stalls + 1 : 0;
    add_legendre(series.data(), powers, tau, end, problem.terms, outcome.moments);
    for (std::size_t index = 0; index < 2; ++index) {
      if (touch[index] == Touch::off) {
        continue;
      }
      const Stop& support = problem.stops[index];
      const double side = index == 0 ? 1.0 : -1.0;
      const double start = tau;
      const auto gap_at = [&](double s) { return side * (value(series.data(), powers, s) - support.place(start + s)); };
      const auto rate_at = [&](double s) {
        return side * (slope(series.data(), powers, s) - support.speed(start + s));
      };
      if (touch[index] == Touch::press) {
        // A stop that gives way within the step makes no kink.
        constexpr double kHard = 10.0;
        outcome.kick += std::min(1.0, support.stiffness / kHard) * end *
                        std::abs(support.stiffness * gap_at(0.5 * end) + support.damping * rate_at(0.5 * end));
        outcome.first_impact = std::min(outcome.first_impact, tau);
        ++outcome.impacts;
      }
      if constexpr (!std::is_same_v<Journal, Silent>) {
        journal.touched(tau, tau + end);
        if (touch[index] == Touch::slack) {
          journal.damped(0.5 * support.stiffness * (gap_at(0.0) * gap_at(0.0) - gap_at(end) * gap_at(end)));
          continue;
        }
        double push = 0.0;
        double work = 0.0;
        double loss = 0.0;
        for (const auto& [at, weight] : kGauss) {
          const double rate = rate_at(at * end);
          const double force = -side * (support.stiffness * gap_at(at * end) + support.damping * rate) * weight * end;
          push += force;
          work += force * support.speed(tau + at * end);
          loss += support.damping * rate * rate * weight * end;
        }
        journal.pressed(static_cast<int>(index), push, work);
        journal.damped(loss);
      }
    }
    if constexpr (!std::is_same_v<Journal, Silent>) {
      if (problem.drag != 0.0) {
        journal.damped(dragged(series.data(), powers, tau, end));
      }
    }
    const double arrived = slope(series.data(), powers, end);
    place = value(series.data(), powers, end);
    velocity = arrived;
    tau += end;
    const int stood = on;
    on = -1;
    fresh = {};
    if (met < 0) {
      for (int stop = 0; stop < 2; ++stop) {  // round-off may leave it below by its last bits
        const Stop& support = problem.stops[static_cast<std::size_t>(stop)];
        const double side = stop == 0 ? 1.0 : -1.0;
        if (support.present && !support.elastic() && side * (place - support.place(tau)) < 0.0) {
          place = support.place(tau);
        }
      }
      if (longest < left || (stalled && end < left)) {
        continue;
      }
      break;
    }

    const auto index = static_cast<std::size_t>(met);
    const Stop& support = problem.stops[index];
    const double side = met == 0 ? 1.0 : -1.0;
    if (support.elastic()) {
      if (touch[index] == Touch::off || opens) {
        place = support.place(tau);
      }
      on = opens ? met : -1;
      fresh[index] = !opens && (touch[index] != Touch::off || support.damping == 0.0 ||
                                side * (velocity - support.speed(tau)) == 0.0);
      const bool pressed = touch[index] == Touch::press;
      touch[index] = opens ? Touch::off : (pressed ? Touch::slack : Touch::press);
      if (arc >= kMostArcs) {
        break;
      }
      continue;
    }
    place = support.place(tau);
    const double ground = support.speed(tau);
    const double arrives = side * (velocity - ground);
    const double before = stands(arrives) ? 0.0 : arrives;
    const double after =
        before < 0.0 ? -falling_restitution(support.restitution, support.yield_speed, -before) * before : before;
    double pull = side * z2 * (value(problem.line.data(), problem.terms, tau) - place);
    if (support.moves) {
      pull -= side * (problem.drag * ground + 2.0 * support.path[1] + 6.0 * tau * support.path[2]);
    }
    if (before < 0.0) {
      journal.impact(met, tau, velocity, ground + side * after);
      outcome.first_impact = std::min(outcome.first_impact, tau);
      outcome.kick += after - before;
      ++outcome.impacts;
    }
    // Where it hits too often, or does not get off, the arc of rest tells whether the line lifts it at once.
    const bool tired = outcome.impacts >= kMostImpacts || arc >= kMostArcs || (before == 0.0 && end == 0.0);
    if (tired ||
        (pull <= z2 * problem.pull_resolution && after * after <= std::max(0.0, -2.0 * pull * problem.hop_tolerance))) {
      journal.rest(met, tau, after);
      stuck = stood == met && before == 0.0 && end == 0.0;
      resting = met;
      velocity = ground;
    } else {
      velocity = ground + side * after;
      on = met;
    }
  }
  outcome.displacement = place;
  outcome.velocity = velocity;
  outcome.resting = resting;
  return outcome;
}

}  // namespace udar::local
