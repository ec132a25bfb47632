#include "udar/app/network_size.hpp"

#include <algorithm>
#include <array>
#include <sstream>
#include <utility>

namespace udar::app {

NetworkSize size_of(const Network& network) {
  const NetworkParameters& parameters = network.parameters();
  NetworkSize size{.junctions = parameters.junctions.size(), .members = parameters.members.size(), .extent = {}};
  for (std::size_t member = 0; member < parameters.members.size(); ++member) {
    const MemberKind& kind = network.kinds()[network.kind(member)];
    size.elements += kind.elements;
    size.unequal += kind.equal_elements() ? 0 : 1;
    size.shortest = member == 0 ? kind.shortest() : std::min(size.shortest, kind.shortest());
  }
  std::ostringstream text;
  text.precision(4);
  constexpr std::array kAxes{std::pair{"x ", &Place::x}, std::pair{", y ", &Place::y}, std::pair{", z ", &Place::z}};
  for (const auto& [name, axis] : kAxes) {
    const auto [least, most] = std::ranges::minmax(
        parameters.junctions, {}, [along = axis](const Junction& junction) { return junction.place.*along; });
    text << name << least.place.*axis << " to " << most.place.*axis << " m";
  }
  size.extent = text.str();
  return size;
}

}  // namespace udar::app
