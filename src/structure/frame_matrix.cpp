#include "structure/frame_matrix.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "structure/member_frame.hpp"
#include "structure/place_algebra.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/junction_rotations.hpp"
#include "udar/structure/matrix_file.hpp"

namespace udar {
namespace {

/// Collects this rank's share of all entries.
class Assembly {
 public:
  explicit Assembly(const Network& network) : network_{&network}, given_{&network.parameters()} {}

  petsc::Matrix run() {
    add_diagonal();
    for (std::size_t member = 0; member < given_->members.size(); ++member) {
      if (network_->member_ranks()[member] == network_->rank()) {
        add_member(member);
      }
    }
    add_junctions();
    const auto rows = 6 * static_cast<PetscInt>(network_->total_nodes());
    petsc::Matrix matrix =
        matrix_of(network_->comm(), rows, rows, entries_, 6 * static_cast<PetscInt>(network_->nodes()));
    UDAR_CALL(MatSetOption(matrix, MAT_SYMMETRIC, PETSC_TRUE));
    return matrix;
  }

 private:
  using Freedoms = std::array<PetscInt, 6>;  // rows of a node's

  [[nodiscard]] Freedoms rows_of(const Network::Node& node) const {
    Freedoms rows{};
    for (std::size_t freedom = 0; freedom < 6; ++freedom) {
      rows.at(freedom) = network_->row(node, freedom);
    }
    return rows;
  }
  [[nodiscard]] const MemberKind& kind_of(std::size_t member) const {
    return network_->kinds()[network_->kind(member)];
  }
  void add(PetscInt row, PetscInt column, double value) {
    if (value != 0.0) {
      entries_.push_back({.row = row, .column = column, .value = value});
    }
  }
  void add_diagonal();
  void add_member(std::size_t number);
  void add_junctions();
  /// Those of a node that are held.
  [[nodiscard]] std::array<bool, 6> held_rows(std::size_t junction) const {
    std::array<bool, 6> held = given_->junctions[junction].held;
    for (std::size_t k = 0; network_->rotary() && k < 3; ++k) {
      held.at(3 + k) = network_->rotations(junction).held.at(k);
    }
    return held;
  }
  /// Axes of the rotations of a member's node.
  [[nodiscard]] const Axes& axes_at(std::size_t member, std::size_t node) const {
    const Member& given = given_->members[member];
    return node == 0                ? network_->rotations(given.ends[0].junction).axes
           : node == given.elements ? network_->rotations(given.ends[1].junction).axes
                                    : network_->axes(member);
  }
  /// A spring against the rotation about an axis in the node's axes.
  void add_rotation(const Freedoms& rows, const std::array<double, 3>& axis, double stiffness) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        add(rows.at(3 + i), rows.at(3 + j), stiffness * (axis.at(i) * axis.at(j)));
      }
    }
  }

  const Network* network_;
  const NetworkParameters* given_;
  std::vector<MatrixEntry> entries_;
};

/// Places on the diagonal, whatever stands there.
void Assembly::add_diagonal() {
  for (std::size_t local = 0; local < network_->nodes(); ++local) {
    for (const PetscInt row : rows_of({.rank = network_->rank(), .local = local})) {
      entries_.push_back({.row = row, .column = row, .value = 0.0});
    }
  }
}

void Assembly::add_member(std::size_t number) {
  const Member& member = given_->members[number];
  const MemberSection& section = given_->sections[member.section];
  const Axes& axes = network_->axes(number);
  constexpr std::array<bool, 6> kFree{};
  const MemberKind& kind = kind_of(number);
  FrameElement::Matrix matrix{};
  for (std::size_t element = 0; element < member.elements; ++element) {
    const bool first = element == 0;
    const bool last = element + 1 == member.elements;
    if (element < 2 || last || !kind.equal_elements()) {  // all between are alike
      matrix = element_of(member, kind.length(element), element).stiffness(section, axes);
    }
    const std::array<Freedoms, 2> rows{rows_of(network_->node(number, element)),
                                       rows_of(network_->node(number, element + 1))};
    const std::array held{first ? held_rows(member.ends[0].junction) : kFree,
                          last ? held_rows(member.ends[1].junction) : kFree};
    const FrameElement::Matrix own =
        network_->rotary() ? turned_rotations(matrix, axes_at(number, element), axes_at(number, element + 1)) : matrix;
    for (std::size_t i = 0; i < 12; ++i) {
      for (std::size_t j = 0; j < 12; ++j) {
        if (!held.at(i / 6).at(i % 6) && !held.at(j / 6).at(j % 6)) {
          add(rows.at(i / 6).at(i % 6), rows.at(j / 6).at(j % 6), own[i][j]);
        }
      }
    }
  }
  // Between two hinges of torsion a member turns about its own axis, without inertia as it likes.
  if (!network_->rotary() && member.elements > 1 && member.ends[0].joint[0] == 0.0 && member.ends[1].joint[0] == 0.0) {
    add_rotation(rows_of(network_->node(number, 1)), axes[0], section.torsion() / kind.element_length);
  }
}

/// Springs, and the identity where something is held.
void Assembly::add_junctions() {
  std::vector<std::array<double, 2>> scale(given_->junctions.size(), {0.0, 0.0});
  for (std::size_t number = 0; number < given_->members.size(); ++number) {
    const Member& member = given_->members[number];
    for (std::size_t end = 0; end < 2; ++end) {
      for (const std::size_t rotation : {0U, 1U}) {
        scale[member.ends.at(end).junction].at(rotation) +=
            scale_of(given_->sections[member.section], kind_of(number).end_length(end), rotation == 1);
      }
    }
  }
  for (const std::size_t number : network_->own_junctions()) {
    const Junction& junction = given_->junctions[number];
    const Freedoms rows = rows_of(network_->junction_node(number));
    const std::array<bool, 6> held = held_rows(number);
    for (std::size_t freedom = 0; freedom < (network_->rotary() ? 3 : 6); ++freedom) {
      add(rows.at(freedom), rows.at(freedom),
          held.at(freedom) ? scale[number].at(freedom / 3) : junction.stiffness.at(freedom));
    }
    for (std::size_t c = 0; network_->rotary() && c < 3; ++c) {
      if (held.at(3 + c)) {
        add(rows.at(3 + c), rows.at(3 + c), scale[number][1]);
      }
      if (!junction.held.at(3 + c) && junction.stiffness.at(3 + c) > 0.0) {
        std::array<double, 3> axis{};
        axis.at(c) = 1.0;
        add_rotation(rows, along(network_->rotations(number).axes, axis), junction.stiffness.at(3 + c));
      }
    }
  }
  for (const auto& [junction, axis, stiffness] : network_->rotation_springs()) {
    if (network_->junction_ranks()[junction] != network_->rank()) {
      continue;
    }
    std::array<double, 3> free_axis = values_of(axis);
    for (std::size_t c = 0; c < 3; ++c) {
      free_axis.at(c) *= given_->junctions[junction].held.at(3 + c) ? 0.0 : 1.0;
    }
    add_rotation(rows_of(network_->junction_node(junction)),
                 network_->rotary() ? along(network_->rotations(junction).axes, free_axis) : free_axis, stiffness);
  }
}

}  // namespace

petsc::Matrix frame_matrix(const Network& network) { return Assembly{network}.run(); }

}  // namespace udar
