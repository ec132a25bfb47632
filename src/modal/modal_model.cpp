#include "udar/modal/modal_model.hpp"

#include <algorithm>
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

/// The rest must be able to give way under every contact point by itself.
PetscInt most_modes(const BeamChain& chain, std::span<const LinePoint> points) {
  return chain.points().total() - std::max<PetscInt>(1, static_cast<PetscInt>(points.size()));
}

}  // namespace

ModalModel::ModalModel(const BeamChain& chain, const FilterParameters& parameters, std::span<const double> force,
                       std::vector<double> axis, std::span<const LinePoint> points, const ModalChoice& choice)
    : axis_{std::move(axis)} {
  choose(chain, parameters, points, choice.modes);
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
  drive_.load = basis_->loads(force);
  rest_ = basis_->residual(force);
  drive_.offset.assign(points.size(), 0.0);
  const MassPoints& masses = chain.points();
  for (std::size_t i = 0; i < rest_.size(); ++i) {
    rest_[i] += axis_[i];
  }
  for (std::size_t c = 0; c < points.size(); ++c) {
    if (masses.owns(points[c].node)) {
      const auto local = static_cast<std::size_t>(points[c].node - masses.begin());
      drive_.offset[c] = points[c].side * (rest_[local] - points[c].height);
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, drive_.offset.data(), static_cast<int>(points.size()), MPI_DOUBLE, MPI_SUM,
                masses.comm());
  solves_ += basis_->solves();
}

void ModalModel::choose(const BeamChain& chain, const FilterParameters& parameters, std::span<const LinePoint> points,
                        PetscInt asked) {
  if (asked > 0) {
    return build(chain, parameters, points, asked);
  }
  constexpr PetscInt kFewest = 12;
  constexpr PetscInt kMost = 100;
  const PetscInt there = most_modes(chain, points);
  const PetscInt most = std::min(kMost, there);
  for (PetscInt modes = std::min(kFewest, most);;) {
    build(chain, parameters, points, modes);
    const PetscInt wanted = std::min(most, wanted_modes(reduced_));
    if (wanted <= modes) {
      return;
    }
    modes = wanted;
  }
}

void ModalModel::build(const BeamChain& chain, const FilterParameters& parameters, std::span<const LinePoint> points,
                       PetscInt modes) {
  solves_ += basis_ != nullptr ? basis_->solves() : 0;
  const PetscInt most = most_modes(chain, points);
  if (modes > most) {
    throw InputError{"modal modes: " + std::to_string(modes) + " is not allowed, expected at most " +
                     std::to_string(most) + ": something must be left to give way under the contact points"};
  }
  basis_ = std::make_unique<ModalBasis>(chain, parameters, modes);
  reduced_ = basis_->reduce(points, columns_);
}

ModalState ModalModel::project(double time, std::span<const double> position, std::span<const double> velocity) const {
  std::vector<double> away(position.begin(), position.end());
  for (std::size_t i = 0; i < away.size(); ++i) {
    away[i] -= axis_[i];
  }
  constexpr double kShare = 1e-3;
  const double outside = std::max(basis_->share_outside(away), basis_->share_outside(velocity));
  if (outside > kShare) {
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
  std::ranges::copy(rest_, position.begin());
  std::ranges::fill(velocity, 0.0);
  for (std::size_t m = 0; m < basis_->modes(); ++m) {
    const std::vector<double>& shape = basis_->shape(m);
    for (std::size_t i = 0; i < shape.size(); ++i) {
      position[i] += state.amplitude[m] * shape[i];
      velocity[i] += state.velocity[m] * shape[i];
    }
  }
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    for (std::size_t i = 0; state.rest_force[c] != 0.0 && i < position.size(); ++i) {
      position[i] += state.rest_force[c] * columns_[c][i];
    }
  }
}

}  // namespace udar
