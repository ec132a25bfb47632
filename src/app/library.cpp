/// @file
/// What makes libudar a plug-in of any PETSc program: `-dll_append libudar.so -pc_type chain -ts_type
/// chebyshev`.

#include "udar/app/run.hpp"
#include "udar/filter/pc_chain.hpp"
#include "udar/integrators/configure.hpp"
#include "udar/petsc/error.hpp"

namespace udar::app {

void register_types() {
  UDAR_CALL(register_pc_chain());
  register_integrators();
}

}  // namespace udar::app

/// PETSc calls this by name, made of the library's, when it loads libudar.
PETSC_EXTERN PetscErrorCode PetscDLLibraryRegister_udar() {
  PetscFunctionBeginUser;
  PetscCall(udar::petsc::guarded(udar::app::register_types));
  PetscFunctionReturn(0);
}
