#pragma once
/// @file
/// Whether the filter pays for a structure.

#include "udar/filter/filtered_structure.hpp"

namespace udar {

/// @brief What a solve costs beside a product with the stiffness, which is what a step without a filter costs.
///
/// Without a filter explicit steps of 2 / w_max take w_max / 2 products a second of motion; the filter takes s wf
/// solves, s = 25 for `-ts_type impact` with 4 solves in a quarter of 1 / wf, and 4.5 for `-ts_type chebyshev` between
/// few impacts. It pays where w_max / wf > 2 s t_solve / t_product. Source: docs/imported.md, "Whether the filter pays"
struct FilterCost {
  double highest_frequency = 0.0;  ///< w_max of the structure without a filter [rad/s]
  double solve_time = 0.0;         ///< of one column [s]
  double batch_time = 0.0;         ///< of one column of four solved together [s]
  double product_time = 0.0;       ///< with the operator [s]
  double factor_nonzeros = 0.0;    ///< of all ranks; 0: the solver does not tell

  static constexpr double kImpactSolves = 25.0;
  static constexpr double kChebyshevSolves = 4.5;
  /// The least w_max / wf with which the filter pays. @param solves s, see above
  [[nodiscard]] double break_even(double solves) const { return 2.0 * solves * solve_time / product_time; }
};

/// @brief Highest frequency of a structure without a filter [rad/s], by SLEPc's Lanczos method on M^(-1/2) C M^(-1/2),
/// from which unknowns without mass are eliminated, to 1e-3 of it; of a network as `Network::highest_frequency`.
/// @param structure not a chain @note Collective. @throws SolveError if SLEPc does not converge
[[nodiscard]] double highest_frequency(const Structure& structure);

/// @brief Measures on an idle structure that is no chain, the least of eleven of each.
/// @note Collective. @throws SolveError as a solve
[[nodiscard]] FilterCost measure_cost(FilteredStructure& structure);

}  // namespace udar
