#include "udar/modal/modal_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <utility>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

/// How far the rest gives way beside the supports, the largest of all points: what is wrong with a model of so many
/// modes is of the order of its square. Rigid points: 0.
double softness(const ReducedModel& model) {
  double largest = 0.0;
  for (std::size_t i = 0; i < model.points(); ++i) {
    if (model.give[i] > 0.0) {
      largest = std::max(largest, model.compliance[i * model.points() + i] / model.give[i]);
    }
  }
  return largest;
}

bool any_rigid(const ReducedModel& model) {
  return std::ranges::any_of(model.give, [](double give) { return give == 0.0; });
}

/// About how many modes will do, never fewer than the model has; as many if these will.
PetscInt wanted_modes(const ReducedModel& model) {
  constexpr double kSoft = 0.03;  // where sags have settled to 0.1 % (docs/theory.md)
  constexpr double kSpan =
      200.0;  // rigid: the last frequency over the first, errors of sags up to 3 % (docs/theory.md)
  const auto modes = static_cast<double>(model.modes());
  // What is left out gives way by the third power of the number of modes; frequencies grow by the square.
  const double soft = std::max(1.0, std::cbrt(softness(model) / kSoft));
  const auto first = std::ranges::find_if(model.frequency, [](double w) { return w > 0.0; });
  const bool rigid = any_rigid(model) && first != model.frequency.end();
  const double span = rigid ? std::max(1.0, std::sqrt(kSpan * *first / model.frequency.back())) : 1.0;
  const double factor = std::max(soft, span);
  return factor == 1.0 ? static_cast<PetscInt>(model.modes())
                       : 2 * static_cast<PetscInt>(std::ceil(0.5 * factor * modes + 0.01));
}

/// How high a support is from a time on, until the next row of its table, in powers of the time since [m/s^n].
std::array<double, 4> powers_of(const SupportMotion& motion, double time) {
  const auto next = std::ranges::upper_bound(motion.time(), time);
  const double length = next != motion.time().end() ? *next - time : 1.0;
  std::array<double, 4> powers = motion.cubic(time, length);
  double unit = 1.0;
  for (double& power : powers) {
    power /= unit;
    unit *= length;
  }
  return powers;
}

/// The rest must be able to give way under every rigid contact point by itself.
PetscInt most_modes(const Structure& structure, std::span<const LinePoint> points) {
  const auto rigid = std::ranges::count(points, 0.0, &LinePoint::compliance);
  return movable_points(structure.points()) - std::max<PetscInt>(1, static_cast<PetscInt>(rigid));
}

}  // namespace

ModalModel::ModalModel(const Structure& structure, const FilterParameters& parameters, const Loads& loads,
                       std::vector<double> axis, std::span<const LinePoint> points, const ModalChoice& choice)
    : masses_{&structure.points()}, loads_{&loads}, points_{points.begin(), points.end()}, axis_{std::move(axis)} {
  choose(structure, parameters, choice.modes);
  set_lags(choice);
  bound_ = reduced_.frequency_bound();
  // Above this, points too close for the modes shake against each other in ways that no beam does.
  constexpr double kStiffest = 4.0;
  const double last = reduced_.frequency.back();
  if (last > 0.0 && !(bound_ <= kStiffest * last)) {
    std::ostringstream message;
    message << "modal modes: " << reduced_.modes() << " is not allowed, contact could swing at " << bound_
            << " rad/s where the last mode has " << last
            << ": contact points are too close for so few modes; give `support stiffness`, fewer points under a "
               "support, or more modes";
    throw InputError{message.str()};
  }
  weight_ = respond(loads.weight());
  for (const LoadPattern& pattern : loads.patterns()) {
    std::vector<double> unit(masses_->points());
    for (std::size_t i = 0; i < pattern.point.size(); ++i) {
      unit[pattern.point[i]] += pattern.share[i];
    }
    unit_loads_.push_back(respond(unit));
  }
  solves_ += basis_->solves();
  drive_from(0.0);
}

void ModalModel::set_lags(const ModalChoice& choice) {
  if (!choice.damping_ratio.empty()) {
    std::size_t flexible = 0;
    for (const double w : reduced_.frequency) {
      reduced_.ratio.push_back(w == 0.0 ? 0.0
                                        : choice.damping_ratio[std::min(flexible, choice.damping_ratio.size() - 1)]);
      flexible += w > 0.0 ? 1 : 0;
    }
  }
  if (std::ranges::any_of(points_, [](const LinePoint& point) { return point.damping > 0.0; })) {
    for (const LinePoint& point : points_) {
      reduced_.support_lag.push_back(point.damping * point.compliance);
    }
  }
  const double last = reduced_.frequency.back();
  reduced_.rest_lag = last > 0.0 ? choice.retardation / last : 0.0;
}

/// @note Collective: about ten line solves and two reductions.
ModalModel::UnitLoad ModalModel::respond(std::span<const double> force) {
  UnitLoad load{.modal = basis_->loads(force), .rest = basis_->residual(force), .at = {}};
  load.at.resize(points_.size());
  for (std::size_t c = 0; c < points_.size(); ++c) {
    if (masses_->owns(points_[c].node)) {
      load.at[c] = points_[c].side * load.rest[static_cast<std::size_t>(points_[c].node - masses_->begin())];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, load.at.data(), static_cast<int>(load.at.size()), MPI_DOUBLE, MPI_SUM, masses_->comm());
  return load;
}

void ModalModel::drive_from(double time) {
  const std::size_t count = unit_loads_.size();
  drive_ = {.time = time, .load = weight_.modal};
  drive_.offset.resize(points_.size());
  for (std::size_t c = 0; c < points_.size(); ++c) {
    const LinePoint& point = points_[c];
    if (masses_->owns(point.node)) {
      const double axis = axis_[static_cast<std::size_t>(point.node - masses_->begin())];
      drive_.offset[c] = point.side * (axis - point.height);
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, drive_.offset.data(), static_cast<int>(points_.size()), MPI_DOUBLE, MPI_SUM,
                masses_->comm());
  const auto add = [](std::vector<double>& to, double factor, const std::vector<double>& what) {
    to.resize(what.size());
    std::ranges::transform(to, what, to.begin(), [factor](double sum, double one) { return sum + factor * one; });
  };
  add(drive_.offset, 1.0, weight_.at);
  force_.assign(count, 0.0);
  force_rate_.assign(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    const auto [force, rate] = loads_->patterns()[i].table->at(time);
    force_[i] = force;
    force_rate_[i] = rate;
    add(drive_.load, force_[i], unit_loads_[i].modal);
    add(drive_.load_rate, force_rate_[i], unit_loads_[i].modal);
    add(drive_.offset, force_[i], unit_loads_[i].at);
    add(drive_.offset_rate, force_rate_[i], unit_loads_[i].at);
  }
  if (std::ranges::any_of(points_, [](const LinePoint& point) { return point.motion != nullptr; })) {
    for (const LinePoint& point : points_) {
      auto& powers = drive_.retreat.emplace_back();
      if (point.motion != nullptr) {
        powers = powers_of(*point.motion, time);
        std::ranges::transform(powers, powers.begin(), [&](double power) { return -point.side * power; });
      }
    }
  }
}

void ModalModel::choose(const Structure& structure, const FilterParameters& parameters, PetscInt asked) {
  if (asked > 0) {
    return build(structure, parameters, asked);
  }
  constexpr PetscInt kFewest = 12;
  constexpr PetscInt kMost = 100;
  // The upper half of the modes of a lumped beam is no beam's, and what is left beside it gives way by next to nothing.
  const PetscInt most =
      std::min({kMost, most_modes(structure, points_), std::max<PetscInt>(structure.points().total() / 2, 2)});
  for (PetscInt modes = std::min(kFewest, most);;) {
    build(structure, parameters, modes);
    const PetscInt wanted = std::min(most, wanted_modes(reduced_));
    if (wanted <= static_cast<PetscInt>(reduced_.modes())) {
      return;
    }
    modes = wanted;
  }
}

void ModalModel::build(const Structure& structure, const FilterParameters& parameters, PetscInt modes) {
  solves_ += basis_ != nullptr ? basis_->solves() : 0;
  const PetscInt most = most_modes(structure, points_);
  if (modes > most) {
    throw InputError{"modal modes: " + std::to_string(modes) + " is not allowed, expected at most " +
                     std::to_string(most) + ": something must be left to give way under the contact points"};
  }
  // Frequencies grow at least as the number of modes does.
  const double guess = basis_ != nullptr
                           ? basis_->separation() * static_cast<double>(modes) / static_cast<double>(basis_->modes())
                           : 0.0;
  basis_ = std::make_unique<ModalBasis>(structure, parameters, modes, guess);
  reduced_ = basis_->reduce(points_, columns_);
}

ModalState ModalModel::project(double time, std::span<const double> position, std::span<const double> velocity) const {
  std::vector<double> away(position.begin(), position.end());
  for (std::size_t i = 0; i < away.size(); ++i) {
    away[i] -= axis_[i];
  }
  constexpr double kShare = 1e-3;
  const double of_places = basis_->share_outside(away);
  const double of_speeds = basis_->share_outside(velocity);
  if (!(of_places <= kShare) || !(of_speeds <= kShare)) {
    const double outside = of_places <= of_speeds ? of_speeds : of_places;
    std::ostringstream message;
    message << "modal modes: " << basis_->modes() << " is not allowed, they leave out " << outside
            << " of the motion at the start, more than " << kShare << "; expected more modes, or a smoother start";
    throw InputError{message.str()};
  }
  ModalState state{reduced_.modes(), reduced_.points()};
  state.time = time;
  state.amplitude = basis_->amplitudes(away);
  state.velocity = basis_->amplitudes(velocity);
  return state;
}

void ModalModel::expand(const ModalState& state, std::span<double> position, std::span<double> velocity) const {
  std::ranges::copy(axis_, position.begin());
  std::ranges::fill(velocity, 0.0);
  const auto add = [](std::span<double> to, double factor, const std::vector<double>& what) {
    for (std::size_t i = 0; factor != 0.0 && i < to.size(); ++i) {
      to[i] += factor * what[i];
    }
  };
  add(position, 1.0, weight_.rest);
  for (std::size_t i = 0; i < unit_loads_.size(); ++i) {
    add(position, force_[i] + (state.time - drive_.time) * force_rate_[i], unit_loads_[i].rest);
  }
  for (std::size_t m = 0; m < basis_->modes(); ++m) {
    add(position, state.amplitude[m], basis_->shape(m));
    add(velocity, state.velocity[m], basis_->shape(m));
  }
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    add(position, state.rest_force[c], columns_[c]);
  }
}

double ModalModel::passed(std::size_t point, double from, double until, std::span<const double> amplitude,
                          std::span<const double> rest_force) const {
  const double length = until - from;
  double sum = length * (axis_[point] + weight_.rest[point]);
  for (std::size_t i = 0; i < unit_loads_.size(); ++i) {
    const double mean = force_[i] + (0.5 * (from + until) - drive_.time) * force_rate_[i];
    sum += length * mean * unit_loads_[i].rest[point];
  }
  for (std::size_t m = 0; m < amplitude.size(); ++m) {
    sum += amplitude[m] * basis_->shape(m)[point];
  }
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    sum += rest_force[c] * columns_[c][point];
  }
  return sum;
}

}  // namespace udar
