/// @file
/// What makes libudar a plug-in of any PETSc program: `-dll_append libudar.so -pc_type chain`.

#include "udar/filter/pc_chain.hpp"

/// PETSc calls this by name, made of the library's, when it loads libudar.
PETSC_EXTERN PetscErrorCode PetscDLLibraryRegister_udar() { return udar::register_pc_chain(); }
