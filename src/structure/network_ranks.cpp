#include "structure/network_ranks.hpp"

#include <metis.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <numeric>
#include <ranges>
#include <string>

#include "structure/disjoint_sets.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

/// What solving for a junction costs, in nodes.
constexpr idx_t kJunctionNodes = 10;

/// Junctions that one rank has for a pair of nodes, as one; and members whose first junction's rank has them for it.
struct Groups {
  std::vector<std::size_t> of;  // by junction, numbered by the least junction of each
  std::size_t count = 0;
  std::vector<std::size_t> members;  // ascending
};

Groups groups_of(const NetworkParameters& network) {
  std::vector<std::size_t> first;  // nodes before the inner ones of each member
  std::size_t nodes = network.junctions.size();
  for (const Member& member : network.members) {
    first.push_back(nodes);
    nodes += member.elements - 1;
  }
  Groups groups{.of = std::vector<std::size_t>(network.junctions.size()), .count = 0, .members = {}};
  const auto junction_of = [&](std::size_t node) {
    if (node < network.junctions.size()) {
      return node;
    }
    const auto member = static_cast<std::size_t>(std::ranges::upper_bound(first, node) - first.begin()) - 1;
    groups.members.push_back(member);
    return network.members[member].ends[0].junction;
  };
  DisjointSets sets{network.junctions.size()};
  for (const auto& [one, other] : network.together) {
    sets.join(junction_of(one), junction_of(other));
  }
  std::ranges::sort(groups.members);
  for (std::size_t junction = 0; junction < groups.of.size(); ++junction) {
    const std::size_t least = sets.find(junction);
    groups.of[junction] = least == junction ? groups.count++ : groups.of[least];
  }
  return groups;
}

/// Groups of junctions as METIS wants them: neighbours of each, and how many members lead there.
struct Graph {
  std::vector<idx_t> first;
  std::vector<idx_t> neighbour;
  std::vector<idx_t> members;
  std::vector<idx_t> weight;  // half the nodes of its members, and those it counts for
};

Graph graph_of(const NetworkParameters& network, const Groups& groups) {
  const std::size_t count = groups.count;
  std::vector<std::vector<idx_t>> neighbours(count);
  std::vector<idx_t> nodes(count, 0);
  std::vector<idx_t> junctions(count, 0);
  for (const std::size_t group : groups.of) {
    ++junctions[group];
  }
  for (const Member& member : network.members) {
    for (std::size_t end = 0; end < 2; ++end) {
      const std::size_t own = groups.of[member.ends[end].junction];
      const std::size_t other = groups.of[member.ends[1 - end].junction];
      if (own != other) {
        neighbours[own].push_back(static_cast<idx_t>(other));
      }
      nodes[own] += static_cast<idx_t>(member.elements - 1);
    }
  }
  Graph graph{.first = {0}, .neighbour = {}, .members = {}, .weight = {}};
  for (std::size_t group = 0; group < count; ++group) {
    std::ranges::sort(neighbours[group]);
    for (const idx_t other : neighbours[group]) {
      if (static_cast<idx_t>(graph.neighbour.size()) == graph.first.back() || graph.neighbour.back() != other) {
        graph.neighbour.push_back(other);
        graph.members.push_back(0);
      }
      ++graph.members.back();
    }
    graph.first.push_back(static_cast<idx_t>(graph.neighbour.size()));
    graph.weight.push_back(nodes[group] / 2 + junctions[group] * kJunctionNodes);
  }
  return graph;
}

/// A rank that METIS left without groups gets the last of the rank that has most.
void fill_empty(std::vector<int>& ranks, int count) {
  std::vector<std::size_t> groups(static_cast<std::size_t>(count), 0);
  for (const int rank : ranks) {
    ++groups[static_cast<std::size_t>(rank)];
  }
  for (auto empty = std::ranges::find(groups, 0U); empty != groups.end(); empty = std::ranges::find(groups, 0U)) {
    const auto most = std::ranges::max_element(groups);
    auto backwards = ranks | std::views::reverse;
    *std::ranges::find(backwards, static_cast<int>(most - groups.begin())) = static_cast<int>(empty - groups.begin());
    --*most;
    ++*empty;
  }
}

/// Equal shares of the weight, one after the other.
std::vector<int> deal_in_order(const Graph& graph, int ranks) {
  const double all = std::accumulate(graph.weight.begin(), graph.weight.end(), 0.0);
  std::vector<int> dealt;
  double before = 0.0;
  for (const idx_t weight : graph.weight) {
    const double middle = before + 0.5 * static_cast<double>(weight);
    dealt.push_back(static_cast<int>(middle / all * ranks));
    before += static_cast<double>(weight);
  }
  fill_empty(dealt, ranks);
  return dealt;
}

std::vector<int> deal_groups(const NetworkParameters& network, const Groups& groups, int ranks) {
  Graph graph = graph_of(network, groups);
  if (network.partition == NetworkPartition::contiguous) {
    return deal_in_order(graph, ranks);
  }
  auto count = static_cast<idx_t>(groups.count);
  idx_t constraints = 1;
  idx_t parts = ranks;
  idx_t cut = 0;
  std::array<idx_t, METIS_NOPTIONS> options{};
  METIS_SetDefaultOptions(options.data());
  options[METIS_OPTION_SEED] = 1;
  options[METIS_OPTION_NUMBERING] = 0;
  std::vector<idx_t> part(groups.count);
  if (METIS_PartGraphKway(&count, &constraints, graph.first.data(), graph.neighbour.data(), graph.weight.data(),
                          nullptr, graph.members.data(), &parts, nullptr, nullptr, options.data(), &cut,
                          part.data()) != METIS_OK) {
    throw SolveError{"METIS did not deal the junctions of the network to the ranks: not memory enough"};
  }
  std::vector<int> dealt(part.begin(), part.end());
  fill_empty(dealt, ranks);
  return dealt;
}

std::vector<int> deal_members(const NetworkParameters& network, const Groups& groups, const std::vector<int>& junctions,
                              int ranks) {
  std::vector<std::size_t> load(static_cast<std::size_t>(ranks), 0);
  std::vector<int> members(network.members.size(), -1);
  const auto rank_of = [&](const Member& member, std::size_t end) { return junctions[member.ends[end].junction]; };
  const auto give = [&](std::size_t member, int rank) {
    members[member] = rank;
    load[static_cast<std::size_t>(rank)] += network.members[member].elements;
  };
  for (const int rank : junctions) {
    load[static_cast<std::size_t>(rank)] += static_cast<std::size_t>(kJunctionNodes);
  }
  for (const bool cut : {false, true}) {
    for (std::size_t number = 0; number < members.size(); ++number) {
      const std::array<int, 2> ends{rank_of(network.members[number], 0), rank_of(network.members[number], 1)};
      if ((ends[0] != ends[1]) == cut) {
        const auto [low, high] = std::minmax(ends[0], ends[1]);
        const bool paired = std::ranges::binary_search(groups.members, number);
        const bool to_high = load[static_cast<std::size_t>(high)] < load[static_cast<std::size_t>(low)];
        give(number, paired ? ends[0] : to_high ? high : low);
      }
    }
  }
  return members;
}

}  // namespace

NetworkRanks deal_to_ranks(const NetworkParameters& network, int ranks) {
  const Groups groups = groups_of(network);
  if (groups.count < static_cast<std::size_t>(ranks)) {
    const bool paired = groups.count < network.junctions.size();
    throw InputError{"network: " + std::to_string(groups.count) + " junctions" +
                     (paired ? ", those that pairs of nodes hold together counted as one," : "") +
                     " are not allowed on " + std::to_string(ranks) + " ranks, expected one a rank at least"};
  }
  if (ranks == 1) {
    return {.junctions = std::vector<int>(network.junctions.size(), 0),
            .members = std::vector<int>(network.members.size(), 0)};
  }
  const std::vector<int> of_groups = deal_groups(network, groups, ranks);
  NetworkRanks dealt;
  std::ranges::transform(groups.of, std::back_inserter(dealt.junctions),
                         [&](std::size_t group) { return of_groups[group]; });
  dealt.members = deal_members(network, groups, dealt.junctions, ranks);
  return dealt;
}

std::size_t count_parts(const NetworkParameters& network) {
  DisjointSets sets{network.junctions.size()};
  for (const Member& member : network.members) {
    sets.join(member.ends[0].junction, member.ends[1].junction);
  }
  std::size_t parts = 0;
  for (std::size_t junction = 0; junction < network.junctions.size(); ++junction) {
    parts += sets.find(junction) == junction ? 1 : 0;
  }
  return parts;
}

}  // namespace udar
