#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

#include "app/input/contact_laws.hpp"
#include "app/input/readers.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"

namespace udar::app {
namespace {

constexpr const char* kPerPair = "one per pair of nodes, -pair_from_place, -pair_from_junction";

constexpr PlaceKeys kFrom{
    .position = {nullptr, nullptr},
    .place = {"-pair_from_place",
              "for a structure in space: the first node of a pair that can touch, x,y,z of the first pair, then of the "
              "second, ...: the nearest node, which no support may touch"},
    .junction = {"-pair_from_junction", "for a network: first nodes of more pairs, names of junctions"},
    .thing = "pair"};
constexpr PlaceKeys kTo{
    .position = {nullptr, nullptr},
    .place = {"-pair_to_place", "the second node of each pair, in the same way"},
    .junction = {"-pair_to_junction", "for a network: second nodes of more pairs, names of junctions"},
    .thing = "pair"};

constexpr LawKeys kLawsOfPairs{.law = "-pair_law",
                               .stiffness = "-pair_stiffness",
                               .exponent = "-pair_exponent",
                               .damping = "-pair_damping",
                               .unloading = "-pair_unloading_stiffness",
                               .plateau = "-pair_plateau_force",
                               .bottoming = "-pair_bottoming_compression",
                               .bottoming_stiffness = "-pair_bottoming_stiffness",
                               .table = "-pair_table",
                               .preload = nullptr,
                               .quantity = "pair",
                               .thing = "pair",
                               .per_thing = kPerPair};

/// Of one pair, three numbers for each or three for all.
Place normal_of(const Numbers& given, std::size_t pair) {
  const std::size_t first = given.size() == 3 ? 0 : 3 * pair;
  const Place normal{.x = given[first], .y = given[first + 1], .z = given[first + 2]};
  const double size = std::hypot(normal.x, normal.y, normal.z);
  if (!(size > 0.0)) {
    throw InputError{
        "option -pair_normal: 0,0,0 is not allowed, expected a direction, 1,0,0, 0,1,0 or 0,0,1, or one "
        "of these turned round"};
  }
  // Adding 0 makes 0 of -0.
  return {.x = normal.x / size + 0.0, .y = normal.y / size + 0.0, .z = normal.z / size + 0.0};
}

}  // namespace

std::pair<std::vector<NodePair>, std::vector<Support>> read_pairs(MPI_Comm comm, const StructureInput& structure,
                                                                  std::size_t strikers) {
  petsc::OptionGroup group{
      comm, "Pairs of nodes that touch across a gap (parts of a structure; lists: one entry per pair, or one for all)"};
  Numbers normal{0.0, 1.0, 0.0};
  NumberList gap{"-pair_gap", {0.0}};
  NumberList restitution{"-pair_restitution", {1.0}};
  NumberList yield_speed{"-pair_yield_speed", {std::numeric_limits<double>::infinity()}};
  LawLists laws{kLawsOfPairs};
  const std::vector<Place> from = read_places(group, kFrom, structure);
  const std::vector<Place> to = read_places(group, kTo, structure);
  const bool turned = group.reals("-pair_normal", normal, "-", petsc::any(),
                                  "from the first node to the second, three numbers for each pair or all of them, "
                                  "along x, y or z: 0,1,0 where the second is above");
  gap.read(group, "m", petsc::non_negative(), "between the two at the start, wherever the axes of their members are");
  restitution.read(group, "-", petsc::between(0.0, 1.0), "of the velocity between the two, v+ = -e v-");
  yield_speed.read(group, "m/s", petsc::positive_or_infinite(),
                   "speed above which restitution falls, e (v / v_y)^(-1/4); inf: it does not");
  laws.read(group);
  const std::size_t count = from.size();
  if (to.size() != count) {
    throw InputError{"options -pair_to_place and -pair_to_junction: " + std::to_string(to.size()) + " nodes for the " +
                     std::to_string(count) +
                     " of -pair_from_place and -pair_from_junction are not allowed, expected one for each"};
  }
  if (turned && normal.size() != 3 && (count == 0 || normal.size() != 3 * count)) {
    throw InputError{"option -pair_normal: " + std::to_string(normal.size()) + " numbers for " + std::to_string(count) +
                     " pairs are not allowed, expected three for each pair, or three for all"};
  }
  if (turned && count == 0) {
    throw InputError{"option -pair_normal: there is nothing that it is for, expected " + std::string{kPerPair}};
  }
  for (NumberList* list : {&gap, &restitution, &yield_speed}) {
    if (count > 0 || list->given) {
      list->spread(count, kPerPair);
    }
  }
  laws.settle(count);
  std::pair<std::vector<NodePair>, std::vector<Support>> read;
  for (std::size_t i = 0; i < count; ++i) {
    read.first.push_back({.from = from[i], .to = to[i], .normal = normal_of(normal, i), .gap = gap[i]});
    Support& face = read.second.emplace_back(
        Support{.position = from[i].x, .restitution = restitution[i], .yield_speed = yield_speed[i]});
    face.strike = static_cast<PetscInt>(strikers + i);
    face.contact_law = laws.law(comm, i);
    if (face.contact_law) {
      refuse_impact_law(kLawsOfPairs.law, "the law decides", restitution, yield_speed.key, face);
    }
  }
  return read;
}

}  // namespace udar::app
