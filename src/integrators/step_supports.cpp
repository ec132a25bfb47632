#include "udar/integrators/step_supports.hpp"

#include <algorithm>

namespace udar {

StepSupports::StepSupports(const Sweep& sweep, const ContactState& contact, const LawHistory& history)
    : sweep_{&sweep}, contact_{&contact}, history_{&history} {
  for (std::size_t from = 0; from < sweep.count; from += kBlock) {
    first_run_.push_back(block_runs_.size());
    for (std::size_t index = 0; index < contact.sets().size(); ++index) {
      const ContactSet& set = contact.sets()[index];
      if (std::max(set.first, from) < std::min(set.last, from + kBlock)) {
        block_runs_.push_back(index);
      }
    }
  }
  first_run_.push_back(block_runs_.size());
  lifts_.resize(contact.sets().size());
}

void StepSupports::begin() {
  if (sweep_->begin == lifted_at_ && sweep_->step == lifted_over_) {
    return;
  }
  lifted_at_ = sweep_->begin;
  lifted_over_ = sweep_->step;
  for (std::size_t index = 0; index < lifts_.size(); ++index) {
    const ContactSet& set = contact_->sets()[index];
    lifts_[index] = set.motion ? set.motion->cubic(sweep_->begin, sweep_->step) : std::array<double, 4>{};
  }
}

std::span<const std::size_t> StepSupports::sets_at(std::size_t node) const {
  const std::size_t block = node / kBlock;
  return std::span{block_runs_}.subspan(first_run_[block], first_run_[block + 1] - first_run_[block]);
}

std::array<double, 2> StepSupports::bounds_of_lift(std::size_t set) const {
  if (!contact_->sets()[set].motion) {
    return {0.0, 0.0};
  }
  const auto& c = lifts_[set];
  const std::array<double, 4> bernstein{c[0], c[0] + c[1] / 3.0, c[0] + (2.0 * c[1] + c[2]) / 3.0,
                                        c[0] + c[1] + c[2] + c[3]};
  return {std::ranges::min(bernstein), std::ranges::max(bernstein)};
}

StopProblem StepSupports::problem(std::size_t node, std::int32_t resting) const {
  StopProblem all;
  all.problem = {.angle = sweep_->angle(), .terms = sweep_->terms, .powers = sweep_->powers()};
  local::Problem& problem = all.problem;
  problem.drag = sweep_->scale().drag;
  problem.line = sweep_->drive_powers(node);
  problem.turn = sweep_->turn_powers(node);
  problem.velocity = sweep_->start[sweep_->count + node] * sweep_->step;
  problem.hop_tolerance = contact_->parameters().hop_tolerance;
  for (const std::size_t of_block : sets_at(node)) {
    const ContactSet& set = contact_->sets()[of_block];
    if (node < set.first || node >= set.last) {
      continue;
    }
    const std::size_t index = set.side > 0.0 ? 0 : 1;
    local::Stop& stop = problem.stops[index];
    const std::array<double, 4>& lift = lifts_[of_block];
    const double at = set.height(node) + lift[0] - sweep_->start[node];
    const bool rests = resting == set.support + 1;
    const bool rests_there = problem.resting == static_cast<int>(index);
    if (rests || (!rests_there && (!stop.present || set.side * at > set.side * stop.at))) {
      stop = {.at = at,
              .restitution = set.law.restitution,
              .yield_speed = set.law.yield_speed * sweep_->step,
              .present = true,
              .moves = set.motion != nullptr,
              .path = {lift[1], lift[2], lift[3]},
              .stiffness = set.stiffness * sweep_->step * sweep_->step,
              .damping = set.damping * sweep_->step,
              .contact_law = set.contact_law.get(),
              .carried = set.carried,
              .step = sweep_->step,
              .largest = history_->largest(set, node)};
      all.sets[index] = &set;
    }
    if (rests) {
      problem.resting = static_cast<int>(index);
    }
    problem.together = std::max(problem.together, contact_->touching_distance(sweep_->start[node], set.height(node)));
    problem.pull_resolution = std::max(problem.pull_resolution, contact_->pull_resolution(set.height(node) + lift[0]));
  }
  return all;
}

}  // namespace udar
