#pragma once
/// @file
/// Move-only owners of PETSc objects.

#include <petscksp.h>
#include <petsctao.h>
#include <petscts.h>

#include <utility>

namespace udar::petsc {

/// @brief Owns one PETSc object and destroys it once; converts to the raw handle wherever PETSc wants one.
/// @note Destruction is collective, as PETSc's `XxxDestroy` is, and does nothing after `PetscFinalize`.
template <class T, PetscErrorCode (*Destroy)(T*)>
class Handle {
 public:
  Handle() noexcept = default;
  explicit Handle(T owned) noexcept : object_{owned} {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  Handle(Handle&& other) noexcept : object_{std::exchange(other.object_, nullptr)} {}
  Handle& operator=(Handle&& other) noexcept {
    if (this != &other) {
      reset();
      object_ = std::exchange(other.object_, nullptr);
    }
    return *this;
  }
  ~Handle() { reset(); }

  /// The raw handle, still owned here.
  // NOLINTNEXTLINE(google-explicit-constructor): PETSc calls take the raw handle
  operator T() const noexcept { return object_; }
  /// Where a PETSc `XxxCreate` writes its result; what was owned before is destroyed.
  T* put() noexcept {
    reset();
    return &object_;
  }
  void reset() noexcept {
    PetscBool finalized = PETSC_FALSE;
    PetscFinalized(&finalized);
    if (object_ != nullptr && finalized == PETSC_FALSE) {
      Destroy(&object_);
    }
    object_ = nullptr;
  }

 private:
  T object_{nullptr};
};

using Vector = Handle<Vec, VecDestroy>;
using Matrix = Handle<Mat, MatDestroy>;
using IndexSet = Handle<IS, ISDestroy>;
using LinearSolver = Handle<KSP, KSPDestroy>;
using TimeStepper = Handle<TS, TSDestroy>;
using Optimizer = Handle<Tao, TaoDestroy>;

}  // namespace udar::petsc
