#include "udar/app/case.hpp"

#include "app/input/readers.hpp"
#include "udar/petsc/error.hpp"

namespace udar::app {

ModelParameters Case::model() const {
  return {.beam = beam,
          .filter = filter,
          .gravity = gravity,
          .loads = loads,
          .damping = damping,
          .initial = initial,
          .supports = supports,
          .contact = contact};
}

Case read_case(MPI_Comm comm) {
  Case input;
  Formulation formulation = Formulation::mixed;
  input.beam = read_beam(comm, formulation);
  input.filter = read_filter(comm, formulation);
  read_initial(comm, input);
  read_contact(comm, input);
  read_output(comm, input);
  read_integration(comm, input);
  if (input.contact.surface == ContactSurface::line &&
      (input.filter.correct_lowest > 0 || !input.filter.correct.empty())) {
    throw InputError{
        "options -filter_correct_modes and -filter_correct_mode are not for -contact_surface line: in these modes the "
        "line is tied rigidly to the masses and would hit with them"};
  }
  return input;
}

}  // namespace udar::app
