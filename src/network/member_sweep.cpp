#include "udar/network/member_sweep.hpp"

#include <algorithm>

#include "network/packs.hpp"
#include "numerics/wide.hpp"

namespace udar::network {
namespace {

using namespace packs;

// NOLINTBEGIN(cppcoreguidelines-pro-type-member-init): packs are written before they are read
/// Adds rotation x arm.
template <std::size_t W>
UDAR_INLINE void cross_arm(const Side<W>& pack, const std::array<wide::Pack<W>, 3>& turned,
                           const std::array<Lanes, 3>& arm, std::array<wide::Pack<W>, 3>& moved) {
  moved[0] += turned[1] * pack(arm[2]) - turned[2] * pack(arm[1]);
  moved[1] += turned[2] * pack(arm[0]) - turned[0] * pack(arm[2]);
  moved[2] += turned[0] * pack(arm[1]) - turned[1] * pack(arm[0]);
}

/// Displacements of the masses at both ends [m], global axes.
template <std::size_t W>
using EndPlaces = std::array<std::array<wide::Pack<W>, 3>, 2>;
/// Of both ends: three displacements or forces, then three rotations or moments, member axes.
template <std::size_t W>
using EndValues = std::array<std::array<wide::Pack<W>, 6>, 2>;

/// Where the masses of a node would put a line without stiffness: displacement, and force over K, apart.
template <std::size_t W>
struct Target {
  wide::Pack<W> x, y, z;     // displacement [m]
  wide::Pack<W> fx, fy, fz;  // force over K [m]
};

/// Walks along the nodes of a pack from the first end to the second. All that differs where elements are unequal, and
/// is not in the tables, is behind `kEqual`.
template <std::size_t W, bool Full, bool Loaded, bool Equal, class Number>
struct Walk {
  using Pack = wide::Pack<W>;
  using Target = network::Target<W>;
  static constexpr std::size_t kWide = W;
  static constexpr bool kFull = Full;
  static constexpr bool kLoaded = Loaded;
  static constexpr bool kEqual = Equal;

  Side<W> pack;
  TableView<Number> tables;
  const Placement& frame;
  const Sweep& given;
  const EndPlaces<W>& ends;
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
    const std::size_t at = pack.node(frame, i);
    pack.template load<Full>(target.x, given.displacement.x, at, frame);
    pack.template load<Full>(target.y, given.displacement.y, at, frame);
    pack.template load<Full>(target.z, given.displacement.z, at, frame);
    if constexpr (Loaded) {
      pack.template load<Full>(target.fx, given.force.x, at, frame);
      pack.template load<Full>(target.fy, given.force.y, at, frame);
      pack.template load<Full>(target.fz, given.force.z, at, frame);
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
  using Pack = typename Walk::Pack;
  const auto& pack = walk.pack;
  using Target = typename Walk::Target;
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
  pack.along(frame.axes[1], rise, pack(condensed.rise[0][0]));
  pack.along(frame.axes[2], rise, pack(condensed.rise[1][0]));
  Pack value;
  for (std::size_t i = 0; i < inner; ++i) {
    target = next;
    walk.at(i + 1, next);
    walk.rise(i + 1, next, target, ahead);
    pack.along(frame.axes[0], rise, value);
    shown_x[0] += pack(weights_x[i][0]) * value;
    shown_x[1] += pack(weights_x[i][1]) * value;
    const std::array<Pack, 3> kink{rise[0] - ahead[0], rise[1] - ahead[1], rise[2] - ahead[2]};
    pack.along(frame.axes[1], kink, value);
    for (std::size_t k = 0; k < 4; ++k) {
      shown_y[k] += pack(weights_y[i][k]) * value;
    }
    pack.along(frame.axes[2], kink, value);
    for (std::size_t k = 0; k < 4; ++k) {
      shown_z[k] += pack(weights_z[i][k]) * value;
    }
    rise = ahead;
  }
  pack.along(frame.axes[0], rise, value);
  shown_x[0] += pack(weights_x[inner][0]) * value;
  shown_x[1] += pack(weights_x[inner][1]) * value;
  pack.along(frame.axes[1], rise, pack(condensed.rise[0][1]));
  pack.along(frame.axes[2], rise, pack(condensed.rise[1][1]));
  for (std::size_t k = 0; k < 4; ++k) {
    pack(condensed.bending[0][k]) = shown_y[k];
    pack(condensed.bending[1][k]) = shown_z[k];
  }
  pack(condensed.axial[0]) = shown_x[0];
  pack(condensed.axial[1]) = shown_x[1];
}

/// Of both bending planes: the state on the way to the second end, the reactions on the way back; and along the axis.
template <std::size_t W>
struct Recursion {
  using Pack = wide::Pack<W>;
  std::array<Pack, 2> deflection;
  std::array<Pack, 2> turn;
  std::array<Pack, 2> force;
  std::array<Pack, 2> moment;
  Pack along;
  Pack pull;
};

/// From what is known of the junctions.
template <std::size_t W>
UDAR_INLINE void bounds_of(const Side<W>& pack, const MemberTables& tables, const Condensed& condensed,
                           const EndValues<W>& known, Bounds& bounds) {
  using Pack = wide::Pack<W>;
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
UDAR_INLINE void carry(const Walk& walk, std::size_t i, const typename Walk::Pack& from, typename Walk::Pack& to) {
  if constexpr (Walk::kEqual) {
    to += from;
  } else {
    to += walk.pack(walk.tables.elements[i].length) * from;
  }
}

/// Behind the first element, and before the last.
template <class Walk>
UDAR_INLINE void start(const Walk& walk, const Bounds& bounds, Recursion<Walk::kWide>& state) {
  const auto& pack = walk.pack;
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
UDAR_INLINE void pass_node(const Walk& walk, std::size_t plane, std::size_t i, const typename Walk::Pack& kink,
                           Recursion<Walk::kWide>& state) {
  using Pack = typename Walk::Pack;
  const auto& pack = walk.pack;
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
UDAR_INLINE void stretch_axis(const Walk& walk, std::size_t i, typename Walk::Pack& value) {
  if constexpr (!Walk::kEqual) {
    value = walk.pack(walk.tables.elements[i].length) * value;
  }
}

/// To the second end: states before each node go where its stretch will be.
template <bool Turned, class Walk>
UDAR_INLINE void sweep_right(const Walk& walk, Recursion<Walk::kWide>& state) {
  using Pack = typename Walk::Pack;
  const auto& pack = walk.pack;
  using Target = typename Walk::Target;
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
  pack.along(frame.axes[0], rise, value);
  stretch_axis(walk, 0, value);
  state.along -= value;
  for (std::size_t i = 0; i < walk.inner; ++i) {
    const std::size_t at = pack.node(frame, i);
    target = next;
    walk.at(i + 1, next);
    walk.rise(i + 1, next, target, ahead);
    pack.template store<kFull>(given.stretch.x + at, state.along, frame);
    pack.template store<kFull>(given.stretch.y + at, state.deflection[0], frame);
    pack.template store<kFull>(given.stretch.z + at, state.deflection[1], frame);
    pack.along(frame.axes[0], ahead, value);
    stretch_axis(walk, i + 1, value);
    state.along = pack(releases[i]) * state.along - value;
    const std::array<Pack, 3> kink{rise[0] - ahead[0], rise[1] - ahead[1], rise[2] - ahead[2]};
    pack.along(frame.axes[1], kink, value);
    pass_node(walk, 0, i, value, state);
    pack.along(frame.axes[2], kink, value);
    pass_node(walk, 1, i, value, state);
    if constexpr (Turned) {  // against the line between the targets, and of that line
      pack.along(frame.axes[1], ahead, value);
      pack.template store<kFull>(given.rotation.y + at, state.turn[0] + value, frame);
      pack.along(frame.axes[2], ahead, value);
      pack.template store<kFull>(given.rotation.z + at, state.turn[1] + value, frame);
    }
    rise = ahead;
  }
}

/// Rotations of inner node i, from the states stored for it and the reactions behind it.
template <class Walk>
UDAR_INLINE void turn_node(const Walk& walk, const Bounds& bounds, const Recursion<Walk::kWide>& state, std::size_t i) {
  using Pack = typename Walk::Pack;
  const auto& pack = walk.pack;
  constexpr bool kFull = Walk::kFull;
  const Placement& frame = walk.frame;
  const Sweep& sweep = walk.given;
  const std::size_t at = pack.node(frame, i);
  const double h = walk.length;
  const auto& y = walk.tables.gains[0][i];
  const auto& z = walk.tables.gains[1][i];
  std::array<Pack, 2> bent{};
  std::array<Pack, 3> global;
  pack.template load<kFull>(bent[0], sweep.rotation.y, at, frame);
  pack.template load<kFull>(bent[1], sweep.rotation.z, at, frame);
  const Pack about_z = (bent[0] + pack(y.turn) * state.force[0] + pack(y.bend) * state.moment[0]) / h;
  const Pack about_y = (bent[1] + pack(z.turn) * state.force[1] + pack(z.bend) * state.moment[1]) / -h;
  Pack about_x = pack(bounds.twist);
  if constexpr (Walk::kEqual) {
    about_x += static_cast<double>(i + 1) * pack(bounds.twist_rise);
  } else {
    about_x += pack(walk.tables.nodes[i].place) * pack(bounds.twist_rise);
  }
  pack.turned_back(frame, {about_x, about_y, about_z}, global);
  pack.template store<kFull>(sweep.rotation.x + at, global[0], frame);
  pack.template store<kFull>(sweep.rotation.y + at, global[1], frame);
  pack.template store<kFull>(sweep.rotation.z + at, global[2], frame);
}

/// A reaction behind inner node i to one behind the element before it. @param stretch of the node
template <class Walk>
UDAR_INLINE void take(const Walk& walk, std::size_t i, const typename Walk::Pack& stretch, typename Walk::Pack& force) {
  if constexpr (Walk::kEqual) {
    force -= stretch;
  } else {
    force -= walk.pack(walk.tables.nodes[i].mass) * stretch;
  }
}

/// Back to the first end.
template <bool Turned, class Walk>
UDAR_INLINE void sweep_left(const Walk& walk, const Bounds& bounds, Recursion<Walk::kWide>& state) {
  using Pack = typename Walk::Pack;
  const auto& pack = walk.pack;
  constexpr bool kFull = Walk::kFull;
  const Placement& frame = walk.frame;
  const Triple<double>& stretch = walk.given.stretch;
  const auto* const gains_y = walk.tables.gains[0];
  const auto* const gains_z = walk.tables.gains[1];
  for (std::size_t i = walk.inner; i-- > 0;) {
    const std::size_t at = pack.node(frame, i);
    Pack dx{};
    std::array<Pack, 2> d{};
    std::array<Pack, 3> global;
    pack.template load<kFull>(dx, stretch.x, at, frame);
    pack.template load<kFull>(d[0], stretch.y, at, frame);
    pack.template load<kFull>(d[1], stretch.z, at, frame);
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
    pack.turned_back(frame, {dx, d[0], d[1]}, global);
    if constexpr (Walk::kLoaded) {
      typename Walk::Target target;
      walk.node(i, target);
      global[0] += target.fx;
      global[1] += target.fy;
      global[2] += target.fz;
    }
    pack.template store<kFull>(stretch.x + at, global[0], frame);
    pack.template store<kFull>(stretch.y + at, global[1], frame);
    pack.template store<kFull>(stretch.z + at, global[2], frame);
  }
}

template <class Walk>
UDAR_INLINE void resolve_pack(const Walk& walk, const Bounds& bounds) {
  Recursion<Walk::kWide> state;
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
template <std::size_t W>
UDAR_INLINE void known_at(const Side<W>& pack, const Placement& frame, const Sweep& sweep, EndValues<W>& known) {
  EndValues<W> global;
  pack.template gather<6>(frame, sweep.value, sweep.pitch, global);
  for (std::size_t end = 0; end < 2; ++end) {
    std::array<wide::Pack<W>, 6>& own = global[end];
    if (frame.offsets) {
      std::array<wide::Pack<W>, 3> moved{own[0], own[1], own[2]};
      cross_arm<W>(pack, {own[3], own[4], own[5]}, frame.offset[end], moved);
      std::ranges::copy(moved, own.begin());
    }
    for (std::size_t i = 0; i < 3; ++i) {
      pack.along(frame.axes[i], {own[0], own[1], own[2]}, known[end][i]);
      pack.along(frame.axes[i], {own[3], own[4], own[5]}, known[end][3 + i]);
    }
  }
}

/// f = K4 s - l, and s has the first and last rise on its right-hand side.
template <std::size_t W>
UDAR_INLINE void load_of(const Side<W>& pack, const MemberTables& tables, const Condensed& condensed,
                         EndValues<W>& load) {
  const double k = tables.node_stiffness();
  const double h = tables.element_length();
  for (std::size_t plane = 0; plane < 2; ++plane) {
    const BendingTable& table = tables.bending(plane);
    const std::size_t about = plane == 0 ? 5 : 4;
    const double turn = plane == 0 ? k * h : -k * h;
    for (std::size_t row = 0; row < 4; ++row) {
      const wide::Pack<W> value = pack(condensed.bending[plane][row]) +
                                  table.stiffness[row][1] * pack(condensed.rise[plane][0]) +
                                  table.stiffness[row][3] * pack(condensed.rise[plane][1]);
      load[row / 2][row % 2 == 0 ? 1 + plane : about] = (row % 2 == 0 ? k : turn) * value;
    }
  }
  for (std::size_t end = 0; end < 2; ++end) {
    load[end][0] = k * pack(condensed.axial[end]);
    load[end][3] = wide::Pack<W>{};
  }
}

/// Turned into global axes, carried from the ends to the junctions, and added there.
template <std::size_t W>
UDAR_INLINE void add_load(const Side<W>& pack, const Placement& frame, const EndValues<W>& load, const Sweep& sweep) {
  for (std::size_t end = 0; end < 2; ++end) {
    std::array<wide::Pack<W>, 6> global;
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
    pack.scatter(frame, end, global, sweep.value, sweep.pitch);
  }
}

/// What a pack is, where it ends, what is condensed or known of it.
struct Task {
  const MemberTables& tables;
  const Placement& frame;
  const Sweep& sweep;
};

template <std::size_t W>
UDAR_INLINE void find_ends(const Side<W>& pack, const Task& task, EndPlaces<W>& ends) {
  if (!task.frame.offsets || task.sweep.angle == nullptr) {
    pack.template gather<3>(task.frame, task.sweep.place, task.sweep.pitch, ends);
    return;
  }
  EndValues<W> all;
  pack.template gather<6>(task.frame, task.sweep.place, task.sweep.pitch, all);
  for (std::size_t end = 0; end < 2; ++end) {  // arms turn with the masses
    std::copy_n(all[end].begin(), 3, ends[end].begin());
    cross_arm<W>(pack, {all[end][3], all[end][4], all[end][5]}, task.frame.offset[end], ends[end]);
  }
}

/// With a walk through these lanes. @param run condenses or resolves
template <bool Full, bool Loaded, bool Equal, std::size_t W, class Number, class Run>
UDAR_INLINE void walk_inside(const Side<W>& pack, const Task& task, const TableView<Number>& read, const Run& run) {
  EndPlaces<W> ends;
  find_ends(pack, task, ends);
  run(Walk<W, Full, Loaded, Equal, Number>{.pack = pack,
                                           .tables = read,
                                           .frame = task.frame,
                                           .given = task.sweep,
                                           .ends = ends,
                                           .inner = task.tables.inner(),
                                           .length = task.tables.element_length(),
                                           .compliance = 1.0 / task.tables.node_stiffness()});
}

template <bool Full, bool Loaded, std::size_t W, class Run>
UDAR_INLINE void walk_loaded(const Side<W>& pack, const Task& task, const Run& run) {
  if (task.frame.own != nullptr) {
    walk_inside<Full, Loaded, false>(pack, task, task.frame.own->view(), run);
  } else if (task.tables.spacing().elements.empty()) {
    walk_inside<Full, Loaded, true>(pack, task, view_of(task.tables), run);
  } else {
    walk_inside<Full, Loaded, false>(pack, task, view_of(task.tables), run);
  }
}

template <bool Full, std::size_t W, class Run>
UDAR_INLINE void walk_full(const Side<W>& pack, const Task& task, const Run& run) {
  task.sweep.force.x != nullptr ? walk_loaded<Full, true>(pack, task, run) : walk_loaded<Full, false>(pack, task, run);
}

template <std::size_t W, class Run>
UDAR_INLINE void walk_any(const Side<W>& pack, const Task& task, const Run& run) {
  pack.members(task.frame) == W ? walk_full<true>(pack, task, run) : walk_full<false>(pack, task, run);
}
// NOLINTEND(cppcoreguidelines-pro-type-member-init)

}  // namespace

void condense(const MemberTables& tables, const Placement& frame, const Sweep& sweep, Condensed& condensed) {
  for_sides(frame, [&](const auto& pack) __attribute__((always_inline)) {
    walk_any(pack, {tables, frame, sweep},
             [&](const auto& walk) __attribute__((always_inline)) { condense_pack(walk, condensed); });
  });
}

void resolve(const MemberTables& tables, const Placement& frame, const Sweep& sweep, const Bounds& bounds) {
  for_sides(frame, [&](const auto& pack) __attribute__((always_inline)) {
    walk_any(pack, {tables, frame, sweep},
             [&](const auto& walk) __attribute__((always_inline)) { resolve_pack(walk, bounds); });
  });
}

void push_junctions(const MemberTables& tables, const Placement& frame, const Sweep& sweep,
                    const Condensed& condensed) {
  for_sides(frame, [&]<std::size_t W>(const Side<W>& pack) __attribute__((always_inline)) {
    EndValues<W> load;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    load_of(pack, tables, condensed, load);
    add_load(pack, frame, load, sweep);
  });
}

void find_bounds(const MemberTables& tables, const Placement& frame, const Sweep& sweep, const Condensed& condensed,
                 Bounds& bounds) {
  for_sides(frame, [&]<std::size_t W>(const Side<W>& pack) __attribute__((always_inline)) {
    EndValues<W> known;  // NOLINT(cppcoreguidelines-pro-type-member-init)
    known_at(pack, frame, sweep, known);
    bounds_of(pack, tables, condensed, known, bounds);
  });
}

}  // namespace udar::network
