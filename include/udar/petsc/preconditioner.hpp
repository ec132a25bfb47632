#pragma once
/// @file
/// Preconditioners of our own as PETSc types.

#include <petscpc.h>

#include <memory>
#include <span>

#include "udar/petsc/log.hpp"

namespace udar::petsc {

/// @brief What a registered `PC` type does. Members may throw; PETSc sees error codes.
class Preconditioner {
 public:
  Preconditioner() = default;
  Preconditioner(const Preconditioner&) = delete;
  Preconditioner& operator=(const Preconditioner&) = delete;
  virtual ~Preconditioner() = default;

  /// Reads options. @param pc for the options prefix
  virtual void set_from_options(PC pc) = 0;
  /// @param amat, pmat the operators of the `PC`
  virtual void set_up(Mat amat, Mat pmat) = 0;
  /// A right-hand side and where its solution goes, local values.
  struct Column {
    const double* right;
    double* solution;
  };
  /// @param columns one, or those of a block that are solved for at once
  virtual void apply(std::span<const Column> columns) = 0;
  /// @param viewer ASCII
  virtual void view(PetscViewer viewer) const = 0;
};

/// @brief Makes `implementation` the inside of a symmetric `PC`; for `PCRegister`'s creation function.
[[nodiscard]] PetscErrorCode attach(PC pc, std::unique_ptr<Preconditioner> implementation);

/// @brief The inside of a `PC` made by `attach`.
[[nodiscard]] Preconditioner* attached(PC pc);

/// @brief Registers `Type` under a name for `-pc_type`. May be called again. @note Not collective.
template <class Type>
[[nodiscard]] PetscErrorCode register_preconditioner(const char* name) {
  PetscFunctionBeginUser;
  PetscCall(register_log_events());
  PetscCall(PCRegister(name, [](PC pc) { return attach(pc, std::make_unique<Type>()); }));
  PetscFunctionReturn(0);
}

}  // namespace udar::petsc
