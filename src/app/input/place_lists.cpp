#include <algorithm>
#include <iterator>

#include "app/input/readers.hpp"
#include "udar/petsc/error.hpp"

namespace udar::app {

std::vector<Place> read_places(petsc::OptionGroup& group, const PlaceKeys& keys, const StructureInput& structure) {
  Numbers position;
  Numbers place;
  std::vector<std::string> junctions;
  if (keys.position[0] != nullptr) {
    group.reals(keys.position[0], position, "m", petsc::any(), keys.position[1]);
  }
  group.reals(keys.place[0], place, "m", petsc::any(), keys.place[1]);
  group.strings(keys.junction[0], junctions, keys.junction[1]);
  if (structure.beam() && !(place.empty() && junctions.empty())) {
    throw InputError{std::string{"options "} + keys.place[0] + " and " + keys.junction[0] +
                     " are not for a beam, expected " +
                     (keys.position[0] != nullptr ? std::string{keys.position[0]} + " [m]"
                                                  : std::string{"-structure_type network or imported"})};
  }
  if (place.size() % 3 != 0) {
    throw InputError{std::string{"option "} + keys.place[0] + ": " + std::to_string(place.size()) +
                     " values given, expected three for each " + keys.thing + ": x,y,z [m]"};
  }
  std::vector<Place> all;
  std::ranges::transform(position, std::back_inserter(all), [](double x) { return Place{.x = x}; });
  for (std::size_t i = 0; i < place.size(); i += 3) {
    all.push_back({.x = place[i], .y = place[i + 1], .z = place[i + 2]});
  }
  for (const std::string& name : junctions) {
    all.push_back(junction_place(keys.junction[0], name, structure.network));
  }
  return all;
}

}  // namespace udar::app
