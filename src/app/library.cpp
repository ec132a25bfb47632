/// @file
/// What makes libudar a plug-in of any PETSc program: `-dll_append libudar.so -pc_type chain -ts_type
/// chebyshev`.

#include <array>

#include "udar/app/run.hpp"
#include "udar/filter/pc_chain.hpp"
#include "udar/filter/pc_network.hpp"
#include "udar/integrators/configure.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"

namespace udar::app {

void register_types() {
  // The line solver's, nested solvers and `filter_moment_` included; that of contact on the line.
  constexpr std::array kFilter{"ksp_",       "pc_",         "mat_",       "sub_",    "mg_",    "eps_",     "st_",
                               "redundant_", "fieldsplit_", "telescope_", "esteig_", "inner_", "schwarz_", "moment_"};
  constexpr std::array kContact{"tao_"};
  petsc::add_solver_prefix("filter_", kFilter);
  petsc::add_solver_prefix("contact_", kContact);
  for (const char* key : {"-ts_impact_moments", "-modal_modes", "-modal_retardation"}) {
    petsc::add_known_key(key);
  }
  UDAR_CALL(register_pc_chain());
  UDAR_CALL(register_pc_network());
  register_integrators();
}

}  // namespace udar::app

/// PETSc calls this by name, made of the library's, when it loads libudar.
PETSC_EXTERN PetscErrorCode PetscDLLibraryRegister_udar() {
  PetscFunctionBeginUser;
  PetscCall(udar::petsc::guarded(udar::app::register_types));
  PetscFunctionReturn(0);
}
