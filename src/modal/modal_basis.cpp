#include "udar/modal/modal_basis.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "udar/filter/modes.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

/// Filter springs on which the modes wanted and the rest are easily told apart: 0.3 of the last mode's frequency
/// (measured: so the Lanczos basis of 2 k + 4 holds k modes, and columns of the rest converge tenfold a solve).
FilterParameters separating(const BeamChain& chain, FilterParameters parameters, PetscInt count) {
  double softest = std::numeric_limits<double>::infinity();
  for (const BeamSegment& segment : chain.parameters().segments) {
    if (!segment.is_gap()) {
      softest = std::min(softest, std::sqrt(segment.bending_stiffness / segment.mass_per_length));
    }
  }
  const double half_waves = std::max(static_cast<double>(count) - 1.5, 1.5);
  constexpr double kShare = 0.3;
  parameters.filter_frequency = kShare * softest * std::pow(std::numbers::pi * half_waves / chain.length(), 2.0);
  return parameters;
}

double add_up(MPI_Comm comm, double value) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, comm);
  return value;
}

}  // namespace

ModalBasis::ModalBasis(const BeamChain& chain, FilterParameters parameters, PetscInt count)
    : line_{chain, separating(chain, parameters, count)} {
  find_rigid();
  const auto rigid = static_cast<PetscInt>(modes());
  if (count < rigid || count >= chain.points().total()) {
    throw InputError{"modal modes: " + std::to_string(count) + " is not allowed, expected " + std::to_string(rigid) +
                     " to " + std::to_string(chain.points().total() - 1) +
                     ": all motions that nothing holds, and fewer than there are points"};
  }
  find_flexible(count - rigid);
}

void ModalBasis::find_rigid() {
  shapes_ = rigid_shapes(line_);
  frequency_.assign(shapes_.size(), 0.0);
}

void ModalBasis::find_flexible(PetscInt count) {
  if (count == 0) {
    return;
  }
  std::vector<Mode> found = modes_beside(line_, shapes_, count);
  for (Mode& mode : found) {
    frequency_.push_back(mode.frequency);
    shapes_.push_back(std::move(mode.shape));
  }
}

std::vector<double> ModalBasis::amplitudes(std::span<const double> values) const {
  const auto mass = line_.mass();
  std::vector<double> sums(modes());
  for (std::size_t m = 0; m < modes(); ++m) {
    for (std::size_t i = 0; i < mass.size(); ++i) {
      sums[m] += mass[i] * shapes_[m][i] * values[i];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, line_.points().comm());
  return sums;
}

std::vector<double> ModalBasis::loads(std::span<const double> force) const {
  std::vector<double> sums(modes());
  for (std::size_t m = 0; m < modes(); ++m) {
    for (std::size_t i = 0; i < force.size(); ++i) {
      sums[m] += shapes_[m][i] * force[i];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, line_.points().comm());
  return sums;
}

double ModalBasis::share_outside(std::span<const double> values) const {
  std::vector<double> rest(values.begin(), values.end());
  const auto norm = [this](const std::vector<double>& of) {
    double sum = 0.0;
    for (std::size_t i = 0; i < of.size(); ++i) {
      sum += line_.mass()[i] * of[i] * of[i];
    }
    return add_up(line_.points().comm(), sum);
  };
  const double all = norm(rest);
  remove_modes(rest);
  return all > 0.0 ? norm(rest) / all : 0.0;
}

/// x - Phi Phi' M x.
void ModalBasis::remove_modes(std::vector<double>& values) const {
  const std::vector<double> amplitude = amplitudes(values);
  for (std::size_t m = 0; m < modes(); ++m) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] -= amplitude[m] * shapes_[m][i];
    }
  }
}

/// The fixed point of g <- P (wf^2 M + C)^-1 (F + wf^2 M g).
std::vector<double> ModalBasis::residual(std::span<const double> force) {
  const std::size_t count = line_.mass().size();
  const auto mass = line_.mass();
  std::vector<double> column(count, 0.0);
  // What the modes carry moves nothing else: weight on a free structure.
  const std::vector<double> modal = loads(force);
  std::vector<double> rest(force.begin(), force.end());
  rest.resize(count, 0.0);
  double left = 0.0;
  double whole = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    whole += rest[i] * rest[i];
    for (std::size_t m = 0; m < modes(); ++m) {
      rest[i] -= mass[i] * shapes_[m][i] * modal[m];
    }
    left += rest[i] * rest[i];
  }
  left = add_up(line_.points().comm(), left);
  whole = add_up(line_.points().comm(), whole);
  constexpr double kNone = 1e-24;  // squares of forces: the rounding of some tens of modes
  if (left <= kNone * whole) {
    return column;
  }
  std::vector<double> stretch(count);
  std::vector<double> next(count);
  constexpr int kMost = 60;
  constexpr double kSettled = 1e-13;  // a solve gains a digit and more; what is left is that of the line solve
  for (int sweep = 0; sweep < kMost; ++sweep) {
    line_.solve(column, rest, stretch, {});
    for (std::size_t i = 0; i < count; ++i) {
      next[i] = column[i] + stretch[i];
    }
    remove_modes(next);
    std::array<double, 2> sums{};
    for (std::size_t i = 0; i < count; ++i) {
      const double change = next[i] - column[i];
      sums[0] += mass[i] * change * change;
      sums[1] += mass[i] * next[i] * next[i];
    }
    MPI_Allreduce(MPI_IN_PLACE, sums.data(), 2, MPI_DOUBLE, MPI_SUM, line_.points().comm());
    column.swap(next);
    if (sums[0] <= kSettled * kSettled * sums[1]) {
      return column;
    }
  }
  throw SolveError{"modal integrator: the static rest under a contact point was not found"};
}

ReducedModel ModalBasis::reduce(std::span<const LinePoint> points, std::vector<std::vector<double>>& columns) {
  const MassPoints& masses = line_.points();
  const std::size_t count = points.size();
  ReducedModel model;
  model.frequency = frequency_;
  model.row.assign(count * modes(), 0.0);
  model.compliance.assign(count * count, 0.0);
  columns.clear();
  for (std::size_t c = 0; c < count; ++c) {
    const LinePoint& point = points[c];
    std::vector<double> force(line_.mass().size(), 0.0);
    if (masses.owns(point.node)) {
      const auto local = static_cast<std::size_t>(point.node - masses.begin());
      force[local] = point.side;
      for (std::size_t m = 0; m < modes(); ++m) {
        model.row[c * modes() + m] = point.side * shapes_[m][local];
      }
    }
    columns.push_back(residual(force));
    model.give.push_back(point.compliance);
  }
  for (std::size_t c = 0; c < count; ++c) {
    for (std::size_t d = 0; d < count; ++d) {
      if (masses.owns(points[d].node)) {
        const double given = points[d].side * columns[c][static_cast<std::size_t>(points[d].node - masses.begin())];
        model.compliance[c * count + d] += 0.5 * given;
        model.compliance[d * count + c] += 0.5 * given;
      }
    }
  }
  for (std::vector<double>* values : {&model.row, &model.compliance}) {
    MPI_Allreduce(MPI_IN_PLACE, values->data(), static_cast<int>(values->size()), MPI_DOUBLE, MPI_SUM, masses.comm());
  }
  return model;
}

}  // namespace udar
