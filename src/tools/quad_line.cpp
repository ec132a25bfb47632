#include "tools/quad_line.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "tools/quad.hpp"
#include "udar/structure/beam_chain.hpp"

namespace udar::tools {

namespace {

/// A 2 x 2 block of the matrix: displacement and moment of a node.
struct Block {
  Quad a, b, c, d;
};
/// Of one element: 1/h and the moments' entries; nothing in a gap.
struct Terms {
  Quad t, diagonal, coupling;
};
/// Whether displacement and moment of a node are unknowns.
using Present = std::array<bool, 2>;

Terms terms_of(const BeamChain& beam, PetscInt number) {
  const BeamElement e = beam.element(number);
  if (!std::isfinite(e.flexural_compliance)) {
    return Terms{0, 0, 0};
  }
  const Quad bend = static_cast<Quad>(e.length) * e.flexural_compliance / 6;
  const Quad shear = static_cast<Quad>(e.shear_compliance) / e.length;
  return Terms{1 / static_cast<Quad>(e.length), -(2 * bend + shear), -(bend - shear)};
}

Present present(const BeamChain& beam, PetscInt node) {
  const BeamEnd* end = beam.end_at(node);
  return {!beam.fixed(node), end == nullptr || !end->moment_free()};
}

/// A node's own block, between two elements. @param k of its filter spring
Block pivot_of(const BeamChain& beam, PetscInt node, double k, const Terms& left, const Terms& right) {
  const Quad tension = beam.parameters().tension;
  const Present here = present(beam, node);
  const Quad off = -(left.t + right.t);
  const bool both = here[0] && here[1];
  Block pivot{here[0] ? static_cast<Quad>(k) + beam.ground_stiffness(node) + tension * (left.t + right.t) : Quad{1},
              both ? off : Quad{0}, both ? off : Quad{0}, here[1] ? left.diagonal + right.diagonal : Quad{1}};
  if (const BeamEnd* end = beam.end_at(node); end != nullptr && here[1]) {
    pivot.d -= 1 / static_cast<Quad>(end->rotational_stiffness);
  }
  return pivot;
}

/// The block of two nodes that an element joins.
Block coupling_of(const BeamChain& beam, const Terms& e, const Present& row, const Present& column) {
  const Quad tension = beam.parameters().tension;
  return Block{row[0] && column[0] ? -tension * e.t : Quad{0}, row[0] && column[1] ? e.t : Quad{0},
               row[1] && column[0] ? e.t : Quad{0}, row[1] && column[1] ? e.coupling : Quad{0}};
}

/// block^-1 (top, bottom)
std::array<Quad, 2> divide(const Block& block, Quad top, Quad bottom) {
  const Quad determinant = block.a * block.d - block.b * block.c;
  return {(block.d * top - block.b * bottom) / determinant, (block.a * bottom - block.c * top) / determinant};
}

}  // namespace

QuadLine quad_line(const BeamChain& beam, double wf, const std::vector<double>& displacement,
                   const std::vector<double>& force) {
  const auto n = static_cast<std::size_t>(beam.nodes());
  std::vector<Block> factor(n);  // inverse of the pivot block times the coupling to the next node
  std::vector<std::array<Quad, 2>> x(n);
  Terms left{0, 0, 0};
  Present before{};
  for (std::size_t i = 0; i < n; ++i) {
    const auto node = static_cast<PetscInt>(i);
    const Terms right = terms_of(beam, node);
    const Present here = present(beam, node);
    const double k = wf * wf * beam.mass(node);
    Block pivot = pivot_of(beam, node, k, left, right);
    const Quad load = force.empty() ? 0.0 : force[i];
    std::array<Quad, 2> b{here[0] ? static_cast<Quad>(k) * displacement[i] + load : Quad{0}, 0};
    if (i > 0) {
      const Block lower = coupling_of(beam, left, here, before);
      const Block& f = factor[i - 1];
      pivot.a -= lower.a * f.a + lower.b * f.c;
      pivot.b -= lower.a * f.b + lower.b * f.d;
      pivot.c -= lower.c * f.a + lower.d * f.c;
      pivot.d -= lower.c * f.b + lower.d * f.d;
      b[0] -= lower.a * x[i - 1][0] + lower.b * x[i - 1][1];
      b[1] -= lower.c * x[i - 1][0] + lower.d * x[i - 1][1];
    }
    x[i] = divide(pivot, b[0], b[1]);
    if (i + 1 < n) {
      const Block upper = coupling_of(beam, right, here, present(beam, node + 1));
      const auto first = divide(pivot, upper.a, upper.c);
      const auto second = divide(pivot, upper.b, upper.d);
      factor[i] = {first[0], second[0], first[1], second[1]};
    }
    left = right;
    before = here;
  }
  QuadLine result{std::vector<double>(n), std::vector<double>(n)};
  for (std::size_t i = n; i-- > 0;) {
    if (i + 1 < n) {
      const Block& f = factor[i];
      x[i][0] -= f.a * x[i + 1][0] + f.b * x[i + 1][1];
      x[i][1] -= f.c * x[i + 1][0] + f.d * x[i + 1][1];
    }
    result.stretch[i] = static_cast<double>(x[i][0] - displacement[i]);
    result.moment[i] = static_cast<double>(x[i][1]);
  }
  return result;
}

double relative_error(const BeamChain& beam, const std::vector<double>& found, const std::vector<double>& exact) {
  std::array<double, 2> largest{};
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double expected = exact[static_cast<std::size_t>(beam.begin()) + i];
    const double error = std::abs(found[i] - expected);
    largest[0] = error <= largest[0] ? largest[0] : error;
    largest[1] = std::max(largest[1], std::abs(expected));
  }
  std::array<double, 2> all{};
  for (std::size_t a = 0; a < 2; ++a) {
    // MPI_MAX may lose a NaN.
    double bad = std::isnan(largest[a]) ? 1.0 : 0.0;
    MPI_Allreduce(MPI_IN_PLACE, &bad, 1, MPI_DOUBLE, MPI_MAX, beam.comm());
    MPI_Allreduce(&largest[a], &all[a], 1, MPI_DOUBLE, MPI_MAX, beam.comm());
    all[a] = bad > 0.0 ? std::nan("") : all[a];
  }
  return all[1] > 0.0 ? all[0] / all[1] : all[0];
}

}  // namespace udar::tools
