#pragma once
/// @file
/// wf^2 M + C of any structure: what the filter's solvers and checks must know of it.

#include <petscmat.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "udar/filter/filter_column.hpp"
#include "udar/filter/line_data.hpp"
#include "udar/structure/field.hpp"

namespace udar {

class Structure;

/// @brief How the bending line is discretised; both describe the same line.
enum class Formulation : std::uint8_t {
  mixed,    ///< displacement and moment (three-moment equation), keeps its digits on fine meshes
  hermite,  ///< displacement and rotation, for comparison
};

/// @brief What shapes a `FilteredStructure`.
struct FilterParameters {
  double filter_frequency = 0.0;  ///< wf [rad/s], > 0; infinite: no filter, the masses are the structure's own
  Formulation formulation = Formulation::mixed;
  PetscInt check_interval = 50;      ///< every so many solves the residual is computed; 0: never
  double residual_tolerance = 1e-8;  ///< largest normwise backward error that passes the check [-]
  double step = 0.0;                 ///< of the integrator that goes without filter [s]

  [[nodiscard]] bool filtered() const noexcept { return !std::isinf(filter_frequency); }
  /// w of the operator w^2 M + C [rad/s]: wf, without filter 2 / step.
  [[nodiscard]] double shift() const noexcept { return filtered() ? filter_frequency : 2.0 / step; }
};

/// @brief Solves for whole columns without a right-hand side in between.
class ColumnSolver {
 public:
  ColumnSolver(const ColumnSolver&) = delete;
  ColumnSolver& operator=(const ColumnSolver&) = delete;
  virtual ~ColumnSolver() = default;
  /// @brief Solves for every column: all of one kind, with the same arrays given. @note Collective.
  virtual void solve(std::span<const FilterColumn> columns) = 0;

 protected:
  ColumnSolver() = default;
};

/// @brief A spring between a point of the structure and the end that a column displaces.
struct ContactSpring {
  std::size_t point = 0;   ///< local
  double stiffness = 0.0;  ///< [N/m], > 0
};

/// @brief The operator wf^2 M + C in unknowns of its own, which are scaled to a diagonal near one; an unknown that is
/// not there has the row of the identity.
///
/// A column is what every structure understands: displacements of the masses and forces in, stretch of the filter
/// springs and internal forces out, one value per local point. Source: docs/theory.md, "The discrete line".
class FilterOperator {
 public:
  FilterOperator(const FilterOperator&) = delete;
  FilterOperator& operator=(const FilterOperator&) = delete;
  virtual ~FilterOperator() = default;

  [[nodiscard]] virtual MPI_Comm comm() const = 0;
  [[nodiscard]] virtual std::span<const double> mass() const = 0;  ///< [kg], local points
  [[nodiscard]] virtual std::size_t unknowns() const = 0;          ///< local rows

  /// The product, without rounding of rigid motions where the structure allows that.
  [[nodiscard]] virtual Mat op() const = 0;
  /// The same assembled, on first demand. @note Collective.
  [[nodiscard]] virtual Mat matrix() = 0;
  /// Infinity norm of the matrix [-]. @note Collective.
  [[nodiscard]] virtual double norm() const = 0;

  /// @brief Right-hand side of a column's displacement and force. @param[out] values this rank's rows
  /// @note Collective: one message to each neighbour at most.
  virtual void right_hand_side(const FilterColumn& column, std::span<double> values) const = 0;
  /// @brief Stretch and, if wanted, internal forces from the unknowns. @note Collective as `right_hand_side`.
  virtual void extract(std::span<const double> unknowns, const FilterColumn& column) const = 0;
  /// @brief The unknowns of a column whose stretch and internal forces are known. @param[out] unknowns local
  /// @note Only of an operator that gives its `line`.
  virtual void unknowns_of(const FilterColumn& column, std::span<double> unknowns) const = 0;
  /// Largest of given displacements [m] in units of the unknowns [-], local points.
  [[nodiscard]] virtual double largest_unknown(const double* displacement) const = 0;

  /// Numbers that `FilterColumn::internal` has per point.
  [[nodiscard]] virtual std::size_t internal_numbers() const = 0;
  /// @brief Internal forces where the structure stands at given places. @param column displacement, of the line Yc [m],
  /// and kink in, internal forces out
  /// @note Collective: a solve. @throws InputError if this operator cannot; SolveError if the solve diverges
  virtual void internal_of(const FilterColumn& column) = 0;
  /// What snapshots show of them.
  [[nodiscard]] virtual std::span<const FieldInfo> internal_fields() const = 0;
  /// How many numbers a field takes: local points, or cells if there are more.
  [[nodiscard]] virtual std::size_t internal_places() const { return mass().size(); }
  /// @brief Values of these fields. @param[out] values `internal_places` of each, field by field
  /// @note Collective: one message to each neighbour at most.
  virtual void internal_values(std::span<const double> internal, std::span<double> values) const = 0;
  /// @brief Elastic energy [J], this rank's share. @param[in] displacement Yc minus the stress-free place [m], local
  /// points @note Collective: one message to each neighbour at most.
  [[nodiscard]] virtual double strain_energy(std::span<const double> displacement,
                                             std::span<const double> internal) const = 0;

  /// What the chain solver needs, null of an operator that it cannot carry.
  [[nodiscard]] virtual const LineData* line() const = 0;
  /// The type of the `PC` that solves for whole columns, where one can.
  [[nodiscard]] virtual const char* solver_type() const;
  /// Why none can: "tension", "Hermite form", or empty.
  [[nodiscard]] virtual std::string block_form_reason() const = 0;
  /// Whether the matrix is positive definite, so that Cholesky is its solver by default.
  [[nodiscard]] virtual bool definite() const = 0;
  /// A solver of its columns around one of the operator's; null: that one serves as it is.
  [[nodiscard]] virtual std::unique_ptr<ColumnSolver> around(ColumnSolver& /*solver*/) const { return nullptr; }
  /// @brief A solver for the structure in which contact springs take the place of the filter's at their points: those
  /// of the filter hold the structure to ground there, and the stretch is that of the contact springs.
  /// @param springs by ascending point; several at a point add up @note Collective; factors.
  /// @throws InputError unless the operator gives its `line`
  [[nodiscard]] virtual std::unique_ptr<ColumnSolver> with_springs(std::span<const ContactSpring> springs) const = 0;
  /// How many points, at least 1, a force on this one moves together: the decay length of the filtered structure over
  /// its mesh width. @throws InputError unless the operator gives its `line`
  [[nodiscard]] virtual double points_moved_together(std::size_t point) const = 0;

 protected:
  FilterOperator() = default;
};

/// @brief The operator of a structure, which must live as long: of a chain `MixedLine` or `HermiteLine`, else
/// `AssembledOperator`. @note Collective. @throws InputError if it cannot give what is asked for
[[nodiscard]] std::unique_ptr<FilterOperator> make_operator(const Structure& structure,
                                                            const FilterParameters& parameters);

}  // namespace udar
