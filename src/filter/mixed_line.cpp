#include "udar/filter/mixed_line.hpp"

#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"

namespace udar {

MixedLine::MixedLine(const BeamChain& beam, double filter_frequency) : BlockLine{beam, filter_frequency} { build(); }

std::string MixedLine::block_form_reason() const { return beam().parameters().tension > 0.0 ? "tension" : ""; }

MixedLine::ElementTerms MixedLine::element_terms(const BeamElement& element) {
  if (!LineData::present(element)) {
    return {};
  }
  const double h = element.length;
  const double bend = h * element.flexural_compliance / 6.0;
  const double shear = element.shear_compliance / h;
  return {.inverse_length = 1.0 / h, .diagonal = -(2.0 * bend + shear), .coupling = -(bend - shear)};
}

BlockLine::ElementMatrix MixedLine::element_matrix(const BeamElement& element) const {
  const ElementTerms e = element_terms(element);
  const double t = e.inverse_length;
  const double pull = beam().parameters().tension * t;
  return {
      {{pull, -t, -pull, t}, {-t, e.diagonal, t, e.coupling}, {-pull, t, pull, -t}, {t, e.coupling, -t, e.diagonal}}};
}

void MixedLine::add_end(const BeamEnd& end, NodeTerms& terms) const {
  terms.present[1] = !end.moment_free();
  terms.diagonal[1] = end.moment_free() ? 0.0 : -1.0 / end.rotational_stiffness;
}

void MixedLine::multiply(std::span<const double> unknowns, std::span<double> product) const {
  const double tension = beam().parameters().tension;
  // Differences come first: they are exact, so that rigid motions give nothing, which the assembled entries cannot
  // promise.
  multiply_by(unknowns, product, [&](const BeamElement& element, const Pair& a, const Pair& b, Pair& to_a, Pair& to_b) {
    const ElementTerms e = element_terms(element);
    const double slope = (b[0] - a[0]) * e.inverse_length;
    const double shear = (b[1] - a[1]) * e.inverse_length - tension * slope;
    to_a = {shear, slope + e.diagonal * a[1] + e.coupling * b[1]};
    to_b = {-shear, -slope + e.coupling * a[1] + e.diagonal * b[1]};
  });
}

void MixedLine::right_hand_side(const FilterColumn& column, std::span<double> values) const {
  const LineData& line = terms();
  const std::size_t count = line.local_nodes();
  const double tension = beam().parameters().tension;
  const auto& scale = line.scale;
  const auto displacement = [&](std::size_t i) { return scale[2 * i] != 0.0 ? column.displacement[i] : 0.0; };
  const auto halo = beam().exchange<1>({displacement(0)}, {displacement(count - 1)});
  const auto slope = [&](std::size_t element, double left, double right) {
    return LineData::present(line.elements[element]) ? (right - left) / line.elements[element].length : 0.0;
  };
  double slope_left = slope(0, halo.left[0], displacement(0));  // of the element on the left of the node
  for (std::size_t i = 0; i < count; ++i) {
    const double own = displacement(i);
    const double slope_right = slope(i + 1, own, i + 1 < count ? displacement(i + 1) : halo.right[0]);
    const double bend = slope_right - slope_left;  // (T u)_i
    const double force = column.force != nullptr ? column.force[i] : 0.0;
    const double ground = spring(i) - line.filter_stiffness[i];
    values[2 * i] = scale[2 * i] * (force - ground * own + tension * bend);
    const double kink = column.kink != nullptr ? column.kink[i] : 0.0;
    values[2 * i + 1] = -scale[2 * i + 1] * (bend - kink);
    slope_left = slope_right;
  }
}

void MixedLine::extract(std::span<const double> unknowns, const FilterColumn& column) const {
  const auto& scale = terms().scale;
  const std::size_t count = terms().local_nodes();
  for (std::size_t i = 0; i < count; ++i) {
    column.stretch[i] = scale[2 * i] * unknowns[2 * i] - (scale[2 * i] != 0.0 ? 0.0 : column.displacement[i]);
    if (column.internal != nullptr) {
      column.internal[i] = scale[2 * i + 1] * unknowns[2 * i + 1];
    }
  }
}

void MixedLine::unknowns_of(const FilterColumn& column, std::span<double> unknowns) const {
  const auto& scale = terms().scale;
  const std::size_t count = terms().local_nodes();
  for (std::size_t i = 0; i < count; ++i) {
    const Pair values{column.stretch[i], column.internal[i]};
    for (std::size_t a = 0; a < 2; ++a) {
      unknowns[2 * i + a] = scale[2 * i + a] != 0.0 ? values[a] / scale[2 * i + a] : 0.0;
    }
  }
}

void MixedLine::create_moment_solver() {
  // Every second unknown: -S, and 1 where a moment is known to be zero.
  petsc::Matrix pointwise;
  petsc::Matrix bending;
  petsc::IndexSet rows;
  UDAR_CALL(MatConvert(matrix(), MATAIJ, MAT_INITIAL_MATRIX, pointwise.put()));
  UDAR_CALL(ISCreateStride(comm(), beam().local_nodes(), 2 * beam().begin() + 1, 2, rows.put()));
  UDAR_CALL(MatCreateSubMatrix(pointwise, rows, rows, MAT_INITIAL_MATRIX, bending.put()));
  // ILU(0) of every rank's block, exact on one rank, and not ICC, which would shift a negative diagonal.
  UDAR_CALL(MatSetOption(bending, MAT_SYMMETRIC, PETSC_FALSE));
  UDAR_CALL(MatCreateVecs(bending, moment_unknowns_.put(), moment_right_.put()));
  UDAR_CALL(KSPCreate(comm(), moment_solver_.put()));
  UDAR_CALL(KSPSetOptionsPrefix(moment_solver_, "filter_moment_"));
  UDAR_CALL(KSPSetOperators(moment_solver_, bending, bending));
  UDAR_CALL(KSPSetTolerances(moment_solver_, 1e-14, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT));
  UDAR_CALL(KSPSetFromOptions(moment_solver_));
  UDAR_CALL(KSPSetUp(moment_solver_));
}

void MixedLine::internal_of(const FilterColumn& column) {
  const std::size_t count = mass().size();
  if (moment_solver_ == nullptr) {
    create_moment_solver();
  }
  std::vector<double> all(2 * count);
  right_hand_side({.displacement = column.displacement, .kink = column.kink}, all);
  {
    const petsc::WriteArray right{moment_right_};
    for (std::size_t i = 0; i < count; ++i) {
      right.values()[i] = all[2 * i + 1];
    }
  }
  UDAR_CALL(KSPSolve(moment_solver_, moment_right_, moment_unknowns_));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  UDAR_CALL(KSPGetConvergedReason(moment_solver_, &reason));
  if (reason <= 0) {
    throw SolveError{std::string{"the solve for bending moments did not converge: "} + KSPConvergedReasons[reason] +
                     " (see -filter_moment_ksp_monitor)"};
  }
  const petsc::ReadArray solution{moment_unknowns_};
  for (std::size_t i = 0; i < count; ++i) {
    column.internal[i] = solution.values()[i] * terms().scale[2 * i + 1];
  }
}

}  // namespace udar
