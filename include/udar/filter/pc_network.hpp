#pragma once
/// @file
/// The network solver as PETSc's preconditioner type `network`.

#include <petscpc.h>

#include "udar/filter/network_operator.hpp"
#include "udar/filter/network_solver.hpp"

namespace udar {

/// The name for `-pc_type`.
inline constexpr const char* kPcNetwork = "network";

/// @brief Registers the type `network`: an exact solve, for `KSPPREONLY` or inside any Krylov method.
///
/// The operator must be that of a network; any other is refused by name. Symmetric: the transpose is itself.
/// `KSPMatSolve` solves columns in batches of four. @note Not collective; may be called again.
[[nodiscard]] PetscErrorCode register_pc_network();

/// @brief Ties a matrix to the operator whose it is; both must live as long.
void compose_network(Mat matrix, const NetworkOperator& network);

/// @brief The solver inside a `PC` of type `network` that has been set up, null for other types.
[[nodiscard]] NetworkSolver* network_solver(PC pc);

}  // namespace udar
