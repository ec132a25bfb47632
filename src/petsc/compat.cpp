#include "udar/petsc/compat.hpp"

#include <petsc/private/tsimpl.h>

namespace udar::petsc {

void use_largest_error(TSAdapt adapt) { adapt->wnormtype = NORM_INFINITY; }

}  // namespace udar::petsc
