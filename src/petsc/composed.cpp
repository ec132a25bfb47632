#include "udar/petsc/composed.hpp"

#include "udar/petsc/error.hpp"
#include "udar/petsc/handle.hpp"

namespace udar::petsc {

void compose_pointer(PetscObject object, const char* name, const void* pointer) {
  Handle<PetscContainer, PetscContainerDestroy> container;
  UDAR_CALL(PetscContainerCreate(PetscObjectComm(object), container.put()));
  UDAR_CALL(PetscContainerSetPointer(container, const_cast<void*>(pointer)));
  UDAR_CALL(PetscObjectCompose(object, name, reinterpret_cast<PetscObject>(static_cast<PetscContainer>(container))));
}

void* composed_pointer(PetscObject object, const char* name) {
  PetscObject found = nullptr;
  void* pointer = nullptr;
  UDAR_CALL(PetscObjectQuery(object, name, &found));
  if (found != nullptr) {
    UDAR_CALL(PetscContainerGetPointer(reinterpret_cast<PetscContainer>(found), &pointer));
  }
  return pointer;
}

}  // namespace udar::petsc
