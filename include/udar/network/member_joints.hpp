#pragma once
/// @file
/// The chain recursion from span to span of members that are cut.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "udar/network/member_sweep.hpp"
#include "udar/network/member_tables.hpp"
#include "udar/structure/member_packs.hpp"

namespace udar::network {

/// @brief Where a span is in packs, and what it shows and is told there.
struct SpanLane {
  const Condensed* shown = nullptr;
  Bounds* bounds = nullptr;
  std::size_t lane = 0;
};

/// @brief A node where a member is cut, member axes.
struct CutNode {
  /// Along the axes force over K [m], then moment about the first over K_t [rad].
  std::array<double, 4> load{};
  std::array<double, 4> stretch{};   ///< [m], [rad]
  std::array<double, 3> rotation{};  ///< about the axes [rad]
};

/// @brief Members of a kind that are cut: between their spans go the states of the recursion, never stiffnesses that
/// are differenced, so that cuts cost no digits however short spans are. Source: docs/theory.md, "Networks"
class MemberJoints {
 public:
  /// @param ends of the whole member @param spans tables of each, used here alone
  MemberJoints(const MemberTables& ends, std::span<const MemberTables* const> spans, const MemberCut& cut);

  /// Of the node before span k = 1, ..., over m.
  [[nodiscard]] double mass(std::size_t k) const { return nodes_[k].mass; }

  /// @brief What a member shows at its ends, from what its spans show.
  void condense(std::span<const SpanLane> spans, std::span<const CutNode> nodes, Condensed& member,
                std::size_t lane) const;
  /// @brief What bounds the spans, and the nodes between them, from what bounds the member.
  void resolve(std::span<const SpanLane> spans, std::span<CutNode> nodes, const Bounds& member, std::size_t lane) const;

 private:
  using Pair = std::array<double, 2>;
  /// A span in a bending plane, and the node before it; names as in docs/theory.md, "Networks".
  struct Step {
    std::array<double, 4> hold{};        // (1 + P J)^-1
    std::array<double, 3> give{};        // (P^-1 + J)^-1
    std::array<double, 3> inform{};      // (P + J^-1)^-1
    std::array<double, 4> transfer{};    // Phi
    std::array<double, 4> from_start{};  // transfer from the member's first end to its own
    double release = 0.0;                // of the node
    double innovation = 0.0;
    double gain = 0.0;
    double turn = 0.0;
    double deflect = 0.0;
    Pair node_from_start{};  // transfer to its displacement

    /// State behind the node and behind the span; what the span shows at its ends.
    [[nodiscard]] Pair behind_node(const Pair& before, double load, double kink) const;
    [[nodiscard]] Pair behind_span(const Pair& before, const Pair& first, const Pair& second) const;
  };
  struct RodStep {
    double hold = 1.0;
    double give = 0.0;
    double inform = 0.0;
    double transfer = 0.0;
    double from_start = 0.0;
    double release = 0.0;
    double innovation = 0.0;
    double deflect = 0.0;
    double node_from_start = 0.0;
  };
  /// Before a span: mass over m, place over h.
  struct Node {
    double mass = 1.0;
    double place = 0.0;
  };
  using Spans = std::span<const SpanLane>;

  void place_nodes();
  void factor_plane(std::size_t plane, std::span<const MemberTables* const> spans);
  /// Along the axis, or about it with rotary inertia: where its numbers are.
  struct Rod {
    std::array<Lanes, 2> Condensed::* shown;
    Lanes Bounds::* start;
    Lanes Bounds::* reaction;
    const AxialTable& (MemberTables::*table)() const;
    std::size_t number;  // of those of a node
    std::vector<RodStep> MemberJoints::* steps;
  };
  static const Rod kAlong;
  static const Rod kAbout;

  void factor_rod(const Rod& rod, long double joint, std::span<const MemberTables* const> spans);
  void condense_plane(std::size_t plane, Spans spans, std::span<const CutNode> nodes, Condensed& member,
                      std::size_t lane) const;
  void condense_rod(const Rod& rod, Spans spans, std::span<const CutNode> nodes, Condensed& member,
                    std::size_t lane) const;
  void resolve_plane(std::size_t plane, Spans spans, std::span<CutNode> nodes, const Bounds& member,
                     std::size_t lane) const;
  void resolve_rod(const Rod& rod, Spans spans, std::span<CutNode> nodes, const Bounds& member, std::size_t lane) const;

  const MemberTables* ends_;
  MemberCut cut_;
  std::vector<Node> nodes_;  // by span
  std::array<std::vector<Step>, 2> steps_;
  std::vector<RodStep> axial_;
  std::vector<RodStep> turning_;
};

}  // namespace udar::network
