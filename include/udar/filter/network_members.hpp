#pragma once
/// @file
/// The members of a rank between its junctions: whole ones and cut ones, by packs.

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "udar/network/member_joints.hpp"
#include "udar/network/member_sweep.hpp"
#include "udar/network/member_tables.hpp"
#include "udar/structure/network.hpp"

namespace udar {

/// @brief Condenses this rank's members to their junctions, and solves inside them when these are known. Source:
/// docs/theory.md, "Networks"
class NetworkMembers {
 public:
  /// Factors the kinds of this rank's members. @param network must live as long @param filter_frequency wf [rad/s]
  NetworkMembers(const Network& network, double filter_frequency);

  /// What this rank has.
  struct Report {
    std::size_t members = 0;
    std::size_t spans = 0;  ///< of those that are cut
    std::size_t packs = 0;
    std::size_t kinds = 0;
    std::size_t table_bytes = 0;
  };
  [[nodiscard]] const Report& report() const noexcept { return report_; }
  /// @param kind of a member of this rank
  [[nodiscard]] const network::MemberTables& ends(std::size_t kind) const { return *tables_[kind].ends; }

  /// @brief Where junctions of the network stand in what `network::Sweep` gives by slots, and the first slot of the
  /// nodes where members are cut.
  void place(const std::function<std::size_t(std::size_t junction)>& slot, std::size_t first_cut);

  void prepare(std::size_t columns);
  /// @param shared those packs that end at junctions of other ranks, and what is cut; else the others. Both are needed,
  /// these first.
  void condense(const network::Sweep& sweep, std::size_t column, bool shared);
  void resolve(const network::Sweep& sweep, std::size_t column);

 private:
  /// Of a kind: whole members, or those that are cut and their spans.
  struct Tables {
    std::unique_ptr<network::MemberTables> ends;
    std::vector<std::shared_ptr<const network::MemberTables>> spans;  // equal ones share
    std::unique_ptr<network::MemberJoints> joints;
  };
  /// Members or spans side by side.
  struct Group {
    network::Placement place;
    const network::MemberTables* tables = nullptr;
    bool whole = true;
    bool shared = false;                               // a lane ends at a junction of another rank
    std::unique_ptr<const network::LaneTables> own{};  // of spans of unequal elements
  };
  /// Where a lane is: which group, and where in it.
  struct Lane {
    std::size_t group = 0;
    std::size_t lane = 0;
  };
  struct CutMember {
    std::size_t number = 0;      // in the network
    Lane ends;                   // of `cut_ends_`
    std::vector<Lane> spans;     // of `groups_`
    std::size_t first_node = 0;  // local, where it is cut
  };

  void factor(std::size_t kind, double filter_frequency);
  void factor_spans(std::size_t kind, double filter_frequency);
  void give_tables(const MemberPack& pack, Group& group);
  void place_lane(network::Placement& place, std::size_t lane, std::size_t member) const;
  void list_cut_members();
  void condense_cut(const network::Sweep& sweep, std::size_t column);
  /// What ends at junctions: pushes them, and knows its ends when they are known.
  static void push(const network::MemberTables& tables, const network::Placement& place, const network::Sweep& sweep,
                   network::Condensed& condensed);
  static void bound(const network::MemberTables& tables, const network::Placement& place, const network::Sweep& sweep,
                    const network::Condensed& condensed, network::Bounds& bounds);
  [[nodiscard]] std::vector<network::SpanLane> lanes_of(const CutMember& member, std::size_t column);
  [[nodiscard]] std::vector<network::CutNode> nodes_of(const CutMember& member, const network::Sweep& sweep) const;
  void write_nodes(const CutMember& member, const std::vector<network::CutNode>& nodes,
                   const network::Sweep& sweep) const;

  const Network* network_;
  std::vector<Tables> tables_;  // by kind, of those that this rank has
  std::vector<Group> groups_;   // as the network's packs
  std::vector<Group> cut_ends_;
  std::vector<CutMember> cut_;
  std::vector<network::Condensed> condensed_;  // by column, then group
  std::vector<network::Condensed> of_cut_;     // by column, then group of `cut_ends_`
  std::vector<network::Bounds> bounds_;        // of `groups_`
  std::vector<network::Bounds> cut_bounds_;
  Report report_;
};

}  // namespace udar
