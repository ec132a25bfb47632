#include "udar/petsc/option_set.hpp"

#include <utility>

#include "udar/petsc/error.hpp"

namespace udar::petsc {

OptionSet::OptionSet() { UDAR_CALL(PetscOptionsCreate(&options_)); }

OptionSet::~OptionSet() {
  PetscBool finalized = PETSC_FALSE;
  PetscFinalized(&finalized);
  if (finalized == PETSC_FALSE) {
    PetscOptionsDestroy(&options_);
  }
}

OptionSet::InForce::InForce(OptionSet& set) : set_{&set} {
  UDAR_CALL(PetscOptionsPush(set.options_));
  std::swap(option_origins(), set.origins_);
}

OptionSet::InForce::~InForce() {
  std::swap(option_origins(), set_->origins_);
  PetscOptionsPop();
}

}  // namespace udar::petsc
