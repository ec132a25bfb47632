#include "udar/contact/carried_masses.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "udar/numerics/positive_inverse.hpp"
#include "udar/petsc/error.hpp"

namespace udar {

CarriedMasses::CarriedMasses(FilteredStructure& line, const InitialState& initial, double gravity)
    : line_{&line}, points_{&line.points()}, riders_{points_->riders()}, gravity_{gravity} {
  const Extent extent = points_->extent();
  for (const Rider& rider : riders_) {
    road_.push_back({initial.axis(rider.passage.end(Passage::Where::before), extent),
                     initial.axis(rider.passage.end(Passage::Where::behind), extent)});
  }
}

double CarriedMasses::Node::height(std::span<const double> values) const {
  double sum = 0.0;
  for (const auto& [unknown, share] : own) {
    sum += share * values[unknown];
  }
  return sum;
}

/// @note Collective.
void CarriedMasses::find_places(const Instant& at) {
  places_.clear();
  std::vector<std::size_t> wanted;
  for (const Rider& rider : riders_) {
    places_.push_back({.state = rider.passage.at(at)});
    if (const Spot& place = places_.back(); place.on()) {
      wanted.insert(wanted.end(), {place.state.node, place.state.node + 1});
    }
  }
  std::ranges::sort(wanted);
  wanted.erase(std::ranges::unique(wanted).begin(), wanted.end());
  if (!std::ranges::equal(wanted, nodes_, {}, {}, &Node::number)) {
    take_nodes(wanted);
  }
  for (Spot& place : places_) {
    place.first = static_cast<std::size_t>(std::ranges::lower_bound(nodes_, place.state.node, {}, &Node::number) -
                                           nodes_.begin());
  }
}

/// Those that are there are kept. @note Collective.
void CarriedMasses::take_nodes(const std::vector<std::size_t>& wanted) {
  std::vector<Node> taken;
  taken.reserve(wanted.size());
  for (const std::size_t number : wanted) {
    const auto kept = std::ranges::find(nodes_, number, &Node::number);
    taken.push_back(kept != nodes_.end() ? std::move(*kept) : response(number));
  }
  nodes_ = std::move(taken);
  compute_compliance();
}

/// @note Collective: a line solve.
CarriedMasses::Node CarriedMasses::response(std::size_t number) {
  const std::size_t count = points_->points();
  Node node{.number = number,
            .own = {},
            .stretch = std::vector<double>(count),
            .moment = std::vector<double>(count * line_->filter_operator().internal_numbers())};
  std::vector<double> force(count, 0.0);
  const auto first = static_cast<std::size_t>(points_->nodes().begin());
  if (number >= first && number - first < points_->own_points()) {
    for (const auto& [point, share] :
         points_->of_unknowns({{.point = points_->global(number - first), .share = 1.0}})) {
      node.own.emplace_back(static_cast<std::size_t>(point - points_->begin()), share);
      force[node.own.back().first] += share;
    }
  }
  const std::vector<double> still(count, 0.0);
  line_->solve(still, force, node.stretch, node.moment);
  return node;
}

/// @note Collective.
void CarriedMasses::compute_compliance() {
  compliance_.clear();
  for (const Node& row : nodes_) {
    for (const Node& column : nodes_) {
      compliance_.push_back(row.height(column.stretch));
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, compliance_.data(), static_cast<int>(compliance_.size()), MPI_DOUBLE, MPI_SUM,
                points_->comm());
}

/// What the line gives way by at one place under 1 N at another, each a share of two nodes.
double CarriedMasses::compliance(const Spot& a, std::array<double, 2> of_a, const Spot& b,
                                 std::array<double, 2> of_b) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < 2; ++i) {
    for (std::size_t j = 0; j < 2; ++j) {
      sum += of_a.at(i) * of_b.at(j) * compliance_[(a.first + i) * nodes_.size() + b.first + j];
    }
  }
  return sum;
}

/// Of the filter spring and of the mass' own, in series.
double CarriedMasses::own_compliance(std::size_t mass) const {
  const double wf = line_->filter_frequency();
  return 1.0 / (wf * wf * riders_[mass].mass) + 1.0 / riders_[mass].stiffness;
}

void CarriedMasses::invert_system() {
  const std::size_t count = riders_.size();
  inverse_.assign(count * count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < count; ++j) {
      if (places_[i].on() && places_[j].on()) {
        inverse_[i * count + j] = compliance(places_[i], places_[i].shares(), places_[j], places_[j].shares());
      }
    }
    inverse_[i * count + i] += own_compliance(i);
  }
  if (!invert_positive(inverse_, count)) {
    throw SolveError{"load axles: forces of the masses are not found, the line's compliance is not positive"};
  }
}

std::vector<double> CarriedMasses::solve(std::span<const double> right) const {
  const std::size_t count = riders_.size();
  std::vector<double> solution(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < count; ++j) {
      solution[i] += inverse_[i * count + j] * right[j];
    }
  }
  return solution;
}

/// @param of_nodes forces [N]
void CarriedMasses::add_forces(std::span<const double> of_nodes, std::span<double> stretch,
                               std::span<double> moment) const {
  for (std::size_t node = 0; node < nodes_.size(); ++node) {
    for (std::size_t i = 0; i < stretch.size(); ++i) {
      stretch[i] += of_nodes[node] * nodes_[node].stretch[i];
    }
    for (std::size_t i = 0; i < moment.size(); ++i) {
      moment[i] += of_nodes[node] * nodes_[node].moment[i];
    }
  }
}

void CarriedMasses::apply(const Instant& at, std::span<const double> position, std::span<double> stretch,
                          std::span<double> moment, Carried& carried) {
  find_places(at);
  const std::size_t count = riders_.size();
  std::vector<double> line(stretch.size());
  std::ranges::transform(position, stretch, line.begin(), std::plus{});
  // By how much the line is too low for a force of none; then climb without forces.
  std::vector<double> sums(2 * count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    const Spot& place = places_[i];
    const double sunk = -riders_[i].mass * gravity_ / riders_[i].stiffness;
    sums[i] += here(riders_[i]) ? line[local(riders_[i])] + sunk : 0.0;
    for (std::size_t k = 0; k < 2 && place.on(); ++k) {
      const double height = nodes_[place.first + k].height(line);
      sums[i] -= place.shares().at(k) * height;
      sums[count + i] += place.rates().at(k) * height;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, points_->comm());
  for (std::size_t i = 0; i < count; ++i) {
    sums[i] -= places_[i].on() ? 0.0 : road_[i].at(places_[i].state.where == Passage::Where::before ? 0 : 1);
  }
  invert_system();
  carried.force = solve(std::span{sums}.first(count));
  carried.climb.assign(sums.begin() + static_cast<std::ptrdiff_t>(count), sums.end());
  std::vector<double> of_nodes(nodes_.size(), 0.0);
  const double wf = line_->filter_frequency();
  for (std::size_t i = 0; i < count; ++i) {
    const Spot& place = places_[i];
    if (here(riders_[i])) {
      stretch[local(riders_[i])] -= carried.force[i] / (wf * wf * riders_[i].mass);
    }
    for (std::size_t k = 0; k < 2 && place.on(); ++k) {
      of_nodes[place.first + k] += place.shares().at(k) * carried.force[i];
    }
    for (std::size_t j = 0; j < count && place.on(); ++j) {
      if (places_[j].on()) {
        carried.climb[i] += compliance(place, place.rates(), places_[j], places_[j].shares()) * carried.force[j];
      }
    }
  }
  add_forces(of_nodes, stretch, moment);
}

void CarriedMasses::add_rate(const Instant& at, std::span<const double> velocity, const Carried& carried,
                             std::span<const double> load_rate, std::span<double> rate) {
  find_places(at);
  const std::size_t count = riders_.size();
  std::vector<double> moving(rate.size());  // of the line without masses
  std::ranges::transform(velocity, rate, moving.begin(), std::plus{});
  for (std::size_t i = 0; i < load_rate.size(); ++i) {
    moving[i] += load_rate[i];
  }
  std::vector<double> sums(count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    const Spot& place = places_[i];
    sums[i] += here(riders_[i]) ? moving[local(riders_[i])] : 0.0;
    for (std::size_t k = 0; k < 2 && place.on(); ++k) {
      sums[i] -= place.shares().at(k) * nodes_[place.first + k].height(moving);
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, points_->comm());
  for (std::size_t i = 0; i < count; ++i) {
    sums[i] -= carried.climb[i];  // with the line's way under all forces as they are
    for (std::size_t j = 0; j < count && places_[i].on(); ++j) {
      if (places_[j].on()) {
        sums[i] -= compliance(places_[i], places_[i].shares(), places_[j], places_[j].rates()) * carried.force[j];
      }
    }
  }
  invert_system();
  const std::vector<double> force_rate = solve(sums);
  std::vector<double> of_nodes(nodes_.size(), 0.0);
  const double wf = line_->filter_frequency();
  for (std::size_t i = 0; i < count; ++i) {
    const Spot& place = places_[i];
    if (here(riders_[i])) {
      rate[local(riders_[i])] -= force_rate[i] / (wf * wf * riders_[i].mass);
    }
    for (std::size_t k = 0; k < 2 && place.on(); ++k) {
      of_nodes[place.first + k] += place.shares().at(k) * force_rate[i] + place.rates().at(k) * carried.force[i];
    }
  }
  add_forces(of_nodes, rate, {});
}

double CarriedMasses::spring_energy(const Carried& carried) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < riders_.size(); ++i) {
    sum += 0.5 * carried.force[i] * carried.force[i] / riders_[i].stiffness;
  }
  return sum;
}

double CarriedMasses::power(const Carried& carried) {
  double sum = 0.0;
  for (std::size_t i = 0; i < carried.force.size(); ++i) {
    sum -= carried.force[i] * carried.climb[i];
  }
  return sum;
}

std::vector<double> CarriedMasses::heights_below(std::span<const double> foot, const Carried& carried) const {
  std::vector<double> heights(riders_.size(), 0.0);
  for (std::size_t i = 0; i < riders_.size(); ++i) {
    if (here(riders_[i])) {
      heights[i] = foot[local(riders_[i])] - (carried.force[i] + riders_[i].mass * gravity_) / riders_[i].stiffness;
    }
  }
  return heights;
}

}  // namespace udar
