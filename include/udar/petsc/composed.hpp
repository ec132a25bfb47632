#pragma once
/// @file
/// Objects of ours that travel with PETSc objects.

#include <petscsys.h>

namespace udar::petsc {

/// @brief Composes a pointer with a PETSc object under a name; null if there is none.
void compose_pointer(PetscObject object, const char* name, const void* pointer);
[[nodiscard]] void* composed_pointer(PetscObject object, const char* name);

/// @brief Lets `value`, which must outlive its use, be found through `object`. @see `composed`
template <class Value>
void compose(PetscObject object, const char* name, const Value& value) {
  compose_pointer(object, name, &value);
}

/// @brief What `compose` put there; null if nothing. `Value` must be the type that was composed.
template <class Value>
[[nodiscard]] const Value* composed(PetscObject object, const char* name) {
  return static_cast<const Value*>(composed_pointer(object, name));
}

}  // namespace udar::petsc
