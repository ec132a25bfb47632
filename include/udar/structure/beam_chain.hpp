#pragma once
/// @file
/// One straight beam cut into elements and distributed over the ranks.

#include <petscsys.h>

#include <array>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "udar/structure/structure.hpp"

namespace udar {

/// @brief A stretch of beam with constant properties.
///
/// One without bending stiffness and mass is a gap, one element long: the beams before and behind it are not connected,
/// their ends there are free.
struct BeamSegment {
  double length = 0.0;                                               ///< [m], > 0
  PetscInt elements = 0;                                             ///< > 0
  double bending_stiffness = 0.0;                                    ///< EI [N m^2], > 0; 0: a gap
  double mass_per_length = 0.0;                                      ///< rhoA [kg/m], > 0; 0: a gap
  double shear_stiffness = std::numeric_limits<double>::infinity();  ///< kGA [N]; infinite: Euler-Bernoulli
  double foundation_stiffness = 0.0;  ///< per length, both ways, unstressed on the reference axis [N/m^2], >= 0
  double section_modulus = 0.0;       ///< W = I/c: bending stress is |M| / W [m^3], >= 0; 0: not known
  double yield_stress = 0.0;          ///< [Pa], >= 0; 0: not known
  double yield_moment = std::numeric_limits<double>::infinity();  ///< plastic moment [N m], > 0; infinite: elastic
  double radius = 0.0;                                            ///< of the tube in pictures [m], >= 0; 0: not known

  [[nodiscard]] bool is_gap() const noexcept { return bending_stiffness == 0.0 && mass_per_length == 0.0; }
};

/// @brief How an end of the line is supported: springs to the reference axis, from 0 (free) to infinity (rigid).
struct BeamEnd {
  double translational_stiffness = 0.0;  ///< [N/m]; infinite: fixed
  double rotational_stiffness = 0.0;     ///< [N m/rad]; infinite: no rotation

  [[nodiscard]] bool fixed() const noexcept { return translational_stiffness == kRigid; }
  [[nodiscard]] bool moment_free() const noexcept { return rotational_stiffness == 0.0; }
  static constexpr double kRigid = std::numeric_limits<double>::infinity();
};

/// @brief A point mass carried by the nearest node.
struct PointMass {
  double position = 0.0;  ///< [m] from the left end
  double mass = 0.0;      ///< [kg], >= 0
};

/// @brief A spring between the line at the nearest node and the reference axis, both ways.
struct LineSupport {
  double position = 0.0;               ///< [m] from the left end
  double stiffness = BeamEnd::kRigid;  ///< [N/m], >= 0; infinite: the line is fixed there
};

/// @brief A part of the axis, often that of a support, whose nodes carry exactly the mass of its length.
struct MassPatch {
  double from = 0.0;  ///< [m] from the left end; may lie off the beam
  double to = 0.0;    ///< [m], > from

  bool operator==(const MassPatch&) const = default;
};

/// @brief A place where the line may turn plastically: the nearest node.
struct HingePlace {
  double position = 0.0;   ///< [m] from the left end
  double hardening = 0.0;  ///< moment over plastic rotation [N m/rad], >= 0
};

/// @brief Where a beam with a yield moment yields.
struct BeamPlasticity {
  std::vector<HingePlace> places;  ///< empty: every node with a yield moment
  double tangent_ratio = 0.0;      ///< of every node: EI after yielding over EI [-], >= 0, < 1
};

/// @brief A node of the line that may turn plastically.
struct PlasticHinge {
  PetscInt node = 0;       ///< global
  double moment = 0.0;     ///< yield moment [N m]
  double hardening = 0.0;  ///< [N m/rad]
};

/// @brief Everything that describes a beam before it is distributed; the same on every rank.
struct BeamParameters {
  std::vector<BeamSegment> segments;
  BeamEnd left;
  BeamEnd right;
  double tension = 0.0;  ///< axial tension [N], >= 0
  std::vector<PointMass> point_masses;
  std::vector<LineSupport> line_supports;
  std::vector<MassPatch> mass_patches;
  BeamPlasticity plasticity{};

  [[nodiscard]] double length() const;  ///< of all segments, gaps included [m]
  [[nodiscard]] bool yields() const;    ///< whether any segment has a yield moment
};

/// @brief What a bending moment comes to in the outermost fibre; not a number where that is not known.
struct MomentStress {
  double stress = 0.0;       ///< 1/W [Pa/(N m)]
  double utilisation = 0.0;  ///< of the yield stress [1/(N m)]
};

/// @brief One element of the massless line.
struct BeamElement {
  double length = 0.0;               ///< h [m]
  double flexural_compliance = 0.0;  ///< 1/EI [1/(N m^2)]
  double shear_compliance = 0.0;     ///< 1/kGA [1/N]; zero for Euler-Bernoulli
};

/// @brief A straight beam of `elements()` elements, or several in a row with gaps between them, whose nodes are dealt
/// to the ranks in contiguous pieces.
///
/// Properties of any node or element follow from the segments, so that no rank stores or builds more than its own
/// nodes. Masses are lumped at the nodes, half an element's mass to each of its ends. Mass patches cut the axis at
/// their edges: what lies on one side of an edge goes to the nearest node of that side, so that mass moves by O(h)
/// there and the total stays. Source: docs/theory.md, "Supports with a width"
class BeamChain final : public Structure {
 public:
  /// @note Collective.
  /// @throws InputError if a parameter is out of range, or there are more ranks than elements
  BeamChain(MPI_Comm comm, BeamParameters parameters);

  [[nodiscard]] const MassPoints& points() const override { return *points_; }
  [[nodiscard]] const BeamChain* chain() const override { return this; }
  /// Lines between neighbours, gaps included; the one to the right of a node is of the node's rank.
  [[nodiscard]] Topology topology() const override;
  [[nodiscard]] PetscInt rigid_modes() const override;
  [[nodiscard]] bool grounded() const override;
  void describe(Description& all) const override;

  [[nodiscard]] MPI_Comm comm() const noexcept { return comm_; }
  [[nodiscard]] const BeamParameters& parameters() const noexcept { return parameters_; }
  [[nodiscard]] PetscInt elements() const noexcept { return first_element_.back(); }
  [[nodiscard]] PetscInt nodes() const noexcept { return elements() + 1; }
  [[nodiscard]] double length() const noexcept { return first_position_.back(); }  ///< [m]

  /// This rank's nodes are [begin, end).
  [[nodiscard]] PetscInt begin() const noexcept { return begin_; }
  [[nodiscard]] PetscInt end() const noexcept { return end_; }
  [[nodiscard]] PetscInt local_nodes() const noexcept { return end_ - begin_; }

  struct NodeRange {
    PetscInt first;
    PetscInt last;
  };
  /// Properties by global number, available on every rank.
  [[nodiscard]] BeamElement element(PetscInt element) const;      ///< infinitely compliant where there is none
  [[nodiscard]] double position(PetscInt node) const;             ///< x [m]
  [[nodiscard]] double mass(PetscInt node) const;                 ///< lumped mass, point masses included [kg]
  [[nodiscard]] double mass_of(NodeRange nodes) const;            ///< of a row of nodes together [kg]
  [[nodiscard]] double ground_stiffness(PetscInt node) const;     ///< foundation and springs [N/m], rigid ones excluded
  [[nodiscard]] bool fixed(PetscInt node) const;                  ///< the line cannot move here
  [[nodiscard]] MomentStress moment_stress(PetscInt node) const;  ///< the larger of the sides on which it is known
  /// @brief The nodes that may yield, ascending: where the line has a moment and a segment beside it a yield moment, of
  /// two the smaller. @throws InputError if a hinge is asked for where there is none
  [[nodiscard]] std::vector<PlasticHinge> plastic_hinges() const;
  [[nodiscard]] PetscInt nearest_node(double position) const;  ///< the left one of two equally near
  /// @brief The nodes beside a place and the shares of a force there that they take, so that force and moment stay; all
  /// of it goes to a node that is there, and to the nearest where there is no element.
  struct NodeShare {
    PetscInt node;
    double share;
  };
  [[nodiscard]] std::array<NodeShare, 2> lever(double position) const;
  /// All nodes in [from, to], edges included to 1e-9 of an element; those that carry its mass if that is a mass patch.
  /// Empty if first > last.
  [[nodiscard]] NodeRange nodes_within(double from, double to) const;

  /// The end condition of a node where a beam begins or ends, null of others.
  [[nodiscard]] const BeamEnd* end_at(PetscInt node) const;

  /// @brief Values of the nodes just outside this rank's piece, zero beyond the beam's ends.
  template <std::size_t Count>
  struct Halo {
    std::array<double, Count> left{};
    std::array<double, Count> right{};
  };
  /// @param[in] first, last  the values of this rank's first and last node
  /// @note Collective: one message to each neighbour.
  template <std::size_t Count>
  [[nodiscard]] Halo<Count> exchange(const std::array<double, Count>& first,
                                     const std::array<double, Count>& last) const {
    Halo<Count> halo;
    exchange(first, last, halo.left, halo.right);
    return halo;
  }

  [[nodiscard]] double total_mass() const noexcept { return total_mass_; }  ///< [kg]

 private:
  [[nodiscard]] std::size_t segment_of_element(PetscInt element) const;
  void exchange(std::span<const double> first, std::span<const double> last, std::span<double> left,
                std::span<double> right) const;

  MPI_Comm comm_;
  BeamParameters parameters_;
  std::vector<PetscInt> first_element_;  // of each segment, then the number of elements
  std::vector<double> first_position_;   // of each segment, then the length
  using NodeValues = std::vector<std::pair<PetscInt, double>>;
  [[nodiscard]] static double sum_at(const NodeValues& values, PetscInt node);

  NodeValues node_masses_;   // point masses by node, ascending
  NodeValues node_springs_;  // line supports by node, ascending
  PetscInt begin_ = 0;
  PetscInt end_ = 0;
  double total_mass_ = 0.0;

  /// Between two edges of mass patches: a row of nodes that carry what lies there.
  struct MassPiece {
    double from;
    double to;
    NodeRange nodes;
    bool patch;  // lies in one
    [[nodiscard]] bool empty() const { return nodes.first > nodes.last; }
  };
  [[nodiscard]] std::vector<double> edges_of_patches() const;
  void cut_masses();
  void give_nodes_to_narrow_patches();
  void refuse_pieces_without_mass() const;
  [[nodiscard]] NodeRange nodes_inside(double from, double to) const;
  [[nodiscard]] double mass_between(double from, double to) const;

  std::vector<MassPiece> pieces_;       // of the whole axis, ascending; empty: no patches
  std::vector<NodeRange> patch_nodes_;  // of each mass patch
  std::unique_ptr<const MassPoints> points_;
};

}  // namespace udar
