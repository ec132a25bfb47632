#include "udar/petsc/preconditioner.hpp"

#include <petsc/private/pcimpl.h>

#include "udar/petsc/error.hpp"

namespace udar::petsc {
namespace {

PetscErrorCode set_from_options(PC pc, PetscOptionItems* /*items*/) {
  return guarded([&] { attached(pc)->set_from_options(pc); });
}

PetscErrorCode set_up(PC pc) {
  return guarded([&] { attached(pc)->set_up(pc->mat, pc->pmat); });
}

PetscErrorCode apply(PC pc, Vec right, Vec solution) {
  return guarded([&] { attached(pc)->apply(right, solution); });
}

PetscErrorCode apply_to_columns(PC pc, Mat right, Mat solution) {
  return guarded([&] { attached(pc)->apply(right, solution); });
}

PetscErrorCode view(PC pc, PetscViewer viewer) {
  return guarded([&] {
    PetscBool text = PETSC_FALSE;
    UDAR_CALL(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(viewer), PETSCVIEWERASCII, &text));
    if (text == PETSC_TRUE) {
      attached(pc)->view(viewer);
    }
  });
}

PetscErrorCode destroy(PC pc) {
  PetscFunctionBeginUser;
  delete attached(pc);  // NOLINT(cppcoreguidelines-owning-memory): PETSc's structure has owned it since `attach`
  pc->data = nullptr;
  PetscFunctionReturn(0);
}

}  // namespace

PetscErrorCode attach(PC pc, std::unique_ptr<Preconditioner> implementation) {
  PetscFunctionBeginUser;
  pc->data = implementation.release();
  pc->ops->setfromoptions = set_from_options;
  pc->ops->setup = set_up;
  pc->ops->apply = apply;
  pc->ops->applytranspose = apply;
  pc->ops->matapply = apply_to_columns;
  pc->ops->view = view;
  pc->ops->destroy = destroy;
  PetscFunctionReturn(0);
}

Preconditioner* attached(PC pc) { return static_cast<Preconditioner*>(pc->data); }

}  // namespace udar::petsc
