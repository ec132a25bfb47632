#include "udar/contact/active_set.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "udar/petsc/log.hpp"

namespace udar {
namespace {

/// Gaps are told from zero above this share of what they are sums of.
constexpr double kRounding = 64.0 * std::numeric_limits<double>::epsilon();
/// Iterations from a guess before it is given up: a border that has moved further than some nodes is found sooner on
/// coarse grids.
constexpr int kMostFromGuess = 5;
/// On a grid but the last, which need not settle: the next one is as good a place to mend a border.
constexpr int kMostOnGrid = 2;
/// On the last grid; found: 25 of 5000 nodes.
constexpr int kMostOnLast = 60;
/// Attempts of all at once without fewer violations before points change sides one by one, as in `Complementarity`.
constexpr int kBlockMoves = 8;
/// Nodes of the coarsest grid to the length that moves with one node.
constexpr double kCoarsest = 4.0;

}  // namespace

ActiveSet::ActiveSet(ContactCompliance& line)
    : line_{&line}, held_(line.points(), 0), right_(line.points()), product_(line.points()) {}

void ActiveSet::assume(std::span<const std::size_t> points) {
  std::ranges::fill(held_, 0);
  for (const std::size_t point : points) {
    held_[point] = 1;
  }
}

std::vector<std::size_t> ActiveSet::held() const {
  std::vector<std::size_t> points;
  for (std::size_t i = 0; i < held_.size(); ++i) {
    if (held_[i] != 0) {
      points.push_back(i);
    }
  }
  return points;
}

/// What held points hold, and how far that moves the others. The line is pinned by the stiffest springs.
void ActiveSet::respond(std::span<const double> gap, std::span<double> force) {
  for (std::size_t i = 0; i < held_.size(); ++i) {
    line_->diagonal()[i] = held_[i] != 0 ? 0.0 : std::numeric_limits<double>::infinity();
    right_[i] = -gap[i];
  }
  line_->factor();
  line_->solve(right_, force, product_);
}

void ActiveSet::find_violating(std::span<const double> gap, std::span<const double> force, PetscInt stride) {
  violating_.clear();
  for (std::size_t i = 0; i < held_.size(); ++i) {
    const bool pulls = held_[i] != 0 && force[i] < 0.0;
    const bool below =
        held_[i] == 0 && line_->node(i) % stride == 0 && gap[i] + product_[i] < -kRounding * (1.0 + std::abs(gap[i]));
    if (pulls || below) {
      violating_.push_back(i);
    }
  }
}

/// Of all ranks.
void ActiveSet::keep_last() {
  PetscInt last = violating_.empty() ? -1 : line_->node(violating_.back());
  const PetscInt own = last;
  {
    const petsc::LogScope reduction{petsc::log_events().reduction};
    MPI_Allreduce(MPI_IN_PLACE, &last, 1, MPIU_INT, MPI_MAX, line_->comm());
  }
  violating_.erase(violating_.begin(), own == last ? violating_.end() - 1 : violating_.end());
}

/// With points of every so many nodes, and those held already.
bool ActiveSet::settle(std::span<const double> gap, std::span<double> force, PetscInt stride, int most) {
  int fewest = std::numeric_limits<int>::max();
  int moves = kBlockMoves;
  for (int iteration = 0; iteration < most; ++iteration) {
    respond(gap, force);
    find_violating(gap, force, stride);
    auto count = static_cast<int>(violating_.size());
    {
      const petsc::LogScope reduction{petsc::log_events().reduction};
      MPI_Allreduce(MPI_IN_PLACE, &count, 1, MPI_INT, MPI_SUM, line_->comm());
    }
    if (count == 0) {
      return true;
    }
    if (count < fewest) {
      fewest = count;
      moves = kBlockMoves;
    } else if (moves > 0) {
      --moves;
    } else {
      keep_last();
    }
    for (const std::size_t i : violating_) {
      held_[i] = held_[i] != 0 ? 0 : 1;
    }
  }
  return false;
}

bool ActiveSet::solve(std::span<const double> gap, bool guessed, std::span<double> force) {
  if (guessed && settle(gap, force, 1, kMostFromGuess)) {
    return true;
  }
  PetscInt stride = 1;
  while (kCoarsest * static_cast<double>(stride) < line_->moved_together()) {
    stride *= 2;
  }
  for (std::size_t i = 0; i < held_.size(); ++i) {
    held_[i] = gap[i] < 0.0 && line_->node(i) % stride == 0 ? 1 : 0;
  }
  for (; stride > 1; stride /= 2) {
    settle(gap, force, stride, kMostOnGrid);
  }
  return settle(gap, force, 1, kMostOnLast);
}

}  // namespace udar
