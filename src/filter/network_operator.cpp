#include "udar/filter/network_operator.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "filter/strained.hpp"
#include "structure/member_frame.hpp"
#include "udar/filter/network_solver.hpp"
#include "udar/filter/pc_network.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/shell_matrix.hpp"
#include "udar/structure/junction_rotations.hpp"

namespace udar {
namespace {

double component(const std::array<double, 3>& axis, const double* vector) {
  return axis[0] * vector[0] + axis[1] * vector[1] + axis[2] * vector[2];
}

double larger(double one, double other) { return std::abs(one) >= std::abs(other) ? one : other; }

/// Whether the element there is as those between.
bool plain(const MemberEnd& end) {
  return end.offset.x == 0.0 && end.offset.y == 0.0 && end.offset.z == 0.0 &&
         std::ranges::all_of(end.joint, [](double joint) { return std::isinf(joint); });
}

}  // namespace

NetworkOperator::NetworkOperator(const Network& network, double filter_frequency)
    : ScaledOperator{network.comm(), network.points(), filter_frequency},
      network_{&network},
      filter_frequency_{filter_frequency} {
  prepare_gather();
  list_springs();
  list_held();
  find_scale();
  op_ = petsc::symmetric_shell<&NetworkOperator::multiply>(comm(), static_cast<PetscInt>(unknowns()),
                                                           6 * static_cast<PetscInt>(network.total_nodes()), *this);
  compose_network(op_, *this);
}

NetworkOperator::~NetworkOperator() = default;

Mat NetworkOperator::matrix() {
  if (matrix_ == nullptr) {
    matrix_ = assembled(network_->stiffness());
    compose_network(matrix_, *this);
  }
  return matrix_;
}

const char* NetworkOperator::solver_type() const { return kPcNetwork; }

/// In nodal order.
std::size_t NetworkOperator::unknown(std::size_t local, std::size_t freedom) const {
  return (3 * (freedom / 3) + Network::kBlock.at(freedom % 3)) * network_->nodes() + local;
}

/// visit(local, axes of its rotations) of this rank's nodes, where there is rotary inertia.
template <class Visit>
void NetworkOperator::each_axes(const Visit& visit) const {
  if (!network_->rotary()) {
    return;
  }
  const std::vector<std::size_t>& own = network_->own_junctions();
  for (std::size_t local = 0; local < own.size(); ++local) {
    visit(local, network_->rotations(own[local]).axes);
  }
  network_->each_inner_node(
      [&](std::size_t local, std::size_t member, std::size_t /*number*/) { visit(local, network_->axes(member)); });
}

const Axes& NetworkOperator::axes_at(const Placed& placed, std::size_t node) const {
  return placed.at_junction.at(node) ? network_->rotations(touched_[placed.where.at(node)]).axes
                                     : network_->axes(placed.member);
}

NetworkOperator::ElementMatrix NetworkOperator::in_own_axes(const Placed& placed, const ElementMatrix& matrix) const {
  return network_->rotary() ? turned_rotations(matrix, axes_at(placed, 0), axes_at(placed, 1)) : matrix;
}

/// The axis; those that turn are at junctions where there is rotary inertia.
std::array<double, 3> NetworkOperator::in_own_axes(const Spring& spring) const {
  return network_->rotary() && spring.first == 3
             ? along(network_->rotations(network_->own_junctions()[spring.local]).axes, spring.axis)
             : spring.axis;
}

NetworkOperator::Nodal NetworkOperator::nodal_of(Rows rows) const {
  Nodal nodal = reordered_back(std::move(rows));
  each_axes([&](std::size_t local, const Axes& axes) {
    const std::array at{unknown(local, 3), unknown(local, 4), unknown(local, 5)};
    const std::array<double, 3> global = from_along(axes, {nodal[at[0]], nodal[at[1]], nodal[at[2]]});
    for (std::size_t k = 0; k < 3; ++k) {
      nodal[at[k]] = global[k];
    }
  });
  return nodal;
}

NetworkOperator::Rows NetworkOperator::rows_of(Nodal nodal) const {
  each_axes([&](std::size_t local, const Axes& axes) {
    const std::array at{unknown(local, 3), unknown(local, 4), unknown(local, 5)};
    const std::array<double, 3> own = along(axes, {nodal[at[0]], nodal[at[1]], nodal[at[2]]});
    for (std::size_t k = 0; k < 3; ++k) {
      nodal[at[k]] = own[k];
    }
  });
  return reordered(std::move(nodal));
}

/// Calls visit(row, place in nodal order) for all rotations about the nodes' own axes.
template <class Visit>
void NetworkOperator::each_rotation(const Visit& visit) const {
  each_axes([&](std::size_t local, const Axes& /*axes*/) {
    for (std::size_t k = 0; k < 3; ++k) {
      visit(3 * network_->nodes() + network_->rotation_place({.rank = network_->rank(), .local = local}, k),
            unknown(local, 3 + k));
    }
  });
}

/// Numbers about the nodes' own axes 0, 1, 2 where nodal order has those about x, y, z, to rows, and back.
NetworkOperator::Rows NetworkOperator::reordered(Nodal own) const {
  if (!network_->rotary()) {
    return own;
  }
  Rows rows = own;
  each_rotation([&](std::size_t row, std::size_t place) { rows[row] = own[place]; });
  return rows;
}
NetworkOperator::Nodal NetworkOperator::reordered_back(Rows rows) const {
  if (!network_->rotary()) {
    return rows;
  }
  Nodal own = rows;
  each_rotation([&](std::size_t row, std::size_t place) { own[place] = rows[row]; });
  return own;
}

/// Rotations of the nodes in global axes that points which turn make, about y, x, z; empty without such points.
std::vector<double> NetworkOperator::turned(const double* points) const {
  if (!network_->rotary()) {
    return {};
  }
  Rows rows(6 * network_->nodes(), 0.0);
  std::copy(points + 3 * network_->nodes(), points + mass().size(),
            rows.begin() + static_cast<std::ptrdiff_t>(3 * network_->nodes()));
  const Nodal nodal = nodal_of(std::move(rows));
  return {nodal.begin() + static_cast<std::ptrdiff_t>(3 * network_->nodes()), nodal.end()};
}

void NetworkOperator::prepare_gather() {
  const std::vector<Member>& members = network_->parameters().members;
  for (std::size_t member = 0; member < members.size(); ++member) {
    if (network_->member_ranks()[member] == network_->rank()) {
      touched_.push_back(members[member].ends[0].junction);
      touched_.push_back(members[member].ends[1].junction);
    }
  }
  std::ranges::sort(touched_);
  touched_.erase(std::ranges::unique(touched_).begin(), touched_.end());
  std::vector<PetscInt> rows;
  for (const std::size_t junction : touched_) {
    for (std::size_t freedom = 0; freedom < 6; ++freedom) {
      rows.push_back(network_->nodal_row(network_->junction_node(junction), freedom));
    }
  }
  const auto count = static_cast<PetscInt>(rows.size());
  petsc::IndexSet from;
  UDAR_CALL(VecCreateMPI(comm(), static_cast<PetscInt>(6 * network_->nodes()), PETSC_DETERMINE, all_.put()));
  UDAR_CALL(ISCreateGeneral(PETSC_COMM_SELF, count, rows.data(), PETSC_COPY_VALUES, from.put()));
  UDAR_CALL(VecCreateSeq(PETSC_COMM_SELF, count, of_junctions_.put()));
  UDAR_CALL(VecScatterCreate(all_, from, of_junctions_, nullptr, gather_.put()));
}

/// Those of junctions to the ground, and those of rotations that nothing else resists.
void NetworkOperator::list_springs() {
  const NetworkParameters& given = network_->parameters();
  const std::vector<std::size_t>& own = network_->own_junctions();
  for (std::size_t local = 0; local < own.size(); ++local) {
    const Junction& junction = given.junctions[own[local]];
    for (std::size_t freedom = 0; freedom < 6; ++freedom) {
      if (junction.stiffness.at(freedom) > 0.0 && !junction.held.at(freedom)) {
        Spring& spring = springs_.emplace_back(
            Spring{.local = local, .first = freedom / 3 * 3, .stiffness = junction.stiffness.at(freedom)});
        spring.axis.at(freedom % 3) = 1.0;
      }
    }
  }
  for (const auto& [junction, axis, stiffness] : network_->rotation_springs()) {
    if (network_->junction_ranks()[junction] == network_->rank()) {
      const std::array<bool, 6>& held = given.junctions[junction].held;
      springs_.push_back({.local = network_->junction_node(junction).local,
                          .first = 3,
                          .axis = {held[3] ? 0.0 : axis.x, held[4] ? 0.0 : axis.y, held[5] ? 0.0 : axis.z},
                          .stiffness = stiffness});
    }
  }
  for (std::size_t number = 0; number < given.members.size(); ++number) {
    const Member& member = given.members[number];
    if (!network_->rotary() && network_->member_ranks()[number] == network_->rank() && member.elements > 1 &&
        member.ends[0].joint[0] == 0.0 && member.ends[1].joint[0] == 0.0) {  // it turns about its own axis
      springs_.push_back({.local = network_->node(number, 1).local,
                          .first = 3,
                          .axis = network_->axes(number)[0],
                          .stiffness = given.sections[member.section].torsion() /
                                       network_->kinds()[network_->kind(number)].element_length});
    }
  }
}

/// With the diagonal of `Network::stiffness` for now.
void NetworkOperator::list_held() {
  const NetworkParameters& given = network_->parameters();
  const std::vector<std::size_t>& own = network_->own_junctions();
  std::vector<std::array<double, 2>> diagonal(own.size(), {0.0, 0.0});
  for (std::size_t number = 0; number < given.members.size(); ++number) {
    for (std::size_t end = 0; end < 2; ++end) {
      const std::size_t junction = given.members[number].ends.at(end).junction;
      if (network_->junction_ranks()[junction] == network_->rank()) {
        for (const std::size_t rotation : {0U, 1U}) {
          diagonal[network_->junction_node(junction).local].at(rotation) +=
              scale_of(given.sections[given.members[number].section],
                       network_->kinds()[network_->kind(number)].end_length(end), rotation == 1);
        }
      }
    }
  }
  for (std::size_t local = 0; local < own.size(); ++local) {
    for (std::size_t freedom = 0; freedom < 6; ++freedom) {
      if (given.junctions[own[local]].held.at(freedom)) {
        held_places_.push_back(unknown(local, freedom));
      }
      const bool own_axis = network_->rotary() && freedom >= 3;
      if (own_axis ? network_->rotations(own[local]).held.at(freedom - 3)
                   : given.junctions[own[local]].held.at(freedom)) {
        held_.emplace_back(own_axis
                               ? 3 * network_->nodes() +
                                     network_->rotation_place({.rank = network_->rank(), .local = local}, freedom - 3)
                               : unknown(local, freedom),
                           diagonal[local].at(freedom / 3));
      }
    }
  }
}

void NetworkOperator::find_scale() {
  Sums sums = no_sums();
  each_element([&](const Placed& placed, const FrameElement& /*element*/, const FrameElement::Matrix& matrix) {
    const FrameElement::Matrix own = in_own_axes(placed, matrix);
    for (std::size_t row = 0; row < 12; ++row) {
      sum_at(sums, placed, row) += own[row][row];
    }
  });
  for (const Spring& spring : springs_) {
    const std::array<double, 3> axis = in_own_axes(spring);
    for (std::size_t k = 0; k < 3; ++k) {
      sums.own[unknown(spring.local, spring.first + k)] += spring.stiffness * axis.at(k) * axis.at(k);
    }
  }
  add_up(sums);
  sums.own = reordered(std::move(sums.own));
  for (const auto& [unknown, diagonal] : held_) {
    sums.own[unknown] = diagonal;
  }
  set_scale(sums.own);
  for (auto& [unknown, diagonal] : held_) {
    diagonal = (diagonal + ground(unknown)) * scale()[unknown] * scale()[unknown];
  }
}

double NetworkOperator::norm() const {
  Sums sums = no_sums();
  const Nodal scales = reordered_back({scale().begin(), scale().end()});
  visit_elements(scales.data(), scales.data() + 3 * network_->nodes(), false,
                 [&](const Placed& placed, const FrameElement& /*element*/, const FrameElement::Matrix& matrix,
                     const Motion& left, const Motion& right) {
                   const FrameElement::Matrix own = in_own_axes(placed, matrix);
                   for (std::size_t row = 0; row < 12; ++row) {
                     double& sum = sum_at(sums, placed, row);
                     for (std::size_t k = 0; k < 6; ++k) {
                       sum += std::abs(own[row][k]) * left.at(k) + std::abs(own[row][6 + k]) * right.at(k);
                     }
                   }
                 });
  for (const Spring& spring : springs_) {
    const std::array<double, 3> axis = in_own_axes(spring);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        sums.own[unknown(spring.local, spring.first + i)] +=
            spring.stiffness * std::abs(axis.at(i) * axis.at(k)) * scales[unknown(spring.local, spring.first + k)];
      }
    }
  }
  add_up(sums);
  sums.own = reordered(std::move(sums.own));
  for (std::size_t i = 0; i < sums.own.size(); ++i) {
    sums.own[i] = scale()[i] * (sums.own[i] + ground(i) * scale()[i]);
  }
  for (const auto& [unknown, diagonal] : held_) {
    sums.own[unknown] = diagonal;
  }
  double norm = sums.own.empty() ? 0.0 : std::ranges::max(sums.own);
  MPI_Allreduce(MPI_IN_PLACE, &norm, 1, MPI_DOUBLE, MPI_MAX, comm());
  return norm;
}

void NetworkOperator::multiply(std::span<const double> x, std::span<double> y) {
  Rows motion(x.size());
  for (std::size_t i = 0; i < motion.size(); ++i) {
    motion[i] = scale()[i] * x[i];
  }
  const Nodal nodal = nodal_of(motion);
  const Rows force = rows_of(forces(nodal.data(), nodal.data() + 3 * network_->nodes()));
  for (std::size_t i = 0; i < y.size(); ++i) {
    y[i] = scale()[i] * (force[i] + ground(i) * motion[i]);
  }
  for (const auto& [unknown, diagonal] : held_) {
    y[unknown] = diagonal * x[unknown];
  }
}

void NetworkOperator::right_hand_side(const FilterColumn& column, std::span<double> values) const {
  const std::vector<double> rotation = turned(column.displacement);
  const Rows force = rows_of(forces(column.displacement, rotation.empty() ? nullptr : rotation.data()));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double given = i < mass().size() && column.force != nullptr ? column.force[i] : 0.0;
    values[i] = scale()[i] * (given - force[i]);
  }
  for (const auto& [unknown, diagonal] : held_) {
    values[unknown] = 0.0;
  }
}

void NetworkOperator::extract(std::span<const double> unknowns, const FilterColumn& column) const {
  extract_stretch(unknowns, column);
  if (column.internal == nullptr) {
    return;
  }
  const std::size_t points = mass().size();
  Rows rows(scale().size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i] = i < points ? column.displacement[i] + column.stretch[i] : scale()[i] * unknowns[i];
  }
  std::ranges::copy_n(rows.begin(), static_cast<std::ptrdiff_t>(points), column.internal + points);
  const Nodal nodal = nodal_of(std::move(rows));
  std::fill_n(column.internal, points, 0.0);
  std::copy(nodal.begin() + static_cast<std::ptrdiff_t>(3 * network_->nodes()), nodal.end(), column.internal);
}

void NetworkOperator::unknowns_of(const FilterColumn& column, std::span<double> unknowns) const {
  const std::size_t points = mass().size();
  Nodal nodal(unknowns.size(), 0.0);
  std::copy_n(column.internal, 3 * network_->nodes(),
              nodal.begin() + static_cast<std::ptrdiff_t>(3 * network_->nodes()));
  const Rows rows = rows_of(std::move(nodal));
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const double stretch = i < points ? column.stretch[i] : rows[i];
    unknowns[i] = i < points && fixed(i) ? 0.0 : stretch / scale()[i];
  }
}

void NetworkOperator::internal_of(const FilterColumn& column) {
  // The line then stands off its masses by 1e-12 of their displacements against each other at the most.
  constexpr double kFarAbove = 1e6;
  if (held_network_ == nullptr) {
    held_network_ = std::make_unique<NetworkSolver>(*network_, kFarAbove * std::sqrt(network_->largest_ratio()));
  }
  const std::size_t points = mass().size();
  std::vector<double> stretch(points);
  const FilterColumn held{.displacement = column.displacement, .stretch = stretch.data(), .internal = column.internal};
  held_network_->solve({&held, 1});
  std::copy_n(column.displacement, points, column.internal + points);
}

/// Displacements and rotations of the junctions that members of this rank end at; what is held stays,
/// unless displacements are those that its place has.
void NetworkOperator::gather(const double* displacement, const double* rotation, bool all_move) const {
  const std::size_t numbers = 3 * network_->nodes();
  {
    const petsc::WriteArray values{all_};
    std::copy_n(displacement, numbers, values.values());
    if (rotation != nullptr) {
      std::copy_n(rotation, numbers, values.values() + numbers);
    } else {
      std::fill_n(values.values() + numbers, numbers, 0.0);
    }
    for (const std::size_t place : held_places_) {
      double& value = values.values()[place];
      value = all_move && place < numbers ? value : 0.0;
    }
  }
  UDAR_CALL(VecScatterBegin(gather_, all_, of_junctions_, INSERT_VALUES, SCATTER_FORWARD));
  UDAR_CALL(VecScatterEnd(gather_, all_, of_junctions_, INSERT_VALUES, SCATTER_FORWARD));
}

NetworkOperator::Sums NetworkOperator::no_sums() const {
  return {.own = Nodal(6 * network_->nodes(), 0.0), .junction = std::vector<double>(6 * touched_.size(), 0.0)};
}

double& NetworkOperator::sum_at(Sums& sums, const Placed& placed, std::size_t row) const {
  const std::size_t node = row / 6;
  return placed.at_junction.at(node) ? sums.junction[6 * placed.where.at(node) + row % 6]
                                     : sums.own[unknown(placed.where.at(node), row % 6)];
}

/// What this rank's members do to junctions, to whoever has these.
void NetworkOperator::add_up(Sums& sums) const {
  {
    const petsc::WriteArray values{all_};
    std::ranges::copy(sums.own, values.values());
    const petsc::WriteArray junctions{of_junctions_};
    std::ranges::copy(sums.junction, junctions.values());
  }
  UDAR_CALL(VecScatterBegin(gather_, of_junctions_, all_, ADD_VALUES, SCATTER_REVERSE));
  UDAR_CALL(VecScatterEnd(gather_, of_junctions_, all_, ADD_VALUES, SCATTER_REVERSE));
  const petsc::ReadArray values{all_};
  std::copy_n(values.values(), sums.own.size(), sums.own.begin());
}

/// What an element is strained by.
auto NetworkOperator::straining() const {
  return [this](const Placed& placed, const FrameElement& element, const FrameElement::Matrix& matrix,
                const Motion& left, const Motion& right) {
    return network_->rotary() ? Strained{matrix, left, right, span_of(element, network_->axes(placed.member))}
                              : Strained{matrix, left, right};
  };
}

/// C times displacements and rotations of this rank's nodes, null for none.
NetworkOperator::Nodal NetworkOperator::forces(const double* displacement, const double* rotation) const {
  Sums sums = no_sums();
  const auto strained_by = straining();
  visit_elements(displacement, rotation, false,
                 [&](const Placed& placed, const FrameElement& element, const FrameElement::Matrix& matrix,
                     const Motion& left, const Motion& right) {
                   const Strained strained = strained_by(placed, element, matrix, left, right);
                   for (std::size_t row = 0; row < 12; ++row) {
                     sum_at(sums, placed, row) += strained.force[row];
                   }
                 });
  for (const auto& [local, first, axis, stiffness] : springs_) {
    const double* values = first == 0 ? displacement : rotation;
    double moved = 0.0;
    for (std::size_t k = 0; values != nullptr && k < 3; ++k) {
      moved += axis.at(k) * values[unknown(local, k)];
    }
    for (std::size_t k = 0; k < 3; ++k) {
      sums.own[unknown(local, first + k)] += stiffness * moved * axis.at(k);
    }
  }
  add_up(sums);
  return std::move(sums.own);
}

/// visit(placed, element, matrix), by member, then from its first end.
template <class Visit>
void NetworkOperator::each_element(const Visit& visit) const {
  const NetworkParameters& given = network_->parameters();
  FrameElement element;
  FrameElement::Matrix matrix{};
  const Member* of = nullptr;  // whose the matrix is
  const Axes* along = nullptr;
  bool special = true;  // whether it is of an end of its own
  for (std::size_t number = 0; number < given.members.size(); ++number) {
    if (network_->member_ranks()[number] != network_->rank()) {
      continue;
    }
    const Member& member = given.members[number];
    const Axes& axes = network_->axes(number);
    const MemberKind& kind = network_->kinds()[network_->kind(number)];
    const auto junction_at = [&](std::size_t end) {
      return static_cast<std::size_t>(std::ranges::lower_bound(touched_, member.ends.at(end).junction) -
                                      touched_.begin());
    };
    Placed placed{.member = number, .at_junction = {true, false}, .where = {junction_at(0), 0}};
    for (std::size_t i = 0; i < member.elements; ++i) {
      const bool last = i + 1 == member.elements;
      const bool own = (i == 0 && !plain(member.ends[0])) || (last && !plain(member.ends[1]));
      const bool other = i == 0 && (of == nullptr || of->section != member.section || *along != axes);
      if (own || special || other || kind.length(i) != element.length) {  // others are alike
        element = element_of(member, kind.length(i), i);
        matrix = element.stiffness(given.sections[member.section], axes);
        of = &member;
        along = &axes;
        special = own;
      }
      placed.at_junction[1] = last;
      placed.where[1] = last ? junction_at(1) : network_->node(number, i + 1).local;
      visit(placed, element, matrix);
      placed.at_junction[0] = false;
      placed.where[0] = placed.where[1];
    }
  }
}

/// visit(placed, element, matrix, left, right), with what both nodes do. @param rotation null for none
template <class Visit>
void NetworkOperator::visit_elements(const double* displacement, const double* rotation, bool all_move,
                                     const Visit& visit) const {
  gather(displacement, rotation, all_move);
  const petsc::ReadArray junctions{of_junctions_};
  const auto motion_of = [&](const Placed& placed, std::size_t node) {
    Motion motion{};
    if (placed.at_junction.at(node)) {
      std::copy_n(junctions.values() + 6 * placed.where.at(node), 6, motion.begin());
      return motion;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t at = unknown(placed.where.at(node), k);
      motion.at(k) = displacement[at];
      motion.at(3 + k) = rotation != nullptr ? rotation[at] : 0.0;
    }
    return motion;
  };
  Motion left{};
  each_element([&](const Placed& placed, const FrameElement& element, const FrameElement::Matrix& matrix) {
    if (placed.at_junction[0]) {
      left = motion_of(placed, 0);
    }
    const Motion right = motion_of(placed, 1);
    visit(placed, element, matrix, left, right);
    left = right;
  });
}

std::span<const FieldInfo> NetworkOperator::internal_fields() const {
  static constexpr auto field = [](std::string_view name, std::string_view unit, std::string_view label) {
    return FieldInfo{.name = name, .unit = unit, .where = Where::cells, .extremes = true, .label = label};
  };
  static constexpr std::array kFields{
      field("axial_force", "N", "axial force"),           field("shear_y", "N", "shear force along y"),
      field("shear_z", "N", "shear force along z"),       field("torque", "N m", "torque"),
      field("moment_y", "N m", "bending moment about y"), field("moment_z", "N m", "bending moment about z")};
  return kFields;
}

std::size_t NetworkOperator::internal_places() const {
  std::size_t elements = 0;  // as many as there are members, or more, where they are short and many meet
  for (const MemberPack& pack : network_->packs().packs()) {
    elements += pack.lanes * pack.elements;
  }
  return std::max(mass().size(), elements);
}

void NetworkOperator::internal_values(std::span<const double> internal, std::span<double> values) const {
  const std::size_t places = internal_places();
  std::size_t cell = 0;
  const auto strained_by = straining();
  visit_elements(internal.data() + mass().size(), internal.data(), true,
                 [&](const Placed& placed, const FrameElement& element, const FrameElement::Matrix& matrix,
                     const Motion& left, const Motion& right) {
                   std::array<double, 12> force = strained_by(placed, element, matrix, left, right).force;
                   const Axes& axes = network_->axes(placed.member);
                   carry_to_end(element.arm[0], force.data());
                   carry_to_end(element.arm[1], force.data() + 6);
                   const double* first = force.data() + 3;
                   const double* last = force.data() + 9;
                   values[cell] = component(axes[0], force.data() + 6);
                   values[places + cell] = component(axes[1], force.data() + 6);
                   values[2 * places + cell] = component(axes[2], force.data() + 6);
                   values[3 * places + cell] = component(axes[0], last);
                   values[4 * places + cell] = larger(-component(axes[1], first), component(axes[1], last));
                   values[5 * places + cell] = larger(-component(axes[2], first), component(axes[2], last));
                   ++cell;
                 });
}

double NetworkOperator::strain_energy(std::span<const double> /*displacement*/,
                                      std::span<const double> internal) const {
  const std::size_t points = mass().size();
  const double* displacement = internal.data() + points;
  double energy = 0.0;
  const auto strained_by = straining();
  visit_elements(displacement, internal.data(), true,
                 [&](const Placed& placed, const FrameElement& element, const FrameElement::Matrix& matrix,
                     const Motion& left, const Motion& right) {
                   const Strained strained = strained_by(placed, element, matrix, left, right);
                   for (std::size_t k = 0; k < 12; ++k) {
                     energy += 0.5 * strained.motion[k] * strained.force[k];
                   }
                 });
  for (const auto& [local, first, axis, stiffness] : springs_) {
    const double* values = first == 0 ? displacement : internal.data();
    double moved = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      moved += axis.at(k) * values[unknown(local, k)];
    }
    energy += 0.5 * stiffness * moved * moved;
  }
  return energy;
}

}  // namespace udar
