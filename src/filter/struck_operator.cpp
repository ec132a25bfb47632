#include "udar/filter/struck_operator.hpp"

#include <algorithm>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

/// The structure's solver among columns of structure and strikers.
class StruckSolver final : public ColumnSolver {
 public:
  StruckSolver(ColumnSolver& structure, const MassPoints& points, double shift)
      : structure_{&structure}, columns_{points, shift} {}

  void solve(std::span<const FilterColumn> columns) override {
    of_structure_.resize(columns.size());
    for (std::size_t c = 0; c < columns.size(); ++c) {
      of_structure_[c] = columns_.of_structure(columns[c], c);
    }
    structure_->solve(of_structure_);
    for (const FilterColumn& column : columns) {
      if (column.stretch != nullptr) {
        columns_.complete(column.force, column.stretch);
      }
    }
  }

 private:
  ColumnSolver* structure_;
  StruckColumns columns_;
  std::vector<FilterColumn> of_structure_;
};

}  // namespace

StruckColumns::StruckColumns(const MassPoints& points, double shift) : points_{&points}, shift2_{shift * shift} {}

const double* StruckColumns::copy(const double* values, std::size_t column,
                                  std::vector<std::vector<double>>& copies) const {
  copies.resize(std::max(copies.size(), column + 1));
  copies[column].assign(values, values + points_->own_points());
  return copies[column].data();
}

const double* StruckColumns::displacement(const double* values, std::size_t column) {
  if (values == nullptr) {
    return nullptr;
  }
  copy(values, column, displacement_);
  each_own(*points_, [&](const Strike& strike, std::size_t centre, std::size_t gap) {
    displacement_[column][centre] = strike.node_of(values[centre], values[gap]);
    if (strike.of_nodes()) {
      displacement_[column][gap] = strike.other_of(values[centre], values[gap]);
    }
  });
  return displacement_[column].data();
}

const double* StruckColumns::force(const double* values, std::size_t column) {
  if (values == nullptr) {
    return nullptr;
  }
  copy(values, column, force_);
  each_own(*points_, [&](const Strike& strike, std::size_t centre, std::size_t gap) {
    force_[column][centre] = strike.force_on_node(values[centre], values[gap]);
    if (strike.of_nodes()) {
      force_[column][gap] = strike.force_on_other(values[centre], values[gap]);
    }
  });
  return force_[column].data();
}

FilterColumn StruckColumns::of_structure(FilterColumn column, std::size_t index) {
  column.displacement = displacement(column.displacement, index);
  column.force = force(column.force, index);
  return column;
}

void StruckColumns::complete(const double* force, double* stretch) const {
  each_own(*points_, [&](const Strike& strike, std::size_t centre, std::size_t gap) {
    const double of_node = stretch[centre];
    double of_other = strike.of_nodes() ? stretch[gap] : 0.0;
    if (!strike.of_nodes() && force != nullptr) {  // nothing ties a striker
      const double mass = strike.share * points_->mass()[centre];
      of_other = strike.force_on_other(force[centre], force[gap]) / (shift2_ * mass);
    }
    stretch[centre] = strike.centre_of(of_node, of_other);
    stretch[gap] = strike.gap_of(of_node, of_other);
  });
  for (const Rider& rider : points_->riders()) {  // what ties it to the line comes later
    if (points_->owns(rider.point)) {
      const auto point = static_cast<std::size_t>(rider.point - points_->begin());
      stretch[point] = force != nullptr ? force[point] / (shift2_ * rider.mass) : 0.0;
    }
  }
}

void StruckColumns::reduce(double* stretch) const {
  each_own(*points_, [&](const Strike& strike, std::size_t centre, std::size_t gap) {
    const double of_centre = stretch[centre];
    stretch[centre] = strike.node_of(of_centre, stretch[gap]);
    if (strike.of_nodes()) {
      stretch[gap] = strike.other_of(of_centre, stretch[gap]);
    }
  });
}

StruckOperator::StruckOperator(std::unique_ptr<FilterOperator> structure, const MassPoints& points, double shift)
    : structure_{std::move(structure)}, points_{&points}, shift_{shift}, columns_{points, shift} {}

void StruckOperator::right_hand_side(const FilterColumn& column, std::span<double> values) const {
  FilterColumn own = columns_.of_structure(column);
  structure_->right_hand_side(own, values);
}

void StruckOperator::extract(std::span<const double> unknowns, const FilterColumn& column) const {
  FilterColumn own = columns_.of_structure(column);
  structure_->extract(unknowns, own);
  if (column.stretch != nullptr) {
    columns_.complete(column.force, column.stretch);
  }
}

void StruckOperator::unknowns_of(const FilterColumn& column, std::span<double> unknowns) const {
  FilterColumn own = columns_.of_structure(column);
  std::vector<double> stretch(column.stretch, column.stretch + points_->points());
  columns_.reduce(stretch.data());
  own.stretch = stretch.data();
  structure_->unknowns_of(own, unknowns);
}

double StruckOperator::largest_unknown(const double* displacement) const {
  return structure_->largest_unknown(columns_.displacement(displacement));
}

/// What is kept for strikers behind the structure's own is not used.
std::span<const double> StruckOperator::own_internal(std::span<const double> internal) const {
  return internal.first(internal_numbers() * points_->own_points());
}

void StruckOperator::internal_of(const FilterColumn& column) {
  structure_->internal_of({.displacement = columns_.displacement(column.displacement), .internal = column.internal});
}

std::size_t StruckOperator::internal_places() const {
  return structure_->internal_places() + points_->points() - points_->own_points();
}

void StruckOperator::internal_values(std::span<const double> internal, std::span<double> values) const {
  std::vector<double> own(internal_fields().size() * structure_->internal_places());
  structure_->internal_values(own_internal(internal), own);
  std::ranges::fill(values, 0.0);
  for (std::size_t field = 0; field < internal_fields().size(); ++field) {
    const auto from = own.begin() + static_cast<std::ptrdiff_t>(field * structure_->internal_places());
    std::copy_n(from, structure_->internal_places(),
                values.begin() + static_cast<std::ptrdiff_t>(field * internal_places()));
  }
}

double StruckOperator::strain_energy(std::span<const double> displacement, std::span<const double> internal) const {
  return structure_->strain_energy({columns_.displacement(displacement.data()), points_->own_points()},
                                   own_internal(internal));
}

std::unique_ptr<ColumnSolver> StruckOperator::around(ColumnSolver& solver) const {
  return std::make_unique<StruckSolver>(solver, *points_, shift_);
}

std::unique_ptr<ColumnSolver> StruckOperator::with_springs(std::span<const ContactSpring> /*springs*/) const {
  throw InputError{"striker mass: contact of the line knows no strikers"};
}

double StruckOperator::points_moved_together(std::size_t /*point*/) const {
  throw InputError{"striker mass: contact of the line knows no strikers"};
}

}  // namespace udar
