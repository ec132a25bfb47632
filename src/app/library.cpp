/// @file
/// What makes libudar a plug-in of any PETSc program: `-dll_append libudar.so -pc_type chain -ts_type
/// chebyshev`.

#include "udar/dynamics/ts_chebyshev.hpp"
#include "udar/dynamics/ts_impact.hpp"
#include "udar/dynamics/ts_moreau.hpp"
#include "udar/filter/pc_chain.hpp"

/// PETSc calls this by name, made of the library's, when it loads libudar.
PETSC_EXTERN PetscErrorCode PetscDLLibraryRegister_udar() {
  PetscFunctionBeginUser;
  PetscCall(udar::register_pc_chain());
  PetscCall(udar::register_ts_chebyshev());
  PetscCall(udar::register_ts_impact());
  PetscCall(udar::register_ts_moreau());
  PetscFunctionReturn(0);
}
