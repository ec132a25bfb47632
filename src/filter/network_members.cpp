#include "udar/filter/network_members.hpp"

#include <algorithm>
#include <span>

namespace udar {

NetworkMembers::NetworkMembers(const Network& network, double filter_frequency)
    : network_{&network}, tables_(network.kinds().size()) {
  for (std::size_t member = 0; member < network.member_ranks().size(); ++member) {
    if (network.member_ranks()[member] == network.rank()) {
      ++report_.members;
      if (tables_[network.kind(member)].ends == nullptr) {
        factor(network.kind(member), filter_frequency);
      }
    }
  }
  report_.packs = network.packs().packs().size();
}

void NetworkMembers::factor(std::size_t kind, double filter_frequency) {
  const MemberKind& whole = network_->kinds()[kind];
  const MemberSection& section = network_->parameters().sections[whole.section];
  const MemberCut& cut = network_->packs().cut(kind);
  Tables& tables = tables_[kind];
  ++report_.kinds;
  const bool is_cut = cut.spans > 1;
  using Part = network::MemberTables::Part;
  tables.ends = std::make_unique<network::MemberTables>(
      section, whole, filter_frequency,
      network::MemberTables::Options{.part = is_cut ? Part::ends : Part::whole, .rotary = network_->rotary()});
  report_.table_bytes += tables.ends->bytes();
  if (is_cut) {
    factor_spans(kind, filter_frequency);
  }
}

void NetworkMembers::factor_spans(std::size_t kind, double filter_frequency) {
  const MemberKind& whole = network_->kinds()[kind];
  const MemberCut& cut = network_->packs().cut(kind);
  Tables& tables = tables_[kind];
  constexpr std::array kRigid{MemberEnd::kRigid, MemberEnd::kRigid, MemberEnd::kRigid};
  std::vector<const network::MemberTables*> spans;
  for (std::size_t k = 0; k < cut.spans; ++k) {
    const std::size_t first = k * cut.length;
    MemberKind span{.section = whole.section,
                    .elements = std::min(cut.length, whole.elements - first),
                    .element_length = whole.element_length,
                    .joint = {kRigid, kRigid}};
    if (!whole.equal_elements()) {
      const auto begin = whole.lengths.begin() + static_cast<std::ptrdiff_t>(first);
      span.lengths.assign(begin, begin + static_cast<std::ptrdiff_t>(span.elements));
    } else if (k > 0 && span.elements == cut.length) {
      tables.spans.push_back(tables.spans.front());
    }
    if (tables.spans.size() == k) {
      tables.spans.push_back(std::make_shared<network::MemberTables>(
          network_->parameters().sections[whole.section], span, filter_frequency,
          network::MemberTables::Options{.part = network::MemberTables::Part::span, .rotary = network_->rotary()}));
      report_.table_bytes += tables.spans.back()->bytes();
    }
    spans.push_back(tables.spans.back().get());
  }
  tables.joints = std::make_unique<network::MemberJoints>(*tables.ends, spans, cut);
}

void NetworkMembers::give_tables(const MemberPack& pack, Group& group) {
  const Tables& tables = tables_[pack.kind];
  if (group.whole) {
    group.tables = tables.ends.get();
    return;
  }
  std::array<const network::MemberTables*, network::kLanes> spans{};
  for (std::size_t lane = 0; lane < network::kLanes; ++lane) {
    spans.at(lane) = tables.spans[pack.span.at(lane)].get();
  }
  group.tables = spans.front();
  if (!network_->kinds()[pack.kind].equal_elements()) {
    group.own = std::make_unique<const network::LaneTables>(spans);
    group.place.own = group.own.get();
    report_.table_bytes += group.own->bytes();
  }
}

/// Axes and arms.
void NetworkMembers::place_lane(network::Placement& place, std::size_t lane, std::size_t member) const {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      place.axes[i][k][lane] = network_->axes(member)[i][k];
    }
  }
  for (std::size_t end = 0; end < 2; ++end) {
    const Place& arm = network_->parameters().members[member].ends[end].offset;
    const std::array<double, 3> offset{arm.x, arm.y, arm.z};
    for (std::size_t i = 0; i < 3; ++i) {
      place.offset[end][i][lane] = offset[i];
      place.offsets = place.offsets || offset[i] != 0.0;
    }
  }
}

/// Members that are cut by eight of a kind, and where their spans are.
void NetworkMembers::list_cut_members() {
  const std::vector<MemberPack>& packs = network_->packs().packs();
  const std::size_t none = network_->member_ranks().size();
  std::vector<std::size_t> where(none, none);  // in `cut_`
  for (std::size_t p = 0; p < packs.size(); ++p) {
    for (std::size_t lane = 0; lane < packs[p].lanes && !groups_[p].whole; ++lane) {
      const std::size_t number = packs[p].member.at(lane);
      if (where[number] == none) {
        where[number] = cut_.size();
        const MemberCut& cut = network_->packs().cut(packs[p].kind);
        cut_.push_back({.number = number,
                        .ends = {},
                        .spans = std::vector<Lane>(cut.spans),
                        .first_node = network_->node(number, cut.length).local});
        report_.spans += cut.spans;
      }
      cut_[where[number]].spans[packs[p].span.at(lane)] = {.group = p, .lane = lane};
    }
  }
}

void NetworkMembers::place(const std::function<std::size_t(std::size_t junction)>& slot, std::size_t first_cut) {
  const std::size_t before_cuts = network_->own_junctions().size();
  const std::vector<Member>& members = network_->parameters().members;
  for (const MemberPack& given : network_->packs().packs()) {
    const MemberCut& cut = network_->packs().cut(given.kind);
    Group& group = groups_.emplace_back();
    group.whole = cut.spans == 1;
    give_tables(given, group);
    group.place.first = given.first;
    group.place.lanes = given.lanes;
    group.place.nodes = network_->nodes();
    for (std::size_t lane = 0; lane < network::kLanes; ++lane) {
      const std::size_t number = given.member.at(lane);
      place_lane(group.place, lane, number);
      group.shared = group.shared || network_->ends_elsewhere(number);
      for (std::size_t end = 0; end < 2; ++end) {
        const std::size_t at = given.span.at(lane) + end;  // spans before it
        group.place.slot[end][lane] = at == 0 ? slot(members[number].ends[0].junction)
                                      : at == cut.spans
                                          ? slot(members[number].ends[1].junction)
                                          : first_cut + network_->node(number, at * cut.length).local - before_cuts;
        for (std::size_t i = 0; i < 3 && at > 0 && at < cut.spans; ++i) {
          group.place.offset[end][i][lane] = 0.0;  // no arm there
        }
      }
    }
  }
  list_cut_members();
  for (CutMember& member : cut_) {
    const network::MemberTables* tables = tables_[network_->kind(member.number)].ends.get();
    if (cut_ends_.empty() || cut_ends_.back().tables != tables || cut_ends_.back().place.lanes == network::kLanes) {
      cut_ends_.push_back({.place = {}, .tables = tables});
    }
    network::Placement& place = cut_ends_.back().place;
    member.ends = {.group = cut_ends_.size() - 1, .lane = place.lanes++};
    for (std::size_t lane = member.ends.lane; lane < network::kLanes; ++lane) {
      place_lane(place, lane, member.number);
      for (std::size_t end = 0; end < 2; ++end) {
        place.slot[end][lane] = slot(members[member.number].ends[end].junction);
      }
    }
  }
  bounds_.resize(groups_.size());
  cut_bounds_.resize(cut_ends_.size());
}

void NetworkMembers::prepare(std::size_t columns) {
  condensed_.resize(groups_.size() * columns);
  of_cut_.resize(cut_ends_.size() * columns);
}

std::vector<network::SpanLane> NetworkMembers::lanes_of(const CutMember& member, std::size_t column) {
  std::vector<network::SpanLane> lanes;
  lanes.reserve(member.spans.size());
  for (const auto& [group, lane] : member.spans) {
    lanes.push_back({.shown = &condensed_[column * groups_.size() + group], .bounds = &bounds_[group], .lane = lane});
  }
  return lanes;
}

/// With the forces on them.
std::vector<network::CutNode> NetworkMembers::nodes_of(const CutMember& member, const network::Sweep& sweep) const {
  std::vector<network::CutNode> nodes(member.spans.size() - 1);
  const double compliance = 1.0 / tables_[network_->kind(member.number)].ends->node_stiffness();
  const Axes& axes = network_->axes(member.number);
  const network::MemberJoints& joints = *tables_[network_->kind(member.number)].joints;
  for (std::size_t i = 0; i < nodes.size() && sweep.force.x != nullptr; ++i) {
    const std::size_t at = member.first_node + i;
    const double own = compliance / joints.mass(i + 1);
    for (std::size_t k = 0; k < 3; ++k) {
      nodes[i].load[k] =
          own * (axes[k][0] * sweep.force.x[at] + axes[k][1] * sweep.force.y[at] + axes[k][2] * sweep.force.z[at]);
    }
    if (sweep.torque != nullptr) {
      const double turning = tables_[network_->kind(member.number)].ends->turning_stiffness();
      nodes[i].load[3] = sweep.torque[at] / (turning * joints.mass(i + 1));
    }
  }
  return nodes;
}

void NetworkMembers::write_nodes(const CutMember& member, const std::vector<network::CutNode>& nodes,
                                 const network::Sweep& sweep) const {
  const Axes& axes = network_->axes(member.number);
  const auto write = [&axes](const network::Triple<double>& to, std::size_t at, std::span<const double> own) {
    std::size_t k = 0;
    for (double* values : {to.x, to.y, to.z}) {
      values[at] = axes[0][k] * own[0] + axes[1][k] * own[1] + axes[2][k] * own[2];
      ++k;
    }
  };
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::size_t at = member.first_node + i;
    write(sweep.stretch, at, nodes[i].stretch);
    std::array<double, 3> rotation = nodes[i].rotation;
    if (sweep.angle != nullptr) {
      sweep.twist[at] = nodes[i].stretch[3];
      rotation[0] = sweep.angle[at] + sweep.twist[at];
    }
    if (sweep.rotation.x != nullptr) {
      write(sweep.rotation, at, rotation);
    }
  }
}

void NetworkMembers::push(const network::MemberTables& tables, const network::Placement& place,
                          const network::Sweep& sweep, network::Condensed& condensed) {
  if (sweep.angle != nullptr) {
    network::turn_ends(tables, place, sweep, condensed);
    network::push_turning(tables, place, sweep, condensed);
  }
  network::push_junctions(tables, place, sweep, condensed);
}

void NetworkMembers::bound(const network::MemberTables& tables, const network::Placement& place,
                           const network::Sweep& sweep, const network::Condensed& condensed, network::Bounds& bounds) {
  network::find_bounds(tables, place, sweep, condensed, bounds);
  if (sweep.angle != nullptr) {
    network::find_turning_bounds(tables, place, sweep, condensed, bounds);
  }
}

void NetworkMembers::condense(const network::Sweep& sweep, std::size_t column, bool shared) {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Group& group = groups_[g];
    if (group.shared != shared) {
      continue;
    }
    network::Condensed& condensed = condensed_[column * groups_.size() + g];
    network::condense(*group.tables, group.place, sweep, condensed);
    if (sweep.angle != nullptr) {
      network::condense_turning(*group.tables, group.place, sweep, condensed);
    }
    if (group.whole) {
      push(*group.tables, group.place, sweep, condensed);
    }
  }
  if (shared) {
    condense_cut(sweep, column);
  }
}

/// When all spans are.
void NetworkMembers::condense_cut(const network::Sweep& sweep, std::size_t column) {
  const std::size_t first = column * cut_ends_.size();
  for (const CutMember& member : cut_) {
    tables_[network_->kind(member.number)].joints->condense(lanes_of(member, column), nodes_of(member, sweep),
                                                            of_cut_[first + member.ends.group], member.ends.lane);
  }
  for (std::size_t g = 0; g < cut_ends_.size(); ++g) {
    push(*cut_ends_[g].tables, cut_ends_[g].place, sweep, of_cut_[first + g]);
  }
}

void NetworkMembers::resolve(const network::Sweep& sweep, std::size_t column) {
  for (std::size_t g = 0; g < cut_ends_.size(); ++g) {
    bound(*cut_ends_[g].tables, cut_ends_[g].place, sweep, of_cut_[column * cut_ends_.size() + g], cut_bounds_[g]);
  }
  for (const CutMember& member : cut_) {
    std::vector<network::CutNode> nodes = nodes_of(member, sweep);
    tables_[network_->kind(member.number)].joints->resolve(lanes_of(member, column), nodes,
                                                           cut_bounds_[member.ends.group], member.ends.lane);
    write_nodes(member, nodes, sweep);
  }
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Group& group = groups_[g];
    if (group.whole) {
      bound(*group.tables, group.place, sweep, condensed_[column * groups_.size() + g], bounds_[g]);
    }
    network::resolve(*group.tables, group.place, sweep, bounds_[g]);
    if (sweep.angle != nullptr) {
      network::resolve_turning(*group.tables, group.place, sweep, bounds_[g]);
    }
  }
}

}  // namespace udar
