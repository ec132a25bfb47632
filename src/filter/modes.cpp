#include "udar/filter/modes.hpp"

#include <slepceps.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/shell_matrix.hpp"

namespace udar {
namespace {

using EigenSolver = petsc::Handle<EPS, EPSDestroy>;

/// The symmetric operator -M^(1/2) d(M^(-1/2) x): its eigenvalues are w^2 / (wf^2 + w^2).
struct FilterShare {
  FilteredStructure* line;
  std::vector<double> displacement;
  std::vector<double> stretch;

  explicit FilterShare(FilteredStructure& filtered)
      : line{&filtered}, displacement(filtered.mass().size()), stretch(filtered.mass().size()) {}
  void multiply(std::span<const double> x, std::span<double> y) {
    const auto mass = line->mass();
    for (std::size_t i = 0; i < mass.size(); ++i) {
      displacement[i] = x[i] / std::sqrt(mass[i]);
    }
    line->solve(displacement, {}, stretch, {});
    for (std::size_t i = 0; i < mass.size(); ++i) {
      y[i] = -stretch[i] * std::sqrt(mass[i]);
    }
  }
};

/// What to ask SLEPc for.
struct EigenQuery {
  PetscInt count = 1;
  EPSWhich end = EPS_SMALLEST_REAL;
  double tolerance = 1e-10;
  EPSConv measure = EPS_CONV_REL;                 // residual relative to the eigenvalue, or as it is
  PetscInt basis = PETSC_DEFAULT;                 // vectors of the Lanczos basis
  std::span<const std::vector<double>> beside{};  // M-orthonormal shapes that are known
};

/// M^(1/2) shape of what is known: the solver looks beside these.
void deflate(EPS solver, const FilteredStructure& line, Vec like, std::span<const std::vector<double>> shapes) {
  std::vector<petsc::Vector> owned(shapes.size());
  std::vector<Vec> known;
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    UDAR_CALL(VecDuplicate(like, owned[k].put()));
    const petsc::WriteArray values{owned[k]};
    for (std::size_t i = 0; i < shapes[k].size(); ++i) {
      values.values()[i] = std::sqrt(line.mass()[i]) * shapes[k][i];
    }
    known.push_back(owned[k]);
  }
  if (!known.empty()) {
    UDAR_CALL(EPSSetDeflationSpace(solver, static_cast<PetscInt>(known.size()), known.data()));
  }
}

/// Eigenvalues from the end asked for on, as many as have converged, and with `shapes` their vectors.
std::vector<double> eigenvalues(FilteredStructure& line, const EigenQuery& wanted,
                                std::vector<std::vector<double>>* shapes) {
  const MassPoints& points = line.points();
  const auto local = static_cast<PetscInt>(points.coordinates());
  const PetscInt total = points.components() * points.total();
  FilterShare context{line};
  const petsc::Matrix shell = petsc::symmetric_shell<&FilterShare::multiply>(points.comm(), local, total, context);
  petsc::Vector vector;
  UDAR_CALL(MatCreateVecs(shell, vector.put(), nullptr));
  // A start that has something of every mode and does not depend on the ranks. Not where the line is fixed: the mass
  // there has a motion of its own.
  double* start = nullptr;
  UDAR_CALL(VecGetArrayWrite(vector, &start));
  for (PetscInt i = 0; i < local; ++i) {
    const auto number = static_cast<double>(points.begin() + i);
    const bool fixed = points.fixed(static_cast<std::size_t>(i));
    start[i] = fixed ? 0.0 : 1.0 + std::sin(0.7 * number * number + number);
  }
  UDAR_CALL(VecRestoreArrayWrite(vector, &start));
  EigenSolver solver;
  UDAR_CALL(EPSCreate(points.comm(), solver.put()));
  UDAR_CALL(EPSSetOptionsPrefix(solver, "filter_"));
  UDAR_CALL(EPSSetOperators(solver, shell, nullptr));
  UDAR_CALL(EPSSetProblemType(solver, EPS_HEP));
  UDAR_CALL(EPSSetWhichEigenpairs(solver, wanted.end));
  UDAR_CALL(EPSSetDimensions(solver, std::min(wanted.count, total), wanted.basis, PETSC_DEFAULT));
  UDAR_CALL(EPSSetConvergenceTest(solver, wanted.measure));
  UDAR_CALL(EPSSetTolerances(solver, wanted.tolerance, PETSC_DEFAULT));
  std::array<Vec, 1> first{vector};
  UDAR_CALL(EPSSetInitialSpace(solver, 1, first.data()));
  deflate(solver, line, vector, wanted.beside);
  UDAR_CALL(EPSSetFromOptions(solver));
  UDAR_CALL(EPSSolve(solver));

  PetscInt converged = 0;
  UDAR_CALL(EPSGetConverged(solver, &converged));
  std::vector<double> values(static_cast<std::size_t>(converged));
  for (PetscInt i = 0; i < converged; ++i) {
    UDAR_CALL(EPSGetEigenpair(solver, i, &values[static_cast<std::size_t>(i)], nullptr,
                              shapes != nullptr ? static_cast<Vec>(vector) : nullptr, nullptr));
    if (shapes != nullptr) {
      const double* entries = nullptr;
      UDAR_CALL(VecGetArrayRead(vector, &entries));
      std::vector<double>& shape = shapes->emplace_back(entries, entries + local);
      UDAR_CALL(VecRestoreArrayRead(vector, &entries));
      for (std::size_t node = 0; node < shape.size(); ++node) {
        shape[node] = points.fixed(node) ? 0.0 : shape[node] / std::sqrt(line.mass()[node]);
      }
    }
  }
  return values;
}

std::vector<Mode> modes_of(FilteredStructure& line, EigenQuery wanted, bool with_shapes) {
  // A mode this slow compared with wf is a rigid motion seen through round-off, which assembled matrices have more of;
  // a value as close to one is the mass where the line is fixed.
  constexpr double kRigid = 1e-12;
  constexpr double kRounding = 64.0 * std::numeric_limits<double>::epsilon();
  double rigid = kRigid;
  if (line.structure().chain() == nullptr) {
    rigid = std::max(rigid, kRounding * line.structure().largest_ratio() / std::pow(line.filter_frequency(), 2.0));
  }
  const PetscInt count = wanted.count;
  wanted.count += line.structure().rigid_modes();
  std::vector<std::vector<double>> shapes;
  const std::vector<double> values = eigenvalues(line, wanted, with_shapes ? &shapes : nullptr);
  const double wf = line.filter_frequency();
  std::vector<Mode> modes;
  for (std::size_t i = 0; i < values.size() && static_cast<PetscInt>(modes.size()) < count; ++i) {
    const double share = values[i];  // w^2 / (wf^2 + w^2)
    if (share > rigid && share < 1.0 - kRigid) {
      Mode mode{.frequency = wf * std::sqrt(share / (1.0 - share)), .filtered = wf * std::sqrt(share), .shape = {}};
      if (with_shapes) {
        mode.shape = std::move(shapes[i]);
      }
      modes.push_back(std::move(mode));
    }
  }
  return modes;
}

/// Near the first frequency of a beam; of matrices, which do not tell, a thousandth of what no frequency is far above:
/// the modes themselves correct it.
double first_guess(const Structure& structure) {
  if (const BeamChain* beam = structure.chain(); beam != nullptr) {
    double softest = std::numeric_limits<double>::infinity();
    for (const BeamSegment& segment : beam->parameters().segments) {
      if (!segment.is_gap()) {
        softest = std::min(softest, std::sqrt(segment.bending_stiffness / segment.mass_per_length));
      }
    }
    return softest * std::pow(std::numbers::pi * 1.5 / beam->length(), 2.0);
  }
  return 1e-3 * std::sqrt(structure.largest_ratio());
}

}  // namespace

double filtered_frequency(double frequency, double filter_frequency) {
  return frequency / std::hypot(1.0, frequency / filter_frequency);
}

double filter_frequency_for(double frequency, double accuracy) {
  return frequency * (1.0 - accuracy) / std::sqrt(accuracy * (2.0 - accuracy));
}

std::vector<Mode> lowest_modes(FilteredStructure& line, PetscInt count) {
  // As it is: relative to the value of a rigid motion, which is rounding, no residual is small.
  return modes_of(line, {.count = count, .measure = EPS_CONV_ABS}, false);
}

std::vector<Mode> exact_modes(const Structure& structure, const FilterParameters& filter, PetscInt count) {
  const double wf = filter.shift();
  FilterParameters parameters = filter;
  // Shares w^2 / (wf^2 + w^2) of the first and the last mode as far from 0 as from 1: wf is their geometric mean.
  parameters.filter_frequency = first_guess(structure);
  constexpr int kMostTrials = 8;
  constexpr double kNear = 2.0;
  constexpr double kFarBelow = 1e-3;
  for (int trial = 0; trial < kMostTrials; ++trial) {
    FilteredStructure line{structure, parameters};
    const std::vector<Mode> rough = modes_of(line, {.count = count, .tolerance = 1e-9, .measure = EPS_CONV_ABS}, false);
    if (rough.empty()) {
      if (structure.chain() != nullptr) {
        break;
      }
      parameters.filter_frequency *= kFarBelow;  // all below what it resolves
      continue;
    }
    const double best = std::sqrt(rough.front().frequency * rough.back().frequency);
    const double ratio = best / std::exchange(parameters.filter_frequency, best);
    if (ratio < kNear && ratio > 1.0 / kNear) {
      break;
    }
  }
  FilteredStructure line{structure, parameters};
  // 1e-13: the line solve is right to 1e-14, and shapes are right to the residual over the distance of the shares,
  // some 1e-2; frequencies to the square of that.
  std::vector<Mode> modes = modes_of(line, {.count = count, .tolerance = 1e-13, .measure = EPS_CONV_ABS}, true);
  for (Mode& mode : modes) {
    mode.filtered = wf > 0.0 ? filtered_frequency(mode.frequency, wf) : 0.0;
  }
  return modes;
}

std::vector<Mode> modes_beside(FilteredStructure& line, std::span<const std::vector<double>> known, PetscInt count) {
  const PetscInt total = line.points().total() - static_cast<PetscInt>(known.size());
  EigenQuery wanted{.count = count, .tolerance = 1e-10, .measure = EPS_CONV_ABS};
  // One sweep of this basis holds so many modes of a beam; else the solver restarts (measured, docs/theory.md).
  constexpr PetscInt kSpare = 12;
  wanted.basis = std::min(std::max(2 * count, count + kSpare), total);
  wanted.beside = known;
  std::vector<std::vector<double>> shapes;
  const std::vector<double> values = eigenvalues(line, wanted, &shapes);
  if (static_cast<PetscInt>(values.size()) < count) {
    throw SolveError{"only " + std::to_string(values.size()) + " of " + std::to_string(count) +
                     " modes converged (see -filter_eps_monitor, -filter_eps_max_it)"};
  }
  std::vector<Mode> modes;
  const double wf = line.filter_frequency();
  for (std::size_t i = 0; static_cast<PetscInt>(i) < count; ++i) {
    modes.push_back({.frequency = wf * std::sqrt(values[i] / (1.0 - values[i])),
                     .filtered = wf * std::sqrt(values[i]),
                     .shape = std::move(shapes[i])});
  }
  return modes;
}

/// Among moving along y and turning, what strains nothing: the null space of a matrix of two.
std::vector<std::vector<double>> rigid_shapes(FilteredStructure& line) {
  const MassPoints& points = line.points();
  const auto mass = line.mass();
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
    line.solve(tried[t], {}, stretch[t], {});
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
  std::vector<std::vector<double>> shapes;
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
    std::vector<double>& shape = shapes.emplace_back(count);
    for (std::size_t i = 0; i < count; ++i) {
      shape[i] = (c * ortho[0][0] + s * ortho[1][0]) * tried[0][i] + s * ortho[1][1] * tried[1][i];
    }
  }
  return shapes;
}

std::optional<double> largest_frequency(FilteredStructure& line) {
  const std::vector<double> values =
      eigenvalues(line, {.count = 1, .end = EPS_LARGEST_REAL, .tolerance = 1e-5}, nullptr);
  return values.empty() ? std::nullopt : std::optional{line.filter_frequency() * std::sqrt(values.front())};
}

double decay_length(const BeamChain& beam, double filter_frequency) {
  double longest = 0.0;
  for (const BeamSegment& segment : beam.parameters().segments) {
    if (!segment.is_gap()) {
      longest = std::max(longest, 4.0 * segment.bending_stiffness / segment.mass_per_length);
    }
  }
  return std::pow(longest / (filter_frequency * filter_frequency), 0.25);
}

}  // namespace udar
