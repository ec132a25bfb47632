#include "udar/motion/energy_balance.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numeric>
#include <vector>

#include "udar/numerics/gauss.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

/// The balance as a restart file keeps it.
using LedgerNumbers = std::array<double, sizeof(EnergyLedger) / sizeof(double)>;
constexpr const char* kLedger = "energy_balance";
constexpr const char* kLoadWork = "load_work";  ///< each rank's
constexpr const char* kBaseWork = "base_work";  ///< the same

/// Each rank's number. @note Collective.
std::vector<double> shares_of(MPI_Comm comm, double own) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  std::vector<double> shares(static_cast<std::size_t>(ranks));
  MPI_Allgather(&own, 1, MPI_DOUBLE, shares.data(), 1, MPI_DOUBLE, comm);
  return shares;
}

/// On as many ranks sums round as before.
double own_share(MPI_Comm comm, const std::vector<double>& shares) {
  int rank = 0;
  int ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  if (shares.size() == static_cast<std::size_t>(ranks)) {
    return shares[static_cast<std::size_t>(rank)];
  }
  return rank == 0 ? std::accumulate(shares.begin(), shares.end(), 0.0) : 0.0;
}

}  // namespace

EnergyBalance::EnergyBalance(Equations& equations, const ContactState& contact, const Kinks& kinks)
    : equations_{&equations},
      contact_{&contact},
      kinks_{&kinks},
      works_{equations.loads().time_dependent() || equations.carried() != nullptr},
      flows_{!equations.filtered() || equations.damping().any() || equations.hinges() != nullptr ||
             std::ranges::any_of(contact.supports(),
                                 [](const Support& support) { return support.motion || support.elastic(); })} {}

void EnergyBalance::start(const Row& row, const DenseOutput& step) {
  ledger_ = equations_->energy(row.line, row.masses.position, row.masses.velocity);
  if (flows_) {
    double springs = step.flow(row.time).stored + contact_->spring_energy(row.time, row.masses.position);
    MPI_Allreduce(MPI_IN_PLACE, &springs, 1, MPI_DOUBLE, MPI_SUM, equations_->points().comm());
    ledger_.support_springs += springs;
  }
  ledger_.initial = ledger_.total();
  ledger_.initial_potential = ledger_.load_potential;
  ledger_.initial_base_potential = ledger_.base_potential;
}

/// What keeps travelling masses at their speeds, by three Gauss points: exact to degree 5. @return of all, on the first
/// rank
double EnergyBalance::travel_work(const DenseOutput& step, double step_begin, double until) const {
  if (equations_->carried() == nullptr || !(until > step_begin)) {
    return 0.0;
  }
  const double off = 0.5 * std::sqrt(0.6);
  const std::array<QuadraturePoint, 3> gauss{{{0.5 - off, 5.0 / 18.0}, {0.5, 8.0 / 18.0}, {0.5 + off, 5.0 / 18.0}}};
  const std::size_t count = equations_->points().points();
  MassState masses{.position = std::vector<double>(count), .velocity = std::vector<double>(count)};
  std::vector<std::uint8_t> resting(count);
  LineState line;
  double work = 0.0;
  for (const auto& [at, weight] : gauss) {
    const double time = step_begin + at * (until - step_begin);
    step.masses(time, masses.position, masses.velocity, resting);
    equations_->evaluate({time, step_begin}, masses.position, line);
    work += weight * (until - step_begin) * CarriedMasses::power(line.carried);
  }
  return on_first_rank() ? work : 0.0;
}

/// But for steps of fixed length dF/dt is constant within a step.
EnergyBalance::Work EnergyBalance::load_work(const DenseOutput& step, double step_begin, double until) const {
  if (!works_) {
    return {};
  }
  const std::vector<double> amplitudes = step.amplitude_integrals(until);
  Work work{.loads = travel_work(step, step_begin, until)};
  for (const LoadPattern& pattern : equations_->loads().patterns()) {
    const bool force = pattern.cause == LoadCause::load || pattern.cause == LoadCause::base;
    if (force && !pattern.table->steady() && !pattern.point.empty()) {
      const std::vector<double> moved = changed_by(pattern, step, step_begin, until, amplitudes);
      double& sum = pattern.cause == LoadCause::base ? work.base : work.loads;
      for (std::size_t i = 0; i < moved.size(); ++i) {
        sum -= pattern.share[i] * moved[i];
      }
    }
  }
  work.base += equations_->held().work(step, equations_->loads(), equations_->axis(), step_begin, until);
  return work;
}

/// Integral of df/dt Yc at each point of a pattern, f its table's value. @param amplitudes integrals of the stretch's
/// in corrected modes
std::vector<double> EnergyBalance::changed_by(const LoadPattern& pattern, const DenseOutput& step, double step_begin,
                                              double until, std::span<const double> amplitudes) const {
  const TimeTable& table = *pattern.table;
  std::vector<double> moved(pattern.point.size(), 0.0);
  std::vector<double> place(moved.size());
  std::vector<double> before(moved.size());
  std::vector<double> after(moved.size());
  step.line_integrals(pattern.point, step_begin, before);
  table.each_piece(step_begin, until, [&](double begin, double end) {
    const auto [value, rate] = table.at({begin, begin});
    if (begin > step_begin) {
      const double jump = value - table.at({begin, kinks_->piece_begin(step_begin, begin)}).value;
      step.line_places(pattern.point, begin, place);
      for (std::size_t i = 0; i < moved.size(); ++i) {
        moved[i] += jump * place[i];
      }
    }
    step.line_integrals(pattern.point, end, after);
    for (std::size_t i = 0; i < moved.size(); ++i) {
      moved[i] += rate * (after[i] - before[i]);
    }
    before.swap(after);
  });
  const double rate = table.at(step_begin).rate;
  const auto corrected = equations_->line().corrected_modes();
  for (std::size_t mode = 0; mode < corrected.size(); ++mode) {
    for (std::size_t i = 0; i < moved.size(); ++i) {
      moved[i] -= rate * amplitudes[mode] * corrected[mode].shape[pattern.point[i]];
    }
  }
  return moved;
}

EnergyBalance::Side EnergyBalance::side(const Instant& at, std::span<const double> position,
                                        std::span<const double> velocity, LineState& line) {
  equations_->evaluate(at, position, line, true);
  const EnergyLedger now = equations_->energy(line, position, velocity);
  Side side{.energy = on_first_rank() ? now.total() + now.base_potential : 0.0,
            .place = equations_->line_stretch(line)};
  std::ranges::transform(side.place, position, side.place.begin(), std::plus{});
  return side;
}

/// The line goes evenly from one place to the other as forces do, so that each works against the middle of both; what
/// contact changes in that is the loads', unless the base alone jumps.
void EnergyBalance::end_jump(const Instant& end, const Side& before, const Side& after, double gained) {
  const double change = after.energy - before.energy + gained;
  bool loads_jump = false;
  bool base_jumps = false;
  double of_base = 0.0;
  for (const LoadPattern& pattern : equations_->loads().patterns()) {
    const double jump = pattern.table->at(end.time).value - pattern.table->at(end).value;
    (pattern.cause == LoadCause::base ? base_jumps : loads_jump) |= jump != 0.0;
    for (std::size_t i = 0; pattern.cause == LoadCause::base && i < pattern.point.size(); ++i) {
      const std::size_t point = pattern.point[i];
      of_base -= 0.5 * jump * pattern.share[i] * (before.place[point] + after.place[point]);
    }
  }
  if (!base_jumps) {
    end_step({.loads = change});
  } else if (!loads_jump) {
    end_step({.base = change});
  } else {
    end_step({.loads = change - of_base, .base = of_base});
  }
}

EnergyLedger EnergyBalance::update(const Row& row, const DenseOutput& step, std::span<double> besides,
                                   double tolerated_energy) {
  enum Share : std::size_t {
    lost,
    load,
    base,
    work,
    damped,
    radiated,
    yielded,
    springs,
    shares
  };  // of this rank, within the step
  EnergyLedger now = equations_->energy(row.line, row.masses.position, row.masses.velocity);
  std::vector<double> sums(shares + besides.size(), 0.0);
  sums[lost] = contact_->journal().lost_before(row.time);
  std::ranges::copy(besides, sums.begin() + shares);
  if (works_) {
    const Work within = load_work(step, row.step_begin, row.time);
    sums[load] = work_.loads + within.loads;
    sums[base] = work_.base + within.base;
  }
  if (flows_) {
    const EnergyFlow flow = step.flow(row.time);
    sums[work] = flow.work;
    sums[damped] = flow.damped;
    sums[radiated] = flow.radiated;
    sums[yielded] = flow.yielded;
    sums[springs] = flow.stored + contact_->spring_energy(row.time, row.masses.position);
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM,
                equations_->points().comm());
  std::copy(sums.begin() + shares, sums.end(), besides.begin());
  now.lost_in_impacts = contact_->counts().lost + sums[lost];
  now.load_work = sums[load];
  now.support_work = contact_->counts().work + sums[work];
  now.lost_in_dampers = contact_->counts().damped + sums[damped];
  now.radiated = contact_->counts().radiated + sums[radiated];
  now.lost_in_hinges = contact_->counts().yielded + sums[yielded];
  now.support_springs += sums[springs];
  now.initial = ledger_.initial;
  now.initial_potential = ledger_.initial_potential;
  now.initial_base_potential = ledger_.initial_base_potential;
  now.base_work = sums[base] - (now.base_potential - now.initial_base_potential);
  now.scale = std::max({ledger_.scale, now.scale, now.turned_over(), tolerated_energy});
  if (std::isfinite(now.drift())) {
    ledger_ = now;
  }
  return now;
}

void EnergyBalance::save(MotionState& state) const {
  state.tables[kLoadWork] = shares_of(equations_->points().comm(), work_.loads);
  state.tables[kBaseWork] = shares_of(equations_->points().comm(), work_.base);
  const auto numbers = std::bit_cast<LedgerNumbers>(ledger_);
  state.tables[kLedger].assign(numbers.begin(), numbers.end());
}

void EnergyBalance::restore(const MotionState& state) {
  const std::vector<double>& saved = state.table(kLedger);
  LedgerNumbers numbers{};
  if (saved.size() != numbers.size()) {
    throw InputError{"restart file: its energy balance has another number of entries"};
  }
  std::ranges::copy(saved, numbers.begin());
  ledger_ = std::bit_cast<EnergyLedger>(numbers);
  work_.loads = own_share(equations_->points().comm(), state.table(kLoadWork));
  work_.base = own_share(equations_->points().comm(), state.table(kBaseWork));
}

}  // namespace udar
