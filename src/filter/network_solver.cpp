#include "udar/filter/network_solver.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <string>

#include "structure/place_algebra.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/junction_rotations.hpp"

namespace udar {
namespace {

using network::Block;
using network::JunctionSystem;
using Real = long double;
using LongMatrix3 = std::array<std::array<Real, 3>, 3>;

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

/// From values of a junction, displacement and rotation in global axes, to those of a member's end in its own.
std::array<std::array<Real, 6>, 6> to_end(const Axes& axes, const Place& offset) {
  // u_end = u + theta x o
  const Real x = offset.x;
  const Real y = offset.y;
  const Real z = offset.z;
  const LongMatrix3 arm{{{0, z, -y}, {-z, 0, x}, {y, -x, 0}}};
  std::array<std::array<Real, 6>, 6> all{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      all[i][k] = all[3 + i][3 + k] = axes[i][k];
      for (std::size_t m = 0; m < 3; ++m) {
        all[i][3 + k] += static_cast<Real>(axes[i][m]) * arm[m][k];
      }
    }
  }
  return all;
}

/// The local points of a column as three directions.
template <class Number>
network::Triple<Number> triple_of(Number* values, std::size_t nodes) {
  return values == nullptr ? network::Triple<Number>{}
                           : network::Triple<Number>{.x = values + nodes, .y = values, .z = values + 2 * nodes};
}

}  // namespace

NetworkSolver::NetworkSolver(const Network& network, double filter_frequency)
    : network_{&network},
      wf2_{filter_frequency * filter_frequency},
      interface_{network},
      members_{network, filter_frequency} {
  number_junctions();
  find_axes();
  factor();
  members_.place([this](std::size_t junction) { return system_->place(local_[junction]); }, junctions_.size());
  report_.members = members_.report();
  report_.junctions = junctions_.size();
  report_.interface = interface_.size();
  report_.own_interface = interface_.shared().size();
  report_.factor_blocks = system_->factor_blocks();
  report_.factor_bytes = system_->factor_bytes();
}

/// Those of no other rank, then those of the interface.
void NetworkSolver::number_junctions() {
  junctions_ = interface_.inner();
  junctions_.insert(junctions_.end(), interface_.shared().begin(), interface_.shared().end());
  local_.assign(network_->parameters().junctions.size(), kNone);
  for (std::size_t i = 0; i < junctions_.size(); ++i) {
    local_[junctions_[i]] = i;
  }
}

/// Of what turns: members at the nodes where they are cut.
void NetworkSolver::find_axes() {
  const std::size_t first = network_->own_junctions().size();
  cut_axes_.resize(network_->rotary() ? network_->packs().cut_nodes() : 0);
  if (!cut_axes_.empty()) {
    network_->each_inner_node([&](std::size_t local, std::size_t member, std::size_t /*number*/) {
      if (local - first < cut_axes_.size()) {
        cut_axes_[local - first] = network_->axes(member)[0];
      }
    });
  }
}

/// What points that turn with own junction i do, in global axes. @param values of the rank's points
std::array<double, 3> NetworkSolver::turned(std::size_t i, const double* values) const {
  const JunctionRotations& rotations = network_->rotations(network_->own_junctions()[i]);
  std::array<double, 3> own{};
  for (std::size_t k = 0; k < rotations.count; ++k) {
    own[k] = values[turning_point(i, k)];
  }
  return from_along(rotations.axes, own);
}

/// Point of a local node about axis k of its own.
std::size_t NetworkSolver::turning_point(std::size_t node, std::size_t k) const {
  return 3 * network_->nodes() + network_->rotation_place({.rank = network_->rank(), .local = node}, k);
}

std::vector<Block> NetworkSolver::member_blocks() const {
  std::vector<Block> blocks;
  std::vector<std::array<std::array<Real, 12>, 12>> stiffness(network_->kinds().size());
  std::vector<bool> known(stiffness.size(), false);
  const NetworkParameters& parameters = network_->parameters();
  for (std::size_t number = 0; number < parameters.members.size(); ++number) {
    if (network_->member_ranks()[number] != network_->rank()) {
      continue;
    }
    const std::size_t kind = network_->kind(number);
    if (!known[kind]) {
      stiffness[kind] = members_.ends(kind).end_stiffness();
      known[kind] = true;
    }
    add_member(stiffness[kind], number, blocks);
  }
  return blocks;
}

/// What a member does to its junctions.
void NetworkSolver::add_member(const std::array<std::array<long double, 12>, 12>& k, std::size_t number,
                               std::vector<Block>& blocks) const {
  const Member& member = network_->parameters().members[number];
  std::array<std::array<std::array<Real, 6>, 6>, 2> t{};
  for (std::size_t end = 0; end < 2; ++end) {
    t[end] = to_end(network_->axes(number), member.ends[end].offset);
  }
  for (const auto& [a, b] : {std::pair{0, 0}, std::pair{1, 1}, std::pair{0, 1}}) {
    const auto row = static_cast<std::size_t>(a);
    const auto column = static_cast<std::size_t>(b);
    Block block{.row = local_[member.ends[row].junction], .column = local_[member.ends[column].junction]};
    std::array<std::array<Real, 6>, 6> half{};  // k t
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t l = 0; l < 6; ++l) {
        for (std::size_t m = 0; m < 6; ++m) {
          half[i][l] += k[6 * row + i][6 * column + m] * t[column][m][l];
        }
      }
    }
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t l = 0; l < 6; ++l) {
        for (std::size_t m = 0; m < 6; ++m) {
          block.value[i][l] += t[row][m][i] * half[m][l];
        }
      }
    }
    blocks.push_back(block);
  }
}

/// Masses and springs of the junctions that are this rank's.
void NetworkSolver::add_grounds(std::vector<Block>& blocks) const {
  const std::span<const double> mass = network_->points().mass();
  const std::vector<std::size_t>& own = network_->own_junctions();
  for (std::size_t i = 0; i < own.size(); ++i) {
    const Junction& junction = network_->parameters().junctions[own[i]];
    Block block{.row = local_[own[i]], .column = local_[own[i]]};
    for (std::size_t k = 0; k < 3; ++k) {
      block.value[k][k] = static_cast<Real>(wf2_) * mass[i] + junction.stiffness[k];
      block.value[3 + k][3 + k] = junction.stiffness[3 + k];
    }
    if (network_->rotary()) {
      const Axes inertia = inertia_of(network_->rotations(own[i]));
      for (std::size_t k = 0; k < 9; ++k) {
        block.value[3 + k / 3][3 + k % 3] += static_cast<Real>(wf2_) * inertia.at(k / 3).at(k % 3);
      }
    }
    blocks.push_back(block);
  }
  for (const RotationSpring& spring : network_->rotation_springs()) {
    if (network_->junction_ranks()[spring.junction] == network_->rank()) {
      Block block{.row = local_[spring.junction], .column = local_[spring.junction]};
      const std::array<double, 3> axis = values_of(spring.axis);
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
          block.value[3 + i][3 + k] = static_cast<Real>(spring.stiffness) * axis[i] * axis[k];
        }
      }
      blocks.push_back(block);
    }
  }
}

/// Unknowns that never move become rows of the identity.
void NetworkSolver::hold(std::vector<Block>& blocks) {
  for (const std::size_t junction : junctions_) {
    held_.push_back(network_->parameters().junctions[junction].held);
  }
  for (Block& block : blocks) {
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t k = 0; k < 6; ++k) {
        if (held_[block.row][i] || held_[block.column][k]) {
          block.value[i][k] = 0;
        }
      }
    }
  }
  for (std::size_t j = 0; j < junctions_.size(); ++j) {
    Block block{.row = j, .column = j};
    for (std::size_t i = 0; i < 6; ++i) {
      block.value[i][i] = held_[j][i] ? 1 : 0;
    }
    blocks.push_back(block);
  }
}

void NetworkSolver::factor() {
  static constexpr std::array kUnknowns{"displacement along x", "displacement along y", "displacement along z",
                                        "rotation about x",     "rotation about y",     "rotation about z"};
  std::vector<Block> blocks = member_blocks();
  add_grounds(blocks);
  hold(blocks);
  std::string failure;
  try {
    system_ = std::make_unique<JunctionSystem>(junctions_.size(), blocks, interface_.shared().size());
  } catch (const JunctionSystem::Loose& loose) {
    const Junction& junction = network_->parameters().junctions[junctions_[loose.block]];
    failure = "junction " + (junction.name.empty() ? std::to_string(junctions_[loose.block]) : junction.name) +
              ": nothing holds its " + kUnknowns[loose.unknown] + ": the structure is a mechanism";
  }
  throw_together<InputError>(network_->comm(), failure);
  for (std::size_t j = 0; j < junctions_.size(); ++j) {
    for (std::size_t k = 0; k < 6; ++k) {
      if (held_[j][k]) {
        held_unknowns_.push_back({system_->place(j), k});
      }
    }
  }
  if (!interface_.empty() && !interface_.invert(system_->schur())) {
    throw InputError{"network: nothing holds an unknown where ranks meet: the structure is a mechanism"};
  }
}

void NetworkSolver::solve(std::span<const FilterColumn> columns, std::span<const double> load) {
  while (!columns.empty()) {
    const std::size_t batch = std::min(columns.size(), JunctionSystem::kBatch);
    const std::size_t loads = load.empty() ? 0 : 6 * junctions_.size() * batch;
    solve_batch(columns.first(batch), load.first(loads));
    columns = columns.subspan(batch);
    load = load.subspan(loads);
  }
}

void NetworkSolver::solve_batch(std::span<const FilterColumn> columns, std::span<const double> load) {
  find_places(columns);
  send_places(columns.size());
  load_own(columns);
  for (std::size_t i = 0; i < load.size(); ++i) {
    const std::size_t c = i / (6 * junctions_.size());
    const std::size_t junction = i / 6 % junctions_.size();
    values_[(system_->place(junction) * columns.size() + c) * JunctionSystem::kPitch + i % 6] += load[i];
  }
  members_.prepare(columns.size());
  condense_members(columns, false);
  receive_places(columns.size());
  condense_members(columns, true);
  solve_junctions(columns.size());
  resolve_members(columns);
  const std::size_t points = network_->points().coordinates();
  for (const FilterColumn& column : columns) {
    for (std::size_t i = 0; column.internal != nullptr && i < points; ++i) {
      column.internal[points + i] = column.displacement[i] + column.stretch[i];
    }
    if (column.internal != nullptr) {
      std::fill_n(column.internal + 3 * network_->nodes(), network_->turning_points(), 0.0);
    }
  }
}

void NetworkSolver::take_moments(std::span<double> rotation, std::span<double> load) const {
  const auto turned = triple_of(rotation.data(), network_->nodes());
  const std::vector<std::size_t>& own = network_->own_junctions();
  for (std::size_t i = 0; i < own.size(); ++i) {
    std::size_t k = 6 * local_[own[i]] + 3;
    for (double* about : {turned.x, turned.y, turned.z}) {
      load[k++] += about[i];
      about[i] = 0.0;
    }
  }
}

/// What the masses of a local node do: displacement, with rotary inertia the rotation, in global axes.
std::array<double, 6> NetworkSolver::moved(const FilterColumn& column, std::size_t i) const {
  const auto given = triple_of(column.displacement, network_->nodes());
  std::array<double, 6> all{given.x[i], given.y[i], given.z[i]};
  if (network_->rotary()) {
    const std::size_t own = network_->own_junctions().size();
    const std::array<double, 3> turned_so =
        i < own ? turned(i, column.displacement)
                : from_along({cut_axes_[i - own]}, {column.displacement[turning_point(i, 0)], 0.0, 0.0});
    std::ranges::copy(turned_so, all.begin() + 3);
  }
  return all;
}

/// Where the places of a local junction begin.
double* NetworkSolver::places_at(std::size_t junction, std::size_t column, std::size_t columns) {
  return places_.data() + (system_->place(junction) * columns + column) * JunctionSystem::kPitch;
}

/// Displacements of the masses at the own junctions and where members are cut.
void NetworkSolver::find_places(std::span<const FilterColumn> columns) {
  const std::vector<std::size_t>& own = network_->own_junctions();
  const std::size_t cut = network_->packs().cut_nodes();
  places_.resize((junctions_.size() + cut) * columns.size() * JunctionSystem::kPitch);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    for (std::size_t i = 0; i < own.size(); ++i) {
      const std::array<double, 6> values = moved(columns[c], i);
      double* to = places_at(local_[own[i]], c, columns.size());
      for (std::size_t k = 0; k < width(); ++k) {
        to[k] = held_[local_[own[i]]][k] ? 0.0 : values[k];  // the line stays there
      }
    }
    for (std::size_t i = 0; i < cut; ++i) {
      const std::array<double, 6> values = moved(columns[c], own.size() + i);
      std::copy_n(values.begin(), width(),
                  places_.data() + ((junctions_.size() + i) * columns.size() + c) * JunctionSystem::kPitch);
    }
  }
}

/// Of the own junctions at which members of other ranks meet.
void NetworkSolver::send_places(std::size_t columns) {
  interface_.send(width() * columns, [&](std::size_t junction, double* values) {
    for (std::size_t c = 0; c < columns; ++c) {
      std::copy_n(places_at(local_[junction], c, columns), width(), values + width() * c);
    }
  });
}

void NetworkSolver::receive_places(std::size_t columns) {
  interface_.receive(width() * columns, [&](std::size_t junction, const double* values) {
    for (std::size_t c = 0; c < columns; ++c) {
      std::copy_n(values + width() * c, width(), places_at(local_[junction], c, columns));
    }
  });
}

/// Forces on the own junctions, and those of their springs to the ground.
void NetworkSolver::load_own(std::span<const FilterColumn> columns) {
  const std::size_t width = columns.size() * JunctionSystem::kPitch;
  values_.assign(junctions_.size() * width, 0.0);
  const std::vector<std::size_t>& own = network_->own_junctions();
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const auto force = triple_of(columns[c].force, network_->nodes());
    for (std::size_t i = 0; i < own.size(); ++i) {
      const std::size_t at = system_->place(local_[own[i]]) * width + c * JunctionSystem::kPitch;
      double* to = values_.data() + at;
      const double* place = places_.data() + at;
      const std::array<double, 3> given =
          force.x != nullptr ? std::array{force.x[i], force.y[i], force.z[i]} : std::array<double, 3>{};
      for (std::size_t k = 0; k < 3; ++k) {
        to[k] = given[k] - network_->parameters().junctions[own[i]].stiffness[k] * place[k];
      }
      if (network_->rotary()) {
        const std::array<double, 3> moment =
            columns[c].force != nullptr ? turned(i, columns[c].force) : std::array<double, 3>{};
        for (std::size_t k = 3; k < 6; ++k) {
          to[k] = moment[k - 3] - network_->parameters().junctions[own[i]].stiffness[k] * place[k];
        }
      }
    }
    for (const RotationSpring& spring : network_->rotation_springs()) {
      if (network_->rotary() && network_->junction_ranks()[spring.junction] == network_->rank()) {
        const std::size_t at = system_->place(local_[spring.junction]) * width + c * JunctionSystem::kPitch + 3;
        const std::array<double, 3> axis = values_of(spring.axis);
        const double* place = places_.data() + at;
        const double turns = axis[0] * place[0] + axis[1] * place[1] + axis[2] * place[2];
        for (std::size_t k = 0; k < 3; ++k) {
          values_[at + k] -= spring.stiffness * turns * axis[k];
        }
      }
    }
  }
}

network::Sweep NetworkSolver::sweep_of(std::span<const FilterColumn> columns, std::size_t column) {
  const std::size_t nodes = network_->nodes();
  const FilterColumn& own = columns[column];
  // Inner nodes by their local numbers; those of junctions have other points there, and nobody asks.
  const auto turning = [&](auto* values) {
    const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(3 * nodes + network_->turning_points_of_junctions()) -
                                 static_cast<std::ptrdiff_t>(network_->own_junctions().size());
    return network_->rotary() && values != nullptr ? values + first : nullptr;
  };
  return {.displacement = triple_of(columns[column].displacement, nodes),
          .force = triple_of(columns[column].force, nodes),
          .place = places_.data() + column * JunctionSystem::kPitch,
          .value = values_.data() + column * JunctionSystem::kPitch,
          .pitch = columns.size() * JunctionSystem::kPitch,
          .stretch = triple_of(columns[column].stretch, nodes),
          .rotation = triple_of(columns[column].internal, nodes),
          .angle = turning(own.displacement),
          .torque = turning(own.force),
          .twist = turning(own.stretch)};
}

void NetworkSolver::condense_members(std::span<const FilterColumn> columns, bool shared) {
  for (std::size_t c = 0; c < columns.size(); ++c) {
    members_.condense(sweep_of(columns, c), c, shared);
  }
}

void NetworkSolver::solve_junctions(std::size_t columns) {
  for (const auto& [place, k] : held_unknowns_) {
    for (std::size_t c = 0; c < columns; ++c) {
      values_[(place * columns + c) * JunctionSystem::kPitch + k] = 0.0;
    }
  }
  system_->forward(values_, columns);
  if (!interface_.empty()) {
    solve_interface(columns);
  }
  system_->backward(values_, columns);
}

void NetworkSolver::solve_interface(std::size_t columns) {
  const std::size_t width = columns * JunctionSystem::kPitch;
  const std::size_t inner = interface_.inner().size();
  std::vector<double> values(6 * columns * interface_.shared().size());
  const auto each = [&](const auto& visit) {
    for (std::size_t j = inner; j < junctions_.size(); ++j) {
      for (std::size_t c = 0; c < columns; ++c) {
        visit(values_.data() + system_->place(j) * width + c * JunctionSystem::kPitch,
              values.data() + 6 * ((j - inner) * columns + c));
      }
    }
  };
  each([](const double* junction, double* value) { std::copy_n(junction, 6, value); });
  interface_.solve(values, columns);
  each([](double* junction, const double* value) { std::copy_n(value, 6, junction); });
}

/// Of own junction i. @param beside its rotation less that of the masses, global axes
void NetworkSolver::resolve_turning(const FilterColumn& column, std::size_t i, const double* beside) const {
  const JunctionRotations& rotations = network_->rotations(network_->own_junctions()[i]);
  const std::array<double, 3> own = along(rotations.axes, {beside[0], beside[1], beside[2]});
  for (std::size_t k = 0; k < rotations.count; ++k) {
    column.stretch[turning_point(i, k)] = own[k];
  }
  if (column.internal != nullptr) {
    const std::array<double, 3> of_masses = turned(i, column.displacement);
    const auto rotation = triple_of(column.internal, network_->nodes());
    rotation.x[i] += of_masses[0];
    rotation.y[i] += of_masses[1];
    rotation.z[i] += of_masses[2];
  }
}

void NetworkSolver::resolve_members(std::span<const FilterColumn> columns) {
  const std::vector<std::size_t>& own = network_->own_junctions();
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const network::Sweep sweep = sweep_of(columns, c);
    for (std::size_t i = 0; i < own.size(); ++i) {
      const std::size_t local = local_[own[i]];
      const double* from = sweep.value + system_->place(local) * sweep.pitch;
      sweep.stretch.x[i] = held_[local][0] ? -sweep.displacement.x[i] : from[0];
      sweep.stretch.y[i] = held_[local][1] ? -sweep.displacement.y[i] : from[1];
      sweep.stretch.z[i] = held_[local][2] ? -sweep.displacement.z[i] : from[2];
      if (sweep.rotation.x != nullptr) {
        sweep.rotation.x[i] = from[3];
        sweep.rotation.y[i] = from[4];
        sweep.rotation.z[i] = from[5];
      }
      if (network_->rotary()) {
        resolve_turning(columns[c], i, from + 3);
      }
    }
    members_.resolve(sweep, c);
  }
}

}  // namespace udar
