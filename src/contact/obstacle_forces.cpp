#include "udar/contact/obstacle_forces.hpp"

#include <petscksp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <string_view>

#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/log.hpp"

namespace udar {
namespace {

/// Complementarity r'(q + W r) over the energy of the contact where the iteration ends: it bounds the square of the
/// line's error in the energy norm. Some digits above what rounding of the gaps leaves on meshes of 1000 nodes.
constexpr double kComplementarity = 1e-15;
/// The same where rounding ends it earlier: no more progress on lines of 20 000 nodes, some 1e-14 (docs/theory.md).
constexpr double kAcceptable = 1e-11;
/// Iterations without half of the complementarity gone that count as its end.
constexpr std::size_t kStalledIterations = 4;
/// Deepest penetration left, over that of the line without contact; found: 5e-11 on 4000 elements
/// (verification.obstacle).
constexpr double kPenetration = 1e-8;
/// Forces that the interior point method may consider, over the largest that one node alone needs.
constexpr double kForceRange = 50.0;
constexpr PetscInt kMostIterations = 100;
}  // namespace

struct ObstacleForces::Callbacks {
  static ObstacleForces& of(Mat matrix) {
    void* self = nullptr;
    UDAR_CALL(MatShellGetContext(matrix, static_cast<void*>(&self)));
    return *static_cast<ObstacleForces*>(self);
  }
  static ObstacleForces& of(PC pc) {
    void* self = nullptr;
    UDAR_CALL(PCShellGetContext(pc, static_cast<void*>(&self)));
    return *static_cast<ObstacleForces*>(self);
  }
  static void product(ObstacleForces& self, Vec unknowns, Vec result) {
    const petsc::ReadArray x{unknowns};
    const petsc::WriteArray y{result};
    ContactCompliance& line = self.line_;
    line.apply({x.values(), line.points()}, {y.values(), line.points()});
    for (std::size_t i = 0; i < line.points(); ++i) {
      y.values()[i] += line.diagonal()[i] * x.values()[i];
    }
  }
  static PetscErrorCode multiply(Mat matrix, Vec unknowns, Vec result) {
    return petsc::guarded([&] { product(of(matrix), unknowns, result); });
  }
  static PetscErrorCode set_diagonal(Mat matrix, Vec diagonal, InsertMode mode) {
    return petsc::guarded([&] {
      const std::span<double> own = of(matrix).line_.diagonal();
      const petsc::ReadArray given{diagonal};
      for (std::size_t i = 0; i < own.size(); ++i) {
        own[i] = given.values()[i] + (mode == ADD_VALUES ? own[i] : 0.0);
      }
    });
  }
  /// What the optimiser puts back after a step: W's own diagonal stays out of it.
  static PetscErrorCode get_diagonal(Mat matrix, Vec diagonal) {
    return petsc::guarded([&] {
      const petsc::WriteArray result{diagonal};
      std::ranges::copy(of(matrix).line_.diagonal(), result.values());
    });
  }
  static PetscErrorCode factor(PC pc) {
    return petsc::guarded([&] { of(pc).line_.factor(); });
  }
  static PetscErrorCode solve(PC pc, Vec right, Vec solution) {
    return petsc::guarded([&] {
      ContactCompliance& line = of(pc).line_;
      const petsc::ReadArray given{right};
      const petsc::WriteArray result{solution};
      line.solve({given.values(), line.points()}, {result.values(), line.points()});
    });
  }
  static PetscErrorCode objective(Tao /*optimizer*/, Vec unknowns, PetscReal* value, Vec gradient, void* context) {
    PetscFunctionBeginUser;
    auto& self = *static_cast<ObstacleForces*>(context);
    PetscCall(petsc::guarded([&] {
      product(self, unknowns, gradient);
      const petsc::ReadArray x{unknowns};
      const petsc::WriteArray g{gradient};
      double sum = 0.0;
      for (std::size_t i = 0; i < self.q_.size(); ++i) {
        sum += x.values()[i] * (0.5 * g.values()[i] + self.q_[i]);
        g.values()[i] += self.q_[i];
      }
      MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, self.line_.comm());
      *value = sum;
    }));
    PetscFunctionReturn(0);
  }
  static PetscErrorCode hessian(Tao /*optimizer*/, Vec /*unknowns*/, Mat /*hessian*/, Mat /*preconditioner*/,
                                void* /*context*/) {
    return 0;
  }
  static PetscErrorCode converged(Tao /*optimizer*/, void* context) {
    return petsc::guarded([&] { static_cast<ObstacleForces*>(context)->test_convergence(); });
  }
};

ObstacleForces::ObstacleForces(FilteredStructure& line, std::span<const LinePoint> points)
    : line_{line, points},
      set_{line_},
      force_bound_{kForceRange * 2.0 * line_.moved_together()},
      q_(points.size(), 0.0),
      gap_(points.size(), 0.0) {
  create_optimizer();
}

ObstacleForces::~ObstacleForces() = default;

void ObstacleForces::create_optimizer() {
  const MPI_Comm comm = line_.comm();
  const auto count = static_cast<PetscInt>(line_.points());
  UDAR_CALL(VecCreateMPI(comm, count, PETSC_DETERMINE, unknowns_.put()));
  for (petsc::Vector* vector : {&lower_, &upper_, &multiplier_, &upper_multiplier_}) {
    UDAR_CALL(VecDuplicate(unknowns_, vector->put()));
  }
  UDAR_CALL(VecSet(lower_, 0.0));
  UDAR_CALL(VecSet(upper_, force_bound_));
  UDAR_CALL(MatCreateShell(comm, count, count, PETSC_DETERMINE, PETSC_DETERMINE, this, hessian_.put()));
  UDAR_CALL(MatShellSetManageScalingShifts(hessian_));
  const auto set = [&](MatOperation operation, auto* function) {
    UDAR_CALL(MatShellSetOperation(hessian_, operation, reinterpret_cast<void (*)()>(function)));
  };
  set(MATOP_MULT, Callbacks::multiply);
  set(MATOP_DIAGONAL_SET, Callbacks::set_diagonal);
  set(MATOP_GET_DIAGONAL, Callbacks::get_diagonal);
  UDAR_CALL(TaoCreate(comm, optimizer_.put()));
  UDAR_CALL(TaoSetOptionsPrefix(optimizer_, "contact_"));
  UDAR_CALL(TaoSetType(optimizer_, TAOBQPIP));
  UDAR_CALL(TaoSetSolution(optimizer_, unknowns_));
  UDAR_CALL(TaoSetVariableBounds(optimizer_, lower_, upper_));
  UDAR_CALL(TaoSetObjectiveAndGradient(optimizer_, nullptr, Callbacks::objective, this));
  UDAR_CALL(TaoSetHessian(optimizer_, hessian_, hessian_, Callbacks::hessian, this));
  KSP solver = nullptr;
  PC preconditioner = nullptr;
  UDAR_CALL(TaoGetKSP(optimizer_, &solver));
  UDAR_CALL(KSPSetType(solver, KSPPREONLY));
  UDAR_CALL(KSPGetPC(solver, &preconditioner));
  UDAR_CALL(PCSetType(preconditioner, PCSHELL));
  UDAR_CALL(PCShellSetContext(preconditioner, this));
  UDAR_CALL(PCShellSetSetUp(preconditioner, Callbacks::factor));
  UDAR_CALL(PCShellSetApply(preconditioner, Callbacks::solve));
  UDAR_CALL(TaoSetMaximumIterations(optimizer_, kMostIterations));
  UDAR_CALL(TaoSetConvergenceTest(optimizer_, Callbacks::converged, this));
  UDAR_CALL(TaoSetFromOptions(optimizer_));
  PetscBool chosen = PETSC_FALSE;
  UDAR_CALL(PetscOptionsHasName(nullptr, "contact_", "-tao_type", &chosen));
  interior_point_alone_ = chosen == PETSC_TRUE;
  TaoType type = nullptr;
  UDAR_CALL(TaoGetType(optimizer_, &type));
  if (std::string_view{type} != TAOBQPIP) {
    throw InputError{"contact tao type: '" + std::string{type} +
                     "' is not allowed, expected " TAOBQPIP
                     ": the iteration ends by the dual variables of an interior point method, and the solves it asks "
                     "for are made for that one"};
  }
}

/// By the complementarity, which falls until rounding stops it.
void ObstacleForces::test_convergence() {
  PetscInt iterations = 0;
  PetscInt most = 0;
  double objective = 0.0;
  double gap = 0.0;
  UDAR_CALL(TaoGetSolutionStatus(optimizer_, &iterations, &objective, nullptr, nullptr, nullptr, nullptr));
  UDAR_CALL(TaoGetMaximumIterations(optimizer_, &most));
  UDAR_CALL(TaoComputeDualVariables(optimizer_, multiplier_, upper_multiplier_));
  {
    // Forces have come down from the bound's order of magnitude: below its rounding they are nothing but that.
    const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * force_bound_;
    const petsc::ReadArray force{unknowns_};
    const petsc::ReadArray distance{multiplier_};
    for (std::size_t i = 0; i < line_.points(); ++i) {
      gap += force.values()[i] > rounding ? force.values()[i] * distance.values()[i] : 0.0;
    }
    MPI_Allreduce(MPI_IN_PLACE, &gap, 1, MPI_DOUBLE, MPI_SUM, line_.comm());
  }
  const double relative = std::abs(gap / objective);
  history_.push_back(relative);
  const bool stalls = history_.size() > kStalledIterations && relative <= kAcceptable &&
                      relative > 0.5 * history_[history_.size() - 1 - kStalledIterations];
  if (!std::isfinite(relative)) {
    UDAR_CALL(TaoSetConvergedReason(optimizer_, TAO_DIVERGED_NAN));
  } else if (iterations > 0 && (relative <= kComplementarity || stalls)) {
    UDAR_CALL(TaoSetConvergedReason(optimizer_, TAO_CONVERGED_USER));
  } else if (iterations >= most) {
    UDAR_CALL(TaoSetConvergedReason(optimizer_, TAO_DIVERGED_MAXITS));
  }
}

/// The deepest of all points, over that of the line without contact, from a line solve with the forces as they are.
double ObstacleForces::penetration(std::span<const double> asked, std::span<const double> force) {
  line_.apply(force, gap_);
  double deepest = 0.0;
  for (std::size_t i = 0; i < line_.points(); ++i) {
    gap_[i] = asked[i] + unit_ * gap_[i];
    deepest = std::isnan(gap_[i]) ? std::numeric_limits<double>::infinity() : std::max(deepest, -gap_[i] / unit_);
  }
  MPI_Allreduce(MPI_IN_PLACE, &deepest, 1, MPI_DOUBLE, MPI_MAX, line_.comm());
  return deepest;
}

/// @return what is wrong, if anything
std::string ObstacleForces::solve_by_interior_point(std::span<const double> asked, std::span<double> force) {
  std::ranges::fill(line_.diagonal(), 0.0);
  history_.clear();
  UDAR_CALL(VecSet(unknowns_, 1.0));
  UDAR_CALL(TaoSolve(optimizer_));
  std::vector<std::size_t> active;
  double most = 0.0;
  {
    const petsc::ReadArray solution{unknowns_};
    const petsc::ReadArray distance{multiplier_};
    for (std::size_t i = 0; i < line_.points(); ++i) {
      // Either of them is a rest of the interior point method: the smaller one, in units of which nodes in contact have
      // one.
      const double r = solution.values()[i];
      force[i] = r > distance.values()[i] && !std::isinf(asked[i]) ? r : 0.0;
      most = std::max(most, force[i]);
      if (force[i] > 0.0) {
        active.push_back(i);
      }
    }
  }
  set_.assume(active);
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_DOUBLE, MPI_MAX, line_.comm());
  const double deepest = penetration(asked, force);
  TaoConvergedReason reason = TAO_CONTINUE_ITERATING;
  UDAR_CALL(TaoGetConvergedReason(optimizer_, &reason));
  if (reason <= 0) {
    return std::string{TaoConvergedReasons[reason]} + " after " + std::to_string(history_.size() - 1) + " iterations";
  }
  if (!(deepest <= kPenetration)) {
    std::ostringstream text;
    text << "the line stays " << deepest << " of its penetration without contact below its supports";
    return text.str();
  }
  if (most > 0.5 * force_bound_) {
    return "a force reached its bound";
  }
  return {};
}

bool ObstacleForces::solve(std::span<const double> gap, std::span<double> force) {
  const MPI_Comm comm = line_.comm();
  std::array<double, 3> most{0.0, 0.0, 0.0};  // penetration, not a number, a guess
  most[2] = set_.held().empty() ? 0.0 : 1.0;
  for (const double value : gap) {
    most[0] = std::max(most[0], -value);
    most[1] = std::isnan(value) ? 1.0 : most[1];
  }
  {
    const petsc::LogScope reduction{petsc::log_events().reduction};
    MPI_Allreduce(MPI_IN_PLACE, most.data(), static_cast<int>(most.size()), MPI_DOUBLE, MPI_MAX, comm);
  }
  if (most[1] != 0.0) {
    throw SolveError{"contact on the line: a gap is not a number"};
  }
  std::ranges::fill(force, 0.0);
  std::ranges::copy(gap, gap_.begin());
  unit_ = most[0];
  if (unit_ == 0.0) {
    set_.assume({});
    return false;
  }
  // Contact moves the line by some times its penetration, nowhere by so many: what is further away needs no digits.
  constexpr double kFarGap = 1e2;
  for (std::size_t i = 0; i < gap.size(); ++i) {
    q_[i] = std::min(gap[i] / unit_, kFarGap);
  }
  const bool settled =
      !interior_point_alone_ && set_.solve(q_, most[2] != 0.0, force) && penetration(gap, force) <= kPenetration;
  const std::string failure = settled ? std::string{} : solve_by_interior_point(gap, force);
  if (!failure.empty()) {
    throw SolveError{"contact on the line: the forces of many nodes were not found (" + failure +
                     "; see -contact_tao_monitor, `contact line dense max`)"};
  }
  for (double& value : force) {
    value *= unit_ * line_.force_unit();
  }
  return true;
}

}  // namespace udar
