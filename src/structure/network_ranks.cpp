#include "structure/network_ranks.hpp"

#include <metis.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <ranges>
#include <string>

#include "structure/disjoint_sets.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

/// What solving for a junction costs, in nodes.
constexpr idx_t kJunctionNodes = 10;

/// Junctions as METIS wants them: neighbours of each, and how many members lead there.
struct Graph {
  std::vector<idx_t> first;
  std::vector<idx_t> neighbour;
  std::vector<idx_t> members;
  std::vector<idx_t> weight;  // half the nodes of its members, and those it counts for
};

Graph graph_of(const NetworkParameters& network) {
  const std::size_t count = network.junctions.size();
  std::vector<std::vector<idx_t>> neighbours(count);
  std::vector<idx_t> nodes(count, 0);
  for (const Member& member : network.members) {
    for (std::size_t end = 0; end < 2; ++end) {
      const std::size_t own = member.ends[end].junction;
      neighbours[own].push_back(static_cast<idx_t>(member.ends[1 - end].junction));
      nodes[own] += static_cast<idx_t>(member.elements - 1);
    }
  }
  Graph graph{.first = {0}, .neighbour = {}, .members = {}, .weight = {}};
  for (std::size_t junction = 0; junction < count; ++junction) {
    std::ranges::sort(neighbours[junction]);
    for (const idx_t other : neighbours[junction]) {
      if (static_cast<idx_t>(graph.neighbour.size()) == graph.first.back() || graph.neighbour.back() != other) {
        graph.neighbour.push_back(other);
        graph.members.push_back(0);
      }
      ++graph.members.back();
    }
    graph.first.push_back(static_cast<idx_t>(graph.neighbour.size()));
    graph.weight.push_back(nodes[junction] / 2 + kJunctionNodes);
  }
  return graph;
}

/// A rank that METIS left without junctions gets the last of the rank that has most.
void fill_empty(std::vector<int>& ranks, int count) {
  std::vector<std::size_t> junctions(static_cast<std::size_t>(count), 0);
  for (const int rank : ranks) {
    ++junctions[static_cast<std::size_t>(rank)];
  }
  for (auto empty = std::ranges::find(junctions, 0U); empty != junctions.end();
       empty = std::ranges::find(junctions, 0U)) {
    const auto most = std::ranges::max_element(junctions);
    auto backwards = ranks | std::views::reverse;
    *std::ranges::find(backwards, static_cast<int>(most - junctions.begin())) =
        static_cast<int>(empty - junctions.begin());
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

std::vector<int> deal_junctions(const NetworkParameters& network, int ranks) {
  Graph graph = graph_of(network);
  if (network.partition == NetworkPartition::contiguous) {
    return deal_in_order(graph, ranks);
  }
  auto count = static_cast<idx_t>(network.junctions.size());
  idx_t constraints = 1;
  idx_t parts = ranks;
  idx_t cut = 0;
  std::array<idx_t, METIS_NOPTIONS> options{};
  METIS_SetDefaultOptions(options.data());
  options[METIS_OPTION_SEED] = 1;
  options[METIS_OPTION_NUMBERING] = 0;
  std::vector<idx_t> part(network.junctions.size());
  if (METIS_PartGraphKway(&count, &constraints, graph.first.data(), graph.neighbour.data(), graph.weight.data(),
                          nullptr, graph.members.data(), &parts, nullptr, nullptr, options.data(), &cut,
                          part.data()) != METIS_OK) {
    throw SolveError{"METIS did not deal the junctions of the network to the ranks: not memory enough"};
  }
  std::vector<int> dealt(part.begin(), part.end());
  fill_empty(dealt, ranks);
  return dealt;
}

std::vector<int> deal_members(const NetworkParameters& network, const std::vector<int>& junctions, int ranks) {
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
        give(number, load[static_cast<std::size_t>(high)] < load[static_cast<std::size_t>(low)] ? high : low);
      }
    }
  }
  return members;
}

}  // namespace

NetworkRanks deal_to_ranks(const NetworkParameters& network, int ranks) {
  if (network.junctions.size() < static_cast<std::size_t>(ranks)) {
    throw InputError{"network: " + std::to_string(network.junctions.size()) + " junctions are not allowed on " +
                     std::to_string(ranks) + " ranks, expected one a rank at least"};
  }
  if (ranks == 1) {
    return {.junctions = std::vector<int>(network.junctions.size(), 0),
            .members = std::vector<int>(network.members.size(), 0)};
  }
  NetworkRanks dealt{.junctions = deal_junctions(network, ranks), .members = {}};
  dealt.members = deal_members(network, dealt.junctions, ranks);
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
