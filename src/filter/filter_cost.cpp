#include "udar/filter/filter_cost.hpp"

#include <petscksp.h>
#include <slepceps.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/network.hpp"

namespace udar {
namespace {

using EigenSolver = petsc::Handle<EPS, EPSDestroy>;

/// M^(-1/2) (C_pp - C_pu C_uu^-1 C_up) M^(-1/2): p are points, u are unknowns without mass.
class ScaledStiffness {
 public:
  explicit ScaledStiffness(const Structure& structure) {
    const Mat stiffness = structure.stiffness();
    const std::span<const double> mass = structure.points().mass();
    PetscInt begin = 0;
    PetscInt end = 0;
    UDAR_CALL(MatGetOwnershipRange(stiffness, &begin, &end));
    std::vector<PetscInt> rows(static_cast<std::size_t>(end - begin));
    std::iota(rows.begin(), rows.end(), begin);
    const MPI_Comm comm = structure.points().comm();
    const auto count = static_cast<PetscInt>(mass.size());
    const auto others = static_cast<PetscInt>(rows.size()) - count;
    petsc::IndexSet points;
    petsc::IndexSet massless;
    UDAR_CALL(ISCreateGeneral(comm, count, rows.data(), PETSC_COPY_VALUES, points.put()));
    UDAR_CALL(ISCreateGeneral(comm, others, rows.data() + count, PETSC_COPY_VALUES, massless.put()));
    UDAR_CALL(MatCreateSubMatrix(stiffness, points, points, MAT_INITIAL_MATRIX, of_points_.put()));
    UDAR_CALL(MatCreateVecs(of_points_, given_.put(), result_.put()));
    UDAR_CALL(VecDuplicate(given_, scale_.put()));
    {
      const petsc::WriteArray scales{scale_};
      std::ranges::transform(mass, scales.values(), [](double m) { return 1.0 / std::sqrt(m); });
    }
    PetscInt all = 0;
    UDAR_CALL(ISGetSize(massless, &all));
    if (all > 0) {
      condense(stiffness, points, massless);
    }
  }

  [[nodiscard]] Vec scale() const { return scale_; }

  void multiply(Vec from, Vec to) {
    UDAR_CALL(VecPointwiseMult(given_, scale_, from));
    UDAR_CALL(MatMult(of_points_, given_, result_));
    if (massless_solver_ != nullptr) {
      UDAR_CALL(MatMult(coupling_, given_, load_));
      UDAR_CALL(KSPSolve(massless_solver_, load_, follow_));
      UDAR_CALL(VecScale(follow_, -1.0));
      UDAR_CALL(MatMultTransposeAdd(coupling_, follow_, result_, result_));
    }
    UDAR_CALL(VecPointwiseMult(to, scale_, result_));
  }

 private:
  void condense(Mat stiffness, IS points, IS massless) {
    petsc::Matrix own;
    UDAR_CALL(MatCreateSubMatrix(stiffness, massless, massless, MAT_INITIAL_MATRIX, own.put()));
    UDAR_CALL(MatCreateSubMatrix(stiffness, massless, points, MAT_INITIAL_MATRIX, coupling_.put()));
    UDAR_CALL(MatCreateVecs(own, follow_.put(), load_.put()));
    MPI_Comm comm = MPI_COMM_NULL;
    UDAR_CALL(PetscObjectGetComm(reinterpret_cast<PetscObject>(stiffness), &comm));
    int size = 1;
    MPI_Comm_size(comm, &size);
    UDAR_CALL(MatSetOption(own, MAT_SPD, PETSC_TRUE));  // those without mass are not loose
    UDAR_CALL(KSPCreate(comm, massless_solver_.put()));
    UDAR_CALL(KSPSetOperators(massless_solver_, own, own));
    UDAR_CALL(KSPSetType(massless_solver_, KSPPREONLY));
    PC factor = nullptr;
    UDAR_CALL(KSPGetPC(massless_solver_, &factor));
    UDAR_CALL(PCSetType(factor, PCCHOLESKY));
    UDAR_CALL(PCFactorSetMatSolverType(factor, size == 1 ? MATSOLVERCHOLMOD : MATSOLVERMUMPS));
  }

  petsc::Matrix of_points_;
  petsc::Matrix coupling_;  // rows of unknowns without mass, columns of points
  petsc::LinearSolver massless_solver_;
  petsc::Vector scale_;
  petsc::Vector given_;
  petsc::Vector result_;
  petsc::Vector load_;
  petsc::Vector follow_;
};

PetscErrorCode multiply(Mat matrix, Vec from, Vec to) {
  PetscFunctionBeginUser;
  ScaledStiffness* scaled = nullptr;
  PetscCall(MatShellGetContext(matrix, static_cast<void*>(&scaled)));
  PetscCall(petsc::guarded([&] { scaled->multiply(from, to); }));
  PetscFunctionReturn(0);
}

/// The least of some repetitions on the slowest rank [s]: others ran while something else had the machine.
template <class Action>
double least_time(MPI_Comm comm, const Action& action) {
  constexpr std::size_t kRepeats = 11;
  std::array<double, kRepeats> times{};
  action();  // first touch
  for (double& time : times) {
    MPI_Barrier(comm);
    const double start = MPI_Wtime();
    action();
    time = MPI_Wtime() - start;
  }
  MPI_Allreduce(MPI_IN_PLACE, times.data(), static_cast<int>(times.size()), MPI_DOUBLE, MPI_MAX, comm);
  return std::ranges::min(times);
}

/// Entries of the solver's factor; 0 if it has none or does not tell.
double factor_nonzeros(KSP solver) {
  PC preconditioner = nullptr;
  UDAR_CALL(KSPGetPC(solver, &preconditioner));
  PetscBool direct = PETSC_FALSE;
  UDAR_CALL(PetscObjectTypeCompareAny(reinterpret_cast<PetscObject>(preconditioner), &direct, PCCHOLESKY, PCLU, ""));
  if (direct == PETSC_FALSE) {
    return 0.0;
  }
  Mat factor = nullptr;
  MatInfo info{};
  UDAR_CALL(PCFactorGetMatrix(preconditioner, &factor));
  UDAR_CALL(MatGetInfo(factor, MAT_GLOBAL_SUM, &info));
  return info.nz_used;
}

}  // namespace

double highest_frequency(const Structure& structure) {
  if (const Network* network = structure.network(); network != nullptr) {
    return network->highest_frequency();
  }
  const MPI_Comm comm = structure.points().comm();
  ScaledStiffness scaled{structure};
  PetscInt local = 0;
  UDAR_CALL(VecGetLocalSize(scaled.scale(), &local));
  petsc::Matrix shell;
  UDAR_CALL(MatCreateShell(comm, local, local, PETSC_DETERMINE, PETSC_DETERMINE, &scaled, shell.put()));
  UDAR_CALL(MatShellSetOperation(shell, MATOP_MULT, reinterpret_cast<void (*)()>(multiply)));
  EigenSolver solver;
  UDAR_CALL(EPSCreate(comm, solver.put()));
  UDAR_CALL(EPSSetOperators(solver, shell, nullptr));
  UDAR_CALL(EPSSetProblemType(solver, EPS_HEP));
  UDAR_CALL(EPSSetWhichEigenpairs(solver, EPS_LARGEST_REAL));
  UDAR_CALL(EPSSetTolerances(solver, 1e-3, PETSC_DEFAULT));  // nobody chooses a method by less
  UDAR_CALL(EPSSolve(solver));
  PetscInt converged = 0;
  UDAR_CALL(EPSGetConverged(solver, &converged));
  if (converged == 0) {
    throw SolveError{"the highest frequency of the structure did not converge"};
  }
  double square = 0.0;
  UDAR_CALL(EPSGetEigenvalue(solver, 0, &square, nullptr));
  return std::sqrt(square);
}

FilterCost measure_cost(FilteredStructure& structure) {
  constexpr std::size_t kTogether = 4;
  const MPI_Comm comm = structure.points().comm();
  const std::size_t count = structure.mass().size();
  std::vector<double> displacement(kTogether * count);
  std::vector<double> stretch(kTogether * count);
  for (std::size_t i = 0; i < displacement.size(); ++i) {
    displacement[i] = std::sin(0.1 * static_cast<double>(i));
  }
  std::vector<FilterColumn> columns;
  columns.reserve(kTogether);
  for (std::size_t c = 0; c < kTogether; ++c) {
    columns.push_back({.displacement = displacement.data() + c * count, .stretch = stretch.data() + c * count});
  }
  petsc::Vector from;
  petsc::Vector to;
  UDAR_CALL(MatCreateVecs(structure.op(), from.put(), to.put()));
  UDAR_CALL(VecSet(from, 1.0));
  FilterCost cost;
  cost.solve_time = least_time(comm, [&] { structure.solve({columns.data(), 1}); });
  cost.batch_time = least_time(comm, [&] { structure.solve(columns); }) / static_cast<double>(kTogether);
  cost.product_time = least_time(comm, [&] { UDAR_CALL(MatMult(structure.op(), from, to)); });
  cost.highest_frequency = highest_frequency(structure.structure());
  cost.factor_nonzeros = factor_nonzeros(structure.solver());
  return cost;
}

}  // namespace udar
