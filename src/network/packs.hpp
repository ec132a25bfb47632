#pragma once
/// @file
/// Numbers of a pack's members side by side in registers.

#include <array>
#include <cstddef>

#include "udar/network/member_sweep.hpp"

#define UDAR_INLINE [[gnu::always_inline]] inline

namespace udar::network::packs {

using Pack = double __attribute__((vector_size(8 * kLanes)));
using Loose [[gnu::vector_size(8 * kLanes), gnu::aligned(8), gnu::may_alias]] = double;

UDAR_INLINE Pack& pack(Lanes& lanes) { return *reinterpret_cast<Pack*>(lanes.value.data()); }
UDAR_INLINE const Pack& pack(const Lanes& lanes) { return *reinterpret_cast<const Pack*>(lanes.value.data()); }

UDAR_INLINE double pack(double shared) { return shared; }  // by all lanes

/// Values of one node's lanes. Lanes that no member has get what stands behind them, if that can be read, else repeat
/// the last: nothing comes of them.
template <bool Full>
UDAR_INLINE void load(Pack& value, const double* nodes, std::size_t at, const Placement& frame) {
  if (Full || at + kLanes <= frame.nodes) {
    value = *reinterpret_cast<const Loose*>(nodes + at);
    return;
  }
  value = Pack{};
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    value[lane] = nodes[at + (lane < frame.lanes ? lane : frame.lanes - 1)];
  }
}
template <bool Full>
UDAR_INLINE void store(double* to, const Pack& value, std::size_t lanes) {
  if constexpr (Full) {
    *reinterpret_cast<Loose*>(to) = value;
  } else {
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      to[lane] = value[lane];
    }
  }
}

// NOLINTBEGIN(cppcoreguidelines-pro-type-member-init): packs are written before they are read
UDAR_INLINE void along(const std::array<Lanes, 3>& axis, const std::array<Pack, 3>& vector, Pack& value) {
  value = pack(axis[0]) * vector[0] + pack(axis[1]) * vector[1] + pack(axis[2]) * vector[2];
}

/// From member axes.
UDAR_INLINE void turned_back(const Placement& frame, const std::array<Pack, 3>& own, std::array<Pack, 3>& global) {
  for (std::size_t k = 0; k < 3; ++k) {
    global[k] = pack(frame.axes[0][k]) * own[0] + pack(frame.axes[1][k]) * own[1] + pack(frame.axes[2][k]) * own[2];
  }
}

/// Values of the junctions, one direction of both ends after the other.
template <std::size_t Count>
UDAR_INLINE void gather(const Placement& pack, const double* from, std::size_t pitch,
                        std::array<std::array<Pack, Count>, 2>& values) {
  for (std::size_t end = 0; end < 2; ++end) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const double* own = from + pack.slot[end][lane] * pitch;
      for (std::size_t k = 0; k < Count; ++k) {
        values[end][k][lane] = own[k];
      }
    }
  }
}
// NOLINTEND(cppcoreguidelines-pro-type-member-init)

}  // namespace udar::network::packs
