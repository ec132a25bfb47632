#include "support/quad_frame.hpp"

#include <array>
#include <cmath>
#include <cstddef>

#include "tools/quad.hpp"

namespace udar::test {
namespace {

using tools::Quad;
using Vector6 = std::array<Quad, 6>;
using Matrix6 = std::array<Vector6, 6>;
using Matrix12 = std::array<std::array<Quad, 12>, 12>;

Quad root(Quad value) {  // Newton from the rounded root
  Quad x = std::sqrt(static_cast<double>(value));
  for (int i = 0; i < 3; ++i) {
    x = (x + value / x) / 2;
  }
  return x;
}

/// Stiffness of one element in member axes: displacements and rotations of its first node, then of its second.
Matrix12 element_matrix(const MemberSection& section, double length) {
  const Quad h = length;
  const Quad e = section.youngs_modulus;
  Matrix12 k{};
  const auto bar = [&](std::size_t at, Quad stiffness) {
    k[at][at] = k[at + 6][at + 6] = stiffness;
    k[at][at + 6] = k[at + 6][at] = -stiffness;
  };
  bar(0, e * section.area / h);
  bar(3, Quad{section.shear_modulus} * section.torsion_constant / h);
  for (std::size_t plane = 0; plane < 2; ++plane) {
    const Quad ei = e * section.inertia[plane];
    const Quad soft = section.shear_factor[plane] > 0.0
                          ? 12 * ei / (h * h * section.shear_factor[plane] * Quad{section.shear_modulus} * section.area)
                          : Quad{0};
    const Quad unit = ei / (h * h * h * (1 + soft));
    const std::array<std::size_t, 4> at =
        plane == 0 ? std::array<std::size_t, 4>{1, 5, 7, 11} : std::array<std::size_t, 4>{2, 4, 8, 10};
    const Quad s = plane == 0 ? h : -h;
    const std::array<std::array<Quad, 4>, 4> bend{{{12, 6 * s, -12, 6 * s},
                                                   {6 * s, (4 + soft) * h * h, -6 * s, (2 - soft) * h * h},
                                                   {-12, -6 * s, 12, -6 * s},
                                                   {6 * s, (2 - soft) * h * h, -6 * s, (4 + soft) * h * h}}};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        k[at[i]][at[j]] = unit * bend[i][j];
      }
    }
  }
  return k;
}

/// A joint of given stiffness between a rotation of the element and what turns it.
void release(Matrix12& k, std::size_t r, double joint) {
  if (std::isinf(joint)) {
    return;
  }
  const Quad spring = joint;
  const Quad own = k[r][r];
  const std::array<Quad, 12> row = k[r];
  for (std::size_t i = 0; i < 12; ++i) {
    for (std::size_t j = 0; j < 12; ++j) {
      if (i != r && j != r) {
        k[i][j] -= row[i] * row[j] / (own + spring);
      }
    }
  }
  for (std::size_t i = 0; i < 12; ++i) {
    k[i][r] = k[r][i] = i == r ? spring * own / (own + spring) : spring * row[i] / (own + spring);
  }
}

/// Turned by a transformation of each end: t' k t.
Matrix12 turned(const Matrix12& k, const std::array<Matrix6, 2>& t) {
  Matrix12 half{};
  Matrix12 all{};
  for (std::size_t i = 0; i < 12; ++i) {
    for (std::size_t j = 0; j < 12; ++j) {
      for (std::size_t m = 0; m < 6; ++m) {
        half[i][j] += k[i][6 * (j / 6) + m] * t[j / 6][m][j % 6];
      }
    }
  }
  for (std::size_t i = 0; i < 12; ++i) {
    for (std::size_t j = 0; j < 12; ++j) {
      for (std::size_t m = 0; m < 6; ++m) {
        all[i][j] += t[i / 6][m][i % 6] * half[6 * (i / 6) + m][j];
      }
    }
  }
  return all;
}

Matrix6 to_end(const Axes& axes, const Place& offset) {
  const Quad x = offset.x;
  const Quad y = offset.y;
  const Quad z = offset.z;
  const std::array<std::array<Quad, 3>, 3> arm{{{0, z, -y}, {-z, 0, x}, {y, -x, 0}}};
  Matrix6 t{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      t[i][k] = t[3 + i][3 + k] = axes[i][k];
      for (std::size_t m = 0; m < 3; ++m) {
        t[i][3 + k] += axes[i][m] * arm[m][k];
      }
    }
  }
  return t;
}

/// A dense symmetric positive definite system.
struct QuadSystem {
  std::size_t size;
  std::vector<Quad> matrix;  // lower triangle, row by row
  std::vector<Quad> right;

  explicit QuadSystem(std::size_t n) : size{n}, matrix(n * n, Quad{0}), right(n, Quad{0}) {}
  void solve() {
    const auto at = [this](std::size_t i, std::size_t j) -> Quad& { return matrix[i * size + j]; };
    for (std::size_t j = 0; j < size; ++j) {
      for (std::size_t i = j; i < size; ++i) {
        Quad sum = at(i, j);
        for (std::size_t m = 0; m < j; ++m) {
          sum -= at(i, m) * at(j, m);
        }
        at(i, j) = i == j ? root(sum) : sum / at(j, j);
      }
    }
    for (std::size_t i = 0; i < size; ++i) {
      for (std::size_t m = 0; m < i; ++m) {
        right[i] -= at(i, m) * right[m];
      }
      right[i] /= at(i, i);
    }
    for (std::size_t i = size; i-- > 0;) {
      for (std::size_t m = i + 1; m < size; ++m) {
        right[i] -= at(m, i) * right[m];
      }
      right[i] /= at(i, i);
    }
  }
};

/// A member's nodes are eliminated from its second end: what is left couples the two ends.
struct Chain {
  struct Node {
    Matrix6 before{};  // own row: of the node before it
    Matrix6 last{};    // and of the second end
    Vector6 right{};
    QuadSystem diagonal{6};
  };
  std::vector<Matrix12> elements;
  std::vector<Vector6> loads;  // of the inner nodes
  std::vector<Quad> grounds;   // wf^2 m of the inner nodes
  std::vector<Node> nodes;
  Matrix12 ends{};
  std::array<Vector6, 2> end_loads{};

  void eliminate();
  [[nodiscard]] std::vector<Vector6> substitute(const Vector6& first, const Vector6& last) const;
};

Vector6 solved(QuadSystem factor, const Vector6& right) {
  std::ranges::copy(right, factor.right.begin());
  factor.solve();
  Vector6 result;
  std::ranges::copy(factor.right, result.begin());
  return result;
}

void Chain::eliminate() {
  const std::size_t inner = loads.size();
  nodes.resize(inner);
  // Of the node to the right of the element: own block, coupling to the last end, and that end's own block.
  Matrix6 own{};
  Matrix6 to_last{};
  Matrix6 last{};
  Vector6 right{};
  Vector6 last_right{};
  const auto block = [](const Matrix12& k, std::size_t a, std::size_t b) {
    Matrix6 part{};
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t j = 0; j < 6; ++j) {
        part[i][j] = k[6 * a + i][6 * b + j];
      }
    }
    return part;
  };
  const auto add = [](Matrix6& to, const Matrix6& what) {
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t j = 0; j < 6; ++j) {
        to[i][j] += what[i][j];
      }
    }
  };
  // The last element: its right node is the end itself.
  own = block(elements[inner], 0, 0);
  to_last = block(elements[inner], 0, 1);
  last = block(elements[inner], 1, 1);
  for (std::size_t i = inner; i-- > 0;) {
    add(own, block(elements[i], 1, 1));
    for (std::size_t k = 0; k < 3; ++k) {
      own[k][k] += grounds[i];
    }
    for (std::size_t k = 0; k < 6; ++k) {
      right[k] += loads[i][k];
    }
    Node& node = nodes[i];
    node.before = block(elements[i], 1, 0);
    node.last = to_last;
    node.right = right;
    for (std::size_t r = 0; r < 6; ++r) {
      for (std::size_t c = 0; c < 6; ++c) {
        node.diagonal.matrix[r * 6 + c] = own[r][c];
      }
    }
    Matrix6 next_own = block(elements[i], 0, 0);
    Matrix6 next_last{};
    Vector6 next_right{};
    const Vector6 of_right = solved(node.diagonal, right);
    for (std::size_t c = 0; c < 6; ++c) {
      Vector6 of_before;
      Vector6 of_last;
      for (std::size_t r = 0; r < 6; ++r) {
        of_before[r] = node.before[r][c];
        of_last[r] = node.last[r][c];
      }
      of_before = solved(node.diagonal, of_before);
      of_last = solved(node.diagonal, of_last);
      for (std::size_t r = 0; r < 6; ++r) {
        for (std::size_t m = 0; m < 6; ++m) {
          next_own[r][c] -= node.before[m][r] * of_before[m];
          next_last[r][c] -= node.before[m][r] * of_last[m];
          last[r][c] -= node.last[m][r] * of_last[m];
        }
      }
    }
    for (std::size_t r = 0; r < 6; ++r) {
      for (std::size_t m = 0; m < 6; ++m) {
        next_right[r] -= node.before[m][r] * of_right[m];
        last_right[r] -= node.last[m][r] * of_right[m];
      }
    }
    own = next_own;
    to_last = next_last;
    right = next_right;
  }
  for (std::size_t r = 0; r < 6; ++r) {
    for (std::size_t c = 0; c < 6; ++c) {
      ends[r][c] = own[r][c];
      ends[r][6 + c] = ends[6 + c][r] = to_last[r][c];
      ends[6 + r][6 + c] = last[r][c];
    }
  }
  end_loads = {right, last_right};
}

std::vector<Vector6> Chain::substitute(const Vector6& first, const Vector6& last) const {
  std::vector<Vector6> values;
  Vector6 before = first;
  for (const Node& node : nodes) {
    Vector6 right = node.right;
    for (std::size_t r = 0; r < 6; ++r) {
      for (std::size_t c = 0; c < 6; ++c) {
        right[r] -= node.before[r][c] * before[c] + node.last[r][c] * last[c];
      }
    }
    before = solved(node.diagonal, right);
    values.push_back(before);
  }
  return values;
}

/// One element of a member in global axes, with the joints and arms at the member's ends.
Matrix12 element_of(const Member& member, const MemberKind& kind, const Matrix12& plain, const Axes& axes,
                    std::size_t e) {
  Matrix12 own = plain;
  std::array<Matrix6, 2> t{to_end(axes, {}), to_end(axes, {})};
  if (e == 0) {
    t[0] = to_end(axes, member.ends[0].offset);
  }
  if (e + 1 == kind.elements) {
    t[1] = to_end(axes, member.ends[1].offset);
  }
  for (std::size_t about = 0; about < 3; ++about) {
    if (e == 0) {
      release(own, 3 + about, kind.joint[0][about]);
    }
    if (e + 1 == kind.elements) {
      release(own, 9 + about, kind.joint[1][about]);
    }
  }
  return turned(own, t);
}

/// A member's chain. The line's displacement is that of the masses plus the stretch: loads are F - C u.
Chain chain_of(const Network& network, std::size_t number, const MemberKind& kind, double wf2, std::size_t first_node,
               const std::vector<double>& u, const std::vector<double>& force) {
  const Member& member = network.parameters().members[number];
  const MemberSection& section = network.parameters().sections[member.section];
  const Axes& axes = network.axes(number);
  const auto node_of = [&](std::size_t i) {
    return i == 0 ? member.ends[0].junction : i == kind.elements ? member.ends[1].junction : first_node + i - 1;
  };
  Chain chain;
  chain.loads.resize(kind.elements - 1);
  for (std::size_t i = 1; i < kind.elements; ++i) {
    const Quad both = Quad{kind.length(i - 1)} + kind.length(i);
    chain.grounds.push_back(Quad{wf2} * section.mass_per_length() * both / 2);
  }
  std::array<Vector6, 2> on_ends{};
  for (std::size_t e = 0; e < kind.elements; ++e) {
    chain.elements.push_back(element_of(member, kind, element_matrix(section, kind.length(e)), axes, e));
    // A translation pushes nothing, so the first node's displacement may be taken off: what is left is small.
    for (std::size_t row = 0; row < 12; ++row) {
      Quad pushed = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        const Quad rise = Quad{u[3 * node_of(e + 1) + k]} - Quad{u[3 * node_of(e) + k]};
        pushed -= chain.elements.back()[row][6 + k] * rise;
      }
      const std::size_t node = e + row / 6;
      if (node == 0 || node == kind.elements) {
        on_ends[node == 0 ? 0 : 1][row % 6] += pushed;
      } else {
        chain.loads[node - 1][row % 6] += pushed;
      }
    }
  }
  if (kind.joint[0][0] == 0.0 && kind.joint[1][0] == 0.0 && kind.elements > 1) {  // it turns freely about its axis
    const Quad spring = Quad{section.torsion()} / kind.element_length;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        chain.elements[0][9 + i][9 + k] += spring * axes[0][i] * axes[0][k];
      }
    }
  }
  for (std::size_t i = 0; i + 1 < kind.elements && !force.empty(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      chain.loads[i][k] += force[3 * (first_node + i) + k];
    }
  }
  chain.eliminate();
  for (std::size_t end = 0; end < 2; ++end) {
    for (std::size_t k = 0; k < 6; ++k) {
      chain.end_loads[end][k] += on_ends[end][k];
    }
  }
  return chain;
}

/// Masses, springs and forces of the junctions; rows of the identity where they are held.
void add_grounds(const Network& network, double wf2, const std::vector<double>& moved, const std::vector<double>& force,
                 QuadSystem& system) {
  const NetworkParameters& parameters = network.parameters();
  const std::span<const double> mass = network.points().mass();
  for (std::size_t j = 0; j < parameters.junctions.size(); ++j) {
    const Junction& junction = parameters.junctions[j];
    for (std::size_t k = 0; k < 6; ++k) {
      const std::size_t row = 6 * j + k;
      Quad& diagonal = system.matrix[row * system.size + row];
      diagonal += (k < 3 ? Quad{wf2} * mass[j] : Quad{0}) + junction.stiffness[k];
      if (k < 3) {
        system.right[row] += (force.empty() ? 0.0 : force[3 * j + k]) - Quad{junction.stiffness[k]} * moved[3 * j + k];
      }
      if (junction.held[k] || diagonal == 0) {
        for (std::size_t i = 0; i < system.size; ++i) {
          system.matrix[row * system.size + i] = system.matrix[i * system.size + row] = 0;
        }
        diagonal = 1;
        system.right[row] = 0;
      }
    }
  }
}

/// Displacements of the masses, none where the line stays.
std::vector<double> where_free(const NetworkParameters& parameters, std::vector<double> displacement) {
  for (std::size_t i = 0; i < 3 * parameters.junctions.size(); ++i) {
    if (parameters.junctions[i / 3].held[i % 3]) {
      displacement[i] = 0.0;
    }
  }
  return displacement;
}

}  // namespace

std::vector<double> quad_stretch(const Network& network, double filter_frequency,
                                 const std::vector<double>& displacement, const std::vector<double>& force) {
  const NetworkParameters& parameters = network.parameters();
  const std::vector<double> moved = where_free(parameters, displacement);
  const double wf2 = filter_frequency * filter_frequency;
  const std::size_t junctions = parameters.junctions.size();
  QuadSystem system{6 * junctions};
  std::vector<Chain> chains;
  std::size_t node = junctions;
  for (std::size_t number = 0; number < parameters.members.size(); ++number) {
    const Member& member = parameters.members[number];
    const Chain& chain =
        chains.emplace_back(chain_of(network, number, network.kinds()[network.kind(number)], wf2, node, moved, force));
    node += network.kinds()[network.kind(number)].elements - 1;
    for (std::size_t i = 0; i < 12; ++i) {
      const std::size_t row = 6 * member.ends[i / 6].junction + i % 6;
      system.right[row] += chain.end_loads[i / 6][i % 6];
      for (std::size_t j = 0; j < 12; ++j) {
        system.matrix[row * system.size + 6 * member.ends[j / 6].junction + j % 6] += chain.ends[i][j];
      }
    }
  }
  add_grounds(network, wf2, moved, force, system);
  system.solve();
  std::vector<double> stretch;
  const auto put = [&](const auto& values) {
    for (std::size_t k = 0; k < 6; ++k) {
      stretch.push_back(static_cast<double>(values[k]));
    }
  };
  const auto of_junction = [&](std::size_t j) {
    Vector6 values;
    std::copy_n(system.right.begin() + static_cast<std::ptrdiff_t>(6 * j), 6, values.begin());
    return values;
  };
  for (std::size_t j = 0; j < junctions; ++j) {
    Vector6 values = of_junction(j);
    for (std::size_t k = 0; k < 3; ++k) {
      values[k] -= Quad{displacement[3 * j + k]} - Quad{moved[3 * j + k]};
    }
    put(values);
  }
  for (std::size_t number = 0; number < chains.size(); ++number) {
    const Member& member = parameters.members[number];
    for (const Vector6& values :
         chains[number].substitute(of_junction(member.ends[0].junction), of_junction(member.ends[1].junction))) {
      put(values);
    }
  }
  return stretch;
}

}  // namespace udar::test
