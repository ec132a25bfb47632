#include "udar/filter/modes.hpp"

#include <slepceps.h>

#include <algorithm>
#include <cmath>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

using EigenSolver = petsc::Handle<EPS, EPSDestroy>;

/// The symmetric operator -M^(1/2) d(M^(-1/2) x): its eigenvalues are w^2 / (wf^2 + w^2).
struct FilterOperator {
  FilteredLine* line;
  std::vector<double> displacement;
  std::vector<double> stretch;

  explicit FilterOperator(FilteredLine& filtered)
      : line{&filtered}, displacement(filtered.mass().size()), stretch(filtered.mass().size()) {}
  void apply(const double* x, double* y) {
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

PetscErrorCode multiply(Mat matrix, Vec x, Vec y) {
  PetscFunctionBeginUser;
  FilterOperator* context = nullptr;
  const double* from = nullptr;
  double* to = nullptr;
  PetscCall(MatShellGetContext(matrix, static_cast<void*>(&context)));
  PetscCall(VecGetArrayRead(x, &from));
  PetscCall(VecGetArray(y, &to));
  PetscCall(petsc::guarded([&] { context->apply(from, to); }));
  PetscCall(VecRestoreArray(y, &to));
  PetscCall(VecRestoreArrayRead(x, &from));
  PetscFunctionReturn(0);
}

}  // namespace

std::vector<Mode> lowest_modes(FilteredLine& line, PetscInt count) {
  // A mode this slow compared with wf is a rigid motion seen through round-off.
  constexpr double kRigid = 1e-12;
  const BeamChain& beam = line.beam();
  const auto gaps = std::ranges::count_if(beam.parameters().segments, &BeamSegment::is_gap);
  const PetscInt rigid_modes = 2 * (static_cast<PetscInt>(gaps) + 1);
  FilterOperator context{line};
  petsc::Matrix shell;
  UDAR_CALL(MatCreateShell(beam.comm(), beam.local_nodes(), beam.local_nodes(), beam.nodes(), beam.nodes(), &context,
                           shell.put()));
  UDAR_CALL(MatShellSetOperation(shell, MATOP_MULT, reinterpret_cast<void (*)()>(multiply)));
  EigenSolver solver;
  UDAR_CALL(EPSCreate(beam.comm(), solver.put()));
  UDAR_CALL(EPSSetOptionsPrefix(solver, "filter_"));
  UDAR_CALL(EPSSetOperators(solver, shell, nullptr));
  UDAR_CALL(EPSSetProblemType(solver, EPS_HEP));
  UDAR_CALL(EPSSetWhichEigenpairs(solver, EPS_SMALLEST_REAL));
  UDAR_CALL(EPSSetDimensions(solver, std::min(count + rigid_modes, beam.nodes()), PETSC_DEFAULT, PETSC_DEFAULT));
  UDAR_CALL(EPSSetTolerances(solver, 1e-10, PETSC_DEFAULT));
  UDAR_CALL(EPSSetFromOptions(solver));
  UDAR_CALL(EPSSolve(solver));

  PetscInt converged = 0;
  UDAR_CALL(EPSGetConverged(solver, &converged));
  const double wf = line.filter_frequency();
  std::vector<Mode> modes;
  for (PetscInt i = 0; i < converged && static_cast<PetscInt>(modes.size()) < count; ++i) {
    double share = 0.0;  // w^2 / (wf^2 + w^2)
    UDAR_CALL(EPSGetEigenvalue(solver, i, &share, nullptr));
    if (share > kRigid && share < 1.0) {
      modes.push_back({.frequency = wf * std::sqrt(share / (1.0 - share)), .filtered = wf * std::sqrt(share)});
    }
  }
  return modes;
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
