#include "udar/motion/held_places.hpp"

#include <numeric>
#include <utility>

namespace udar {
namespace {

/// Calls visit(move, point) for what is held rigidly, or for what is on a spring.
template <class Visit>
void each_moved(std::span<const HeldMove> moves, bool held, const Visit& visit) {
  for (const HeldMove& move : moves) {
    for (const MovedPoint& moved : move.points) {
      if (moved.held() == held) {
        visit(move, moved);
      }
    }
  }
}

}  // namespace

std::vector<std::size_t> held_points(std::span<const HeldMove> moves) {
  std::vector<std::size_t> points;
  each_moved(moves, true, [&](const HeldMove& /*move*/, const MovedPoint& moved) { points.push_back(moved.point); });
  return points;
}

HeldPlaces::HeldPlaces(const FilteredStructure& line, std::vector<HeldMove> moves)
    : line_{&line}, moves_{std::move(moves)} {}

/// Of k (b - y)^2 / 2 all but k y^2 / 2.
double HeldPlaces::stored(const Instant& at, std::span<const double> displacement) const {
  double energy = 0.0;
  each_moved(moves_, false, [&](const HeldMove& move, const MovedPoint& moved) {
    const double foot = moved.share * move.table->at(at).value;
    energy += moved.here() ? moved.stiffness * foot * (0.5 * foot - displacement[moved.point]) : 0.0;
  });
  return energy;
}

double HeldPlaces::work(const DenseOutput& step, const Loads& loads, std::span<const double> axis, double begin,
                        double until) const {
  if (!(until > begin)) {
    return 0.0;
  }
  return work_of_springs(step, axis, begin, until) + work_of_held(step, loads, axis, begin, until);
}

/// The integral of k (b - y) b' dt: of b^2 at once, of y by the line, piece by piece.
double HeldPlaces::work_of_springs(const DenseOutput& step, std::span<const double> axis, double begin,
                                   double until) const {
  double sum = 0.0;
  each_moved(moves_, false, [&](const HeldMove& move, const MovedPoint& moved) {
    double before = 0.0;
    move.table->each_piece(begin, until, [&](double from, double to) {
      double after = 0.0;
      if (moved.here()) {
        step.line_integrals({&moved.point, 1}, to, {&after, 1});
        const auto [foot, velocity] = move.table->at(from);
        const double way = (to - from) * (moved.share * (foot + 0.5 * (to - from) * velocity) + axis[moved.point]);
        sum += moved.stiffness * moved.share * velocity * (way - (after - before));
      }
      before = after;
    });
  });
  return sum;
}

/// All of a reaction is linear in where the masses are.
double HeldPlaces::work_of_held(const DenseOutput& step, const Loads& loads, std::span<const double> axis, double begin,
                                double until) const {
  const double time = until - begin;
  std::vector<double> velocity;  // of each of `MovedPoints`
  std::vector<double> middle;    // integral of where it is
  bool moves = false;
  each_moved(moves_, true, [&](const HeldMove& move, const MovedPoint& moved) {
    const auto [value, rate] = move.table->at(begin);
    velocity.push_back(moved.share * rate);
    middle.push_back(moved.share * time * (value + 0.5 * time * rate));
    moves = moves || rate != 0.0;
  });
  if (!moves) {
    return 0.0;
  }
  std::vector<double> push(axis.size());  // integral of wf^2 M u + F
  step.mass_integrals(until, push);
  const double wf2 = line_->filter_frequency() * line_->filter_frequency();
  for (std::size_t i = 0; i < push.size(); ++i) {
    push[i] = wf2 * line_->mass()[i] * (push[i] - time * axis[i]);
  }
  std::vector<double> work;
  for (const double at : {begin, until}) {
    const std::span<const double> force = loads.force({at, begin}, work);
    for (std::size_t i = 0; i < force.size(); ++i) {
      push[i] += loads.is_force(i) ? 0.5 * time * force[i] : 0.0;
    }
  }
  const std::vector<double> impulse = reactions(push, middle);
  return std::inner_product(velocity.begin(), velocity.end(), impulse.begin(), 0.0);
}

/// By the reciprocity of the line: R = K b - psi' (wf^2 M u + F).
std::vector<double> HeldPlaces::reactions(std::span<const double> push, std::span<const double> moved) const {
  const auto shapes = line_->moved().shapes();
  std::vector<double> all;
  for (std::size_t k = 0; k < shapes.size(); ++k) {
    double sum = 0.0;
    for (std::size_t i = 0; i < push.size(); ++i) {
      sum -= shapes[k].line[i] * push[i];
    }
    for (std::size_t j = 0; shapes[k].here && j < shapes.size(); ++j) {
      sum += line_->moved().stiffness()[k * shapes.size() + j] * moved[j];
    }
    all.push_back(sum);
  }
  return all;
}

std::vector<PlaceState> HeldPlaces::states(const Instant& at, const Loads& loads, std::span<const double> position,
                                           std::span<const double> line, std::span<const double> axis) const {
  const double wf2 = line_->filter_frequency() * line_->filter_frequency();
  std::vector<double> work;
  const std::span<const double> force = loads.force(at, work);
  std::vector<double> push(axis.size());
  for (std::size_t i = 0; i < push.size(); ++i) {
    const double pushed = !force.empty() && loads.is_force(i) ? force[i] : 0.0;
    push[i] = wf2 * line_->mass()[i] * (position[i] - axis[i]) + pushed;
  }
  std::vector<double> moved;
  each_moved(moves_, true, [&](const HeldMove& move, const MovedPoint& point) {
    moved.push_back(point.share * move.table->at(at).value);
  });
  const std::vector<double> reaction = reactions(push, moved);
  std::vector<double> forces(moves_.size(), 0.0);
  for (std::size_t next = 0, k = 0; k < moves_.size(); ++k) {
    for (const MovedPoint& point : moves_[k].points) {
      const double way = point.share * moves_[k].table->at(at).value;
      const double spring =
          point.held() || !point.here() ? 0.0 : point.stiffness * (way + axis[point.point] - line[point.point]);
      forces[k] += point.share * (point.held() ? reaction[next++] : spring);
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, forces.data(), static_cast<int>(forces.size()), MPI_DOUBLE, MPI_SUM,
                line_->points().comm());
  std::vector<PlaceState> states;
  for (std::size_t k = 0; k < moves_.size(); ++k) {
    const auto [displacement, velocity] = moves_[k].table->at(at);
    states.push_back({.displacement = displacement, .velocity = velocity, .force = forces[k]});
  }
  return states;
}

}  // namespace udar
