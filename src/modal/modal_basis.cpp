#include "udar/modal/modal_basis.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "udar/filter/rigid_shapes.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

/// Two frequencies this close are one, with any shapes in between.
constexpr double kSameFrequency = 1e-6;

/// Whether all of its flexible modes have a frequency of their own, by what is known of a line.
bool is_single_beam(const Structure& structure) {
  const BeamChain* beam = structure.chain();
  return beam != nullptr && std::ranges::none_of(beam->parameters().segments, &BeamSegment::is_gap);
}

double add_up(MPI_Comm comm, double value) {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_SUM, comm);
  return value;
}

}  // namespace

PetscInt movable_points(const MassPoints& points) {
  PetscInt count = 0;
  for (std::size_t i = 0; i < points.points(); ++i) {
    count += points.fixed(i) ? 0 : 1;
  }
  MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPIU_INT, MPI_SUM, points.comm());
  return count;
}

ModalBasis::ModalBasis(const Structure& structure, const FilterParameters& parameters, PetscInt count, double guess)
    : separation_{separate_modes(structure, parameters, count, guess)}, line_{structure, separation_.filter} {
  shapes_ = rigid_shapes(line_);
  frequency_.assign(shapes_.size(), 0.0);
  const auto rigid = static_cast<PetscInt>(modes());
  const PetscInt all = movable_points(structure.points());
  if (count < rigid || count >= all) {
    throw InputError{"modal modes: " + std::to_string(count) + " is not allowed, expected " + std::to_string(rigid) +
                     " to " + std::to_string(all - 1) +
                     ": all motions that nothing holds, and fewer than there are points"};
  }
  find_flexible(count - rigid);
}

void ModalBasis::find_flexible(PetscInt count) {
  const bool single = is_single_beam(line_.structure());
  std::vector<Mode> found;
  if (count > 0) {
    // What shapes are off by is the residual over the distance to the next mode, which of a single beam is far.
    found = modes_beside(line_, shapes_,
                         single ? ModeSearch{.count = count} : ModeSearch{.count = count, .tolerance = 1e-13});
  }
  if (!single) {
    add_companions(found);
    const auto alike = [](const Mode& a, const Mode& b) { return b.frequency <= (1.0 + kSameFrequency) * a.frequency; };
    auto wanted = static_cast<std::size_t>(count);
    for (std::size_t first = 0, last = 1; first < found.size(); first = last++) {
      while (last < found.size() && alike(found[last - 1], found[last])) {
        ++last;
      }
      wanted = first < wanted ? std::max(wanted, last) : wanted;
      settle({found.begin() + static_cast<std::ptrdiff_t>(first), last - first});
    }
    found.resize(std::min(wanted, found.size()));
  }
  for (Mode& mode : found) {
    frequency_.push_back(mode.frequency);
    shapes_.push_back(std::move(mode.shape));
  }
}

/// Modes up to the last one found that the search has passed by, as one start vector gives one mode of each frequency.
void ModalBasis::add_companions(std::vector<Mode>& found) {
  constexpr PetscInt kFew = 3;
  constexpr double kRough = 1e-6;
  constexpr double kFine = 1e-13;
  const double last = (found.empty() ? 0.0 : found.back().frequency) * (1.0 + kSameFrequency);
  std::vector<std::vector<double>> known = shapes_;
  for (const Mode& mode : found) {
    known.push_back(mode.shape);
  }
  const PetscInt all = movable_points(line_.points());
  for (int start = 1; static_cast<PetscInt>(known.size()) < all; ++start) {
    const PetscInt few = std::min(kFew, all - static_cast<PetscInt>(known.size()));
    const std::vector<Mode> seen = modes_beside(line_, known, {.count = few, .tolerance = kRough, .start = start});
    const auto passed_by =
        static_cast<PetscInt>(std::ranges::count_if(seen, [&](const Mode& mode) { return mode.frequency <= last; }));
    if (passed_by == 0) {
      break;
    }
    for (Mode& mode : modes_beside(line_, known, {.count = passed_by, .tolerance = kFine, .start = start})) {
      known.push_back(mode.shape);
      found.push_back(std::move(mode));
    }
  }
  std::ranges::stable_sort(found, {}, &Mode::frequency);
}

/// Gives modes of one frequency shapes that depend on nothing but the structure: what vectors the same on any ranks
/// have of them, one after the other beside those before. Of a single mode that is its sign.
void ModalBasis::settle(std::span<Mode> alike) const {
  constexpr int kVectors = 11;  // none that a search starts from
  const MassPoints& points = line_.points();
  const std::size_t size = alike.size();
  std::vector<double> shares(size * size, 0.0);  // of each vector: of each mode in it
  for (std::size_t v = 0; v < size; ++v) {
    for (std::size_t m = 0; m < size; ++m) {
      for (std::size_t i = 0; i < points.points(); ++i) {
        shares[v * size + m] +=
            line_.mass()[i] * start_value(points, i, kVectors + static_cast<int>(v)) * alike[m].shape[i];
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, shares.data(), static_cast<int>(shares.size()), MPI_DOUBLE, MPI_SUM, points.comm());
  const auto row = [&](std::size_t v) { return std::span{shares}.subspan(v * size, size); };
  std::vector<std::vector<double>> shapes(size, std::vector<double>(points.points(), 0.0));
  for (std::size_t v = 0; v < size; ++v) {
    for (std::size_t before = 0; before < v; ++before) {
      const double same = std::inner_product(row(v).begin(), row(v).end(), row(before).begin(), 0.0);
      for (std::size_t m = 0; m < size; ++m) {
        row(v)[m] -= same * row(before)[m];
      }
    }
    const double length = std::sqrt(std::inner_product(row(v).begin(), row(v).end(), row(v).begin(), 0.0));
    for (std::size_t m = 0; m < size; ++m) {
      row(v)[m] /= length;
      for (std::size_t i = 0; i < points.points(); ++i) {
        shapes[v][i] += row(v)[m] * alike[m].shape[i];
      }
    }
  }
  for (std::size_t v = 0; v < size; ++v) {
    alike[v].shape = std::move(shapes[v]);
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
  return all == 0.0 ? 0.0 : norm(rest) / all;
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
    left += line_.points().fixed(i) ? 0.0 : rest[i] * rest[i];  // what is held takes its force by itself
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
