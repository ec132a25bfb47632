#include "udar/app/assembly.hpp"

namespace udar::app {
namespace {

FilteredLine& prepared(FilteredLine& line, const std::function<void(FilteredLine&)>& prepare) {
  if (prepare) {
    prepare(line);
  }
  return line;
}

}  // namespace

Assembly::Assembly(MPI_Comm comm, const Case& input, const std::function<void(FilteredLine&)>& prepare)
    : beam{comm, input.beam},
      line{beam, input.filter},
      loads{beam, input.gravity, input.loads},
      equations{prepared(line, prepare), loads, input.initial, input.damping},
      input_{&input} {}

}  // namespace udar::app
