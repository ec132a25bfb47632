/* A PETSc program that knows nothing of udar: heat conduction along a rod, solved as the options say. */
#include <petscts.h>

int main(int argc, char** argv) {
  const PetscInt size = 10;
  PetscInt begin = 0;
  PetscInt end = 0;
  Mat matrix = NULL;
  Vec right = NULL;
  Vec solution = NULL;
  KSP solver = NULL;
  TS stepper = NULL;
  PetscBool stepped = PETSC_FALSE;
  PetscLogEvent event = -1;

  PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
  PetscCall(MatCreateAIJ(PETSC_COMM_WORLD, PETSC_DECIDE, PETSC_DECIDE, size, size, 3, NULL, 2, NULL, &matrix));
  PetscCall(PetscObjectSetName((PetscObject)matrix, "heat"));
  PetscCall(MatGetOwnershipRange(matrix, &begin, &end));
  for (PetscInt row = begin; row < end; ++row) {
    const PetscInt columns[3] = {row - 1, row, row + 1 < size ? row + 1 : -1}; /* -1: left out */
    const PetscScalar values[3] = {-1.0, 2.0, -1.0};
    PetscCall(MatSetValues(matrix, 1, &row, 3, columns, values, INSERT_VALUES));
  }
  PetscCall(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  PetscCall(MatCreateVecs(matrix, &solution, &right));
  PetscCall(VecSet(right, 1.0));
  PetscCall(KSPCreate(PETSC_COMM_WORLD, &solver));
  PetscCall(KSPSetOperators(solver, matrix, matrix));
  PetscCall(KSPSetFromOptions(solver));
  PetscCall(KSPSolve(solver, right, solution));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "solved\n"));
  PetscCall(PetscLogEventGetId("FilterSolve", &event));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "log event of udar: %s\n", event >= 0 ? "yes" : "no"));
  PetscCall(PetscOptionsHasName(NULL, NULL, "-ts_type", &stepped));
  if (stepped) {
    PetscCall(TSCreate(PETSC_COMM_WORLD, &stepper));
    PetscCall(TSSetSolution(stepper, solution));
    PetscCall(TSSetFromOptions(stepper));
    PetscCall(TSSetUp(stepper));
  }
  PetscCall(TSDestroy(&stepper));
  PetscCall(KSPDestroy(&solver));
  PetscCall(VecDestroy(&solution));
  PetscCall(VecDestroy(&right));
  PetscCall(MatDestroy(&matrix));
  PetscCall(PetscFinalize());
  return 0;
}
