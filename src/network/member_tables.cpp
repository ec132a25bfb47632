#include "udar/network/member_tables.hpp"

#include <cmath>

namespace udar::network {
namespace {

using Real = long double;
using Symmetric = std::array<Real, 3>;  // 00, 01, 11
using Matrix2 = std::array<Real, 4>;    // row by row

/// A p A' with A = [1 1; 0 1]: through an element.
Symmetric carried(const Symmetric& p) { return {p[0] + 2 * p[1] + p[2], p[1] + p[2], p[2]}; }
/// A' j A: back through it.
Symmetric carried_back(const Symmetric& j) { return {j[0], j[0] + j[1], j[0] + 2 * j[1] + j[2]}; }
/// A f
Matrix2 transferred(const Matrix2& f) { return {f[0] + f[2], f[1] + f[3], f[2], f[3]}; }

Symmetric inverse(const Symmetric& c) {
  const Real det = c[0] * c[2] - c[1] * c[1];
  return {c[2] / det, -c[1] / det, c[0] / det};
}

/// One plane of one member while it is factored; names as in docs/theory.md, "Networks".
struct Plane {
  Symmetric element;  // compliance
  Real first_joint;   // compliance of the joints, infinite: a hinge
  Real second_joint;
  std::size_t elements;
  bool open = false;  // weights are those of a span

  struct Node {
    Real release, deflect, turn, bend;
    Matrix2 transfer;  // Phi just right of it
  };
  std::vector<Node> nodes{};
  Symmetric compliance{};  // C
  Matrix2 transfer{1, 0, 0, 1};

  [[nodiscard]] bool hinged_first() const { return std::isinf(first_joint); }
  void sweep_right();
  void sweep_left(BendingTable& table) const;
  [[nodiscard]] Symmetric end_stiffness() const;
};

void Plane::sweep_right() {
  Symmetric& p = compliance;
  Matrix2& f = transfer;
  p = {0, 0, hinged_first() ? 0 : first_joint};
  for (std::size_t i = 1; i <= elements; ++i) {
    p = carried(p);
    for (std::size_t k = 0; k < 3; ++k) {
      p[k] += element[k];
    }
    f = transferred(f);
    if (i == elements) {
      break;
    }
    Node node{};
    if (i == 1 && hinged_first()) {
      // The rotation is what this node makes it: displacement and rotation take all of its news.
      node = {.release = 0, .deflect = 1, .turn = 1, .bend = 1 + element[0], .transfer = {0, 0, -1, 0}};
      p = {1, 1, node.bend};
    } else {
      const Real release = 1 / (p[0] + 1);
      const Real turn = p[1] * release;
      node = {.release = release, .deflect = p[0] * release, .turn = turn, .bend = p[2] - turn * p[1], .transfer = {}};
      p = {node.deflect, turn, node.bend};
      node.transfer = {f[0] * release, f[1] * release, f[2] - turn * f[0], f[3] - turn * f[1]};
    }
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
  for (std::size_t i = elements; i >= 1; --i) {
    if (i < elements) {
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
      // N = [R 0; -G1 1]: j <- N' j N + R e1 e1', b <- b N
      const Real r = node.release;
      const Real g = node.turn;
      j = {r * (r * j[0] - g * j[1]) - g * (r * j[1] - g * j[2]) + r, r * j[1] - g * j[2], j[2]};
      b = {b[0] * r - b[1] * g, b[1], b[2] * r - b[3] * g, b[3]};
    }
    j = carried_back(j);
    b = {b[0], b[0] + b[1], b[2], b[2] + b[3]};
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
  const Real k = 1 / (plane.element[0] + plane.second_joint);
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
  if (plane.elements == 1 && plane.hinged_first()) {
    single_hinged(plane, table);
    return table;
  }
  plane.sweep_right();
  for (const Plane::Node& node : plane.nodes) {
    table.gains.push_back({.keep = static_cast<double>(node.release - node.turn),
                           .deflect = static_cast<double>(node.deflect),
                           .turn = static_cast<double>(node.turn),
                           .release = static_cast<double>(node.release),
                           .bend = static_cast<double>(node.bend)});
  }
  plane.sweep_left(table);
  return table;
}

AxialTable factor_axial(Real element, std::size_t elements, bool open) {
  AxialTable table;
  Real p = 0;
  Real phi = 1;
  std::vector<Real> before;  // phi before each element
  std::vector<Real> release;
  for (std::size_t i = 1; i <= elements; ++i) {
    before.push_back(phi);
    p += element;
    if (i < elements) {
      const Real r = 1 / (p + 1);
      release.push_back(r);
      table.releases.push_back(static_cast<double>(r));
      table.keeps.push_back(static_cast<double>(p * r));
      p *= r;
      phi *= r;
    }
  }
  Real j = 0;
  Real b = 1;
  table.weights.resize(elements);
  for (std::size_t i = elements; i >= 1; --i) {
    if (i < elements) {
      const Real r = release[i - 1];
      j = r * r * j + r;
      b *= r;
    }
    const Real pull = before[i - 1] * j;
    table.weights[i - 1] = open ? std::array{static_cast<double>(pull), static_cast<double>(-b)}
                                : std::array{static_cast<double>(pull + phi * b / p), static_cast<double>(-b / p)};
  }
  table.open = {.compliance = p, .stiffness = j, .transfer = phi};
  table.stiffness = {static_cast<double>(j + phi * phi / p), static_cast<double>(-phi / p), static_cast<double>(1 / p)};
  return table;
}

}  // namespace

MemberTables::MemberTables(const MemberSection& section, const MemberKind& kind, double filter_frequency, Part part)
    : kind_{kind}, stiffness_{filter_frequency * filter_frequency * section.mass_per_length() * kind.element_length} {
  const Real h = kind.element_length;
  const Real k = stiffness_;
  for (std::size_t plane = 0; plane < 2; ++plane) {
    const std::size_t about = plane == 0 ? 2 : 1;  // the rotation that belongs to it
    const Real bend = k * h * h * h / static_cast<Real>(section.bending(plane));
    const auto joint = [&](std::size_t end) { return k * h * h / static_cast<Real>(kind.joint[end][about]); };
    bending_[plane] = factor({.element = {bend / 3 + k * h * section.shear_compliance(plane), bend / 2, bend},
                              .first_joint = joint(0),
                              .second_joint = joint(1),
                              .elements = kind.elements,
                              .open = part == Part::span});
  }
  axial_ = factor_axial(k * h / static_cast<Real>(section.axial()), kind.elements, part == Part::span);
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
    axial_.releases = axial_.keeps = {};
    axial_.weights = {};
  }
}

std::size_t MemberTables::bytes() const noexcept {
  std::size_t numbers = 2 * axial_.releases.size() + 2 * axial_.weights.size();
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
  all[3][3] = all[9][9] = torsion_;
  all[3][9] = all[9][3] = -static_cast<Real>(torsion_);
  return all;
}

}  // namespace udar::network
