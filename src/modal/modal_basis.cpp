#include "udar/modal/modal_basis.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>

#include "udar/filter/modes.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

/// Filter springs on which the modes wanted and the rest are easily told apart: 0.3 of the last mode's frequency
/// (measured: so a Lanczos basis of 2 k holds k modes, and columns of the rest gain more than a digit a solve).
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

/// Among moving along y and turning, what strains nothing: the null space of a matrix of two.
void ModalBasis::find_rigid() {
  const MassPoints& points = line_.points();
  const auto mass = line_.mass();
  const std::size_t count = mass.size();
  std::array<std::vector<double>, 2> tried;
  std::array<std::vector<double>, 2> stretch;
  const Extent extent = points.extent();
  for (std::size_t t = 0; t < tried.size(); ++t) {
    tried[t].resize(count);
    stretch[t].resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const double x = 2.0 * (points.place(i).x - extent.middle()) / extent.length();
      tried[t][i] = points.fixed(i) ? 0.0 : t == 0 ? 1.0 : x;
    }
    line_.solve(tried[t], {}, stretch[t], {});
  }
  // s' M s and u' M u of the two.
  std::array<double, 6> sums{};
  for (std::size_t i = 0; i < count; ++i) {
    const std::array<double, 2> u{tried[0][i], tried[1][i]};
    const std::array<double, 2> s{stretch[0][i], stretch[1][i]};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t a = k / 2;
      const std::size_t b = (k + 1) / 2;
      sums[k] += mass[i] * u[a] * u[b];
      sums[3 + k] += mass[i] * s[a] * s[b];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, points.comm());
  // M-orthonormal combinations of the two, then those of them that strain least.
  const double first = 1.0 / std::sqrt(sums[0]);
  const double mixed = sums[1] / sums[0];
  const double second = 1.0 / std::sqrt(sums[2] - mixed * sums[1]);
  const std::array<std::array<double, 2>, 2> ortho{{{first, 0.0}, {-mixed * second, second}}};
  std::array<double, 3> strain{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& a = ortho[k / 2];
    const auto& b = ortho[(k + 1) / 2];
    strain[k] = a[0] * b[0] * sums[3] + (a[0] * b[1] + a[1] * b[0]) * sums[4] + a[1] * b[1] * sums[5];
  }
  // The square of what a line solve rounds by; the share of a true mode, over that of the last, is far above.
  constexpr double kRigid = 1e-20;
  // Where both are free they stay as they are, on any number of ranks.
  const double angle = strain[0] + strain[2] > kRigid ? 0.5 * std::atan2(2.0 * strain[1], strain[0] - strain[2]) : 0.0;
  for (const double turned : {angle, angle + 0.5 * std::numbers::pi}) {
    const double c = turned == 0.0 ? 1.0 : std::cos(turned);
    const double s = std::sin(turned);
    const double share = c * c * strain[0] + 2.0 * c * s * strain[1] + s * s * strain[2];
    if (share > kRigid) {
      continue;
    }
    std::vector<double>& shape = shapes_.emplace_back(count);
    for (std::size_t i = 0; i < count; ++i) {
      shape[i] = (c * ortho[0][0] + s * ortho[1][0]) * tried[0][i] + s * ortho[1][1] * tried[1][i];
    }
    frequency_.push_back(0.0);
  }
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

std::vector<double> ModalBasis::residual(std::span<const double> force) {
  const auto mass = line_.mass();
  // What the modes carry moves nothing else: weight on a free structure.
  const std::vector<double> modal = loads(force);
  std::vector<double> rest(force.begin(), force.end());
  rest.resize(mass.size(), 0.0);
  double left = 0.0;
  double whole = 0.0;
  for (std::size_t i = 0; i < mass.size(); ++i) {
    whole += rest[i] * rest[i];
    for (std::size_t m = 0; m < modes(); ++m) {
      rest[i] -= mass[i] * shapes_[m][i] * modal[m];
    }
    left += rest[i] * rest[i];
  }
  left = add_up(line_.points().comm(), left);
  whole = add_up(line_.points().comm(), whole);
  constexpr double kNone = 1e-24;  // squares of forces: the rounding of some tens of modes
  return left <= kNone * whole ? std::vector<double>(mass.size(), 0.0) : static_under(std::move(rest));
}

/// C g = F for a force that no mode has, by conjugate gradients with line solves in front: z = (wf^2 M + C)^-1 r has
/// C z = r - wf^2 M z, and the numbers w^2 / (wf^2 + w^2) that they meet differ by a tenth.
std::vector<double> ModalBasis::static_under(std::vector<double> rest) {
  const MPI_Comm comm = line_.points().comm();
  const auto mass = line_.mass();
  const std::size_t count = mass.size();
  const double wf = line_.filter_frequency();
  const std::vector<double> none(count, 0.0);
  std::vector<double> column(count, 0.0);
  std::vector<double> solved(count);
  std::vector<double> direction(count, 0.0);
  std::vector<double> pull(count, 0.0);  // C direction
  double slope = 1.0;
  constexpr int kMost = 60;
  constexpr double kSettled = 1e-13;                                               // beside it a line solve rounds
  const double least = kSettled * std::pow(std::max(wf, frequency_.back()), 2.0);  // C on what modes leave is stiffer
  for (int sweep = 0; sweep < kMost; ++sweep) {
    line_.solve(none, rest, solved, {});
    remove_modes(solved);
    const double before =
        std::exchange(slope, add_up(comm, std::inner_product(solved.begin(), solved.end(), rest.begin(), 0.0)));
    const double keep = sweep > 0 ? slope / before : 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      direction[i] = solved[i] + keep * direction[i];
      pull[i] = rest[i] - wf * wf * mass[i] * solved[i] + keep * pull[i];
    }
    const double step = slope / add_up(comm, std::inner_product(direction.begin(), direction.end(), pull.begin(), 0.0));
    std::array<double, 2> sums{};
    for (std::size_t i = 0; i < count; ++i) {
      column[i] += step * direction[i];
      rest[i] -= step * pull[i];
      sums[0] += line_.points().fixed(i) ? 0.0 : rest[i] * rest[i] / mass[i];
      sums[1] += mass[i] * column[i] * column[i];
    }
    MPI_Allreduce(MPI_IN_PLACE, sums.data(), 2, MPI_DOUBLE, MPI_SUM, comm);
    if (sums[0] <= least * least * sums[1]) {
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
