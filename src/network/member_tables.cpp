#include "udar/network/member_tables.hpp"

#include <cmath>

namespace udar::network {
namespace {

using Real = long double;
using Symmetric = std::array<Real, 3>;  // 00, 01, 11
using Matrix2 = std::array<Real, 4>;    // row by row

/// A p A' with A = [1 s; 0 1]: through an element of length s h.
Symmetric carried(const Symmetric& p, Real s) { return {p[0] + 2 * s * p[1] + s * s * p[2], p[1] + s * p[2], p[2]}; }
/// A' j A: back through it.
Symmetric carried_back(const Symmetric& j, Real s) {
  return {j[0], s * j[0] + j[1], s * s * j[0] + 2 * s * j[1] + j[2]};
}
/// A f
Matrix2 transferred(const Matrix2& f, Real s) { return {f[0] + s * f[2], f[1] + s * f[3], f[2], f[3]}; }

Symmetric inverse(const Symmetric& c) {
  const Real det = c[0] * c[2] - c[1] * c[1];
  return {c[2] / det, -c[1] / det, c[0] / det};
}

/// Elements over h, and masses of the nodes between them over m.
struct Steps {
  std::vector<Real> length;
  std::vector<Real> mass;

  explicit Steps(const MemberKind& kind) {
    const Real h = kind.element_length;
    for (std::size_t i = 0; i < kind.elements; ++i) {
      length.push_back(kind.equal_elements() ? 1 : kind.length(i) / h);
    }
    for (std::size_t i = 1; i < kind.elements; ++i) {
      mass.push_back((length[i - 1] + length[i]) / 2);
    }
  }
  [[nodiscard]] std::size_t elements() const { return length.size(); }
};

/// One plane of one member while it is factored; names as in docs/theory.md, "Networks".
struct Plane {
  const Steps& steps;
  Real bend;         // h^3 K / EI
  Real shear;        // h K / kGA
  Real first_joint;  // compliance of the joints, infinite: a hinge
  Real second_joint;
  bool open = false;  // weights are those of a span

  struct Node {
    Real release, innovation, gain;  // 1 - G0, 1 / S, G1
    Real deflect, turn, bend;        // P just right of it
    Matrix2 transfer;                // Phi there
  };
  std::vector<Node> nodes{};
  Symmetric compliance{};  // C
  Matrix2 transfer{1, 0, 0, 1};

  [[nodiscard]] bool hinged_first() const { return std::isinf(first_joint); }
  /// Compliance of an element.
  [[nodiscard]] Symmetric element(std::size_t i) const {
    const Real s = steps.length[i];
    return {bend * s * s * s / 3 + shear * s, bend * s * s / 2, bend * s};
  }
  void sweep_right();
  void sweep_left(BendingTable& table) const;
  [[nodiscard]] Symmetric end_stiffness() const;
};

void Plane::sweep_right() {
  Symmetric& p = compliance;
  Matrix2& f = transfer;
  p = {0, 0, hinged_first() ? 0 : first_joint};
  for (std::size_t i = 1; i <= steps.elements(); ++i) {
    const Real s = steps.length[i - 1];
    const Symmetric own = element(i - 1);
    p = carried(p, s);
    for (std::size_t k = 0; k < 3; ++k) {
      p[k] += own[k];
    }
    f = transferred(f, s);
    if (i == steps.elements()) {
      break;
    }
    const Real give = 1 / steps.mass[i - 1];  // of the filter spring
    Node node{};
    if (i == 1 && hinged_first()) {
      // The rotation is what this node makes it: displacement and rotation take all of its news.
      node = {.release = 0,
              .innovation = 0,
              .gain = 1 / s,
              .deflect = give,
              .turn = give / s,
              .bend = (give + own[0]) / (s * s),
              .transfer = {0, 0, -1 / s, 0}};
    } else {
      const Real innovation = 1 / (p[0] + give);
      const Real release = give * innovation;
      const Real gain = p[1] * innovation;
      node = {.release = release,
              .innovation = innovation,
              .gain = gain,
              .deflect = p[0] * release,
              .turn = p[1] * release,
              .bend = p[2] - gain * p[1],
              .transfer = {f[0] * release, f[1] * release, f[2] - gain * f[0], f[3] - gain * f[1]}};
    }
    p = {node.deflect, node.turn, node.bend};
    f = node.transfer;
    nodes.push_back(node);
  }
  compliance[2] += std::isinf(second_joint) ? 0 : second_joint;
}

/// C^-1, of a hinge that of its force alone.
Symmetric Plane::end_stiffness() const {
  return std::isinf(second_joint) ? Symmetric{1 / compliance[0], 0, 0} : inverse(compliance);
}

void Plane::sweep_left(BendingTable& table) const {
  const Symmetric c = end_stiffness();
  const Matrix2& f = transfer;
  // phi' c v for a vector v
  const auto from_end = [&](const std::array<Real, 2>& v) {
    return std::array<Real, 2>{f[0] * v[0] + f[2] * v[1], f[1] * v[0] + f[3] * v[1]};
  };
  const auto pressed = [&](Real b0, Real b1) {
    return std::array<Real, 2>{c[0] * b0 + c[1] * b1, c[1] * b0 + c[2] * b1};
  };
  Symmetric j{};
  Matrix2 b{1, 0, 0, 1};
  table.weights.resize(nodes.size());
  for (std::size_t i = steps.elements(); i >= 1; --i) {
    if (i < steps.elements()) {
      const Node& node = nodes[i - 1];
      const std::array<Real, 2> end = pressed(b[1], b[3]);
      const std::array<Real, 2> start = from_end(end);
      const Matrix2& own = node.transfer;
      const Real force = -(own[0] * j[1] + own[2] * j[2]);
      const Real moment = -(own[1] * j[1] + own[3] * j[2]);
      table.weights[i - 1] =
          open ? std::array{static_cast<double>(force), static_cast<double>(moment), static_cast<double>(b[1]),
                            static_cast<double>(b[3])}
               : std::array{static_cast<double>(force - start[0]), static_cast<double>(moment - start[1]),
                            static_cast<double>(end[0]), static_cast<double>(end[1])};
      // N = [1 - G0 0; -G1 1]: j <- N' j N + e1 e1' / S, b <- b N
      const Real r = node.release;
      const Real g = node.gain;
      j = {r * (r * j[0] - g * j[1]) - g * (r * j[1] - g * j[2]) + node.innovation, r * j[1] - g * j[2], j[2]};
      b = {b[0] * r - b[1] * g, b[1], b[2] * r - b[3] * g, b[3]};
    }
    const Real s = steps.length[i - 1];
    j = carried_back(j, s);
    b = {b[0], s * b[0] + b[1], b[2], s * b[2] + b[3]};
  }
  table.open = {.compliance = compliance, .stiffness = j, .transfer = transfer};
  // [j + phi' c phi, -phi' c; -c phi, c]
  const std::array<Real, 2> column0 = pressed(f[0], f[2]);
  const std::array<Real, 2> column1 = pressed(f[1], f[3]);
  const std::array<Real, 2> of0 = from_end(column0);
  const std::array<Real, 2> of1 = from_end(column1);
  std::array<std::array<Real, 4>, 4> k{{{j[0] + of0[0], j[1] + of1[0], -column0[0], -column0[1]},
                                        {j[1] + of0[1], j[2] + of1[1], -column1[0], -column1[1]},
                                        {-column0[0], -column1[0], c[0], c[1]},
                                        {-column0[1], -column1[1], c[1], c[2]}}};
  if (hinged_first()) {
    for (std::size_t i = 0; i < 4; ++i) {
      k[1][i] = k[i][1] = 0;
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t l = 0; l < 4; ++l) {
      table.stiffness[i][l] = static_cast<double>(k[i][l]);
    }
  }
}

/// A single element hinged at its first end: a spring against the line that the other end prolongs.
void single_hinged(const Plane& plane, BendingTable& table) {
  if (std::isinf(plane.second_joint)) {
    return;
  }
  const Real k = 1 / (plane.element(0)[0] + plane.second_joint);
  constexpr std::array<double, 4> kAway{1, 0, -1, 1};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t l = 0; l < 4; ++l) {
      table.stiffness[i][l] = static_cast<double>(k * kAway[i] * kAway[l]);
    }
  }
}

BendingTable factor(Plane plane) {
  BendingTable table;
  table.hinged_first = plane.hinged_first();
  if (plane.steps.elements() == 1 && plane.hinged_first()) {
    single_hinged(plane, table);
    return table;
  }
  plane.sweep_right();
  for (std::size_t i = 0; i < plane.nodes.size(); ++i) {
    const Plane::Node& node = plane.nodes[i];
    table.gains.push_back({.keep = static_cast<double>(node.release - plane.steps.length[i + 1] * node.gain),
                           .deflect = static_cast<double>(node.deflect),
                           .turn = static_cast<double>(node.turn),
                           .release = static_cast<double>(node.release),
                           .bend = static_cast<double>(node.bend)});
  }
  plane.sweep_left(table);
  return table;
}

/// Along the axis, or about it.
struct Rod {
  Real element = 0;      // K h / EA, compliance of an element of length h
  Real first_joint = 0;  // those of the joints, infinite: a hinge
  Real second_joint = 0;
};

AxialTable factor_axial(const Rod& rod, const Steps& steps, bool open) {
  AxialTable table;
  const std::size_t elements = steps.elements();
  Real p = rod.first_joint;
  Real phi = 1;
  std::vector<Real> before;  // phi before each element
  std::vector<Real> innovation;
  std::vector<Real> release;
  for (std::size_t i = 1; i <= elements; ++i) {
    before.push_back(phi);
    p += steps.length[i - 1] * rod.element;
    if (i < elements) {
      const Real give = 1 / steps.mass[i - 1];
      innovation.push_back(1 / (p + give));
      const Real r = give * innovation.back();
      release.push_back(r);
      table.releases.push_back(static_cast<double>(r));
      p = std::isinf(p) ? give : p * r;  // behind a hinge the node is where its mass is
      table.keeps.push_back(static_cast<double>(p));
      phi *= r;
    }
  }
  p += rod.second_joint;
  Real j = 0;
  Real b = 1;
  table.weights.resize(elements);
  for (std::size_t i = elements; i >= 1; --i) {
    if (i < elements) {
      const Real r = release[i - 1];
      j = r * r * j + innovation[i - 1];
      b *= r;
    }
    const Real s = steps.length[i - 1];
    const Real pull = before[i - 1] * j;
    table.weights[i - 1] =
        open ? std::array{static_cast<double>(s * pull), static_cast<double>(-s * b)}
             : std::array{static_cast<double>(s * (pull + phi * b / p)), static_cast<double>(-s * b / p)};
  }
  table.open = {.compliance = p, .stiffness = j, .transfer = phi};
  table.stiffness = {static_cast<double>(j + phi * phi / p), static_cast<double>(-phi / p), static_cast<double>(1 / p)};
  return table;
}

Spacing<double> spacing_of(const Steps& steps) {
  Spacing<double> spacing;
  Real place = 0;
  for (std::size_t i = 0; i < steps.elements(); ++i) {
    const Real s = steps.length[i];
    spacing.elements.push_back({.length = static_cast<double>(s), .inverse = static_cast<double>(1 / s)});
    if (i + 1 < steps.elements()) {
      place += s;
      spacing.nodes.push_back({.mass = static_cast<double>(steps.mass[i]),
                               .inverse = static_cast<double>(1 / steps.mass[i]),
                               .place = static_cast<double>(place)});
    }
  }
  return spacing;
}

}  // namespace

MemberTables::MemberTables(const MemberSection& section, const MemberKind& kind, double filter_frequency,
                           const Options& options)
    : kind_{kind},
      stiffness_{filter_frequency * filter_frequency * section.mass_per_length() * kind.element_length},
      turning_stiffness_{options.rotary ? filter_frequency * filter_frequency * section.polar() * kind.element_length
                                        : 0.0} {
  const Part part = options.part;
  const Real h = kind.element_length;
  const Real k = stiffness_;
  const Steps steps{kind};
  if (!kind.equal_elements()) {
    spacing_ = spacing_of(steps);
  }
  for (std::size_t plane = 0; plane < 2; ++plane) {
    const std::size_t about = plane == 0 ? 2 : 1;  // the rotation that belongs to it
    const auto joint = [&](std::size_t end) { return k * h * h / static_cast<Real>(kind.joint[end][about]); };
    bending_[plane] = factor({.steps = steps,
                              .bend = k * h * h * h / static_cast<Real>(section.bending(plane)),
                              .shear = k * h * section.shear_compliance(plane),
                              .first_joint = joint(0),
                              .second_joint = joint(1),
                              .open = part == Part::span});
  }
  axial_ = factor_axial({.element = k * h / static_cast<Real>(section.axial())}, steps, part == Part::span);
  if (rotary()) {
    const Real turning = turning_stiffness_;
    turning_ = factor_axial({.element = turning * h / static_cast<Real>(section.torsion()),
                             .first_joint = turning / static_cast<Real>(kind.joint[0][0]),
                             .second_joint = turning / static_cast<Real>(kind.joint[1][0])},
                            steps, part == Part::span);
  }
  const double flexible = kind.element_length * static_cast<double>(kind.elements) / section.torsion();
  torsion_ = 1.0 / (flexible + 1.0 / kind.joint[0][0] + 1.0 / kind.joint[1][0]);
  if (kind.joint[0][0] == 0.0) {  // it follows the second end, between two hinges nothing
    twist_.second = kind.joint[1][0] == 0.0 ? 0.0 : 1.0;
  } else {
    twist_.second = torsion_ / kind.joint[0][0];
    twist_.first = 1.0 - twist_.second;
    twist_.element = torsion_ * kind.element_length / section.torsion();
  }
  if (part == Part::ends) {
    for (BendingTable& table : bending_) {
      table.gains = {};
      table.weights = {};
    }
    for (AxialTable* table : {&axial_, &turning_}) {
      table->releases = table->keeps = {};
      table->weights = {};
    }
    spacing_ = {};
  }
}

std::size_t MemberTables::bytes() const noexcept {
  std::size_t numbers = 2 * spacing_.elements.size() + 3 * spacing_.nodes.size();
  for (const AxialTable* table : {&axial_, &turning_}) {
    numbers += 2 * table->releases.size() + 2 * table->weights.size();
  }
  for (const BendingTable& table : bending_) {
    numbers += 5 * table.gains.size() + 4 * table.weights.size();
  }
  return numbers * sizeof(double);
}

std::array<std::array<long double, 12>, 12> MemberTables::end_stiffness() const {
  std::array<std::array<long double, 12>, 12> all{};
  const Real k = stiffness_;
  const Real h = kind_.element_length;
  for (std::size_t plane = 0; plane < 2; ++plane) {
    // Displacement, then rotation, of both ends; u_z goes with -theta_y.
    const std::array<std::size_t, 4> at =
        plane == 0 ? std::array<std::size_t, 4>{1, 5, 7, 11} : std::array<std::size_t, 4>{2, 4, 8, 10};
    const Real turn = plane == 0 ? h : -h;
    const std::array<Real, 4> unit{1, turn, 1, turn};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t l = 0; l < 4; ++l) {
        all[at[i]][at[l]] += k * unit[i] * unit[l] * bending_[plane].stiffness[i][l];
      }
    }
  }
  all[0][0] = k * axial_.stiffness[0];
  all[0][6] = all[6][0] = k * axial_.stiffness[1];
  all[6][6] = k * axial_.stiffness[2];
  if (rotary()) {
    all[3][3] = static_cast<Real>(turning_stiffness_) * turning_.stiffness[0];
    all[3][9] = all[9][3] = static_cast<Real>(turning_stiffness_) * turning_.stiffness[1];
    all[9][9] = static_cast<Real>(turning_stiffness_) * turning_.stiffness[2];
  } else {
    all[3][3] = all[9][9] = torsion_;
    all[3][9] = all[9][3] = -static_cast<Real>(torsion_);
  }
  return all;
}

}  // namespace udar::network
