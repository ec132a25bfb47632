#include "udar/app/model.hpp"

namespace udar::app {
namespace {

FilteredStructure& prepared(FilteredStructure& line, const std::function<void(FilteredStructure&)>& prepare) {
  if (prepare) {
    prepare(line);
  }
  return line;
}

}  // namespace

Model::Model(MPI_Comm comm, const Case& input, const std::function<void(FilteredStructure&)>& prepare)
    : beam{comm, input.beam},
      line{beam, input.filter},
      loads{beam, input.gravity, input.loads},
      equations{prepared(line, prepare), loads, input.initial, input.damping},
      input_{&input} {}

}  // namespace udar::app
