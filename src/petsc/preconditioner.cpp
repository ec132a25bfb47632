#include "udar/petsc/preconditioner.hpp"

#include <petsc/private/pcimpl.h>

#include <vector>

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
  return guarded([&] {
    Preconditioner::Column column{};
    UDAR_CALL(VecGetArrayRead(right, &column.right));
    UDAR_CALL(VecGetArrayWrite(solution, &column.solution));
    attached(pc)->apply({&column, 1});
    UDAR_CALL(VecRestoreArrayWrite(solution, &column.solution));
    UDAR_CALL(VecRestoreArrayRead(right, &column.right));
  });
}

PetscErrorCode apply_to_columns(PC pc, Mat right, Mat solution) {
  return guarded([&] {
    PetscInt count = 0;
    PetscInt right_pitch = 0;
    PetscInt solution_pitch = 0;
    const double* from = nullptr;
    double* to = nullptr;
    UDAR_CALL(MatGetSize(right, nullptr, &count));
    UDAR_CALL(MatDenseGetLDA(right, &right_pitch));
    UDAR_CALL(MatDenseGetLDA(solution, &solution_pitch));
    UDAR_CALL(MatDenseGetArrayRead(right, &from));
    UDAR_CALL(MatDenseGetArrayWrite(solution, &to));
    std::vector<Preconditioner::Column> columns;
    columns.reserve(static_cast<std::size_t>(count));
    for (PetscInt c = 0; c < count; ++c) {
      columns.push_back({.right = from + c * right_pitch, .solution = to + c * solution_pitch});
    }
    attached(pc)->apply(columns);
    UDAR_CALL(MatDenseRestoreArrayWrite(solution, &to));
    UDAR_CALL(MatDenseRestoreArrayRead(right, &from));
  });
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
