#include "udar/petsc/time_integrator.hpp"

#include <petsc/private/tsimpl.h>

#include "udar/petsc/error.hpp"

namespace udar::petsc {
namespace {

TimeIntegrator* inside(TS stepper) { return static_cast<TimeIntegrator*>(stepper->data); }

PetscErrorCode set_from_options(TS stepper, PetscOptionItems* items) {
  return guarded([&] { inside(stepper)->set_from_options(stepper, items); });
}

PetscErrorCode set_up(TS stepper) {
  return guarded([&] {
    TSAdapt adapt = nullptr;
    UDAR_CALL(TSGetAdapt(stepper, &adapt));
    UDAR_CALL(TSAdaptCandidatesClear(adapt));
    inside(stepper)->set_up(stepper);
  });
}

PetscErrorCode step(TS stepper) {
  return guarded([&] { inside(stepper)->step(stepper); });
}

PetscErrorCode roll_back(TS stepper) {
  return guarded([&] { inside(stepper)->roll_back(stepper); });
}

PetscErrorCode interpolate(TS stepper, PetscReal time, Vec solution) {
  return guarded([&] { inside(stepper)->interpolate(stepper, time, solution); });
}

PetscErrorCode error_norm(TS stepper, NormType /*type*/, PetscInt* order, PetscReal* norm) {
  PetscFunctionBeginUser;
  const TimeIntegrator::Error error = inside(stepper)->error();
  *norm = error.norm;
  if (order != nullptr) {
    *order = error.order;
  }
  PetscFunctionReturn(0);
}

PetscErrorCode view(TS stepper, PetscViewer viewer) {
  return guarded([&] {
    PetscBool text = PETSC_FALSE;
    UDAR_CALL(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(viewer), PETSCVIEWERASCII, &text));
    if (text == PETSC_TRUE) {
      inside(stepper)->view(stepper, viewer);
    }
  });
}

PetscErrorCode destroy(TS stepper) {
  PetscFunctionBeginUser;
  delete inside(stepper);  // NOLINT(cppcoreguidelines-owning-memory): PETSc's structure has owned it since `attach`
  stepper->data = nullptr;
  PetscFunctionReturn(0);
}

}  // namespace

PetscErrorCode attach(TS stepper, std::unique_ptr<TimeIntegrator> implementation) {
  PetscFunctionBeginUser;
  stepper->data = implementation.release();
  stepper->ops->setfromoptions = set_from_options;
  stepper->ops->setup = set_up;
  stepper->ops->step = step;
  stepper->ops->rollback = roll_back;
  stepper->ops->interpolate = interpolate;
  stepper->ops->evaluatewlte = error_norm;
  stepper->ops->view = view;
  stepper->ops->destroy = destroy;
  stepper->usessnes = PETSC_FALSE;
  stepper->default_adapt_type = TSADAPTBASIC;
  PetscFunctionReturn(0);
}

TimeIntegrator* attached(TS stepper) {
  return stepper->ops->step == step ? static_cast<TimeIntegrator*>(stepper->data) : nullptr;
}

Judgement judge_step(TS stepper, double length) {
  TSAdapt adapt = nullptr;
  PetscBool accepted = PETSC_FALSE;
  double next = length;
  UDAR_CALL(TSGetAdapt(stepper, &adapt));
  UDAR_CALL(TSAdaptCandidatesClear(adapt));
  UDAR_CALL(TSAdaptCandidateAdd(adapt, nullptr, inside(stepper)->error().order, 1, 1.0, 1.0, PETSC_TRUE));
  UDAR_CALL(TSAdaptChoose(adapt, stepper, length, nullptr, &next, &accepted));
  return {.accepted = accepted == PETSC_TRUE, .next_step = next};
}

void count_rejection(TS stepper) { ++stepper->reject; }

}  // namespace udar::petsc
