#pragma once
/// @file
/// The chain solver as PETSc's preconditioner type `chain`.

#include <petscpc.h>

#include "udar/filter/chain_solver.hpp"

namespace udar {

/// The name for `-pc_type`.
inline constexpr const char* kPcChain = "chain";

/// @brief Registers the type `chain`: an exact solve, for `KSPPREONLY` or inside any Krylov method.
///
/// The operator must carry its line (`compose_line`); any other is refused by name. Symmetric: the transpose is itself.
/// `KSPMatSolve` solves columns in batches of four. @note Not collective; may be called again.
/// Options: `-pc_chain_lanes` 0, 1, 4 or 8 spans side by side in a vector register, 0: what the processor has.
[[nodiscard]] PetscErrorCode register_pc_chain();

/// @brief The solver inside a `PC` of type `chain` that has been set up, null for other types.
[[nodiscard]] ChainSolver* chain_solver(PC pc);

}  // namespace udar
