#pragma once
/// @file
/// Structures of straight beams in three dimensions: frames, grillages, lattices, pipe networks.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "udar/petsc/handle.hpp"
#include "udar/structure/member_packs.hpp"
#include "udar/structure/structure.hpp"

namespace udar {

/// @brief Cross section and material of members. Axes of a member: x along it, y and z the principal axes of its
/// section.
struct MemberSection {
  std::string name;                      ///< for messages
  double youngs_modulus = 0.0;           ///< E [Pa], > 0
  double shear_modulus = 0.0;            ///< G [Pa], > 0
  double density = 0.0;                  ///< [kg/m^3], > 0
  double area = 0.0;                     ///< A [m^2], > 0
  std::array<double, 2> inertia{};       ///< of bending in the planes xy (I about z) and xz (I about y) [m^4], > 0
  double torsion_constant = 0.0;         ///< J [m^4], > 0
  std::array<double, 2> shear_factor{};  ///< k of k G A along y and z, Timoshenko; 0: no shear strain
  double radius = 0.0;                   ///< for pictures [m]; 0: that of a circle of this area

  [[nodiscard]] double tube_radius() const;                                         ///< of the tube in pictures [m]
  [[nodiscard]] double mass_per_length() const noexcept { return density * area; }  ///< [kg/m]
  [[nodiscard]] double axial() const noexcept { return youngs_modulus * area; }     ///< EA [N]
  [[nodiscard]] double bending(std::size_t plane) const { return youngs_modulus * inertia.at(plane); }  ///< [N m^2]
  [[nodiscard]] double torsion() const noexcept { return shear_modulus * torsion_constant; }            ///< GJ [N m^2]
  /// Rotary inertia about the axis, of unit length [kg m].
  [[nodiscard]] double polar() const noexcept { return density * (inertia[0] + inertia[1]); }
  /// 1 / (k G A) [1/N].
  [[nodiscard]] double shear_compliance(std::size_t plane) const {
    const double k = shear_factor.at(plane);
    return k > 0.0 ? 1.0 / (k * shear_modulus * area) : 0.0;
  }
};

/// @brief Where members meet or end.
struct Junction {
  std::string name;                   ///< for messages
  Place place{};                      ///< [m]
  std::array<bool, 6> held{};         ///< displacements along x, y, z, rotations about them: never move
  std::array<double, 6> stiffness{};  ///< of springs to the ground: three [N/m], three [N m/rad]
  double mass = 0.0;                  ///< of a point mass besides that of the members [kg]
};

/// @brief One end of a member.
struct MemberEnd {
  static constexpr double kRigid = std::numeric_limits<double>::infinity();

  std::size_t junction = 0;
  Place offset{};  ///< rigid arm from the junction to the end [m]
  /// Of the joint between junction and member about the member's x, y, z [N m/rad]; infinite: rigid, 0: a hinge.
  std::array<double, 3> joint{kRigid, kRigid, kRigid};
};

/// @brief A straight beam between two junctions.
struct Member {
  std::string name;  ///< for messages
  std::array<MemberEnd, 2> ends{};
  std::size_t section = 0;
  std::size_t elements = 1;
  /// Lengths of the elements from the first end, in any unit: they share that of the member; empty: equal ones.
  std::vector<double> spacing{};
  /// The member's y axis is in the plane of its x axis and this; zero: the global y axis, of a member along y the
  /// global x axis.
  Place orientation{};
};

/// @brief What nodes of a region face: there they have a mass along the normal.
struct FacedPlane {
  Region region;
  Facing facing{};
};

/// @brief How junctions are dealt to ranks: by METIS, or in their order.
enum class NetworkPartition : std::uint8_t { metis, contiguous };

/// @brief A network as it is given, equal on every rank.
struct NetworkParameters {
  std::vector<MemberSection> sections;
  std::vector<Junction> junctions;
  std::vector<Member> members;
  std::vector<FacedPlane> planes{};
  NetworkPartition partition = NetworkPartition::metis;
  bool rotary_inertia = false;  ///< whether nodes have inertia against the twist of their members
  /// Pairs of nodes that one rank has, numbered junctions first, then the inner nodes of each member.
  std::vector<std::array<std::size_t, 2>> together{};
};

/// @brief The axes of a member: rows are unit vectors along x, y, z in global axes.
using Axes = std::array<std::array<double, 3>, 3>;

/// @brief The axes of a junction's rotations: the principal ones of its rotary inertia first, then those without.
struct JunctionRotations {
  Axes axes{};                      ///< rows are orthonormal; those that are held, along global axes, are the last
  std::size_t count = 0;            ///< of those with inertia, none of them held
  std::array<double, 3> inertia{};  ///< about these [kg m^2]
  std::array<bool, 3> held{};       ///< of each axis
};

/// @brief Members that differ by place and direction alone.
struct MemberKind {
  std::size_t section = 0;
  std::size_t elements = 1;
  double element_length = 0.0;                   ///< of unequal ones their mean [m]
  std::array<std::array<double, 3>, 2> joint{};  ///< of both ends, as `MemberEnd::joint`
  std::vector<double> lengths{};                 ///< of unequal elements from the first end [m], else empty

  [[nodiscard]] bool equal_elements() const noexcept { return lengths.empty(); }
  /// Of one element [m].
  [[nodiscard]] double length(std::size_t element) const {
    return equal_elements() ? element_length : lengths[element];
  }
  /// Of the element at the first or second end [m].
  [[nodiscard]] double end_length(std::size_t end) const { return length(end == 0 ? 0 : elements - 1); }
  /// Whose mass inner node i = 1, ... has: half of each element beside it [m].
  [[nodiscard]] double node_length(std::size_t i) const {
    return equal_elements() ? element_length : 0.5 * (lengths[i - 1] + lengths[i]);
  }
  [[nodiscard]] double shortest() const;      ///< element [m]
  [[nodiscard]] double inner_length() const;  ///< whose mass all inner nodes have [m]
};

/// @brief A spring to the ground against a rotation of a junction that nothing else resists.
struct RotationSpring {
  std::size_t junction = 0;
  Place axis{};            ///< unit vector [-]
  double stiffness = 0.0;  ///< [N m/rad]
};

/// @brief Masses at the junctions and at the nodes of members, three scalar points each: all nodes along y first, then
/// along x, then along z.
///
/// With rotary inertia there are points that turn behind them (`MassPoints::turning`): of each junction about those
/// principal axes about which members have inertia, then of each inner node about its member's axis. Their mass is
/// rho I_p h [kg m^2], their place an angle [rad].
///
/// A node that faces an oblique plane has axes of its own, one of them the plane's normal, others those of planes at
/// right angles to it (`MassPoints::frames`). The stiffness knows nothing of that.
/// Nodes are numbered junctions first, then the inner nodes of each member from its first end to its second. A local
/// node is a junction of this rank, or where a member is cut, or stands in a pack. An element's mass is halved between
/// its ends; that of a member's end is at its junction, whatever the offset. Other rotations have no mass. One that
/// nothing resists couples to no force: it is held by a spring, that of a straight line of members about its own axis
/// with a note. Source: docs/theory.md, "Networks"
class Network final : public Structure {
 public:
  /// Which block of the points is that along x, y, z.
  static constexpr std::array<std::size_t, 3> kBlock{1, 0, 2};

  /// Deals junctions and members to the ranks, a member to a rank of one of its junctions.
  /// @note Collective. @throws InputError naming junction, member or section, the value and its unit, if something is
  /// not allowed, does not exist, or stands twice at one place; if a node faces two planes that are not at right
  /// angles, or is held in some directions and faces an oblique one; if a junction can turn without being resisted (of
  /// members of one element with two offsets that is left to the solver of the filter); if there are more ranks than
  /// junctions; if a node faces a field where that has no height
  Network(MPI_Comm comm, NetworkParameters parameters);

  [[nodiscard]] const MassPoints& points() const override { return *points_; }
  [[nodiscard]] const Network* network() const override { return this; }
  /// The frame of all elements in displacements and rotations, `MATAIJ`: `row` says which is where. A coordinate that
  /// is held has a row and a column of the identity, times the stiffness of the members there. On first demand.
  /// @note Collective.
  [[nodiscard]] Mat stiffness() const override;
  /// Of the stiffest kind of element, whatever its direction, and the stiffest spring.
  [[nodiscard]] double largest_ratio() const override;
  /// Highest natural frequency of a long member of the stiffest kind of element, 2c/h along it or 4 sqrt(EI/m)/h^2
  /// across [rad/s].
  [[nodiscard]] double highest_frequency() const;
  [[nodiscard]] Topology topology() const override;  ///< a line for each element
  [[nodiscard]] PetscInt rigid_modes() const override { return 6 * static_cast<PetscInt>(connected_parts_); }
  [[nodiscard]] bool grounded() const override;
  void describe(Description& all) const override;

  [[nodiscard]] MPI_Comm comm() const noexcept { return comm_; }
  [[nodiscard]] int rank() const noexcept { return rank_; }
  [[nodiscard]] const NetworkParameters& parameters() const noexcept { return parameters_; }
  /// What the user should know, and what looks like a mistake; equal on every rank.
  [[nodiscard]] const std::vector<std::string>& notes() const noexcept { return notes_; }
  [[nodiscard]] const std::vector<std::string>& warnings() const noexcept { return warnings_; }
  [[nodiscard]] std::size_t connected_parts() const noexcept { return connected_parts_; }
  [[nodiscard]] const std::vector<RotationSpring>& rotation_springs() const noexcept { return rotation_springs_; }

  [[nodiscard]] const Axes& axes(std::size_t member) const { return axes_[member]; }
  [[nodiscard]] const std::vector<MemberKind>& kinds() const noexcept { return kinds_; }
  [[nodiscard]] std::size_t kind(std::size_t member) const { return member_kinds_[member]; }
  /// Where the inner nodes of this rank's members stand.
  [[nodiscard]] const MemberPacks& packs() const noexcept { return packs_; }
  /// Rank of each junction and member; equal on every rank.
  [[nodiscard]] const std::vector<int>& junction_ranks() const noexcept { return junction_ranks_; }
  [[nodiscard]] const std::vector<int>& member_ranks() const noexcept { return member_ranks_; }
  /// Whether a member ends at a junction that is not this rank's.
  [[nodiscard]] bool ends_elsewhere(std::size_t member) const;
  /// Junctions of this rank, ascending: local node is the place in this list.
  [[nodiscard]] const std::vector<std::size_t>& own_junctions() const noexcept { return own_junctions_; }
  [[nodiscard]] std::size_t nodes() const noexcept;  ///< of this rank
  [[nodiscard]] std::size_t total_nodes() const noexcept { return rank_nodes_.back(); }

  [[nodiscard]] std::size_t total_elements() const noexcept {
    return total_nodes() - parameters_.junctions.size() + parameters_.members.size();
  }

  /// A node of any rank: its rank, and which of that rank's nodes it is.
  struct Node {
    int rank = 0;
    std::size_t local = 0;
  };
  [[nodiscard]] Node junction_node(std::size_t junction) const;
  /// Node 0, ..., `elements` of a member of this rank, those of its junctions included.
  [[nodiscard]] Node node(std::size_t member, std::size_t number) const;
  /// Global point of a node along x, y, z: 0, 1, 2.
  [[nodiscard]] PetscInt point(const Node& node, std::size_t direction) const;
  /// Row of the stiffness: of displacements along x, y, z, 0, 1, 2, and of rotations about them, 3, 4, 5. Each rank's
  /// rows are its points, then the rotations of all its nodes about y, then about x, then about z. With rotary inertia
  /// rotations are those about the axes of the node, and behind the points are by node those without inertia.
  [[nodiscard]] PetscInt row(const Node& node, std::size_t freedom) const;
  /// The same of rows that are, on each rank, displacements of all its nodes along y, x, z, then rotations about them.
  [[nodiscard]] PetscInt nodal_row(const Node& node, std::size_t freedom) const;

  /// @name Of rotary inertia @{
  [[nodiscard]] bool rotary() const noexcept { return parameters_.rotary_inertia; }
  /// Axes of the rotations of a junction.
  [[nodiscard]] const JunctionRotations& rotations(std::size_t junction) const { return turning_.rotations[junction]; }
  /// Points of this rank that turn, those of its junctions first.
  [[nodiscard]] std::size_t turning_points() const noexcept;
  [[nodiscard]] std::size_t turning_points_of_junctions() const noexcept;
  /// Where, among the rank's rows of rotations, is that of a node about axis 0, 1, 2 of its own; first those that are
  /// points.
  [[nodiscard]] std::size_t rotation_place(const Node& node, std::size_t axis) const;
  /// visit(local, member, number) of all inner nodes of this rank's members, numbers counted from 1.
  void each_inner_node(
      const std::function<void(std::size_t local, std::size_t member, std::size_t number)>& visit) const;
  /// @}

 private:
  /// Rotary inertia of junctions; empty without.
  struct Turning {
    std::vector<JunctionRotations> rotations{};  // by junction
    std::vector<std::size_t> first{};            // of each rank, in `before`
    std::vector<std::size_t> before{};           // points at the rank's junctions before, at last of all of them
  };

  void deal();
  void sort_members();
  void pack_members();
  void place_points();
  void count_turning_points();
  void add_turning_points(PointTable& table) const;
  [[nodiscard]] std::vector<NodeFrame> node_frames(std::span<const Place> places,
                                                   std::span<const std::size_t> fixed) const;

  MPI_Comm comm_;
  int rank_ = 0;
  NetworkParameters parameters_;
  std::vector<Axes> axes_;
  std::vector<MemberKind> kinds_;
  std::vector<std::size_t> member_kinds_;
  MemberPacks packs_;
  std::vector<int> junction_ranks_;
  std::vector<int> member_ranks_;
  std::vector<std::size_t> own_junctions_;
  std::vector<std::size_t> junction_places_;  // of each junction, among its rank's
  std::vector<std::size_t> rank_nodes_;       // nodes of all ranks before, then of all
  Turning turning_;
  std::size_t connected_parts_ = 1;
  std::vector<RotationSpring> rotation_springs_;
  std::vector<std::string> notes_;
  std::vector<std::string> warnings_;
  std::unique_ptr<PlacedPoints> points_;
  mutable petsc::Matrix stiffness_;
};

}  // namespace udar
