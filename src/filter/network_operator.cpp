#include "udar/filter/network_operator.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "structure/member_frame.hpp"
#include "udar/filter/pc_network.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

double component(const std::array<double, 3>& axis, const double* vector) {
  return axis[0] * vector[0] + axis[1] * vector[1] + axis[2] * vector[2];
}

double larger(double one, double other) { return std::abs(one) >= std::abs(other) ? one : other; }

/// Moments at the end of a rigid arm instead of at the node.
void carry_to_end(const Place& arm, double* force) {
  force[3] -= arm.y * force[2] - arm.z * force[1];
  force[4] -= arm.z * force[0] - arm.x * force[2];
  force[5] -= arm.x * force[1] - arm.y * force[0];
}

}  // namespace

NetworkOperator::NetworkOperator(const Network& network, double filter_frequency)
    : AssembledOperator{network.stiffness(), network.points(), filter_frequency, Translation::by_direction},
      network_{&network},
      filter_frequency_{filter_frequency} {
  compose_network(op(), *this);
  prepare_gather();
}

const char* NetworkOperator::solver_type() const { return kPcNetwork; }

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
      rows.push_back(network_->row(network_->junction_node(junction), freedom));
    }
  }
  const auto count = static_cast<PetscInt>(rows.size());
  petsc::IndexSet from;
  UDAR_CALL(MatCreateVecs(op(), all_.put(), nullptr));
  UDAR_CALL(ISCreateGeneral(PETSC_COMM_SELF, count, rows.data(), PETSC_COPY_VALUES, from.put()));
  UDAR_CALL(VecCreateSeq(PETSC_COMM_SELF, count, of_junctions_.put()));
  UDAR_CALL(VecScatterCreate(all_, from, of_junctions_, nullptr, gather_.put()));
}

void NetworkOperator::extract(std::span<const double> unknowns, const FilterColumn& column) const {
  FilterColumn stretch = column;
  stretch.internal = nullptr;
  AssembledOperator::extract(unknowns, stretch);
  const std::size_t points = mass().size();
  for (std::size_t i = 0; column.internal != nullptr && i < points; ++i) {
    column.internal[i] = scale()[points + i] * unknowns[points + i];
    column.internal[points + i] = column.displacement[i] + column.stretch[i];
  }
}

void NetworkOperator::unknowns_of(const FilterColumn& column, std::span<double> unknowns) const {
  const std::size_t points = mass().size();
  for (std::size_t i = 0; i < points; ++i) {
    unknowns[i] = fixed(i) ? 0.0 : column.stretch[i] / scale()[i];
    unknowns[points + i] = column.internal[i] / scale()[points + i];
  }
}

/// Displacements and rotations of the junctions that members of this rank end at.
void NetworkOperator::gather(std::span<const double> internal) const {
  const std::size_t points = mass().size();
  {
    const petsc::WriteArray values{all_};
    std::copy_n(internal.data() + points, points, values.values());
    std::copy_n(internal.data(), points, values.values() + points);
  }
  UDAR_CALL(VecScatterBegin(gather_, all_, of_junctions_, INSERT_VALUES, SCATTER_FORWARD));
  UDAR_CALL(VecScatterEnd(gather_, all_, of_junctions_, INSERT_VALUES, SCATTER_FORWARD));
}

/// visit(axes, element, motion, force): what both nodes do, less the translation of the first, and the forces that this
/// takes, twelve of each in global axes; by member, then element.
template <class Visit>
void NetworkOperator::visit_elements(std::span<const double> internal, const Visit& visit) const {
  gather(internal);
  const petsc::ReadArray junctions{of_junctions_};
  const std::size_t nodes = network_->nodes();
  const std::size_t points = mass().size();
  const NetworkParameters& given = network_->parameters();
  for (std::size_t number = 0; number < given.members.size(); ++number) {
    if (network_->member_ranks()[number] != network_->rank()) {
      continue;
    }
    const Member& member = given.members[number];
    const double length = network_->kinds()[network_->kind(number)].element_length;
    const auto motion_of = [&](std::size_t i) {
      Motion motion{};
      if (i == 0 || i == member.elements) {
        const auto at = std::ranges::lower_bound(touched_, member.ends.at(i == 0 ? 0 : 1).junction) - touched_.begin();
        std::copy_n(junctions.values() + 6 * at, 6, motion.begin());
        return motion;
      }
      const std::size_t local = network_->node(number, i).local;
      for (std::size_t k = 0; k < 3; ++k) {
        motion.at(k) = internal[points + Network::kBlock.at(k) * nodes + local];
        motion.at(3 + k) = internal[Network::kBlock.at(k) * nodes + local];
      }
      return motion;
    };
    FrameElement element;
    FrameElement::Matrix matrix{};
    Motion left = motion_of(0);
    for (std::size_t i = 0; i < member.elements; ++i) {
      if (i < 2 || i + 1 == member.elements) {  // all between are alike
        element = element_of(member, length, i);
        matrix = element.stiffness(given.sections[member.section], network_->axes(number));
      }
      const Motion right = motion_of(i + 1);
      std::array<double, 12> motion{};
      std::array<double, 12> force{};
      for (std::size_t k = 0; k < 6; ++k) {
        motion.at(k) = k < 3 ? 0.0 : left.at(k);
        motion.at(6 + k) = right.at(k) - (k < 3 ? left.at(k) : 0.0);
      }
      for (std::size_t row = 0; row < 12; ++row) {
        for (std::size_t k = 0; k < 12; ++k) {
          force.at(row) += matrix[row][k] * motion.at(k);
        }
      }
      visit(network_->axes(number), element, motion, force);
      left = right;
    }
  }
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
  visit_elements(internal, [&](const Axes& axes, const FrameElement& element, const std::array<double, 12>& /*motion*/,
                               std::array<double, 12> force) {
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
  double energy = 0.0;
  visit_elements(internal, [&](const Axes& /*axes*/, const FrameElement& /*element*/,
                               const std::array<double, 12>& motion, const std::array<double, 12>& force) {
    for (std::size_t k = 0; k < 12; ++k) {
      energy += 0.5 * motion.at(k) * force.at(k);
    }
  });
  const std::size_t nodes = network_->nodes();
  const std::size_t points = mass().size();
  const std::vector<std::size_t>& own = network_->own_junctions();
  for (std::size_t i = 0; i < own.size(); ++i) {
    const std::array<double, 6>& spring = network_->parameters().junctions[own[i]].stiffness;
    for (std::size_t k = 0; k < 3; ++k) {
      const double moved = internal[points + Network::kBlock.at(k) * nodes + i];
      const double turned = internal[Network::kBlock.at(k) * nodes + i];
      energy += 0.5 * (spring.at(k) * moved * moved + spring.at(3 + k) * turned * turned);
    }
  }
  return energy;
}

}  // namespace udar
