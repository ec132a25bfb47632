#pragma once
/// @file
/// Numbers of a pack's members side by side in registers: of all eight, or of as many at a time as these hold.

#include <algorithm>
#include <array>
#include <cstddef>

#include "numerics/wide.hpp"
#include "udar/network/member_sweep.hpp"

namespace udar::network::packs {

/// W lanes of a pack, from `first` on.
template <std::size_t W>
struct Side {
  using Pack = wide::Pack<W>;
  std::size_t first = 0;

  UDAR_INLINE Pack& operator()(Lanes& lanes) const { return *reinterpret_cast<Pack*>(lanes.value.data() + first); }
  UDAR_INLINE const Pack& operator()(const Lanes& lanes) const {
    return *reinterpret_cast<const Pack*>(lanes.value.data() + first);
  }
  UDAR_INLINE double operator()(double shared) const { return shared; }  // by all lanes

  /// Where the values of inner node i begin, of the rank's local nodes.
  [[nodiscard]] UDAR_INLINE std::size_t node(const Placement& frame, std::size_t i) const {
    return frame.first + i * frame.lanes + first;
  }
  [[nodiscard]] UDAR_INLINE std::size_t members(const Placement& frame) const {
    return std::min(W, frame.lanes - first);
  }

  /// Values of one node's lanes. Lanes that no member has get what stands behind them, if that can be read, else repeat
  /// the last: nothing comes of them.
  template <bool Full>
  UDAR_INLINE void load(Pack& value, const double* nodes, std::size_t at, const Placement& frame) const {
    if (Full || at + W <= frame.nodes) {
      wide::load<W>(value, nodes + at);
      return;
    }
    value = Pack{};
    for (std::size_t lane = 0; lane < W; ++lane) {
      value[lane] = nodes[at + std::min(lane, members(frame) - 1)];
    }
  }
  template <bool Full>
  UDAR_INLINE void store(double* to, const Pack& value, const Placement& frame) const {
    if constexpr (Full) {
      wide::store<W>(to, value);
    } else {
      for (std::size_t lane = 0; lane < members(frame); ++lane) {
        to[lane] = value[lane];
      }
    }
  }

  UDAR_INLINE void along(const std::array<Lanes, 3>& axis, const std::array<Pack, 3>& vector, Pack& value) const {
    value = (*this)(axis[0]) * vector[0] + (*this)(axis[1]) * vector[1] + (*this)(axis[2]) * vector[2];
  }

  // NOLINTBEGIN(cppcoreguidelines-pro-type-member-init): packs are written before they are read
  /// From member axes.
  UDAR_INLINE void turned_back(const Placement& frame, const std::array<Pack, 3>& own,
                               std::array<Pack, 3>& global) const {
    for (std::size_t k = 0; k < 3; ++k) {
      global[k] =
          (*this)(frame.axes[0][k]) * own[0] + (*this)(frame.axes[1][k]) * own[1] + (*this)(frame.axes[2][k]) * own[2];
    }
  }

  /// Values of the junctions, one direction of both ends after the other. @param from eight numbers of a junction
  template <std::size_t Count>
  UDAR_INLINE void gather(const Placement& frame, const double* from, std::size_t pitch,
                          std::array<std::array<Pack, Count>, 2>& values) const {
    for (std::size_t end = 0; end < 2; ++end) {
      const std::size_t* slot = frame.slot[end].data() + first;
      wide::unrolled<(Count + W - 1) / W>([&](auto part) __attribute__((always_inline)) {
        constexpr std::size_t kFrom = part * W;
        std::array<Pack, W> rows;
        wide::unrolled<W>([&](auto lane) __attribute__((always_inline)) {
          wide::load<W>(rows[lane], from + slot[lane] * pitch + kFrom);
        });
        wide::transpose<W>(rows.data());
        wide::unrolled<std::min(W, Count - kFrom)>(
            [&](auto i) __attribute__((always_inline)) { values[end][kFrom + i] = rows[i]; });
      });
    }
  }
  /// Adds values of six directions to those of the junctions at one end.
  UDAR_INLINE void scatter(const Placement& frame, std::size_t end, const std::array<Pack, 6>& values, double* to,
                           std::size_t pitch) const {
    const std::size_t* slot = frame.slot[end].data() + first;
    wide::unrolled<(6 + W - 1) / W>([&](auto part) __attribute__((always_inline)) {
      constexpr std::size_t kFrom = part * W;
      std::array<Pack, W> rows{};
      wide::unrolled<std::min<std::size_t>(W, 6 - kFrom)>(
          [&](auto i) __attribute__((always_inline)) { rows[i] = values[kFrom + i]; });
      wide::transpose<W>(rows.data());
      wide::unrolled<W>([&](auto lane) __attribute__((always_inline)) {
        if (lane < members(frame)) {
          double* own = to + slot[lane] * pitch + kFrom;
          Pack sum;
          wide::load<W>(sum, own);
          sum += rows[lane];
          wide::store<W>(own, sum);
        }
      });
    });
  }
  // NOLINTEND(cppcoreguidelines-pro-type-member-init)
};

/// @brief Calls `each` with every side of a pack that has members. @param each a generic lambda, as of `wide::run`, of
/// a `Side<W>`
template <class Each>
void for_sides(const Placement& frame, const Each& each) {
  wide::run([&]<std::size_t W>() __attribute__((always_inline)) {
    for (std::size_t first = 0; first < frame.lanes; first += W) {
      each(Side<W>{first});
    }
  });
}

}  // namespace udar::network::packs
