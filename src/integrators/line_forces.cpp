#include "udar/integrators/line_forces.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "udar/numerics/power_series.hpp"
#include "udar/numerics/roots.hpp"
#include "udar/petsc/log.hpp"

namespace udar {
namespace {

/// The first point is as far from its border as the last, to the bit.
constexpr std::array<QuadraturePoint, kGauss.size()> kPoints = [] {
  auto points = kGauss;
  points.front().at = 1.0 - points.back().at;
  return points;
}();

}  // namespace

LineForces::LineForces(Sweep& sweep, LineContact& contact, ContactState& state)
    : sweep_{&sweep}, contact_{&contact}, state_{&state}, kink_integral_{kink_integral(sweep.terms)} {
  for (std::size_t q = 0; q < kPoints.size(); ++q) {
    for (std::size_t j = 0; j < sweep.terms; ++j) {
      legendre_[q][j] = legendre(j, kPoints[q].at);
    }
    force_at_[q].resize(contact.points().size());
    gap_at_[q].resize(contact.dense() ? 0 : contact.points().size());
  }
  gap_.resize(contact.points().size());
}

void LineForces::begin() {
  first_sweep_ = true;
  const std::size_t terms = sweep_->terms;
  face_.assign(contact_->points().size() * terms, 0.0);
  const SupportMotion* known = nullptr;
  std::array<double, kMostTerms> lift{};
  for (std::size_t i = 0; i < contact_->points().size(); ++i) {
    const LinePoint& point = contact_->points()[i];
    face_[i * terms] = point.height;
    if (point.motion != nullptr && point.motion.get() != known) {
      known = point.motion.get();
      const std::array<double, 4> cubic = known->cubic(sweep_->begin, sweep_->step);
      lift = {};
      for (std::size_t q = 0; q < kPoints.size(); ++q) {
        add_projection(q, power_series::value(cubic.data(), cubic.size(), kPoints[q].at), lift.data());
      }
    }
    for (std::size_t j = 0; point.motion != nullptr && j < terms; ++j) {
      face_[i * terms + j] += lift[j];
    }
  }
}

/// What a value at a Gauss point adds to the Legendre coefficients of a function.
void LineForces::add_projection(std::size_t q, double value, double* coefficients) const {
  for (std::size_t j = 0; j < sweep_->terms; ++j) {
    coefficients[j] += static_cast<double>(2 * j + 1) * kPoints[q].weight * legendre_[q][j] * value;
  }
}

/// What a kink of unit slope costs: the errors of the Gauss points' integrals, of the line's motion and of its moment
/// about the end, which momentum and place of the masses take over, or what the terms leave of it. Each of these has
/// zeros, but no two in one place.
double LineForces::missed_of(double tau) const {
  const double left = 1.0 - tau;
  double sum = -0.5 * left * left;
  double moment = -left * left * left / 6.0;
  for (const auto& point : kPoints) {
    const double ramp = point.weight * std::max(point.at - tau, 0.0);
    sum += ramp;
    moment += (1.0 - point.at) * ramp;
  }
  return std::max({std::abs(sum), std::abs(moment), kink_miss(sweep_->terms, tau)});
}

void LineForces::apply() {
  const std::size_t terms = sweep_->terms;
  const std::size_t count = contact_->points().size();
  contact_->gather(
      terms,
      [&](std::size_t point, std::size_t j) {
        const std::size_t node = contact_->local(point);
        const bool steady = j < 2 && !sweep_->series.steady[j].empty();
        return sweep_->line(j, node) + sweep_->moment(j, node) + (steady ? sweep_->series.steady[j][node] : 0.0) +
               (j == 0 ? sweep_->start[node] : 0.0);
      },
      free_gap_);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < terms; ++j) {
      free_gap_[i * terms + j] = contact_->points()[i].side * (free_gap_[i * terms + j] - face_[i * terms + j]);
    }
  }
  force_.assign(count * terms, 0.0);
  for (std::size_t q = 0; q < kPoints.size(); ++q) {
    // From the set of the last sweep; at first from that of the point before, so that a restart finds the same.
    const bool guess = !first_sweep_ || q == 0;
    const Active guessed = first_sweep_ ? Active{} : active_[q];
    free_gap_at(kPoints[q].at);
    if (contact_->dense()) {
      if (guess) {
        contact_->problem().assume(guessed);
      }
      contact_->problem().solve(gap_, force_at_[q]);
      active_[q] = contact_->problem().active();
      in_contact_[q] = !active_[q].empty();
    } else {
      ObstacleForces& many = contact_->many();
      if (guess) {
        many.assume(guessed);
      }
      in_contact_[q] = many.solve(gap_, force_at_[q]);
      active_[q] = many.active();
      gap_at_[q].assign(many.gaps().begin(), many.gaps().end());
    }
    for (std::size_t i = 0; in_contact_[q] && i < count; ++i) {
      if (force_at_[q][i] != 0.0) {
        add_projection(q, force_at_[q][i], &force_[i * terms]);
      }
    }
  }
  first_sweep_ = false;
  kinks_.clear();
  own_kinks_.clear();
  if (contact_->dense()) {
    locate_kinks();
  } else {
    estimate_kinks();
  }

  std::array<double*, kMostTerms> line{};
  for (std::size_t j = 0; j < terms; ++j) {
    line[j] = sweep_->series.rows[j].data();
  }
  contact_->add(force_, {line.data(), terms}, {});
  std::vector<double> amplitude(sweep_->series.amplitude.size());
  for (std::size_t j = 0; j < terms && !amplitude.empty(); ++j) {
    std::ranges::fill(amplitude, 0.0);
    contact_->add_amplitudes(force_, j, terms, amplitude);
    for (std::size_t mode = 0; mode < amplitude.size(); ++mode) {
      sweep_->series.amplitude[mode][j] += amplitude[mode];
    }
  }
}

void LineForces::locate_kinks() {
  for (std::size_t q = 0; q + 1 < kPoints.size(); ++q) {
    if (active_[q] != active_[q + 1]) {
      const double tau = std::min(first_change(active_[q], kPoints[q].at, kPoints[q + 1].at), kPoints[q + 1].at);
      add_kink(active_[q], active_[q + 1], tau);
    }
  }
  find_border_kink(active_.front(), kPoints.front().at, 0.0);
  find_border_kink(active_.back(), kPoints.back().at, 1.0);
}

/// Of many points: where contact of all begins and ends, by the free line; and for each of this rank's that changes
/// sides between two Gauss points, where its gap, gone on with from the open side, closes. What of these is before
/// the first or after the last Gauss point is not seen.
void LineForces::estimate_kinks() {
  find_borders_of_contact();
  const auto slope = [&](std::size_t i, std::size_t q) {  // between a Gauss point and the next
    return (gap_at_[q + 1][i] - gap_at_[q][i]) / (kPoints[q + 1].at - kPoints[q].at);
  };
  for (std::size_t q = 0; q + 1 < kPoints.size(); ++q) {
    for (std::size_t i = 0; in_contact_[q] && in_contact_[q + 1] && i < gap_.size(); ++i) {
      const bool before = force_at_[q][i] > 0.0;
      const bool after = force_at_[q + 1][i] > 0.0;
      if (before == after) {
        continue;
      }
      // Where there is no second point on the open side, the gap across is the least slope that fits.
      const bool known = before ? q + 2 < kPoints.size() : q > 0;
      const double open = known ? slope(i, before ? q + 1 : q - 1) : slope(i, q);
      const std::size_t from = before ? q + 1 : q;
      const double tau = open != 0.0 ? kPoints[from].at - gap_at_[from][i] / open : kPoints[from].at;
      own_kinks_.push_back({.tau = std::clamp(tau, kPoints[q].at, kPoints[q + 1].at), .jump = std::abs(open)});
    }
  }
}

/// Contact begins, and in reversed time ends, where the free line first is below a support.
void LineForces::find_borders_of_contact() {
  const std::size_t terms = sweep_->terms;
  std::array<double, 2> own{1.0, 1.0};  // from the beginning, from the end
  std::array<double, 2> jump{};
  for (std::size_t i = 0; i < gap_.size(); ++i) {
    const double* series = free_gap_.data() + i * terms;
    double reach = 0.0;  // no Legendre polynomial exceeds one
    for (std::size_t j = 1; j < terms; ++j) {
      reach += std::abs(series[j]);
    }
    for (std::size_t end = 0; series[0] <= reach && end < 2; ++end) {
      const auto gap = sweep_->powers([&](std::size_t j) { return (end * j % 2 == 1 ? -1.0 : 1.0) * series[j]; });
      const double zero = gap[0] <= 0.0 ? 0.0 : first_zero(gap.data(), terms, own[end]);
      if (zero >= 0.0 && zero < own[end]) {
        own[end] = zero;
        jump[end] = std::abs(power_series::slope(gap.data(), terms, zero));
      }
    }
  }
  const petsc::LogScope reduction{petsc::log_events().reduction};
  std::array<double, 2> first = own;
  MPI_Allreduce(MPI_IN_PLACE, first.data(), 2, MPI_DOUBLE, MPI_MIN, contact_->comm());
  if (first[0] == 1.0) {
    return;
  }
  for (std::size_t end = 0; end < 2; ++end) {
    jump[end] = own[end] == first[end] ? jump[end] : 0.0;
  }
  MPI_Allreduce(MPI_IN_PLACE, jump.data(), 2, MPI_DOUBLE, MPI_MAX, contact_->comm());
  for (std::size_t end = 0; end < 2; ++end) {
    if (first[end] > 0.0) {
      kinks_.push_back({.tau = end == 1 ? 1.0 - first[end] : first[end], .jump = jump[end]});
    }
  }
}

/// Fills `gap_` with the gaps of the free line.
void LineForces::free_gap_at(double tau) {
  std::array<double, kMostTerms> values{};
  for (std::size_t j = 0; j < sweep_->terms; ++j) {
    values[j] = legendre(j, tau);
  }
  for (std::size_t i = 0; i < gap_.size(); ++i) {
    gap_[i] = 0.0;
    for (std::size_t j = 0; j < sweep_->terms; ++j) {
      gap_[i] += free_gap_[i * sweep_->terms + j] * values[j];
    }
  }
}

/// Before the first and after the last Gauss point.
void LineForces::find_border_kink(const Active& inside, double at, double border) {
  const double tau = first_change(inside, at, border);
  if (std::abs(tau - at) >= std::abs(border - at)) {
    return;
  }
  const double beyond = 0.5 * (tau + border);
  free_gap_at(beyond);
  std::vector<double> force(gap_.size());
  contact_->problem().solve(gap_, force);
  const Active outside = contact_->problem().active();
  if (outside != inside) {
    add_kink(inside, outside, tau);
  }
}

/// Legendre coefficients of gaps and forces by point while these points touch.
void LineForces::motion(const Active& active, std::vector<double>& gap, std::vector<double>& force) const {
  const std::size_t terms = sweep_->terms;
  const std::size_t count = gap_.size();
  contact_->problem().assume(active);
  gap.resize(count * terms);
  force.resize(count * terms);
  std::vector<double> column(count);
  std::vector<double> forces(count);
  std::vector<double> gaps(count);
  for (std::size_t j = 0; j < terms; ++j) {
    for (std::size_t i = 0; i < count; ++i) {
      column[i] = free_gap_[i * terms + j];
    }
    contact_->problem().respond(column, forces);
    contact_->problem().gaps(column, forces, gaps);
    for (std::size_t i = 0; i < count; ++i) {
      gap[i * terms + j] = gaps[i];
      force[i * terms + j] = forces[i];
    }
  }
}

/// When, on the way from one time to another (which may be earlier), a force or an open gap turns negative; beyond the
/// end: never.
double LineForces::first_change(const Active& active, double from, double to) const {
  const std::size_t terms = sweep_->terms;
  std::vector<double> gap;
  std::vector<double> force;
  motion(active, gap, force);
  const double length = std::abs(to - from);
  const double direction = to > from ? 1.0 : -1.0;
  double first = 2.0;
  auto next = active.begin();
  for (std::size_t i = 0; i < gap_.size(); ++i) {
    const bool touches = next != active.end() && *next == i;
    next += touches ? 1 : 0;
    const double* series = (touches ? force : gap).data() + i * terms;
    std::array<double, kMostTerms> powers{};
    for (std::size_t j = 0; j < terms; ++j) {
      for (std::size_t k = 0; k <= j; ++k) {
        powers[k] += series[j] * kLegendre[j][k];
      }
    }
    power_series::shift(powers.data(), terms, from);
    double sign = 1.0;
    for (std::size_t k = 0; k < terms; ++k) {
      powers[k] *= sign;
      sign *= direction;
    }
    powers[0] = std::max(powers[0], 0.0);  // negative by rounding only
    const double zero = first_zero(powers.data(), terms, length);
    if (zero >= 0.0) {
      first = std::min(first, zero);
    }
  }
  return from + direction * first;
}

/// Where a support gives way the line's slope jumps by less than that of its gap, which is from the face. What pulls
/// the masses jumps by what forces do in corrected modes besides.
void LineForces::add_kink(const Active& before, const Active& after, double tau) {
  const std::size_t terms = sweep_->terms;
  std::vector<double> gap_before;
  std::vector<double> gap_after;
  std::vector<double> force_before;
  std::vector<double> force;
  motion(before, gap_before, force_before);
  motion(after, gap_after, force);
  std::vector<double> turn(force.size() / terms);
  for (std::size_t i = 0; i < turn.size(); ++i) {
    for (std::size_t j = 1; j < terms; ++j) {
      turn[i] += (force[i * terms + j] - force_before[i * terms + j]) * legendre_slope(j, tau);
    }
  }
  std::vector<double> amplitude(sweep_->series.amplitude.size());
  contact_->add_amplitudes(turn, 0, 1, amplitude);
  double jump = 0.0;
  for (std::size_t i = 0; i < gap_.size(); ++i) {
    double slope = contact_->nearer(i, amplitude);
    for (std::size_t j = 1; j < terms; ++j) {
      slope += (gap_after[i * terms + j] - gap_before[i * terms + j]) * legendre_slope(j, tau);
    }
    jump = std::max(jump, std::abs(slope));
  }
  kinks_.push_back({.tau = tau, .jump = jump});
}

void LineForces::tell(Tally& tally) const {
  const auto enter = [&](const Kink& kink) {
    const double missed = kink.jump * missed_of(kink.tau) / kink_integral_;
    const auto bin = std::min(static_cast<std::size_t>(kink.tau * kBins), kBins - 1);
    tally.most[Tally::kink] = std::max(tally.most[Tally::kink], missed);
    tally.kick[bin] += missed;
    tally.first[bin] = std::min(tally.first[bin], kink.tau);
  };
  std::ranges::for_each(own_kinks_, enter);
  if (contact_->on_first_rank()) {  // sums over the ranks count them once
    std::ranges::for_each(kinks_, enter);
  }
}

EnergyFlow LineForces::flow(double until) const {
  const std::size_t terms = sweep_->terms;
  EnergyFlow sum;
  for (const std::size_t i : contact_->mine()) {
    const LinePoint& point = contact_->points()[i];
    for (std::size_t q = 0; point.motion != nullptr && q < kPoints.size(); ++q) {
      const double tau = kPoints[q].at * until;
      double force = 0.0;
      double rise = 0.0;  // over the step
      for (std::size_t j = 0; j < terms; ++j) {
        force += force_[i * terms + j] * legendre(j, tau);
        rise += face_[i * terms + j] * legendre_slope(j, tau);
      }
      sum.work += point.side * force * rise * kPoints[q].weight * until;
    }
  }
  return sum;
}

/// Smallest distances are those of the line that the forces hold at the Gauss points, not of its polynomial.
void LineForces::write_journal() {
  const std::size_t terms = sweep_->terms;
  state_->journal().record_flow(flow(1.0));
  for (const std::size_t i : contact_->mine()) {
    const LinePoint& point = contact_->points()[i];
    state_->journal().record_force(point.support, point.side * force_[i * terms] * sweep_->step);
    if (force_[i * terms] > 0.0) {
      state_->journal().record_contact_time(contact_->local(i), {sweep_->begin, sweep_->begin + sweep_->step});
    }
  }
  for (std::size_t q = 0; q < kPoints.size(); ++q) {
    if (contact_->dense()) {
      free_gap_at(kPoints[q].at);
      gap_at_[q].resize(gap_.size());
      contact_->problem().assume(active_[q]);
      contact_->problem().gaps(gap_, force_at_[q], gap_at_[q]);
    }
    for (const std::size_t i : contact_->mine()) {
      const double given = contact_->points()[i].compliance * force_at_[q][i];
      state_->record_gap(gap_at_[q][i] - given, contact_->local(i), sweep_->begin + kPoints[q].at * sweep_->step);
    }
  }
  if (std::ranges::find(in_contact_, true) != in_contact_.end()) {
    // Contact begins and ends with a kink.
    const auto at = [&](double tau) { return sweep_->begin + tau * sweep_->step; };
    double from = 0.0;
    double until = 1.0;
    if (!kinks_.empty()) {
      const auto [first, last] = std::ranges::minmax_element(kinks_, {}, &Kink::tau);
      from = in_contact_.front() ? 0.0 : first->tau;
      until = in_contact_.back() ? 1.0 : last->tau;
    }
    state_->journal().record_line_contact({at(from), at(until)});
  }
}

}  // namespace udar
