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
  int start = 0;                                  // which start vector
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
  {
    const petsc::WriteArray start{vector};
    for (std::size_t i = 0; i < points.coordinates(); ++i) {
      start.values()[i] = start_value(points, i, wanted.start);
    }
  }
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

/// As a share of what there can be: of a motion without strain, or of the mass where the line is fixed, from one.
constexpr double kNoStrain = 1e-12;

std::vector<Mode> modes_of(FilteredStructure& line, EigenQuery wanted, bool with_shapes) {
  const double rigid = zero_share(line);
  const PetscInt count = wanted.count;
  wanted.count += line.structure().rigid_modes();
  std::vector<std::vector<double>> shapes;
  const std::vector<double> values = eigenvalues(line, wanted, with_shapes ? &shapes : nullptr);
  const double wf = line.filter_frequency();
  std::vector<Mode> modes;
  for (std::size_t i = 0; i < values.size() && static_cast<PetscInt>(modes.size()) < count; ++i) {
    const double share = values[i];  // w^2 / (wf^2 + w^2)
    if (share > rigid && share < 1.0 - kNoStrain) {
      Mode mode{.frequency = wf * std::sqrt(share / (1.0 - share)), .filtered = wf * std::sqrt(share), .shape = {}};
      if (with_shapes) {
        mode.shape = std::move(shapes[i]);
      }
      modes.push_back(std::move(mode));
    }
  }
  return modes;
}

/// Of waves so many halves of which are the length of the beam, in its softest part [rad/s].
double frequency_of(const BeamChain& beam, double half_waves) {
  double softest = std::numeric_limits<double>::infinity();
  for (const BeamSegment& segment : beam.parameters().segments) {
    if (!segment.is_gap()) {
      softest = std::min(softest, std::sqrt(segment.bending_stiffness / segment.mass_per_length));
    }
  }
  return softest * std::pow(std::numbers::pi * half_waves / beam.length(), 2.0);
}

/// Near the first frequency of a beam; of others, which do not tell, a thousandth of what no frequency is far above:
/// the modes themselves correct it.
double first_guess(const Structure& structure) {
  constexpr double kFirst = 1.5;  // half waves
  return structure.chain() != nullptr ? frequency_of(*structure.chain(), kFirst)
                                      : 1e-3 * std::sqrt(structure.largest_ratio());
}

/// Goes from the filter frequency of `parameters` to the one that `best` makes of the modes seen there, until these are
/// near each other. @return line solves
template <class Best>
PetscInt settle_filter(const Structure& structure, FilterParameters& parameters, const EigenQuery& rough,
                       const Best& best) {
  constexpr int kMostTrials = 8;
  constexpr double kNear = 2.0;
  constexpr double kFarBelow = 1e-3;
  PetscInt solves = 0;
  for (int trial = 0; trial < kMostTrials; ++trial) {
    FilteredStructure line{structure, parameters};
    const std::vector<Mode> modes = modes_of(line, rough, false);
    solves += line.solves();
    if (modes.empty()) {
      if (structure.chain() != nullptr) {
        break;
      }
      parameters.filter_frequency *= kFarBelow;  // all below what it resolves
      continue;
    }
    const double wanted = best(modes);
    const double ratio = wanted / std::exchange(parameters.filter_frequency, wanted);
    if (ratio < kNear && ratio > 1.0 / kNear) {
      break;
    }
  }
  return solves;
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
  settle_filter(
      structure, parameters, {.count = count, .tolerance = 1e-9, .measure = EPS_CONV_ABS},
      [](const std::vector<Mode>& modes) { return std::sqrt(modes.front().frequency * modes.back().frequency); });
  FilteredStructure line{structure, parameters};
  // 1e-13: the line solve is right to 1e-14, and shapes are right to the residual over the distance of the shares,
  // some 1e-2; frequencies to the square of that.
  std::vector<Mode> modes = modes_of(line, {.count = count, .tolerance = 1e-13, .measure = EPS_CONV_ABS}, true);
  for (Mode& mode : modes) {
    mode.filtered = wf > 0.0 ? filtered_frequency(mode.frequency, wf) : 0.0;
  }
  return modes;
}

double start_value(const MassPoints& points, std::size_t point, int which) {
  const auto number = static_cast<double>(points.number(point));
  // Not where the line is fixed: the mass there has a motion of its own.
  return points.fixed(point) ? 0.0 : 1.0 + std::sin((0.7 + 0.1 * which) * number * number + number);
}

double zero_share(const FilteredStructure& line) {
  constexpr double kRounding = 64.0 * std::numeric_limits<double>::epsilon();
  return line.structure().chain() != nullptr ? kNoStrain
                                             : std::max(kNoStrain, kRounding * line.structure().largest_ratio() /
                                                                       std::pow(line.filter_frequency(), 2.0));
}

Separation separate_modes(const Structure& structure, const FilterParameters& filter, PetscInt count, double guess) {
  constexpr double kShare = 0.3;
  Separation found{.filter = filter};
  if (const BeamChain* beam = structure.chain(); beam != nullptr) {
    found.filter.filter_frequency =
        kShare * frequency_of(*beam, std::max(static_cast<double>(count) - 1.5, 1.5));  // two of them are rigid
    return found;
  }
  found.filter.filter_frequency = guess > 0.0 ? guess : first_guess(structure);
  const PetscInt flexible = std::max<PetscInt>(count - structure.rigid_modes(), 1);
  found.solves = settle_filter(structure, found.filter, {.count = flexible, .tolerance = 1e-7, .measure = EPS_CONV_ABS},
                               [](const std::vector<Mode>& modes) { return kShare * modes.back().frequency; });
  return found;
}

std::vector<Mode> modes_beside(FilteredStructure& line, std::span<const std::vector<double>> known,
                               const ModeSearch& search) {
  const PetscInt total = line.points().total() - static_cast<PetscInt>(known.size());
  const PetscInt count = search.count;
  EigenQuery wanted{.count = count, .tolerance = search.tolerance, .measure = EPS_CONV_ABS, .start = search.start};
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
  const double none = zero_share(line);
  for (std::size_t i = 0; static_cast<PetscInt>(i) < count; ++i) {
    const double share = values[i] > none ? values[i] : 0.0;
    modes.push_back({.frequency = wf * std::sqrt(share / (1.0 - share)),
                     .filtered = wf * std::sqrt(share),
                     .shape = std::move(shapes[i])});
  }
  return modes;
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
