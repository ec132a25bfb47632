#include "network/packs.hpp"
#include "numerics/clones.hpp"

namespace udar::network {
namespace {

using namespace packs;

// NOLINTBEGIN(cppcoreguidelines-pro-type-member-init): packs are written before they are read
/// Along the nodes of a pack with their angles about its axis: what `Walk` is of displacements.
template <bool Full, bool Loaded, bool Equal, class Number>
struct TurningWalk {
  static constexpr bool kFull = Full;
  static constexpr bool kLoaded = Loaded;
  static constexpr bool kEqual = Equal;

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
    load<Full>(target[0], given.angle, frame.first + i * frame.lanes, frame);
    if constexpr (Loaded) {
      load<Full>(target[1], given.torque, frame.first + i * frame.lanes, frame);
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
UDAR_INLINE void turn_about(const Walk& walk, std::size_t at, const Pack& angle) {
  const Placement& frame = walk.frame;
  std::size_t k = 0;
  for (double* rotation : {walk.given.rotation.x, walk.given.rotation.y, walk.given.rotation.z}) {
    Pack value;
    load<Walk::kFull>(value, rotation, at, frame);
    value += pack(frame.axes[0][k++]) * angle;
    store<Walk::kFull>(rotation + at, value, frame.lanes);
  }
}

template <class Walk>
UDAR_INLINE void resolve_turning_pack(const Walk& walk, const Bounds& bounds) {
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
    store<kFull>(walk.given.twist + frame.first + i * frame.lanes, state, frame.lanes);
    left = right;
  }
  for (std::size_t i = walk.inner; i-- > 0;) {
    const std::size_t at = frame.first + i * frame.lanes;
    load<kFull>(state, walk.given.twist, at, frame);
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
    store<kFull>(walk.given.twist + at, state, frame.lanes);
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
UDAR_INLINE void turned_ends(const Placement& frame, const double* from, std::size_t pitch,
                             std::array<std::array<Pack, 3>, 2>& own) {
  std::array<std::array<Pack, 3>, 2> global;
  gather<3>(frame, from + 3, pitch, global);
  for (std::size_t end = 0; end < 2; ++end) {
    for (std::size_t k = 0; k < 3; ++k) {
      along(frame.axes[k], global[end], own[end][k]);
    }
  }
}

template <bool Full, bool Loaded, bool Equal, class Number, class Run>
UDAR_INLINE void turn_inside(const TurningTask& task, const TurningView<Number>& read, const Run& run) {
  std::array<std::array<Pack, 3>, 2> ends;
  turned_ends(task.frame, task.sweep.place, task.sweep.pitch, ends);
  run(TurningWalk<Full, Loaded, Equal, Number>{.tables = read,
                                               .frame = task.frame,
                                               .given = task.sweep,
                                               .ends = {ends[0][0], ends[1][0]},
                                               .inner = task.tables.inner(),
                                               .compliance = 1.0 / task.tables.turning_stiffness()});
}

template <bool Full, bool Loaded, class Run>
UDAR_INLINE void turn_loaded(const TurningTask& task, const Run& run) {
  if (task.frame.own != nullptr) {
    turn_inside<Full, Loaded, false>(task, task.frame.own->turning(), run);
  } else if (task.tables.spacing().elements.empty()) {
    turn_inside<Full, Loaded, true>(task, turning_of(task.tables), run);
  } else {
    turn_inside<Full, Loaded, false>(task, turning_of(task.tables), run);
  }
}

template <bool Full, class Run>
UDAR_INLINE void turn_any(const TurningTask& task, const Run& run) {
  task.sweep.torque != nullptr ? turn_loaded<Full, true>(task, run) : turn_loaded<Full, false>(task, run);
}

template <bool Full>
UDAR_INLINE void condense_turning_any(const TurningTask& task, Condensed& condensed) {
  turn_any<Full>(task,
                 [&](const auto& walk) __attribute__((always_inline)) { condense_turning_pack(walk, condensed); });
}
template <bool Full>
UDAR_INLINE void resolve_turning_any(const TurningTask& task, const Bounds& bounds) {
  turn_any<Full>(task, [&](const auto& walk) __attribute__((always_inline)) { resolve_turning_pack(walk, bounds); });
}

UDAR_CLONES void condense_turning_full(const TurningTask& task, Condensed& condensed) {
  condense_turning_any<true>(task, condensed);
}
UDAR_CLONES void condense_turning_part(const TurningTask& task, Condensed& condensed) {
  condense_turning_any<false>(task, condensed);
}
UDAR_CLONES void resolve_turning_full(const TurningTask& task, const Bounds& bounds) {
  resolve_turning_any<true>(task, bounds);
}
UDAR_CLONES void resolve_turning_part(const TurningTask& task, const Bounds& bounds) {
  resolve_turning_any<false>(task, bounds);
}

UDAR_CLONES void turn_rises(const TurningTask& task, Condensed& condensed) {
  const double h = task.tables.element_length();
  std::array<std::array<Pack, 3>, 2> ends;
  turned_ends(task.frame, task.sweep.place, task.sweep.pitch, ends);
  for (std::size_t end = 0; end < 2; ++end) {
    pack(condensed.rise[0][end]) -= h * ends[end][2];
    pack(condensed.rise[1][end]) += h * ends[end][1];
  }
}

UDAR_CLONES void push_turning_of(const TurningTask& task, const Condensed& condensed) {
  for (std::size_t end = 0; end < 2; ++end) {
    const Pack moment = task.tables.turning_stiffness() * pack(condensed.turning[end]);
    for (std::size_t k = 0; k < 3; ++k) {
      const Pack about = pack(task.frame.axes[0][k]) * moment;
      for (std::size_t lane = 0; lane < task.frame.lanes; ++lane) {
        task.sweep.value[task.frame.slot[end][lane] * task.sweep.pitch + 3 + k] += about[lane];
      }
    }
  }
}

UDAR_CLONES void bound_turning(const TurningTask& task, const Condensed& condensed, Bounds& bounds) {
  const AxialTable& turning = task.tables.turning();
  std::array<std::array<Pack, 3>, 2> ends;
  turned_ends(task.frame, task.sweep.value, task.sweep.pitch, ends);
  pack(bounds.spin) = ends[0][0];
  pack(bounds.torque) =
      turning.stiffness[1] * ends[0][0] + turning.stiffness[2] * ends[1][0] - pack(condensed.turning[1]);
  pack(bounds.twist) = pack(bounds.twist_rise) = Pack{};
}
// NOLINTEND(cppcoreguidelines-pro-type-member-init)

}  // namespace

void condense_turning(const MemberTables& tables, const Placement& pack, const Sweep& sweep, Condensed& condensed) {
  const TurningTask task{tables, pack, sweep};
  pack.lanes == kLanes ? condense_turning_full(task, condensed) : condense_turning_part(task, condensed);
}

void resolve_turning(const MemberTables& tables, const Placement& pack, const Sweep& sweep, const Bounds& bounds) {
  const TurningTask task{tables, pack, sweep};
  pack.lanes == kLanes ? resolve_turning_full(task, bounds) : resolve_turning_part(task, bounds);
}

void turn_ends(const MemberTables& tables, const Placement& pack, const Sweep& sweep, Condensed& condensed) {
  turn_rises({tables, pack, sweep}, condensed);
}

void push_turning(const MemberTables& tables, const Placement& pack, const Sweep& sweep, const Condensed& condensed) {
  push_turning_of({tables, pack, sweep}, condensed);
}

void find_turning_bounds(const MemberTables& tables, const Placement& pack, const Sweep& sweep,
                         const Condensed& condensed, Bounds& bounds) {
  bound_turning({tables, pack, sweep}, condensed, bounds);
}

}  // namespace udar::network
