#include "udar/structure/network.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <sstream>
#include <tuple>
#include <utility>

#include "structure/frame_matrix.hpp"
#include "structure/free_rotations.hpp"
#include "structure/member_frame.hpp"
#include "structure/network_checks.hpp"
#include "structure/network_ranks.hpp"
#include "structure/node_axes.hpp"
#include "structure/place_algebra.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/junction_rotations.hpp"

namespace udar {
namespace {

/// Lengths of elements that differ by less, relative to them, are one; unequal ones are differences of places.
constexpr double kSameLength = 1e-12;
constexpr double kSameUnequal = 1e-9;

/// Finds the kind of a member, or makes one.
class Kinds {
 public:
  explicit Kinds(std::vector<MemberKind>& kinds) : kinds_{&kinds} {}

  std::size_t number_of(MemberKind kind) {
    std::multimap<double, std::size_t>& near = alike_[{kind.section, kind.elements, kind.joint}];
    const double same = kind.equal_elements() ? kSameLength : kSameUnequal;
    for (auto at = near.lower_bound(kind.element_length * (1.0 - same));
         at != near.end() && at->first <= kind.element_length * (1.0 + same); ++at) {
      if (equally_cut((*kinds_)[at->second], kind)) {
        return at->second;
      }
    }
    near.emplace(kind.element_length, kinds_->size());
    kinds_->push_back(std::move(kind));
    return kinds_->size() - 1;
  }

 private:
  static bool equally_cut(const MemberKind& one, const MemberKind& other) {
    return std::ranges::equal(one.lengths, other.lengths,
                              [](double a, double b) { return std::abs(a - b) <= kSameUnequal * a; });
  }

  std::vector<MemberKind>* kinds_;
  std::map<std::tuple<std::size_t, std::size_t, std::array<std::array<double, 3>, 2>>,
           std::multimap<double, std::size_t>>
      alike_;
};

/// Of the elements of a member [m]; empty if they are equal.
std::vector<double> lengths_of(const Member& member, double length) {
  if (std::ranges::adjacent_find(member.spacing, std::not_equal_to{}) == member.spacing.end()) {
    return {};
  }
  const double whole = std::accumulate(member.spacing.begin(), member.spacing.end(), 0.0);
  std::vector<double> lengths = member.spacing;
  for (double& element : lengths) {
    element *= length / whole;
  }
  return lengths;
}

/// FNV-1a of the bits of numbers.
class Checksum {
 public:
  template <class... Numbers>
  void add(const Numbers&... numbers) {
    (add_one(numbers), ...);
  }
  [[nodiscard]] std::uint64_t value() const noexcept { return value_; }

 private:
  void add_one(double number) { add_bits(std::bit_cast<std::uint64_t>(number)); }
  void add_one(std::size_t number) { add_bits(number); }
  void add_one(bool number) { add_bits(number ? 1 : 0); }
  void add_one(const Place& place) { add(place.x, place.y, place.z); }
  template <class Number, std::size_t Count>
  void add_one(const std::array<Number, Count>& numbers) {
    for (const Number& number : numbers) {
      add_one(number);
    }
  }
  void add_bits(std::uint64_t bits) {
    for (int byte = 0; byte < 8; ++byte, bits >>= 8U) {
      value_ = (value_ ^ (bits & 0xffU)) * 0x100000001b3ULL;
    }
  }
  std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

/// Of all that shapes the motion.
std::uint64_t checksum_of(const NetworkParameters& network) {
  Checksum sum;
  const auto& [sections, junctions, members, planes, partition_unused, rotary, together_unused] = network;
  static_cast<void>(planes);  // those of supports
  static_cast<void>(partition_unused);
  static_cast<void>(together_unused);
  for (const auto& [name, youngs, shear, density, area, inertia, torsion, shear_factor, radius_unused] : sections) {
    static_cast<void>(radius_unused);
    sum.add(youngs, shear, density, area, inertia, torsion, shear_factor);
  }
  for (const auto& [name, place, held, stiffness, mass] : junctions) {
    sum.add(place, held, stiffness, mass);
  }
  for (const auto& [name, ends, section, elements, spacing, orientation] : members) {
    for (const auto& [junction, offset, joint] : ends) {
      sum.add(junction, offset, joint);
    }
    sum.add(section, elements, orientation);
    for (const double length : spacing) {
      sum.add(length);
    }
  }
  if (rotary) {
    sum.add(rotary);
  }
  return sum.value();
}

/// Of each junction: half an element of each member there, and its own [kg].
std::vector<double> junction_masses(const Network& network) {
  const NetworkParameters& given = network.parameters();
  std::vector<double> masses;
  masses.reserve(given.junctions.size());
  for (const Junction& junction : given.junctions) {
    masses.push_back(junction.mass);
  }
  for (std::size_t number = 0; number < given.members.size(); ++number) {
    const Member& member = given.members[number];
    const MemberKind& kind = network.kinds()[network.kind(number)];
    for (std::size_t end = 0; end < 2; ++end) {
      masses[member.ends.at(end).junction] +=
          0.5 * kind.end_length(end) * given.sections[member.section].mass_per_length();
    }
  }
  return masses;
}

NetworkParameters checked(NetworkParameters parameters) {
  check_network(parameters);
  return parameters;
}

}  // namespace

double MemberKind::shortest() const { return equal_elements() ? element_length : std::ranges::min(lengths); }

double MemberKind::inner_length() const {
  double length = equal_elements() ? element_length * static_cast<double>(elements - 1) : 0.0;
  for (std::size_t i = 1; i < lengths.size(); ++i) {
    length += node_length(i);
  }
  return length;
}

double MemberSection::tube_radius() const { return radius > 0.0 ? radius : std::sqrt(area / std::numbers::pi); }

Network::Network(MPI_Comm comm, NetworkParameters parameters)
    : comm_{comm}, parameters_{checked(std::move(parameters))} {
  MPI_Comm_rank(comm_, &rank_);
  axes_.reserve(parameters_.members.size());
  for (const Member& member : parameters_.members) {
    axes_.push_back(axes_of(parameters_, member));
  }
  sort_members();
  deal();
  pack_members();
  if (rotary()) {
    turning_.rotations = rotations_of_junctions(parameters_, axes_, kinds_, member_kinds_);
    count_turning_points();
  }
  place_points();
  warnings_ = overlaps_of(parameters_, axes_);
  connected_parts_ = count_parts(parameters_);
  if (connected_parts_ > 1) {
    notes_.push_back("network: " + std::to_string(connected_parts_) + " parts that no member connects");
  }
  FreeRotations free = hold_free_rotations(*this);
  rotation_springs_ = std::move(free.springs);
  notes_.insert(notes_.end(), free.notes.begin(), free.notes.end());
}

/// Kinds of all members.
void Network::sort_members() {
  Kinds kinds{kinds_};
  member_kinds_.reserve(parameters_.members.size());
  for (const Member& member : parameters_.members) {
    const double length = norm(span_of(parameters_, member));
    member_kinds_.push_back(kinds.number_of({.section = member.section,
                                             .elements = member.elements,
                                             .element_length = length / static_cast<double>(member.elements),
                                             .joint = {member.ends[0].joint, member.ends[1].joint},
                                             .lengths = lengths_of(member, length)}));
  }
}

void Network::deal() {
  int size = 1;
  MPI_Comm_size(comm_, &size);
  NetworkRanks ranks = deal_to_ranks(parameters_, size);
  junction_ranks_ = std::move(ranks.junctions);
  member_ranks_ = std::move(ranks.members);
  std::vector<std::size_t> nodes(static_cast<std::size_t>(size), 0);
  for (std::size_t junction = 0; junction < junction_ranks_.size(); ++junction) {
    junction_places_.push_back(nodes[static_cast<std::size_t>(junction_ranks_[junction])]++);
    if (junction_ranks_[junction] == rank_) {
      own_junctions_.push_back(junction);
    }
  }
  for (std::size_t member = 0; member < member_ranks_.size(); ++member) {
    nodes[static_cast<std::size_t>(member_ranks_[member])] += parameters_.members[member].elements - 1;
  }
  rank_nodes_.push_back(0);
  for (const std::size_t count : nodes) {
    rank_nodes_.push_back(rank_nodes_.back() + count);
  }
  if (6.0 * static_cast<double>(total_nodes()) > static_cast<double>(PETSC_MAX_INT)) {
    throw InputError{"network: " + std::to_string(total_nodes()) +
                     " nodes are not allowed with this PETSc, expected fewer, or one with 64-bit integers"};
  }
}

/// This rank's members of each kind, in the order of the network; those that end at a junction of another rank last, so
/// that packs of the others need not wait for it.
void Network::pack_members() {
  std::vector<MemberPacks::Kind> own;
  own.reserve(kinds_.size());
  for (const MemberKind& kind : kinds_) {
    own.push_back({.elements = kind.elements, .equal = kind.equal_elements()});
  }
  for (const bool waits : {false, true}) {
    for (std::size_t member = 0; member < member_ranks_.size(); ++member) {
      if (member_ranks_[member] == rank_ && ends_elsewhere(member) == waits) {
        own[member_kinds_[member]].members.push_back(member);
      }
    }
  }
  packs_ = MemberPacks{own, parameters_.members.size(), own_junctions_.size()};
}

bool Network::ends_elsewhere(std::size_t member) const {
  return std::ranges::any_of(parameters_.members[member].ends,
                             [this](const MemberEnd& end) { return junction_ranks_[end.junction] != rank_; });
}

void Network::place_points() {
  std::vector<double> mass(nodes());
  std::vector<Place> place(nodes());
  std::vector<std::int64_t> number(nodes());
  const std::vector<double> at_junctions = junction_masses(*this);
  for (std::size_t local = 0; local < own_junctions_.size(); ++local) {
    const std::size_t junction = own_junctions_[local];
    mass[local] = at_junctions[junction];
    place[local] = parameters_.junctions[junction].place;
    number[local] = static_cast<std::int64_t>(junction);
  }
  std::vector<std::int64_t> first_number;  // of each member's inner nodes
  auto next = static_cast<std::int64_t>(parameters_.junctions.size());
  for (const Member& member : parameters_.members) {
    first_number.push_back(next);
    next += static_cast<std::int64_t>(member.elements) - 1;
  }
  for (std::size_t index = 0; index < parameters_.members.size(); ++index) {
    if (member_ranks_[index] != rank_) {
      continue;
    }
    const Member& member = parameters_.members[index];
    const MemberKind& kind = kinds_[member_kinds_[index]];
    const double per_length = parameters_.sections[member.section].mass_per_length();
    const Place from = end_place(parameters_, member, 0);
    const Place span = span_of(parameters_, member);
    const std::vector<double> shares = node_shares(member);
    for (std::size_t i = 1; i < member.elements; ++i) {
      const std::size_t local = node(index, i).local;
      mass[local] = per_length * kind.node_length(i);
      place[local] = from + shares[i - 1] * span;
      number[local] = first_number[index] + static_cast<std::int64_t>(i) - 1;
    }
  }
  PointTable table;
  constexpr std::array kBlocks{std::pair{Direction::y, 1}, std::pair{Direction::x, 0}, std::pair{Direction::z, 2}};
  for (const auto& [direction, axis] : kBlocks) {
    for (std::size_t local = 0; local < own_junctions_.size(); ++local) {
      if (parameters_.junctions[own_junctions_[local]].held.at(static_cast<std::size_t>(axis))) {
        table.fixed.push_back(table.mass.size() + local);
      }
    }
    table.mass.insert(table.mass.end(), mass.begin(), mass.end());
    table.place.insert(table.place.end(), place.begin(), place.end());
    table.direction.insert(table.direction.end(), nodes(), direction);
    for (const std::int64_t node : number) {
      table.number.push_back(3 * node + axis);
    }
  }
  table.nodes = nodes();
  table.frames = node_frames({table.place.data(), nodes()}, table.fixed);
  if (rotary()) {
    add_turning_points(table);
  }
  points_ = std::make_unique<PlacedPoints>(comm_, 1, std::move(table));
}

/// Of nodes that face oblique planes. @param places of the nodes @param fixed points, ascending @note Collective.
std::vector<NodeFrame> Network::node_frames(std::span<const Place> places, std::span<const std::size_t> fixed) const {
  std::vector<NodeFrame> frames;
  std::string fault;
  for (std::size_t node = 0; node < places.size() && !parameters_.planes.empty() && fault.empty(); ++node) {
    const std::array points{node + nodes(), node, node + 2 * nodes()};
    const auto held =
        std::ranges::count_if(points, [&](std::size_t point) { return std::ranges::binary_search(fixed, point); });
    try {
      const auto axes = held < 3 ? node_axes(parameters_.planes, places[node]) : std::nullopt;
      if (axes && held > 0) {
        const auto [x, y, z] = places[node];
        std::ostringstream text;
        text << "support normal: the node at (" << x << ", " << y << ", " << z
             << ") m faces an oblique plane and is held in some directions, which is not allowed";
        fault = text.str();
      } else if (axes) {
        frames.push_back({.points = points, .axes = *axes});
      }
    } catch (const InputError& error) {
      fault = error.what();
    }
  }
  throw_together<InputError>(comm_, fault);
  return frames;
}

void Network::count_turning_points() {
  const std::size_t ranks = rank_nodes_.size() - 1;
  std::vector<std::vector<std::size_t>> counts(ranks);
  for (std::size_t junction = 0; junction < junction_ranks_.size(); ++junction) {  // in the order of their places
    counts[static_cast<std::size_t>(junction_ranks_[junction])].push_back(turning_.rotations[junction].count);
  }
  for (const std::vector<std::size_t>& own : counts) {
    turning_.first.push_back(turning_.before.size());
    std::size_t before = 0;
    for (const std::size_t count : own) {
      turning_.before.push_back(before);
      before += count;
    }
    turning_.before.push_back(before);
  }
  turning_.first.push_back(turning_.before.size());
}

/// Numbers behind those of all displacements.
void Network::add_turning_points(PointTable& table) const {
  const std::size_t first = table.mass.size();
  const auto numbers = 3 * static_cast<std::int64_t>(total_nodes());
  table.mass.resize(first + turning_points());
  table.place.resize(table.mass.size());
  table.number.resize(table.mass.size());
  table.direction.resize(table.mass.size(), Direction::other);
  table.turning.resize(turning_points());
  const auto add = [&](std::size_t local, std::size_t axis, double inertia, const std::array<double, 3>& about) {
    const std::size_t at = rotation_place({.rank = rank_, .local = local}, axis);
    table.mass[first + at] = inertia;
    table.place[first + at] = table.place[local];
    table.number[first + at] = numbers + table.number[local] - 1 + static_cast<std::int64_t>(axis);
    table.turning[at] = place_of(about);
  };
  for (std::size_t local = 0; local < own_junctions_.size(); ++local) {
    const JunctionRotations& own = turning_.rotations[own_junctions_[local]];
    for (std::size_t k = 0; k < own.count; ++k) {
      add(local, k, own.inertia.at(k), own.axes.at(k));
    }
  }
  each_inner_node([&](std::size_t local, std::size_t member, std::size_t number) {
    const MemberKind& kind = kinds_[member_kinds_[member]];
    add(local, 0, parameters_.sections[kind.section].polar() * kind.node_length(number), axes_[member][0]);
  });
}

void Network::each_inner_node(
    const std::function<void(std::size_t local, std::size_t member, std::size_t number)>& visit) const {
  for (std::size_t member = 0; member < member_ranks_.size(); ++member) {
    for (std::size_t i = 1; member_ranks_[member] == rank_ && i < parameters_.members[member].elements; ++i) {
      visit(node(member, i).local, member, i);
    }
  }
}

std::size_t Network::turning_points_of_junctions() const noexcept {
  return rotary() ? turning_.before[turning_.first[static_cast<std::size_t>(rank_) + 1] - 1] : 0;
}

std::size_t Network::turning_points() const noexcept {
  return rotary() ? turning_points_of_junctions() + nodes() - own_junctions_.size() : 0;
}

std::size_t Network::rotation_place(const Node& node, std::size_t axis) const {
  const auto rank = static_cast<std::size_t>(node.rank);
  const std::size_t* const before = &turning_.before[turning_.first[rank]];
  const std::size_t junctions = turning_.first[rank + 1] - turning_.first[rank] - 1;
  const std::size_t count = rank_nodes_[rank + 1] - rank_nodes_[rank];
  const std::size_t points = before[junctions] + count - junctions;
  if (node.local < junctions) {
    const std::size_t own = before[node.local + 1] - before[node.local];
    return axis < own ? before[node.local] + axis : points + 3 * node.local - before[node.local] + axis - own;
  }
  const std::size_t inner = node.local - junctions;
  return axis == 0 ? before[junctions] + inner : points + 3 * junctions - before[junctions] + 2 * inner + axis - 1;
}

std::size_t Network::nodes() const noexcept {
  const auto own = static_cast<std::size_t>(rank_);
  return rank_nodes_[own + 1] - rank_nodes_[own];
}

Network::Node Network::junction_node(std::size_t junction) const {
  return {.rank = junction_ranks_[junction], .local = junction_places_[junction]};
}

Network::Node Network::node(std::size_t member, std::size_t number) const {
  const Member& given = parameters_.members[member];
  if (number == 0 || number == given.elements) {
    return junction_node(given.ends[number == 0 ? 0 : 1].junction);
  }
  return {.rank = member_ranks_[member], .local = packs_.node(member, member_kinds_[member], number)};
}

PetscInt Network::point(const Node& node, std::size_t direction) const {
  const auto rank = static_cast<std::size_t>(node.rank);
  const std::size_t first = rank_nodes_[rank];
  const std::size_t count = rank_nodes_[rank + 1] - first;
  std::size_t turning = 0;  // of ranks before
  for (std::size_t r = 0; rotary() && r < rank; ++r) {
    const std::size_t junctions = turning_.first[r + 1] - turning_.first[r] - 1;
    turning += turning_.before[turning_.first[r + 1] - 1] + rank_nodes_[r + 1] - rank_nodes_[r] - junctions;
  }
  return static_cast<PetscInt>(3 * first + turning + kBlock.at(direction) * count + node.local);
}

PetscInt Network::row(const Node& node, std::size_t freedom) const {
  if (!rotary() || freedom < 3) {
    return nodal_row(node, freedom);
  }
  const std::size_t first = rank_nodes_[static_cast<std::size_t>(node.rank)];
  const std::size_t count = rank_nodes_[static_cast<std::size_t>(node.rank) + 1] - first;
  return static_cast<PetscInt>(6 * first + 3 * count + rotation_place(node, freedom - 3));
}

PetscInt Network::nodal_row(const Node& node, std::size_t freedom) const {
  const std::size_t first = rank_nodes_[static_cast<std::size_t>(node.rank)];
  const std::size_t count = rank_nodes_[static_cast<std::size_t>(node.rank) + 1] - first;
  return static_cast<PetscInt>(6 * first + (3 * (freedom / 3) + kBlock.at(freedom % 3)) * count + node.local);
}

Mat Network::stiffness() const {
  if (stiffness_ == nullptr) {
    stiffness_ = frame_matrix(*this);
  }
  return stiffness_;
}

double Network::largest_ratio() const {
  // At a node between equal elements; where others meet it is the mean of theirs by mass.
  double largest = 0.0;
  for (const MemberKind& kind : kinds_) {
    const MemberSection& section = parameters_.sections[kind.section];
    const double h = kind.shortest();
    double stiffness = section.axial() / h;
    for (std::size_t plane = 0; plane < 2; ++plane) {
      stiffness = std::max(stiffness,
                           1.0 / (h * h * h / (12.0 * section.bending(plane)) + h * section.shear_compliance(plane)));
    }
    largest = std::max(largest, 2.0 * stiffness / (section.mass_per_length() * h));
    if (rotary()) {
      largest = std::max(largest, 2.0 * section.torsion() / (section.polar() * h * h));
    }
  }
  const std::vector<double> masses = junction_masses(*this);
  double spring = 0.0;
  for (std::size_t i = 0; i < masses.size(); ++i) {
    const std::array<double, 6>& stiffness = parameters_.junctions[i].stiffness;
    spring = std::max(spring, std::max({stiffness[0], stiffness[1], stiffness[2]}) / masses[i]);
  }
  return largest + spring;
}

double Network::highest_frequency() const {
  double highest = 0.0;
  for (const MemberKind& kind : kinds_) {
    const MemberSection& section = parameters_.sections[kind.section];
    const double h = kind.shortest();
    const double bending = std::max(section.bending(0), section.bending(1));
    highest = std::max({highest, 2.0 / h * std::sqrt(section.axial() / section.mass_per_length()),
                        4.0 / (h * h) * std::sqrt(bending / section.mass_per_length()),
                        rotary() ? 2.0 / h * std::sqrt(section.torsion() / section.polar()) : 0.0});
  }
  return highest;
}

Topology Network::topology() const {
  Topology topology{.name = "network", .shape = Topology::Shape::line, .corners = {}};
  for (std::size_t point = 0; point < 3 * nodes(); ++point) {
    topology.node.push_back(point % nodes());
  }
  topology.node.resize(points_->points());
  for (std::size_t local = 0; rotary() && local < nodes(); ++local) {
    const std::size_t count = local < own_junctions_.size() ? turning_.rotations[own_junctions_[local]].count : 1;
    for (std::size_t k = 0; k < count; ++k) {
      topology.node[3 * nodes() + rotation_place({.rank = rank_, .local = local}, k)] = local;
    }
  }
  for (std::size_t local = 0; local < nodes(); ++local) {
    topology.node_number.push_back(points_->number(local) / 3);
  }
  const auto global = [this](const Node& node) {
    return static_cast<PetscInt>(rank_nodes_[static_cast<std::size_t>(node.rank)] + node.local);
  };
  std::int64_t next = 0;
  for (std::size_t number = 0; number < parameters_.members.size(); ++number) {
    const Member& member = parameters_.members[number];
    for (std::size_t i = 0; member_ranks_[number] == rank_ && i < member.elements; ++i) {
      topology.corners.push_back(global(node(number, i)));
      topology.corners.push_back(global(node(number, i + 1)));
      topology.cell_number.push_back(next + static_cast<std::int64_t>(i));
      topology.member.push_back(static_cast<std::int64_t>(number));
      topology.radius.push_back(parameters_.sections[member.section].tube_radius());
    }
    next += static_cast<std::int64_t>(member.elements);
  }
  return topology;
}

bool Network::grounded() const {
  return std::ranges::any_of(parameters_.junctions, [](const Junction& junction) {
    return std::ranges::find(junction.held, true) != junction.held.end() ||
           std::ranges::any_of(junction.stiffness, [](double stiffness) { return stiffness > 0.0; });
  });
}

void Network::describe(Description& all) const {
  double mass = 0.0;
  for (const double at_junction : junction_masses(*this)) {
    mass += at_junction;
  }
  for (std::size_t number = 0; number < parameters_.members.size(); ++number) {
    const MemberKind& kind = kinds_[member_kinds_[number]];
    mass += parameters_.sections[kind.section].mass_per_length() * kind.inner_length();
  }
  all.add("structure", "network");
  all.add("junctions", static_cast<double>(parameters_.junctions.size()));
  all.add("members", static_cast<double>(parameters_.members.size()));
  all.add("nodes", static_cast<double>(total_nodes()));
  all.add("kinds of members", static_cast<double>(kinds_.size()));
  all.add("mass [kg]", mass);
  if (rotary()) {
    all.add("rotary inertia", "of members about their axes");
  }
  all.add("sections, junctions and members, checksum", std::to_string(checksum_of(parameters_)));
}

}  // namespace udar
