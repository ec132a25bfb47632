#include "udar/structure/network_place.hpp"

#include <algorithm>
#include <cmath>

#include "structure/member_frame.hpp"
#include "structure/place_algebra.hpp"

namespace udar {
namespace {

Place turned(const Place& place, const Place& angles) {
  const auto about = [](double angle, double& first, double& second) {
    const double before = first;
    first = std::cos(angle) * before - std::sin(angle) * second;
    second = std::sin(angle) * before + std::cos(angle) * second;
  };
  Place now = place;
  about(angles.x, now.y, now.z);
  about(angles.y, now.z, now.x);
  about(angles.z, now.x, now.y);
  return now;
}

}  // namespace

void place_network(NetworkParameters& network, const Place& angles, const Place& shift) {
  if (norm(angles) > 0.0) {
    for (Member& member : network.members) {
      // Where there are no such axes the network says so.
      if (norm(span_of(network, member)) > 0.0 && !orientation_is_parallel(network, member)) {
        member.orientation = turned(place_of(axes_of(network, member)[1]), angles);
      }
    }
    for (Member& member : network.members) {
      for (MemberEnd& end : member.ends) {
        end.offset = turned(end.offset, angles);
      }
    }
    for (Junction& junction : network.junctions) {
      junction.place = turned(junction.place, angles);
    }
  }
  for (Junction& junction : network.junctions) {
    junction.place = junction.place + shift;
  }
}

std::vector<Place> node_places(const NetworkParameters& network) {
  std::vector<Place> places;
  places.reserve(network.junctions.size());
  for (const Junction& junction : network.junctions) {
    places.push_back(junction.place);
  }
  for (const Member& member : network.members) {
    const Place from = end_place(network, member, 0);
    const Place span = span_of(network, member);
    for (const double share : node_shares(member)) {
      places.push_back(from + share * span);
    }
  }
  return places;
}

std::vector<std::array<std::size_t, 2>> paired_nodes(const NetworkParameters& network,
                                                     std::span<const NodePair> pairs) {
  const std::vector<Place> places = pairs.empty() ? std::vector<Place>{} : node_places(network);
  const auto nearest = [&](const Place& at) {
    const auto away = [&](const Place& node) { return norm(node - at); };
    return static_cast<std::size_t>(std::ranges::min_element(places, {}, away) - places.begin());
  };
  std::vector<std::array<std::size_t, 2>> together;
  for (const NodePair& pair : pairs) {
    together.push_back({nearest(pair.from), nearest(pair.to)});
  }
  return together;
}

}  // namespace udar
