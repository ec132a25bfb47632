#pragma once
/// @file
/// What equal members share: gains and weights of the chain recursion in both planes, along and about their axis.

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "udar/structure/network.hpp"

namespace udar::network {

/// @brief Unequal elements: h is their mean length, and K = wf^2 m that of a node between two elements of length h.
template <class Number>
struct Spacing {
  struct Element {
    Number length;   // over h
    Number inverse;  // h over it
  };
  struct Node {
    Number mass;     // over m
    Number inverse;  // m over it
    Number place;    // from the first end, over h
  };
  std::vector<Element> elements;  ///< empty if they are equal
  std::vector<Node> nodes;        ///< between them
};

/// @brief What the recursion takes of its news at an inner node.
template <class Number>
struct Gain {
  Number keep;     // 1 - G0 - s G1, not rounded apart; s the next element over h, G1 that of the news
  Number deflect;  // P00 behind the node; of equal elements this and the next are the gains G0, G1
  Number turn;     // P01
  Number release;  // 1 - G0
  Number bend;     // P11
};

/// @brief A bending plane of a member: states (w, h theta) at its ends in units of displacement, forces over K = wf^2 m
/// of an inner node, moments over K h.
struct BendingTable {
  std::vector<Gain<double>> gains;  ///< of the inner nodes
  /// What a kink there, a change of slope times h, shows at the ends: force, moment, force, moment; of a span force and
  /// moment at the first end, displacement and rotation of the second, which is free.
  std::vector<std::array<double, 4>> weights;
  std::array<std::array<double, 4>, 4> stiffness{};
  bool hinged_first = false;  ///< rotations of the first end have no meaning
  /// Of a span: compliance of its second end with the first held, stiffness of its first end with the second free (00,
  /// 01, 11), transfer from end to end by rows.
  struct Open {
    std::array<long double, 3> compliance{};
    std::array<long double, 3> stiffness{};
    std::array<long double, 4> transfer{};
  };
  Open open;
};

/// @brief The same along the axis.
struct AxialTable {
  std::vector<double> releases;                ///< 1 - G of the inner nodes
  std::vector<double> keeps;                   ///< P behind them
  std::vector<std::array<double, 2>> weights;  ///< what the strain of an element, times h, shows at the ends likewise
  std::array<double, 3> stiffness{};           ///< 00, 01, 11
  /// Of a span, as of bending.
  struct Open {
    long double compliance = 0;
    long double stiffness = 0;
    long double transfer = 1;
  };
  Open open;
};

/// @brief A kind of member, factored in long double. Source: docs/theory.md, "Networks"
class MemberTables {
 public:
  /// A member between junctions, what of it is seen at the ends alone, or a span of a member: those have rigid joints.
  enum class Part : std::uint8_t { whole, ends, span };
  struct Options {
    Part part = Part::whole;
    bool rotary = false;  ///< whether nodes have inertia against torsion
  };

  /// @param kind of a span of unequal elements with the `element_length` of the whole @param filter_frequency wf
  /// [rad/s]
  MemberTables(const MemberSection& section, const MemberKind& kind, double filter_frequency, const Options& options);

  [[nodiscard]] const MemberKind& kind() const noexcept { return kind_; }
  [[nodiscard]] std::size_t inner() const noexcept { return kind_.elements - 1; }
  [[nodiscard]] std::size_t bytes() const noexcept;                                      ///< of gains and weights
  [[nodiscard]] double element_length() const noexcept { return kind_.element_length; }  ///< h, mean of unequal ones
  [[nodiscard]] const Spacing<double>& spacing() const noexcept { return spacing_; }
  [[nodiscard]] double node_stiffness() const noexcept { return stiffness_; }  ///< K [N/m]
  /// In the plane xy, state (u_y, theta_z), or xz, state (u_z, -theta_y).
  [[nodiscard]] const BendingTable& bending(std::size_t plane) const { return bending_[plane]; }
  [[nodiscard]] const AxialTable& axial() const noexcept { return axial_; }
  [[nodiscard]] double torsion() const noexcept { return torsion_; }  ///< between the ends [N m/rad]
  /// About the axis with rotary inertia: states are angles, moments over K_t = wf^2 J of an inner node; else empty.
  [[nodiscard]] const AxialTable& turning() const noexcept { return turning_; }
  [[nodiscard]] double turning_stiffness() const noexcept { return turning_stiffness_; }  ///< K_t [N m/rad], 0: none
  [[nodiscard]] bool rotary() const noexcept { return turning_stiffness_ > 0.0; }
  /// Rotation about the axis that inner nodes have of the first end's and of the second's, and of their difference with
  /// each element from the first.
  struct Twist {
    double first = 0.0;
    double second = 0.0;
    double element = 0.0;
  };
  [[nodiscard]] const Twist& twist() const noexcept { return twist_; }
  /// What the member does to its ends [N, N m; m, rad]: displacements along and rotations about its axes x, y, z of the
  /// first end, then of the second.
  [[nodiscard]] std::array<std::array<long double, 12>, 12> end_stiffness() const;

 private:
  MemberKind kind_;
  double stiffness_;
  Spacing<double> spacing_;
  std::array<BendingTable, 2> bending_;
  AxialTable axial_;
  AxialTable turning_;
  double turning_stiffness_ = 0.0;
  double torsion_ = 0.0;
  Twist twist_;
};

}  // namespace udar::network
