#pragma once
/// @file
/// Who gets which junctions and members.

#include <cstddef>
#include <vector>

#include "udar/structure/network.hpp"

namespace udar {

/// @brief Ranks of junctions and members.
struct NetworkRanks {
  std::vector<int> junctions;
  std::vector<int> members;
};

/// @brief Deals junctions to ranks, balanced by the nodes of their members, by METIS so that few members are cut, or in
/// their order; a member that is cut goes to the lighter of its two ranks. The same on every rank.
/// @throws InputError if there are fewer junctions than ranks
[[nodiscard]] NetworkRanks deal_to_ranks(const NetworkParameters& network, int ranks);

/// @brief How many parts a network has that no member connects.
[[nodiscard]] std::size_t count_parts(const NetworkParameters& network);

}  // namespace udar
