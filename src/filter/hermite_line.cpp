#include "udar/filter/hermite_line.hpp"

#include "udar/petsc/error.hpp"

namespace udar {

HermiteLine::HermiteLine(const BeamChain& beam, double filter_frequency) : BlockLine{beam, filter_frequency} {
  build();
}

BlockLine::ElementMatrix HermiteLine::element_matrix(const BeamElement& element) const {
  const HermiteElement e = hermite_element(element, beam().parameters().tension);
  return {{{e.side, e.cross, -e.side, e.cross},
           {e.cross, e.diagonal, -e.cross, e.coupling},
           {-e.side, -e.cross, e.side, -e.cross},
           {e.cross, e.coupling, -e.cross, e.diagonal}}};
}

void HermiteLine::add_end(const BeamEnd& end, NodeTerms& terms) const {
  terms.present[1] = end.rotational_stiffness != BeamEnd::kRigid;
  terms.diagonal[1] = terms.present[1] ? end.rotational_stiffness : 0.0;
}

void HermiteLine::multiply(std::span<const double> unknowns, std::span<double> product) const {
  multiply_by(unknowns, product, [&](const BeamElement& element, const Pair& a, const Pair& b, Pair& to_a, Pair& to_b) {
    const HermiteElement e = hermite_element(element, beam().parameters().tension);
    const double rise = e.side * (a[0] - b[0]);
    const double turn = e.cross * (a[1] + b[1]);
    to_a = {rise + turn, e.cross * (a[0] - b[0]) + e.diagonal * a[1] + e.coupling * b[1]};
    to_b = {-rise - turn, e.cross * (a[0] - b[0]) + e.coupling * a[1] + e.diagonal * b[1]};
  });
}

void HermiteLine::right_hand_side(const FilterColumn& column, std::span<double> values) const {
  const LineData& line = terms();
  const std::size_t count = line.local_nodes();
  for (std::size_t i = 0; i < count; ++i) {
    const double force = column.force != nullptr ? column.force[i] : 0.0;
    values[2 * i] = line.scale[2 * i] * (line.filter_stiffness[i] * column.displacement[i] + force);
    values[2 * i + 1] = 0.0;
  }
}

void HermiteLine::extract(std::span<const double> unknowns, const FilterColumn& column) const {
  const std::size_t count = terms().local_nodes();
  for (std::size_t i = 0; i < count; ++i) {
    column.stretch[i] = terms().scale[2 * i] * unknowns[2 * i] - column.displacement[i];
  }
  if (column.internal != nullptr) {
    moments(unknowns, {column.internal, count});
  }
}

void HermiteLine::unknowns_of(const FilterColumn& /*column*/, std::span<double> /*unknowns*/) const {
  throw InputError{"the Hermite form is not solved by columns: its rotations are not among what a column has"};
}

void HermiteLine::internal_of(const FilterColumn& /*column*/) {
  throw InputError{"beam formulation: `filter frequency` none needs mixed, which has the moments of a given line"};
}

void HermiteLine::moments(std::span<const double> unknowns, std::span<double> moment) const {
  const LineData& line = terms();
  const std::size_t count = line.local_nodes();
  const auto halo = beam().exchange(values_at(unknowns, 0), values_at(unknowns, count - 1));
  for (std::size_t i = 0; i < count; ++i) {
    // At the left end of the element on the right, at the last node at the right end of the one on the left.
    const bool last = !LineData::present(line.elements[i + 1]);
    const BeamElement& element = line.elements[last ? i : i + 1];
    const double h = element.length;
    const double ratio = shear_ratio(element);
    const double factor = 1.0 / (element.flexural_compliance * h * h * (1.0 + ratio));
    const Pair own = values_at(unknowns, i);  // (w, theta)
    const Pair other = last ? (i > 0 ? values_at(unknowns, i - 1) : halo.left)
                            : (i + 1 < count ? values_at(unknowns, i + 1) : halo.right);
    const double turn = h * ((4.0 + ratio) * own[1] + (2.0 - ratio) * other[1]);
    moment[i] = factor * (6.0 * (other[0] - own[0]) + (last ? turn : -turn));
  }
}

}  // namespace udar
