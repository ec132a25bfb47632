#pragma once
/// @file
/// What differs between PETSc versions, and the few settings that PETSc offers on the command line only.

#include <petscts.h>

namespace udar::petsc {

/// @brief Lets the step control judge a step by its largest scaled error instead of the mean square.
///
/// The mean square dilutes what happens at a few masses near a support by the size of the whole beam. PETSc 3.18 offers
/// this on the command line only (`-ts_adapt_wnormtype`); call before `TSSetFromOptions`.
void use_largest_error(TSAdapt adapt);

}  // namespace udar::petsc
