#include "local/law_arcs.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "udar/numerics/gauss.hpp"
#include "udar/numerics/power_series.hpp"
#include "udar/numerics/roots.hpp"

namespace udar::local {
namespace {

using power_series::slope;
using power_series::value;

/// Over the step squared: what a force [N] gives to each of the masses that share it [m per step^2].
double share_of(const Stop& stop) { return stop.step * stop.step / stop.carried; }

/// Powers of the force of a piece from those of the compression, one after the other.
class ForceSeries {
 public:
  /// @param step [s]
  ForceSeries(const LawPiece& piece, double step) : piece_{&piece}, step_{step} {}

  /// @param d powers of the compression [m], up to the k + 1st @return the kth of the force [N]
  double next(std::size_t k, const double* d) {
    if (piece_->coefficient == 0.0) {
      return k == 0 ? piece_->force + piece_->stiffness * (d[0] - piece_->from) : piece_->stiffness * d[k];
    }
    power_[k] = raised(k, d);
    double sum = power_[k];
    if (piece_->damping > 0.0) {
      double damped = 0.0;
      for (std::size_t j = 0; j <= k; ++j) {
        damped += static_cast<double>(j + 1) * d[j + 1] * power_[k - j];
      }
      sum += piece_->damping / step_ * damped;
    }
    return piece_->coefficient * sum;
  }

 private:
  /// u = d^n has d u' = n u d'.
  [[nodiscard]] double raised(std::size_t k, const double* d) const {
    const double n = piece_->exponent;
    if (n == 1.0) {
      return d[k];
    }
    if (k == 0) {
      return std::pow(d[0], n);
    }
    double sum = 0.0;
    for (std::size_t j = 1; j <= k; ++j) {
      sum += (n * static_cast<double>(j) - static_cast<double>(k - j)) * d[j] * power_[k - j];
    }
    return sum / (static_cast<double>(k) * d[0]);
  }

  const LawPiece* piece_;
  double step_;
  std::array<double, kMostPowers> power_{};
};

/// A law at work on an arc.
struct Pressing {
  std::size_t stop = 0;
  LawPiece piece;
  std::array<double, kMostTerms> path{};
  std::array<double, kMostPowers> compression{};
};

/// How far the series of a motion at such a speed is exact to its last bits.
double reach(const FreeArc& arc, double speed) {
  constexpr double kLastBit = 0.5 * std::numeric_limits<double>::epsilon();
  double least = arc.longest;
  for (std::size_t k = kMostPowers - 3; k < kMostPowers; ++k) {
    const double term = static_cast<double>(k) * std::abs(arc.series[k]);
    const double far = std::pow(kLastBit * speed / term, 1.0 / static_cast<double>(k - 1));
    least = far < least ? far : least;
  }
  return least;
}

/// First zero of what ends a piece. @param skip how often it is zero at the start by construction
double first_end(const double* series, std::size_t count, std::size_t skip, double end) {
  while (skip > 0 && skip < 3 && series[skip] == 0.0) {
    ++skip;
  }
  const double* from = series + skip;
  return *from < 0.0 ? 0.0 : first_zero(from, count - skip, end);
}

}  // namespace

LawMotion law_motion(const Problem& problem, const Mass& mass, std::size_t stop) {
  const Stop& support = problem.stops[stop];
  const double side = side_of(stop);
  return {.compression = -side * (mass.place - support.place(mass.tau)),
          .rate = -side * (mass.velocity - support.speed(mass.tau)) / support.step,
          .mass = support.carried,
          .resolution = problem.together};
}

double face_of_law(const Stop& stop, const LawState& state) { return stop.contact_law->permanent_set(state.largest); }

void start_law_arc(const Problem& problem, const Mass& mass, FreeArc& arc) {
  constexpr double kGrowth = 1.62;  // as in `start_free_arc`
  const double z2 = problem.angle * problem.angle;
  const auto line = line_from(problem, mass.tau);
  arc.left = problem.until - mass.tau;
  double stiffness = 0.0;
  double damping = 0.0;
  double stiff = 0.0;
  double energy = 0.0;                      // of curved laws, per mass [m^2 per step^2]
  std::array<double, kMostTerms> target{};  // k q + c q' of springs on the other side
  std::array<std::optional<Pressing>, 2> laws;
  std::array<std::optional<ForceSeries>, 2> forces;
  bool curved = false;
  for (std::size_t index = 0; index < 2; ++index) {
    const Stop& stop = problem.stops[index];
    const LawState& state = mass.law[index];
    if (state.closed()) {
      Pressing& law = laws[index].emplace(
          Pressing{.stop = index, .piece = stop.contact_law->piece(state), .path = path_from(stop, mass.tau)});
      forces[index].emplace(law.piece, stop.step);
      curved = curved || law.piece.coefficient > 0.0;
      stiff += share_of(stop) * std::abs(law.piece.stiffness);
      energy += share_of(stop) * stop.contact_law->stored(law_motion(problem, mass, index).compression, state.largest);
    } else if (mass.touch[index].pressing()) {
      const auto path = path_from(stop, mass.tau);
      stiffness += stop.stiffness;
      damping += stop.damping;
      for (std::size_t k = 0; k < 4; ++k) {
        target[k] += stop.stiffness * path[k] + stop.damping * static_cast<double>(k + 1) * path[k + 1];
      }
    }
  }
  arc.powers = curved ? kMostPowers : std::max(problem.powers, powers_for(kGrowth));
  arc.longest = std::min(arc.left, 1.0 / std::max(std::sqrt(z2 + stiffness + stiff), damping + problem.drag));
  auto& series = arc.series;
  series[0] = mass.place;
  series[1] = mass.velocity;
  const auto compress = [&](Pressing& law, std::size_t k) {
    const double path = k < 4 ? law.path[k] : 0.0;
    law.compression[k] = -side_of(law.stop) * (series[k] - path);
  };
  for (auto& law : laws) {
    if (law) {
      compress(*law, 0);
    }
  }
  for (std::size_t k = 0; k + 2 < arc.powers; ++k) {
    double pull = z2 * ((k < problem.terms ? line[k] : 0.0) - series[k]);
    pull -= static_cast<double>(k + 1) * problem.drag * series[k + 1];
    pull += (k < kMostTerms ? target[k] : 0.0) - stiffness * series[k] -
            damping * static_cast<double>(k + 1) * series[k + 1];
    for (std::size_t index = 0; index < 2; ++index) {
      if (laws[index]) {
        compress(*laws[index], k + 1);
        pull +=
            side_of(index) * share_of(problem.stops[index]) * forces[index]->next(k, laws[index]->compression.data());
      }
    }
    series[k + 2] = pull / static_cast<double>((k + 1) * (k + 2));
  }
  if (curved) {
    arc.longest = reach(arc, std::sqrt(mass.velocity * mass.velocity + 2.0 * energy));
    arc.longest = mass.arcs < kMostArcs ? arc.longest : arc.left;
  }
}

StopEvent end_of_law(const Problem& problem, const Mass& mass, std::size_t stop, FreeArc& arc, double end) {
  const Stop& support = problem.stops[stop];
  const LawState& state = mass.law[stop];
  const LawPiece piece = support.contact_law->piece(state);
  const auto& gap = arc.gap;
  std::array<double, kMostPowers> series{};
  StopEvent first;
  const auto see = [&](LawEnd which, std::size_t count) {
    const std::size_t skip = state.zero != which ? 0 : (state.turned ? 2 : 1);
    const double at = first_end(series.data(), count, skip, first.at >= 0.0 ? first.at : end);
    if (at >= 0.0 && (first.at < 0.0 || at < first.at)) {
      first = {.at = at, .opens = false, .end = which};
    }
  };
  if (piece.low > -LawPiece::kNowhere) {
    for (std::size_t k = 0; k < arc.powers; ++k) {
      series[k] = -gap[k];
    }
    series[0] -= piece.low;
    see(LawEnd::low, arc.powers);
  }
  if (piece.high < LawPiece::kNowhere) {
    std::copy_n(gap.begin(), arc.powers, series.begin());
    series[0] += piece.high;
    see(LawEnd::high, arc.powers);
  }
  if (piece.grows || piece.pulls != 0.0) {
    for (std::size_t k = 0; k + 1 < arc.powers; ++k) {
      series[k] = -static_cast<double>(k + 1) * gap[k + 1];
    }
  }
  if (piece.grows) {
    series[0] = state.turned || stands(problem, series[0]) ? 0.0 : series[0];
    see(LawEnd::turn, arc.powers - 1);
  } else if (piece.pulls != 0.0) {
    for (std::size_t k = 0; k + 1 < arc.powers; ++k) {
      series[k] *= piece.pulls * piece.damping / support.step;
    }
    series[0] += piece.pulls;
    see(LawEnd::pull, arc.powers - 1);
  }
  return first;
}

StopReport report_law(const Problem& problem, const FreeArc& arc, const Mass& mass, std::size_t stop) {
  const Stop& support = problem.stops[stop];
  const LawState& state = mass.law[stop];
  const LawPiece piece = support.contact_law->piece(state);
  const double side = side_of(stop);
  StopReport report{.touched = true, .pressed = true};
  if (piece.pulls < 0.0) {  // the face follows at no force, with what was stored lost
    const auto in_law = [&](double s) {
      const double d = -side * (value(arc.series.data(), arc.powers, s) - support.place(mass.tau + s));
      return share_of(support) * support.contact_law->stored(d, state.largest);
    };
    report.damped = in_law(0.0) - in_law(arc.length);
    return report;
  }
  for (const auto& [at, weight] : kGauss) {
    const double s = at * arc.length;
    const double ground = support.speed(mass.tau + s);
    const double d = -side * (value(arc.series.data(), arc.powers, s) - support.place(mass.tau + s));
    const double rate = -side * (slope(arc.series.data(), arc.powers, s) - ground) / support.step;
    const double push = side * share_of(support) * piece.at(d, rate) * weight * arc.length;
    report.push += push;
    report.work += push * ground;
    report.damped +=
        share_of(support) * support.step * support.contact_law->loss_rate(state, d, rate) * weight * arc.length;
  }
  return report;
}

void count_law(const Problem& problem, const FreeArc& arc, const Mass& mass, std::size_t stop, Outcome& outcome) {
  constexpr double kHard = 10.0;  // as for springs
  const Stop& support = problem.stops[stop];
  const LawPiece piece = support.contact_law->piece(mass.law[stop]);
  const double side = side_of(stop);
  const double middle = 0.5 * arc.length;
  const double place = value(arc.series.data(), arc.powers, middle) - support.place(mass.tau + middle);
  const double speed = slope(arc.series.data(), arc.powers, middle) - support.speed(mass.tau + middle);
  const double hard = share_of(support) * std::abs(piece.tangent(-side * place)) / kHard;
  outcome.kick += std::min(1.0, hard) * arc.length * share_of(support) *
                  std::abs(piece.at(-side * place, -side * speed / support.step));
  outcome.first_impact = std::min(outcome.first_impact, mass.tau);
  ++outcome.impacts;
}

void pass_law(const Problem& problem, double length, Mass& mass) {
  for (std::size_t stop = 0; stop < 2; ++stop) {
    LawState& state = mass.law[stop];
    if (!state.closed() || length == 0.0) {
      continue;
    }
    state.zero = LawEnd::none;
    state.turned = false;
    if (problem.stops[stop].contact_law->piece(state).grows) {
      state.largest = std::max(state.largest, law_motion(problem, mass, stop).compression);
    }
  }
}

void change_law(const Problem& problem, const FreeArc& arc, Mass& mass) {
  const auto stop = static_cast<std::size_t>(arc.met);
  const Stop& support = problem.stops[stop];
  LawState& state = mass.law[stop];
  const bool met = !state.closed();
  if (!met) {
    state = support.contact_law->next(state, arc.end, law_motion(problem, mass, stop).compression);
  }
  const bool opens = !met && !state.closed();
  if (met || opens) {
    mass.place = support.place(mass.tau) - side_of(stop) * face_of_law(support, state);
  }
  if (met) {
    state = support.contact_law->touch(state, law_motion(problem, mass, stop));
  }
  mass.standing = opens ? arc.met : -1;
}

}  // namespace udar::local
