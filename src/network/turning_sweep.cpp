#include "network/packs.hpp"
#include "numerics/wide.hpp"

namespace udar::network {
namespace {

using namespace packs;

// NOLINTBEGIN(cppcoreguidelines-pro-type-member-init): packs are written before they are read
/// Along the nodes of a pack with their angles about its axis: what `Walk` is of displacements.
template <std::size_t W, bool Full, bool Loaded, bool Equal, class Number>
struct TurningWalk {
  using Pack = wide::Pack<W>;
  static constexpr bool kFull = Full;
  static constexpr bool kLoaded = Loaded;
  static constexpr bool kEqual = Equal;

  Side<W> pack;
  TurningView<Number> tables;
  const Placement& frame;
  const Sweep& given;
  std::array<Pack, 2> ends;
  std::size_t inner;
  double compliance;  // 1 / K_t

  /// Angle of the mass of inner node i, behind the last of the second end, and moment over its K_t.
  UDAR_INLINE void at(std::size_t i, std::array<Pack, 2>& target) const {
    target[1] = Pack{};
    if (i == inner) {
      target[0] = ends[1];
      return;
    }
    pack.template load<Full>(target[0], given.angle, pack.node(frame, i), frame);
    if constexpr (Loaded) {
      pack.template load<Full>(target[1], given.torque, pack.node(frame, i), frame);
      target[1] *= compliance;
      if constexpr (!Equal) {
        target[1] = pack(tables.nodes[i].inverse) * target[1];
      }
    }
  }
  /// Over the length of element i, times h.
  UDAR_INLINE void rise(std::size_t i, const std::array<Pack, 2>& right, const std::array<Pack, 2>& left,
                        Pack& value) const {
    value = right[0] - left[0];
    if constexpr (Loaded) {
      value += right[1] - left[1];
    }
    if constexpr (!Equal) {
      value = pack(tables.elements[i].inverse) * value;
    }
  }
  /// And back.
  UDAR_INLINE void stretched(std::size_t i, Pack& value) const {
    if constexpr (!Equal) {
      value = pack(tables.elements[i].length) * value;
    }
  }
};

template <class Walk>
UDAR_INLINE void condense_turning_pack(const Walk& walk, Condensed& condensed) {
  using Pack = typename Walk::Pack;
  const auto& pack = walk.pack;
  std::array<Pack, 2> shown{};
  std::array<Pack, 2> left{walk.ends[0], Pack{}};
  std::array<Pack, 2> right;
  Pack rise;
  for (std::size_t i = 0; i <= walk.inner; ++i) {
    walk.at(i, right);
    walk.rise(i, right, left, rise);
    shown[0] += pack(walk.tables.weights[i][0]) * rise;
    shown[1] += pack(walk.tables.weights[i][1]) * rise;
    left = right;
  }
  pack(condensed.turning[0]) = shown[0];
  pack(condensed.turning[1]) = shown[1];
}

/// Adds the rotation about the axis to those across it.
template <class Walk>
UDAR_INLINE void turn_about(const Walk& walk, std::size_t at, const typename Walk::Pack& angle) {
  using Pack = typename Walk::Pack;
  const auto& pack = walk.pack;
  const Placement& frame = walk.frame;
  std::size_t k = 0;
  for (double* rotation : {walk.given.rotation.x, walk.given.rotation.y, walk.given.rotation.z}) {
    Pack value;
    pack.template load<Walk::kFull>(value, rotation, at, frame);
    value += pack(frame.axes[0][k++]) * angle;
    pack.template store<Walk::kFull>(rotation + at, value, frame);
  }
}

template <class Walk>
UDAR_INLINE void resolve_turning_pack(const Walk& walk, const Bounds& bounds) {
  using Pack = typename Walk::Pack;
  const auto& pack = walk.pack;
  constexpr bool kFull = Walk::kFull;
  const Placement& frame = walk.frame;
  Pack state = pack(bounds.spin);
  Pack torque = pack(bounds.torque);
  std::array<Pack, 2> left{walk.ends[0], Pack{}};
  std::array<Pack, 2> right;
  Pack rise;
  for (std::size_t i = 0; i < walk.inner; ++i) {
    walk.at(i, right);
    walk.rise(i, right, left, rise);
    walk.stretched(i, rise);
    state = i == 0 ? state - rise : pack(walk.tables.releases[i - 1]) * state - rise;
    pack.template store<kFull>(walk.given.twist + pack.node(frame, i), state, frame);
    left = right;
  }
  for (std::size_t i = walk.inner; i-- > 0;) {
    const std::size_t at = pack.node(frame, i);
    pack.template load<kFull>(state, walk.given.twist, at, frame);
    state = pack(walk.tables.releases[i]) * state + pack(walk.tables.keeps[i]) * torque;
    if constexpr (Walk::kEqual) {
      torque -= state;
    } else {
      torque -= pack(walk.tables.nodes[i].mass) * state;
    }
    walk.at(i, right);
    if constexpr (Walk::kLoaded) {
      state += right[1];
    }
    pack.template store<kFull>(walk.given.twist + at, state, frame);
    if (walk.given.rotation.x != nullptr) {
      turn_about(walk, at, right[0] + state);
    }
  }
}

struct TurningTask {
  const MemberTables& tables;
  const Placement& frame;
  const Sweep& sweep;
};

/// Components along the axes of the rotations at both ends in what junctions have: of the masses, or beside them.
template <std::size_t W>
UDAR_INLINE void turned_ends(const Side<W>& pack, const Placement& frame, const double* from, std::size_t pitch,
                             std::array<std::array<wide::Pack<W>, 3>, 2>& own) {
  std::array<std::array<wide::Pack<W>, 6>, 2> global;
  pack.template gather<6>(frame, from, pitch, global);
  for (std::size_t end = 0; end < 2; ++end) {
    for (std::size_t k = 0; k < 3; ++k) {
      pack.along(frame.axes[k], {global[end][3], global[end][4], global[end][5]}, own[end][k]);
    }
  }
}

template <bool Full, bool Loaded, bool Equal, std::size_t W, class Number, class Run>
UDAR_INLINE void turn_inside(const Side<W>& pack, const TurningTask& task, const TurningView<Number>& read,
                             const Run& run) {
  std::array<std::array<wide::Pack<W>, 3>, 2> ends;
  turned_ends(pack, task.frame, task.sweep.place, task.sweep.pitch, ends);
  run(TurningWalk<W, Full, Loaded, Equal, Number>{.pack = pack,
                                                  .tables = read,
                                                  .frame = task.frame,
                                                  .given = task.sweep,
                                                  .ends = {ends[0][0], ends[1][0]},
                                                  .inner = task.tables.inner(),
                                                  .compliance = 1.0 / task.tables.turning_stiffness()});
}

template <bool Full, bool Loaded, std::size_t W, class Run>
UDAR_INLINE void turn_loaded(const Side<W>& pack, const TurningTask& task, const Run& run) {
  if (task.frame.own != nullptr) {
    turn_inside<Full, Loaded, false>(pack, task, task.frame.own->turning(), run);
  } else if (task.tables.spacing().elements.empty()) {
    turn_inside<Full, Loaded, true>(pack, task, turning_of(task.tables), run);
  } else {
    turn_inside<Full, Loaded, false>(pack, task, turning_of(task.tables), run);
  }
}

template <bool Full, std::size_t W, class Run>
UDAR_INLINE void turn_full(const Side<W>& pack, const TurningTask& task, const Run& run) {
  task.sweep.torque != nullptr ? turn_loaded<Full, true>(pack, task, run) : turn_loaded<Full, false>(pack, task, run);
}

template <std::size_t W, class Run>
UDAR_INLINE void turn_any(const Side<W>& pack, const TurningTask& task, const Run& run) {
  pack.members(task.frame) == W ? turn_full<true>(pack, task, run) : turn_full<false>(pack, task, run);
}
// NOLINTEND(cppcoreguidelines-pro-type-member-init)

}  // namespace

void condense_turning(const MemberTables& tables, const Placement& frame, const Sweep& sweep, Condensed& condensed) {
  for_sides(frame, [&](const auto& pack) __attribute__((always_inline)) {
    turn_any(pack, {tables, frame, sweep},
             [&](const auto& walk) __attribute__((always_inline)) { condense_turning_pack(walk, condensed); });
  });
}

void resolve_turning(const MemberTables& tables, const Placement& frame, const Sweep& sweep, const Bounds& bounds) {
  for_sides(frame, [&](const auto& pack) __attribute__((always_inline)) {
    turn_any(pack, {tables, frame, sweep},
             [&](const auto& walk) __attribute__((always_inline)) { resolve_turning_pack(walk, bounds); });
  });
}

void turn_ends(const MemberTables& tables, const Placement& frame, const Sweep& sweep, Condensed& condensed) {
  const double h = tables.element_length();
  for_sides(frame, [&]<std::size_t W>(const Side<W>& pack) __attribute__((always_inline)) {
    std::array<std::array<wide::Pack<W>, 3>, 2> ends;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    turned_ends(pack, frame, sweep.place, sweep.pitch, ends);
    for (std::size_t end = 0; end < 2; ++end) {
      pack(condensed.rise[0][end]) -= h * ends[end][2];
      pack(condensed.rise[1][end]) += h * ends[end][1];
    }
  });
}

void push_turning(const MemberTables& tables, const Placement& frame, const Sweep& sweep, const Condensed& condensed) {
  for_sides(frame, [&]<std::size_t W>(const Side<W>& pack) __attribute__((always_inline)) {
    for (std::size_t end = 0; end < 2; ++end) {
      const wide::Pack<W> moment = tables.turning_stiffness() * pack(condensed.turning[end]);
      std::array<wide::Pack<W>, 6> about{};
      for (std::size_t k = 0; k < 3; ++k) {
        about[3 + k] = pack(frame.axes[0][k]) * moment;
      }
      pack.scatter(frame, end, about, sweep.value, sweep.pitch);
    }
  });
}

void find_turning_bounds(const MemberTables& tables, const Placement& frame, const Sweep& sweep,
                         const Condensed& condensed, Bounds& bounds) {
  const AxialTable& turning = tables.turning();
  for_sides(frame, [&]<std::size_t W>(const Side<W>& pack) __attribute__((always_inline)) {
    std::array<std::array<wide::Pack<W>, 3>, 2> ends;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    turned_ends(pack, frame, sweep.value, sweep.pitch, ends);
    pack(bounds.spin) = ends[0][0];
    pack(bounds.torque) =
        turning.stiffness[1] * ends[0][0] + turning.stiffness[2] * ends[1][0] - pack(condensed.turning[1]);
    pack(bounds.twist) = pack(bounds.twist_rise) = wide::Pack<W>{};
  });
}

}  // namespace udar::network
