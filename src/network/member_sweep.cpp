#include "udar/network/member_sweep.hpp"

#include <algorithm>

#include "network/packs.hpp"
#include "numerics/clones.hpp"

namespace udar::network {
namespace {

using namespace packs;

// NOLINTBEGIN(cppcoreguidelines-pro-type-member-init): packs are written before they are read
/// Adds rotation x arm.
UDAR_INLINE void cross_arm(const std::array<Pack, 3>& turned, const std::array<Lanes, 3>& arm,
                           std::array<Pack, 3>& moved) {
  moved[0] += turned[1] * pack(arm[2]) - turned[2] * pack(arm[1]);
  moved[1] += turned[2] * pack(arm[0]) - turned[0] * pack(arm[2]);
  moved[2] += turned[0] * pack(arm[1]) - turned[1] * pack(arm[0]);
}

/// Displacements of the masses at both ends [m], global axes.
using EndPlaces = std::array<std::array<Pack, 3>, 2>;
/// Of both ends: three displacements or forces, then three rotations or moments, member axes.
using EndValues = std::array<std::array<Pack, 6>, 2>;

/// Where the masses of a node would put a line without stiffness: displacement, and force over K, apart.
struct Target {
  Pack x, y, z;     // displacement [m]
  Pack fx, fy, fz;  // force over K [m]
};

/// Walks along the nodes of a pack from the first end to the second. All that differs where elements are unequal, and
/// is not in the tables, is behind `kEqual`.
template <bool Full, bool Loaded, bool Equal, class Number>
struct Walk {
  static constexpr bool kFull = Full;
  static constexpr bool kLoaded = Loaded;
  static constexpr bool kEqual = Equal;

  TableView<Number> tables;
  const Placement& frame;
  const Sweep& given;
  const EndPlaces& ends;
  std::size_t inner;
  double length;      // h
  double compliance;  // 1 / K

  UDAR_INLINE void end(std::size_t which, Target& target) const {
    target.x = ends[which][0];
    target.y = ends[which][1];
    target.z = ends[which][2];
    target.fx = target.fy = target.fz = Pack{};
  }
  UDAR_INLINE void node(std::size_t i, Target& target) const {
    const std::size_t at = frame.first + i * frame.lanes;
    load<Full>(target.x, given.displacement.x, at, frame);
    load<Full>(target.y, given.displacement.y, at, frame);
    load<Full>(target.z, given.displacement.z, at, frame);
    if constexpr (Loaded) {
      load<Full>(target.fx, given.force.x, at, frame);
      load<Full>(target.fy, given.force.y, at, frame);
      load<Full>(target.fz, given.force.z, at, frame);
      target.fx *= compliance;
      target.fy *= compliance;
      target.fz *= compliance;
    }
    if constexpr (Loaded && !Equal) {
      const auto& inverse = pack(tables.nodes[i].inverse);
      target.fx = inverse * target.fx;
      target.fy = inverse * target.fy;
      target.fz = inverse * target.fz;
    }
  }
  /// Target of inner node i, behind the last of the second end.
  UDAR_INLINE void at(std::size_t i, Target& target) const { i < inner ? node(i, target) : end(1, target); }

  /// How much the targets rise from one end of element i to the other, over its length times h. Differences first, for
  /// a rigid motion must leave nothing.
  UDAR_INLINE void rise(std::size_t i, const Target& right, const Target& left, std::array<Pack, 3>& value) const {
    value[0] = right.x - left.x;
    value[1] = right.y - left.y;
    value[2] = right.z - left.z;
    if constexpr (Loaded) {
      value[0] += right.fx - left.fx;
      value[1] += right.fy - left.fy;
      value[2] += right.fz - left.fz;
    }
    if constexpr (!Equal) {
      const auto& inverse = pack(tables.elements[i].inverse);
      value[0] = inverse * value[0];
      value[1] = inverse * value[1];
      value[2] = inverse * value[2];
    }
  }
};

template <class Walk>
UDAR_INLINE void condense_pack(const Walk& walk, Condensed& condensed) {
  const Placement& frame = walk.frame;
  const std::size_t inner = walk.inner;
  const auto* const weights_y = walk.tables.weights[0];
  const auto* const weights_z = walk.tables.weights[1];
  const auto* const weights_x = walk.tables.axial_weights;
  std::array<Pack, 4> shown_y{};
  std::array<Pack, 4> shown_z{};
  std::array<Pack, 2> shown_x{};
  Target target;
  Target next;
  std::array<Pack, 3> rise;
  std::array<Pack, 3> ahead;
  walk.end(0, target);
  walk.at(0, next);
  walk.rise(0, next, target, rise);
  along(frame.axes[1], rise, pack(condensed.rise[0][0]));
  along(frame.axes[2], rise, pack(condensed.rise[1][0]));
  Pack value;
  for (std::size_t i = 0; i < inner; ++i) {
    target = next;
    walk.at(i + 1, next);
    walk.rise(i + 1, next, target, ahead);
    along(frame.axes[0], rise, value);
    shown_x[0] += pack(weights_x[i][0]) * value;
    shown_x[1] += pack(weights_x[i][1]) * value;
    const std::array<Pack, 3> kink{rise[0] - ahead[0], rise[1] - ahead[1], rise[2] - ahead[2]};
    along(frame.axes[1], kink, value);
    for (std::size_t k = 0; k < 4; ++k) {
      shown_y[k] += pack(weights_y[i][k]) * value;
    }
    along(frame.axes[2], kink, value);
    for (std::size_t k = 0; k < 4; ++k) {
      shown_z[k] += pack(weights_z[i][k]) * value;
    }
    rise = ahead;
  }
  along(frame.axes[0], rise, value);
  shown_x[0] += pack(weights_x[inner][0]) * value;
  shown_x[1] += pack(weights_x[inner][1]) * value;
  along(frame.axes[1], rise, pack(condensed.rise[0][1]));
  along(frame.axes[2], rise, pack(condensed.rise[1][1]));
  for (std::size_t k = 0; k < 4; ++k) {
    pack(condensed.bending[0][k]) = shown_y[k];
    pack(condensed.bending[1][k]) = shown_z[k];
  }
  pack(condensed.axial[0]) = shown_x[0];
  pack(condensed.axial[1]) = shown_x[1];
}

/// Of both bending planes: the state on the way to the second end, the reactions on the way back; and along the axis.
struct Recursion {
  std::array<Pack, 2> deflection;
  std::array<Pack, 2> turn;
  std::array<Pack, 2> force;
  std::array<Pack, 2> moment;
  Pack along;
  Pack pull;
};

/// From what is known of the junctions.
UDAR_INLINE void bounds_of(const MemberTables& tables, const Condensed& condensed, const EndValues& known,
                           Bounds& bounds) {
  const double h = tables.element_length();
  for (std::size_t plane = 0; plane < 2; ++plane) {
    const BendingTable& table = tables.bending(plane);
    const std::size_t about = plane == 0 ? 5 : 4;
    const double sign = plane == 0 ? h : -h;
    const std::array<Pack, 4> ends{known[0][1 + plane], sign * known[0][about] - pack(condensed.rise[plane][0]),
                                   known[1][1 + plane], sign * known[1][about] - pack(condensed.rise[plane][1])};
    Pack force = -pack(condensed.bending[plane][2]);
    Pack moment = -pack(condensed.bending[plane][3]);
    for (std::size_t k = 0; k < 4; ++k) {
      force += table.stiffness[2][k] * ends[k];
      moment += table.stiffness[3][k] * ends[k];
    }
    pack(bounds.force[plane]) = force;
    pack(bounds.moment[plane]) = moment;
    pack(bounds.deflection[plane]) = ends[0];
    pack(bounds.turn[plane]) = table.hinged_first ? Pack{} : ends[1];
  }
  const AxialTable& axial = tables.axial();
  pack(bounds.along) = known[0][0];
  pack(bounds.pull) = axial.stiffness[1] * known[0][0] + axial.stiffness[2] * known[1][0] - pack(condensed.axial[1]);
  const MemberTables::Twist& twist = tables.twist();
  pack(bounds.twist) = twist.first * known[0][3] + twist.second * known[1][3];
  pack(bounds.twist_rise) = twist.element * (known[1][3] - known[0][3]);
}

/// Adds what a rotation moves, or a force turns, over element i.
template <class Walk>
UDAR_INLINE void carry(const Walk& walk, std::size_t i, const Pack& from, Pack& to) {
  if constexpr (Walk::kEqual) {
    to += from;
  } else {
    to += pack(walk.tables.elements[i].length) * from;
  }
}

/// Behind the first element, and before the last.
template <class Walk>
UDAR_INLINE void start(const Walk& walk, const Bounds& bounds, Recursion& state) {
  for (std::size_t plane = 0; plane < 2; ++plane) {
    state.force[plane] = pack(bounds.force[plane]);
    state.moment[plane] = pack(bounds.moment[plane]);
    carry(walk, walk.inner, state.force[plane], state.moment[plane]);
    state.turn[plane] = pack(bounds.turn[plane]);
    state.deflection[plane] = pack(bounds.deflection[plane]);
    carry(walk, 0, state.turn[plane], state.deflection[plane]);
  }
  state.along = pack(bounds.along);
  state.pull = pack(bounds.pull);
}

/// Through inner node i and the element behind it. @param kink there
template <class Walk>
UDAR_INLINE void pass_node(const Walk& walk, std::size_t plane, std::size_t i, const Pack& kink, Recursion& state) {
  const auto& gain = walk.tables.gains[plane][i];
  Pack& deflection = state.deflection[plane];
  Pack& turn = state.turn[plane];
  const Pack turned = turn + kink;
  if constexpr (Walk::kEqual) {
    turn = turned - pack(gain.turn) * deflection;
    deflection = pack(gain.keep) * deflection + turned;
  } else {
    turn = turned - pack(walk.tables.nodes[i].mass) * (pack(gain.turn) * deflection);
    deflection = pack(gain.keep) * deflection + pack(walk.tables.elements[i + 1].length) * turned;
  }
}

/// From a strain of element i, times h, to what it is longer.
template <class Walk>
UDAR_INLINE void stretch_axis(const Walk& walk, std::size_t i, Pack& value) {
  if constexpr (!Walk::kEqual) {
    value = pack(walk.tables.elements[i].length) * value;
  }
}

/// To the second end: states before each node go where its stretch will be.
template <bool Turned, class Walk>
UDAR_INLINE void sweep_right(const Walk& walk, Recursion& state) {
  constexpr bool kFull = Walk::kFull;
  const Placement& frame = walk.frame;
  const Sweep& given = walk.given;
  const auto* const releases = walk.tables.releases;
  Target target;
  Target next;
  std::array<Pack, 3> rise;
  std::array<Pack, 3> ahead;
  Pack value;
  walk.end(0, target);
  walk.at(0, next);
  walk.rise(0, next, target, rise);
  along(frame.axes[0], rise, value);
  stretch_axis(walk, 0, value);
  state.along -= value;
  for (std::size_t i = 0; i < walk.inner; ++i) {
    const std::size_t at = frame.first + i * frame.lanes;
    target = next;
    walk.at(i + 1, next);
    walk.rise(i + 1, next, target, ahead);
    store<kFull>(given.stretch.x + at, state.along, frame.lanes);
    store<kFull>(given.stretch.y + at, state.deflection[0], frame.lanes);
    store<kFull>(given.stretch.z + at, state.deflection[1], frame.lanes);
    along(frame.axes[0], ahead, value);
    stretch_axis(walk, i + 1, value);
    state.along = pack(releases[i]) * state.along - value;
    const std::array<Pack, 3> kink{rise[0] - ahead[0], rise[1] - ahead[1], rise[2] - ahead[2]};
    along(frame.axes[1], kink, value);
    pass_node(walk, 0, i, value, state);
    along(frame.axes[2], kink, value);
    pass_node(walk, 1, i, value, state);
    if constexpr (Turned) {  // against the line between the targets, and of that line
      along(frame.axes[1], ahead, value);
      store<kFull>(given.rotation.y + at, state.turn[0] + value, frame.lanes);
      along(frame.axes[2], ahead, value);
      store<kFull>(given.rotation.z + at, state.turn[1] + value, frame.lanes);
    }
    rise = ahead;
  }
}

/// Rotations of inner node i, from the states stored for it and the reactions behind it.
template <class Walk>
UDAR_INLINE void turn_node(const Walk& walk, const Bounds& bounds, const Recursion& state, std::size_t i) {
  constexpr bool kFull = Walk::kFull;
  const Placement& frame = walk.frame;
  const Sweep& sweep = walk.given;
  const std::size_t at = frame.first + i * frame.lanes;
  const double h = walk.length;
  const auto& y = walk.tables.gains[0][i];
  const auto& z = walk.tables.gains[1][i];
  std::array<Pack, 2> bent{};
  std::array<Pack, 3> global;
  load<kFull>(bent[0], sweep.rotation.y, at, frame);
  load<kFull>(bent[1], sweep.rotation.z, at, frame);
  const Pack about_z = (bent[0] + pack(y.turn) * state.force[0] + pack(y.bend) * state.moment[0]) / h;
  const Pack about_y = (bent[1] + pack(z.turn) * state.force[1] + pack(z.bend) * state.moment[1]) / -h;
  Pack about_x = pack(bounds.twist);
  if constexpr (Walk::kEqual) {
    about_x += static_cast<double>(i + 1) * pack(bounds.twist_rise);
  } else {
    about_x += pack(walk.tables.nodes[i].place) * pack(bounds.twist_rise);
  }
  turned_back(frame, {about_x, about_y, about_z}, global);
  store<kFull>(sweep.rotation.x + at, global[0], frame.lanes);
  store<kFull>(sweep.rotation.y + at, global[1], frame.lanes);
  store<kFull>(sweep.rotation.z + at, global[2], frame.lanes);
}

/// A reaction behind inner node i to one behind the element before it. @param stretch of the node
template <class Walk>
UDAR_INLINE void take(const Walk& walk, std::size_t i, const Pack& stretch, Pack& force) {
  if constexpr (Walk::kEqual) {
    force -= stretch;
  } else {
    force -= pack(walk.tables.nodes[i].mass) * stretch;
  }
}

/// Back to the first end.
template <bool Turned, class Walk>
UDAR_INLINE void sweep_left(const Walk& walk, const Bounds& bounds, Recursion& state) {
  constexpr bool kFull = Walk::kFull;
  const Placement& frame = walk.frame;
  const Triple<double>& stretch = walk.given.stretch;
  const auto* const gains_y = walk.tables.gains[0];
  const auto* const gains_z = walk.tables.gains[1];
  for (std::size_t i = walk.inner; i-- > 0;) {
    const std::size_t at = frame.first + i * frame.lanes;
    Pack dx{};
    std::array<Pack, 2> d{};
    std::array<Pack, 3> global;
    load<kFull>(dx, stretch.x, at, frame);
    load<kFull>(d[0], stretch.y, at, frame);
    load<kFull>(d[1], stretch.z, at, frame);
    if constexpr (Turned) {
      turn_node(walk, bounds, state, i);
    }
    dx = pack(walk.tables.releases[i]) * dx + pack(walk.tables.keeps[i]) * state.pull;
    take(walk, i, dx, state.pull);
    d[0] = pack(gains_y[i].release) * d[0] + pack(gains_y[i].deflect) * state.force[0] +
           pack(gains_y[i].turn) * state.moment[0];
    take(walk, i, d[0], state.force[0]);
    carry(walk, i, state.force[0], state.moment[0]);
    d[1] = pack(gains_z[i].release) * d[1] + pack(gains_z[i].deflect) * state.force[1] +
           pack(gains_z[i].turn) * state.moment[1];
    take(walk, i, d[1], state.force[1]);
    carry(walk, i, state.force[1], state.moment[1]);
    turned_back(frame, {dx, d[0], d[1]}, global);
    if constexpr (Walk::kLoaded) {
      Target target;
      walk.node(i, target);
      global[0] += target.fx;
      global[1] += target.fy;
      global[2] += target.fz;
    }
    store<kFull>(stretch.x + at, global[0], frame.lanes);
    store<kFull>(stretch.y + at, global[1], frame.lanes);
    store<kFull>(stretch.z + at, global[2], frame.lanes);
  }
}

template <class Walk>
UDAR_INLINE void resolve_pack(const Walk& walk, const Bounds& bounds) {
  Recursion state;
  start(walk, bounds, state);
  if (walk.given.rotation.x != nullptr) {
    sweep_right<true>(walk, state);
    sweep_left<true>(walk, bounds, state);
  } else {
    sweep_right<false>(walk, state);
    sweep_left<false>(walk, bounds, state);
  }
}

/// Of the junctions in global axes, to the ends in member axes.
UDAR_INLINE void known_at(const Placement& frame, const Sweep& sweep, EndValues& known) {
  EndValues global;
  gather<6>(frame, sweep.value, sweep.pitch, global);
  for (std::size_t end = 0; end < 2; ++end) {
    std::array<Pack, 6>& own = global[end];
    if (frame.offsets) {
      std::array<Pack, 3> moved{own[0], own[1], own[2]};
      cross_arm({own[3], own[4], own[5]}, frame.offset[end], moved);
      std::ranges::copy(moved, own.begin());
    }
    for (std::size_t i = 0; i < 3; ++i) {
      along(frame.axes[i], {own[0], own[1], own[2]}, known[end][i]);
      along(frame.axes[i], {own[3], own[4], own[5]}, known[end][3 + i]);
    }
  }
}

/// f = K4 s - l, and s has the first and last rise on its right-hand side.
UDAR_INLINE void load_of(const MemberTables& tables, const Condensed& condensed, EndValues& load) {
  const double k = tables.node_stiffness();
  const double h = tables.element_length();
  for (std::size_t plane = 0; plane < 2; ++plane) {
    const BendingTable& table = tables.bending(plane);
    const std::size_t about = plane == 0 ? 5 : 4;
    const double turn = plane == 0 ? k * h : -k * h;
    for (std::size_t row = 0; row < 4; ++row) {
      const Pack value = pack(condensed.bending[plane][row]) +
                         table.stiffness[row][1] * pack(condensed.rise[plane][0]) +
                         table.stiffness[row][3] * pack(condensed.rise[plane][1]);
      load[row / 2][row % 2 == 0 ? 1 + plane : about] = (row % 2 == 0 ? k : turn) * value;
    }
  }
  for (std::size_t end = 0; end < 2; ++end) {
    load[end][0] = k * pack(condensed.axial[end]);
    load[end][3] = Pack{};
  }
}

/// Turned into global axes, carried from the ends to the junctions, and added there.
UDAR_INLINE void add_load(const Placement& frame, const EndValues& load, const Sweep& sweep) {
  for (std::size_t end = 0; end < 2; ++end) {
    std::array<Pack, 6> global;
    for (std::size_t k = 0; k < 3; ++k) {
      global[k] = pack(frame.axes[0][k]) * load[end][0] + pack(frame.axes[1][k]) * load[end][1] +
                  pack(frame.axes[2][k]) * load[end][2];
      global[3 + k] = pack(frame.axes[1][k]) * load[end][4] + pack(frame.axes[2][k]) * load[end][5];
    }
    if (frame.offsets) {  // arm x force
      const auto& arm = frame.offset[end];
      global[3] += pack(arm[1]) * global[2] - pack(arm[2]) * global[1];
      global[4] += pack(arm[2]) * global[0] - pack(arm[0]) * global[2];
      global[5] += pack(arm[0]) * global[1] - pack(arm[1]) * global[0];
    }
    for (std::size_t lane = 0; lane < frame.lanes; ++lane) {
      double* to = sweep.value + frame.slot[end][lane] * sweep.pitch;
      for (std::size_t k = 0; k < 6; ++k) {
        to[k] += global[k][lane];
      }
    }
  }
}

/// What a pack is, where it ends, what is condensed or known of it.
struct Task {
  const MemberTables& tables;
  const Placement& frame;
  const Sweep& sweep;
};

UDAR_INLINE void add_arms(const Task& task, EndPlaces& ends) {
  EndPlaces turned;
  gather<3>(task.frame, task.sweep.place + 3, task.sweep.pitch, turned);
  for (std::size_t end = 0; end < 2; ++end) {
    cross_arm(turned[end], task.frame.offset[end], ends[end]);
  }
}

/// With a walk through the pack. @param run condenses or resolves
template <bool Full, bool Loaded, bool Equal, class Number, class Run>
UDAR_INLINE void walk_inside(const Task& task, const TableView<Number>& read, const Run& run) {
  EndPlaces ends;
  gather<3>(task.frame, task.sweep.place, task.sweep.pitch, ends);
  if (task.frame.offsets && task.sweep.angle != nullptr) {  // arms turn with the masses
    add_arms(task, ends);
  }
  run(Walk<Full, Loaded, Equal, Number>{.tables = read,
                                        .frame = task.frame,
                                        .given = task.sweep,
                                        .ends = ends,
                                        .inner = task.tables.inner(),
                                        .length = task.tables.element_length(),
                                        .compliance = 1.0 / task.tables.node_stiffness()});
}

template <bool Full, bool Loaded, class Run>
UDAR_INLINE void walk_loaded(const Task& task, const Run& run) {
  if (task.frame.own != nullptr) {
    walk_inside<Full, Loaded, false>(task, task.frame.own->view(), run);
  } else if (task.tables.spacing().elements.empty()) {
    walk_inside<Full, Loaded, true>(task, view_of(task.tables), run);
  } else {
    walk_inside<Full, Loaded, false>(task, view_of(task.tables), run);
  }
}

template <bool Full, class Run>
UDAR_INLINE void walk_any(const Task& task, const Run& run) {
  task.sweep.force.x != nullptr ? walk_loaded<Full, true>(task, run) : walk_loaded<Full, false>(task, run);
}

UDAR_INLINE void push_ends(const Task& task, const Condensed& condensed) {
  EndValues load;
  load_of(task.tables, condensed, load);
  add_load(task.frame, load, task.sweep);
}

UDAR_INLINE void bounds_at(const Task& task, const Condensed& condensed, Bounds& bounds) {
  EndValues known;
  known_at(task.frame, task.sweep, known);
  bounds_of(task.tables, condensed, known, bounds);
}

template <bool Full>
UDAR_INLINE void condense_any(const Task& task, Condensed& condensed) {
  walk_any<Full>(task, [&](const auto& walk) __attribute__((always_inline)) { condense_pack(walk, condensed); });
}
template <bool Full>
UDAR_INLINE void resolve_any(const Task& task, const Bounds& bounds) {
  walk_any<Full>(task, [&](const auto& walk) __attribute__((always_inline)) { resolve_pack(walk, bounds); });
}
// NOLINTEND(cppcoreguidelines-pro-type-member-init)

UDAR_CLONES void condense_full(const Task& task, Condensed& condensed) { condense_any<true>(task, condensed); }
UDAR_CLONES void condense_part(const Task& task, Condensed& condensed) { condense_any<false>(task, condensed); }
UDAR_CLONES void resolve_full(const Task& task, const Bounds& bounds) { resolve_any<true>(task, bounds); }
UDAR_CLONES void resolve_part(const Task& task, const Bounds& bounds) { resolve_any<false>(task, bounds); }
UDAR_CLONES void push(const Task& task, const Condensed& condensed) { push_ends(task, condensed); }
UDAR_CLONES void bound(const Task& task, const Condensed& condensed, Bounds& bounds) {
  bounds_at(task, condensed, bounds);
}

}  // namespace

void condense(const MemberTables& tables, const Placement& pack, const Sweep& sweep, Condensed& condensed) {
  const Task task{tables, pack, sweep};
  pack.lanes == kLanes ? condense_full(task, condensed) : condense_part(task, condensed);
}

void resolve(const MemberTables& tables, const Placement& pack, const Sweep& sweep, const Bounds& bounds) {
  const Task task{tables, pack, sweep};
  pack.lanes == kLanes ? resolve_full(task, bounds) : resolve_part(task, bounds);
}

void push_junctions(const MemberTables& tables, const Placement& pack, const Sweep& sweep, const Condensed& condensed) {
  push({tables, pack, sweep}, condensed);
}

void find_bounds(const MemberTables& tables, const Placement& pack, const Sweep& sweep, const Condensed& condensed,
                 Bounds& bounds) {
  bound({tables, pack, sweep}, condensed, bounds);
}

}  // namespace udar::network
