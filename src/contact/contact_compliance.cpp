#include "udar/contact/contact_compliance.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <string>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

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

ContactCompliance::ContactCompliance(FilteredStructure& line, std::span<const LinePoint> points)
    : line_{&line}, free_{operator_of(line).with_springs({})} {
  for (const LinePoint& point : points) {
    node_.push_back(point.node - line.points().begin());
    side_.push_back(point.side);
  }
  const std::size_t count = points.size();
  by_node_.resize(count);
  std::iota(by_node_.begin(), by_node_.end(), std::size_t{0});
  std::ranges::stable_sort(by_node_, {}, [&](std::size_t i) { return node_[i]; });
  for (auto* work : {&diagonal_, &factored_, &spring_}) {
    work->assign(count, 0.0);
  }
  for (auto* work : {&zero_, &load_, &target_, &stretch_}) {
    work->assign(line.mass().size(), 0.0);
  }
  // A node's filter spring, and how many of them move with one node.
  const double wf2 = line.filter_frequency() * line.filter_frequency();
  std::array<double, 2> sums{static_cast<double>(count), 0.0};
  for (const PetscInt node : node_) {
    const auto i = static_cast<std::size_t>(node);
    sums[1] += wf2 * line.mass()[i];
    moved_together_ = std::max(moved_together_, line.filter_operator().points_moved_together(i));
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), 2, MPI_DOUBLE, MPI_SUM, comm());
  MPI_Allreduce(MPI_IN_PLACE, &moved_together_, 1, MPI_DOUBLE, MPI_MAX, comm());
  force_unit_ = sums[1] / sums[0];
  for (const LinePoint& point : points) {
    yield_.push_back(point.yield(line.parameters()) * force_unit_);
  }
}

/// W r, both in units.
void ContactCompliance::apply(std::span<const double> force, std::span<double> gap) {
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
double ContactCompliance::beside(std::size_t point) const {
  return std::max(diagonal_[point] + yield_[point], kStiffest);
}

/// The line with the springs 1 / D. They take the filter's place in the chain solver, and those of the filter go to
/// ground, so that it tells how far they are stretched without a difference.
void ContactCompliance::factor() {
  int changed = factored_ == diagonal_ && shifted_ != nullptr ? 0 : 1;
  MPI_Allreduce(MPI_IN_PLACE, &changed, 1, MPI_INT, MPI_LOR, comm());
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
void ContactCompliance::solve(std::span<const double> right, std::span<double> solution, std::span<double> product) {
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
    const double moved = side_[i] * stretch_[static_cast<std::size_t>(node_[i])];
    solution[i] = (solution[i] - moved) / beside(i);
    if (!product.empty()) {
      product[i] = moved;
    }
  }
}

}  // namespace udar
