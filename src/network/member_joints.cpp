#include "udar/network/member_joints.hpp"

#include <cmath>

namespace udar::network {
namespace {

using Real = long double;
using RealSymmetric = std::array<Real, 3>;  // 00, 01, 11
using RealMatrix = std::array<Real, 4>;     // row by row
using Vector = std::array<double, 2>;

RealMatrix product(const RealMatrix& a, const RealMatrix& b) {
  return {a[0] * b[0] + a[1] * b[2], a[0] * b[1] + a[1] * b[3], a[2] * b[0] + a[3] * b[2], a[2] * b[1] + a[3] * b[3]};
}
/// The symmetric product of two matrices.
RealSymmetric symmetric(const RealMatrix& a, const RealMatrix& b) {
  const RealMatrix all = product(a, b);
  return {all[0], (all[1] + all[2]) / 2, all[3]};
}
RealMatrix full(const RealSymmetric& s) { return {s[0], s[1], s[1], s[2]}; }
RealMatrix transposed(const RealMatrix& m) { return {m[0], m[2], m[1], m[3]}; }

/// (1 + P J)^-1; every term of the determinant is positive.
RealMatrix held(const RealSymmetric& p, const RealSymmetric& j) {
  const RealMatrix pj = product(full(p), full(j));
  const Real determinant = 1 + pj[0] + pj[3] + (p[0] * p[2] - p[1] * p[1]) * (j[0] * j[2] - j[1] * j[1]);
  return {(1 + pj[3]) / determinant, -pj[1] / determinant, -pj[2] / determinant, (1 + pj[0]) / determinant};
}

template <std::size_t Count>
std::array<double, Count> rounded(const std::array<Real, Count>& values) {
  std::array<double, Count> result{};
  for (std::size_t i = 0; i < Count; ++i) {
    result.at(i) = static_cast<double>(values.at(i));
  }
  return result;
}

Vector times(const std::array<double, 4>& m, const Vector& v) {
  return {m[0] * v[0] + m[1] * v[1], m[2] * v[0] + m[3] * v[1]};
}
Vector transposed_times(const std::array<double, 4>& m, const Vector& v) {
  return {m[0] * v[0] + m[2] * v[1], m[1] * v[0] + m[3] * v[1]};
}
Vector symmetric_times(const std::array<double, 3>& m, const Vector& v) {
  return {m[0] * v[0] + m[1] * v[1], m[1] * v[0] + m[2] * v[1]};
}
Vector plus(const Vector& a, const Vector& b) { return {a[0] + b[0], a[1] + b[1]}; }
Vector minus(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1]}; }

/// What a span shows in a plane: at its first end, and at its second one while that is free.
struct Shown {
  Vector first;
  Vector second;
  double first_rise;
  double last_rise;

  Shown(const SpanLane& span, std::size_t plane)
      : first{span.shown->bending[plane][0][span.lane], span.shown->bending[plane][1][span.lane]},
        second{span.shown->bending[plane][2][span.lane], span.shown->bending[plane][3][span.lane]},
        first_rise{span.shown->rise[plane][0][span.lane]},
        last_rise{span.shown->rise[plane][1][span.lane]} {}
};

}  // namespace

const MemberJoints::Rod MemberJoints::kAlong{.shown = &Condensed::axial,
                                             .start = &Bounds::along,
                                             .reaction = &Bounds::pull,
                                             .table = &MemberTables::axial,
                                             .number = 0,
                                             .steps = &MemberJoints::axial_};
const MemberJoints::Rod MemberJoints::kAbout{.shown = &Condensed::turning,
                                             .start = &Bounds::spin,
                                             .reaction = &Bounds::torque,
                                             .table = &MemberTables::turning,
                                             .number = 3,
                                             .steps = &MemberJoints::turning_};

MemberJoints::MemberJoints(const MemberTables& ends, std::span<const MemberTables* const> spans, const MemberCut& cut)
    : ends_{&ends}, cut_{cut}, nodes_(cut.spans) {
  place_nodes();
  factor_plane(0, spans);
  factor_plane(1, spans);
  factor_rod(kAlong, 0, spans);
  if (ends.rotary()) {
    factor_rod(kAbout, static_cast<Real>(ends.turning_stiffness()) / static_cast<Real>(ends.kind().joint[0][0]), spans);
  }
}

void MemberJoints::place_nodes() {
  const MemberKind& kind = ends_->kind();
  double place = 0.0;  // of unequal elements [m]
  for (std::size_t k = 1; k < cut_.spans; ++k) {
    const std::size_t at = k * cut_.length;
    nodes_[k] = {.mass = kind.node_length(at) / kind.element_length, .place = static_cast<double>(at)};
    for (std::size_t i = at - cut_.length; i < at && !kind.equal_elements(); ++i) {
      place += kind.length(i);
      nodes_[k].place = place / kind.element_length;
    }
  }
}

void MemberJoints::factor_plane(std::size_t plane, std::span<const MemberTables* const> spans) {
  const Real h = ends_->element_length();
  const Real joint = ends_->node_stiffness() * h * h / static_cast<Real>(ends_->kind().joint[0][plane == 0 ? 2 : 1]);
  RealSymmetric p{0, 0, std::isinf(joint) ? 0 : joint};
  RealMatrix from_start{1, 0, 0, 1};
  for (std::size_t k = 0; k < cut_.spans; ++k) {
    Step step;
    if (k > 0) {
      const Real give = 1 / static_cast<Real>(nodes_[k].mass);
      const Real innovation = 1 / (p[0] + give);
      const Real release = give * innovation;
      const Real gain = p[1] * innovation;
      step.node_from_start = {static_cast<double>(from_start[0]), static_cast<double>(from_start[1])};
      step.release = static_cast<double>(release);
      step.innovation = static_cast<double>(innovation);
      step.gain = static_cast<double>(gain);
      step.deflect = static_cast<double>(p[0] * release);
      step.turn = static_cast<double>(p[1] * release);
      p = {p[0] * release, p[1] * release, p[2] - gain * p[1]};
      from_start = product({release, 0, -gain, 1}, from_start);
    }
    const BendingTable::Open& open = spans[k]->bending(plane).open;
    const RealSymmetric& j = open.stiffness;
    RealMatrix hold = held(p, j);
    RealSymmetric give = symmetric(hold, full(p));
    if (k == 0 && std::isinf(joint)) {  // the first end turns as it likes
      hold = {1, 0, -j[1] / j[2], 0};
      give = {0, 0, 1 / j[2]};
    }
    step.hold = rounded(hold);
    step.give = rounded(give);
    step.inform = rounded(symmetric(full(j), hold));
    step.transfer = rounded(open.transfer);
    step.from_start = rounded(from_start);
    p = symmetric(product(open.transfer, full(give)), transposed(open.transfer));
    for (std::size_t i = 0; i < 3; ++i) {
      p[i] += open.compliance[i];
    }
    from_start = product(product(open.transfer, hold), from_start);
    steps_[plane].push_back(step);
  }
}

/// @param joint compliance at the first end, infinite: a hinge
void MemberJoints::factor_rod(const Rod& rod, long double joint, std::span<const MemberTables* const> spans) {
  Real p = joint;
  Real from_start = 1;
  for (std::size_t k = 0; k < cut_.spans; ++k) {
    RodStep step;
    if (k > 0) {
      const Real give = 1 / static_cast<Real>(nodes_[k].mass);
      const Real innovation = 1 / (p + give);
      const Real release = give * innovation;
      step.node_from_start = static_cast<double>(from_start);
      step.release = static_cast<double>(release);
      step.innovation = static_cast<double>(innovation);
      step.deflect = static_cast<double>(p * release);
      p *= release;
      from_start *= release;
    }
    const AxialTable::Open& open = (spans[k]->*rod.table)().open;
    const bool loose = std::isinf(p);  // at a hinge of several elements
    const Real hold = 1 / (1 + p * open.stiffness);
    const Real give = loose ? 1 / open.stiffness : hold * p;
    step.hold = static_cast<double>(hold);
    step.give = static_cast<double>(give);
    step.inform = static_cast<double>(hold * open.stiffness);
    step.transfer = static_cast<double>(open.transfer);
    step.from_start = static_cast<double>(from_start);
    p = loose ? open.compliance + open.transfer * give * open.transfer
              : open.compliance + open.transfer * hold * p * open.transfer;
    from_start *= open.transfer * hold;
    (this->*rod.steps).push_back(step);
  }
}

MemberJoints::Pair MemberJoints::Step::behind_node(const Pair& before, double load, double kink) const {
  const double news = load - before[0];
  return {load - release * news, before[1] + kink + gain * news};
}

MemberJoints::Pair MemberJoints::Step::behind_span(const Pair& before, const Pair& first, const Pair& second) const {
  return plus(times(transfer, plus(times(hold, before), symmetric_times(give, first))), second);
}

void MemberJoints::condense(Spans spans, std::span<const CutNode> nodes, Condensed& member, std::size_t lane) const {
  condense_plane(0, spans, nodes, member, lane);
  condense_plane(1, spans, nodes, member, lane);
  condense_rod(kAlong, spans, nodes, member, lane);
  if (ends_->rotary()) {
    condense_rod(kAbout, spans, nodes, member, lane);
  }
}

/// From a first end that stands still: state of the second while it is free, and what pushes the first.
void MemberJoints::condense_plane(std::size_t plane, Spans spans, std::span<const CutNode> nodes, Condensed& member,
                                  std::size_t lane) const {
  Vector state{};
  Vector pushed{};
  double last_rise = 0.0;
  for (std::size_t k = 0; k < spans.size(); ++k) {
    const Step& step = steps_[plane][k];
    const Shown shown{spans[k], plane};
    if (k > 0) {
      const double load = nodes[k - 1].load[1 + plane];
      const double news = load - state[0];
      pushed[0] += step.node_from_start[0] * step.innovation * news;
      pushed[1] += step.node_from_start[1] * step.innovation * news;
      state = step.behind_node(state, load, last_rise - shown.first_rise);
    } else {
      member.rise[plane][0][lane] = shown.first_rise;
    }
    pushed = plus(pushed, transposed_times(step.from_start, minus(transposed_times(step.hold, shown.first),
                                                                  symmetric_times(step.inform, state))));
    state = step.behind_span(state, shown.first, shown.second);
    last_rise = shown.last_rise;
  }
  member.rise[plane][1][lane] = last_rise;
  const auto& k = ends_->bending(plane).stiffness;
  for (std::size_t row = 0; row < 4; ++row) {
    member.bending[plane][row][lane] = (row < 2 ? pushed[row] : 0.0) + k[row][2] * state[0] + k[row][3] * state[1];
  }
}

void MemberJoints::condense_rod(const Rod& rod, Spans spans, std::span<const CutNode> nodes, Condensed& member,
                                std::size_t lane) const {
  double state = 0.0;
  double pushed = 0.0;
  for (std::size_t k = 0; k < spans.size(); ++k) {
    const RodStep& step = (this->*rod.steps)[k];
    const std::array<Lanes, 2>& shown = spans[k].shown->*rod.shown;
    const double first = shown[0][spans[k].lane];
    const double second = shown[1][spans[k].lane];
    if (k > 0) {
      const double load = nodes[k - 1].load[rod.number];
      const double news = load - state;
      pushed += step.node_from_start * step.innovation * news;
      state = load - step.release * news;
    }
    pushed += step.from_start * (step.hold * first - step.inform * state);
    state = step.transfer * (step.hold * state + step.give * first) + second;
  }
  const auto& stiffness = (ends_->*rod.table)().stiffness;
  std::array<Lanes, 2>& shows = member.*rod.shown;
  shows[0][lane] = pushed + stiffness[1] * state;
  shows[1][lane] = stiffness[2] * state;
}

void MemberJoints::resolve(Spans spans, std::span<CutNode> nodes, const Bounds& member, std::size_t lane) const {
  resolve_plane(0, spans, nodes, member, lane);
  resolve_plane(1, spans, nodes, member, lane);
  resolve_rod(kAlong, spans, nodes, member, lane);
  if (ends_->rotary()) {
    resolve_rod(kAbout, spans, nodes, member, lane);
  }
  for (std::size_t k = 0; k < spans.size(); ++k) {
    const double rise = member.twist_rise[lane];
    const double twist = member.twist[lane] + nodes_[k].place * rise;
    spans[k].bounds->twist[spans[k].lane] = twist;
    spans[k].bounds->twist_rise[spans[k].lane] = rise;
    if (k > 0) {
      nodes[k - 1].rotation[0] = twist;
    }
  }
}

/// States on the way to the second end wait where the spans' bounds will be.
void MemberJoints::resolve_plane(std::size_t plane, Spans spans, std::span<CutNode> nodes, const Bounds& member,
                                 std::size_t lane) const {
  Vector state{member.deflection[plane][lane], member.turn[plane][lane]};
  double last_rise = 0.0;
  for (std::size_t k = 0; k < spans.size(); ++k) {
    const Step& step = steps_[plane][k];
    const Shown shown{spans[k], plane};
    if (k > 0) {
      const double load = nodes[k - 1].load[1 + plane];
      const double news = load - state[0];
      nodes[k - 1].stretch[1 + plane] = news;
      state = step.behind_node(state, load, last_rise - shown.first_rise);
    }
    spans[k].bounds->deflection[plane][spans[k].lane] = state[0];
    spans[k].bounds->turn[plane][spans[k].lane] = state[1];
    state = step.behind_span(state, shown.first, shown.second);
    last_rise = shown.last_rise;
  }
  Vector reaction{member.force[plane][lane], member.moment[plane][lane]};
  for (std::size_t k = spans.size(); k-- > 0;) {
    const Step& step = steps_[plane][k];
    const Shown shown{spans[k], plane};
    Bounds& bounds = *spans[k].bounds;
    const std::size_t own = spans[k].lane;
    const Vector before{bounds.deflection[plane][own], bounds.turn[plane][own]};
    const Vector pushed = plus(transposed_times(step.transfer, reaction), shown.first);
    const Vector start = plus(times(step.hold, before), symmetric_times(step.give, pushed));
    bounds.deflection[plane][own] = start[0];
    bounds.turn[plane][own] = start[1];
    bounds.force[plane][own] = reaction[0];
    bounds.moment[plane][own] = reaction[1];
    reaction = minus(transposed_times(step.hold, pushed), symmetric_times(step.inform, before));
    if (k > 0) {
      CutNode& node = nodes[k - 1];
      const double news = node.stretch[1 + plane];
      const double stretch = step.deflect * reaction[0] + step.turn * reaction[1] - step.release * news;
      node.stretch[1 + plane] = stretch + node.load[1 + plane];
      node.rotation[2 - plane] = (plane == 0 ? 1.0 : -1.0) * (start[1] + shown.first_rise) / ends_->element_length();
      reaction[0] -= nodes_[k].mass * stretch;
    }
  }
}

void MemberJoints::resolve_rod(const Rod& rod, Spans spans, std::span<CutNode> nodes, const Bounds& member,
                               std::size_t lane) const {
  double state = (member.*rod.start)[lane];
  for (std::size_t k = 0; k < spans.size(); ++k) {
    const RodStep& step = (this->*rod.steps)[k];
    if (k > 0) {
      const double load = nodes[k - 1].load[rod.number];
      const double news = load - state;
      nodes[k - 1].stretch[rod.number] = news;
      state = load - step.release * news;
    }
    (spans[k].bounds->*rod.start)[spans[k].lane] = state;
    const std::array<Lanes, 2>& shown = spans[k].shown->*rod.shown;
    state = step.transfer * (step.hold * state + step.give * shown[0][spans[k].lane]) + shown[1][spans[k].lane];
  }
  double reaction = (member.*rod.reaction)[lane];
  for (std::size_t k = spans.size(); k-- > 0;) {
    const RodStep& step = (this->*rod.steps)[k];
    Bounds& bounds = *spans[k].bounds;
    const std::size_t own = spans[k].lane;
    double& start = (bounds.*rod.start)[own];
    const double before = start;
    const double pushed = step.transfer * reaction + (spans[k].shown->*rod.shown)[0][own];
    start = step.hold * before + step.give * pushed;
    (bounds.*rod.reaction)[own] = reaction;
    reaction = step.hold * pushed - step.inform * before;
    if (k > 0) {
      CutNode& node = nodes[k - 1];
      const double stretch = step.deflect * reaction - step.release * node.stretch[rod.number];
      node.stretch[rod.number] = stretch + node.load[rod.number];
      reaction -= nodes_[k].mass * stretch;
    }
  }
}

}  // namespace udar::network
