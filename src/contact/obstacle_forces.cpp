#include "udar/contact/obstacle_forces.hpp"

#include <petscksp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
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
/// The stiffest spring 1 / D: beyond, rounding in the solve with it costs more (measured: 1e-12 at 3e-13, 1e-8 at
/// 1e-18) than what is left undone, D times the change of the forces, which the next iteration finds.
constexpr double kStiffest = 1e-13;
/// The softest: beyond, a node has no contact and its force is about to vanish. What it still moves the line is far
/// below the force's own change, and ranks lose digits over springs that differ by more (measured: 1e-8 at 1e13).
constexpr double kSoftest = 1e9;

FilterOperator& operator_of(FilteredStructure& line) {
  FilterOperator& filter = line.filter_operator();
  if (line.chain() == nullptr || filter.line() == nullptr) {
    const std::string reason = filter.block_form_reason();
    throw InputError{"contact line dense max: so many contact nodes need the chain solver, and this line has none (" +
                     (reason.empty() ? std::string{"-filter_pc_type"} : reason) +
                     "); raise it, or choose narrower supports, fewer elements, or `contact surface` mass"};
  }
  return filter;
}

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
    const std::size_t count = self.node_.size();
    self.compliance({x.values(), count}, {y.values(), count});
    for (std::size_t i = 0; i < count; ++i) {
      y.values()[i] += self.diagonal_[i] * x.values()[i];
    }
  }
  static PetscErrorCode multiply(Mat matrix, Vec unknowns, Vec result) {
    return petsc::guarded([&] { product(of(matrix), unknowns, result); });
  }
  static PetscErrorCode set_diagonal(Mat matrix, Vec diagonal, InsertMode mode) {
    return petsc::guarded([&] {
      ObstacleForces& self = of(matrix);
      const petsc::ReadArray given{diagonal};
      for (std::size_t i = 0; i < self.diagonal_.size(); ++i) {
        self.diagonal_[i] = given.values()[i] + (mode == ADD_VALUES ? self.diagonal_[i] : 0.0);
      }
    });
  }
  /// What the optimiser puts back after a step: W's own diagonal stays out of it.
  static PetscErrorCode get_diagonal(Mat matrix, Vec diagonal) {
    return petsc::guarded([&] {
      const petsc::WriteArray result{diagonal};
      std::ranges::copy(of(matrix).diagonal_, result.values());
    });
  }
  static PetscErrorCode factor(PC pc) {
    return petsc::guarded([&] { of(pc).factor(); });
  }
  static PetscErrorCode solve(PC pc, Vec right, Vec solution) {
    return petsc::guarded([&] {
      ObstacleForces& self = of(pc);
      const petsc::ReadArray given{right};
      const petsc::WriteArray result{solution};
      self.solve_shifted({given.values(), self.node_.size()}, {result.values(), self.node_.size()});
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
      MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_DOUBLE, MPI_SUM, self.line_->points().comm());
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
    : line_{&line}, free_{operator_of(line).with_springs({})} {
  const MassPoints& beam = line.points();
  for (const LinePoint& point : points) {
    node_.push_back(point.node - beam.begin());
    side_.push_back(point.side);
  }
  const std::size_t count = points.size();
  by_node_.resize(count);
  std::iota(by_node_.begin(), by_node_.end(), std::size_t{0});
  std::ranges::stable_sort(by_node_, {}, [&](std::size_t i) { return node_[i]; });
  for (auto* work : {&q_, &diagonal_, &factored_, &spring_, &gap_}) {
    work->assign(count, 0.0);
  }
  for (auto* work : {&zero_, &load_, &target_, &stretch_}) {
    work->assign(line.mass().size(), 0.0);
  }
  // A node's filter spring, and how many of them move with one node.
  const double wf2 = line.filter_frequency() * line.filter_frequency();
  std::array<double, 3> sums{static_cast<double>(count), 0.0, 1.0};
  for (const PetscInt node : node_) {
    const auto i = static_cast<std::size_t>(node);
    sums[1] += wf2 * line.mass()[i];
    sums[2] = std::max(sums[2], line.filter_operator().points_moved_together(i));
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), 2, MPI_DOUBLE, MPI_SUM, beam.comm());
  MPI_Allreduce(MPI_IN_PLACE, &sums[2], 1, MPI_DOUBLE, MPI_MAX, beam.comm());
  force_unit_ = sums[1] / sums[0];
  for (const LinePoint& point : points) {
    yield_.push_back(point.compliance * force_unit_);
  }
  force_bound_ = kForceRange * 2.0 * sums[2];
  create_optimizer();
}

ObstacleForces::~ObstacleForces() = default;

void ObstacleForces::create_optimizer() {
  const MPI_Comm comm = line_->points().comm();
  const auto count = static_cast<PetscInt>(node_.size());
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
  TaoType type = nullptr;
  UDAR_CALL(TaoGetType(optimizer_, &type));
  if (std::string_view{type} != TAOBQPIP) {
    throw InputError{"contact tao type: '" + std::string{type} +
                     "' is not allowed, expected " TAOBQPIP
                     ": the iteration ends by the dual variables of an interior point method, and the solves it asks "
                     "for are made for that one"};
  }
}

/// W r, both in units.
void ObstacleForces::compliance(std::span<const double> force, std::span<double> gap) {
  for (std::size_t i = 0; i < node_.size(); ++i) {
    load_[static_cast<std::size_t>(node_[i])] += side_[i] * force_unit_ * force[i];
  }
  const FilterColumn column{.displacement = zero_.data(), .force = load_.data(), .stretch = stretch_.data()};
  free_->solve({&column, 1});
  for (std::size_t i = 0; i < node_.size(); ++i) {
    const auto node = static_cast<std::size_t>(node_[i]);
    gap[i] = side_[i] * stretch_[node] + yield_[i] * force[i];
    load_[node] = 0.0;
  }
}

/// D: what stands beside the compliance of the line on the diagonal.
double ObstacleForces::beside(std::size_t point) const { return std::max(diagonal_[point] + yield_[point], kStiffest); }

/// The line with the springs 1 / D. They take the filter's place in the chain solver, and those of the filter go to
/// ground, so that it tells how far they are stretched without a difference.
void ObstacleForces::factor() {
  int changed = factored_ == diagonal_ && shifted_ != nullptr ? 0 : 1;
  MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPI_INT, MPI_LOR, line_->points().comm());
  if (changed == 0) {
    return;  // predictor and corrector share a matrix
  }
  std::vector<ContactSpring> springs;
  for (const std::size_t i : by_node_) {
    const auto node = static_cast<std::size_t>(node_[i]);
    spring_[i] = beside(i) < kSoftest ? force_unit_ / beside(i) : 0.0;
    if (spring_[i] != 0.0) {
      springs.push_back({.point = node, .stiffness = spring_[i]});
    }
  }
  shifted_ = line_->filter_operator().with_springs(springs);
  factored_ = diagonal_;
}

/// (W + D) x = y: springs 1 / D from the line to ground that is moved by y, x is what they hold.
void ObstacleForces::solve_shifted(std::span<const double> right, std::span<double> solution) {
  // Where two springs share a node, they pull towards their mean; x of one is then relative to its own end.
  for (std::size_t from = 0; from < by_node_.size();) {
    std::size_t to = from;
    std::size_t stiffest = from;
    const auto node = node_[by_node_[from]];
    for (; to < by_node_.size() && node_[by_node_[to]] == node; ++to) {
      stiffest = spring_[by_node_[to]] > spring_[by_node_[stiffest]] ? to : stiffest;
    }
    const std::size_t base = by_node_[stiffest];
    const double origin = side_[base] * right[base];
    double moved = 0.0;
    double together = 0.0;  // springs of the node
    for (std::size_t k = from; k < to; ++k) {
      const std::size_t i = by_node_[k];
      together += spring_[i];
      moved += k == stiffest ? 0.0 : spring_[i] * (side_[i] * right[i] - origin);
    }
    const bool sprung = spring_[base] > 0.0;
    moved = sprung ? moved / together : -origin;
    target_[static_cast<std::size_t>(node)] = sprung ? origin + moved : 0.0;
    for (std::size_t k = from; k < to; ++k) {
      const std::size_t i = by_node_[k];
      solution[i] = k == stiffest ? -side_[i] * moved : right[i] - side_[i] * (origin + moved);
    }
    from = to;
  }
  const FilterColumn column{.displacement = target_.data(), .force = nullptr, .stretch = stretch_.data()};
  shifted_->solve({&column, 1});
  for (std::size_t i = 0; i < node_.size(); ++i) {
    solution[i] = (solution[i] - side_[i] * stretch_[static_cast<std::size_t>(node_[i])]) / beside(i);
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
    for (std::size_t i = 0; i < node_.size(); ++i) {
      gap += force.values()[i] > rounding ? force.values()[i] * distance.values()[i] : 0.0;
    }
    MPI_Allreduce(MPI_IN_PLACE, &gap, 1, MPI_DOUBLE, MPI_SUM, line_->points().comm());
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

/// The conditions, from a line solve with the forces as they are; what is wrong, if anything.
std::string ObstacleForces::check(std::span<const double> asked, std::span<double> force) {
  const MPI_Comm comm = line_->points().comm();
  {
    const petsc::ReadArray solution{unknowns_};
    const petsc::ReadArray distance{multiplier_};
    for (std::size_t i = 0; i < node_.size(); ++i) {
      // Either of them is a rest of the interior point method: the smaller one, in units of which nodes in contact have
      // one.
      const double r = solution.values()[i];
      force[i] = r > distance.values()[i] && !std::isinf(asked[i]) ? r : 0.0;
    }
  }
  compliance(force, gap_);
  std::array<double, 2> most{0.0, 0.0};  // penetration, force
  for (std::size_t i = 0; i < node_.size(); ++i) {
    gap_[i] = asked[i] + unit_ * gap_[i];
    most[0] = std::isnan(gap_[i]) ? std::numeric_limits<double>::infinity() : std::max(most[0], -gap_[i] / unit_);
    most[1] = std::max(most[1], force[i]);
    force[i] *= unit_ * force_unit_;
  }
  MPI_Allreduce(MPI_IN_PLACE, most.data(), static_cast<int>(most.size()), MPI_DOUBLE, MPI_MAX, comm);
  TaoConvergedReason reason = TAO_CONTINUE_ITERATING;
  UDAR_CALL(TaoGetConvergedReason(optimizer_, &reason));
  if (reason <= 0) {
    return std::string{TaoConvergedReasons[reason]} + " after " + std::to_string(history_.size() - 1) + " iterations";
  }
  if (!(most[0] <= kPenetration)) {
    std::ostringstream text;
    text << "the line stays " << most[0] << " of its penetration without contact below its supports";
    return text.str();
  }
  if (most[1] > 0.5 * force_bound_) {
    return "a force reached its bound";
  }
  return {};
}

bool ObstacleForces::solve(std::span<const double> gap, std::span<double> force) {
  const MPI_Comm comm = line_->points().comm();
  std::array<double, 2> most{0.0, 0.0};  // penetration, not a number
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
    return false;
  }
  // Contact moves the line by some times its penetration, nowhere by so many: what is further away needs no digits.
  constexpr double kFarGap = 1e2;
  for (std::size_t i = 0; i < gap.size(); ++i) {
    q_[i] = std::min(gap[i] / unit_, kFarGap);
  }
  std::ranges::fill(diagonal_, 0.0);
  history_.clear();
  UDAR_CALL(VecSet(unknowns_, 1.0));
  UDAR_CALL(TaoSolve(optimizer_));
  const std::string failure = check(gap, force);
  if (!failure.empty()) {
    throw SolveError{"contact on the line: the forces of many nodes were not found (" + failure +
                     "; see -contact_tao_monitor, `contact line dense max`)"};
  }
  return true;
}

}  // namespace udar
