#include <array>
#include <cstdint>
#include <limits>
#include <utility>

#include "app/input/contact_laws.hpp"
#include "app/input/readers.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"

namespace udar::app {
namespace {

constexpr const char* kPerStriker = "one per -striker_position, -striker_place, -striker_junction";

constexpr PlaceKeys kStrikers{
    .position = {"-striker_position", "where they strike, x: the nearest node, which no support may touch"},
    .place = {"-striker_place",
              "for a structure in space: where more strike, x,y,z of the first, then of the second, ...: the nearest "
              "node"},
    .junction = {"-striker_junction", "for a network: where more strike, names of junctions"},
    .thing = "striker"};

constexpr LawKeys kLawsOfStrikers{.law = "-striker_law",
                                  .stiffness = "-striker_stiffness",
                                  .exponent = "-striker_exponent",
                                  .damping = "-striker_damping",
                                  .unloading = "-striker_unloading_stiffness",
                                  .plateau = "-striker_plateau_force",
                                  .bottoming = "-striker_bottoming_compression",
                                  .bottoming_stiffness = "-striker_bottoming_stiffness",
                                  .table = "-striker_table",
                                  .preload = nullptr,
                                  .quantity = "striker",
                                  .thing = "striker",
                                  .per_thing = kPerStriker};

enum class Stand : std::uint8_t { above, below };
constexpr std::array kStands{Names<Stand>{"above", Stand::above}, Names<Stand>{"below", Stand::below}};

}  // namespace

std::pair<std::vector<Striker>, std::vector<Support>> read_strikers(MPI_Comm comm, const StructureInput& structure) {
  petsc::OptionGroup group{comm,
                           "Strikers (rigid masses, guided along y; lists: one entry per striker, or one for all)"};
  NumberList mass{"-striker_mass", {0.0}};
  NumberList gap{"-striker_gap", {0.0}};
  NumberList velocity{"-striker_velocity", {0.0}};
  NumberList restitution{"-striker_restitution", {1.0}};
  NumberList yield_speed{"-striker_yield_speed", {std::numeric_limits<double>::infinity()}};
  std::vector<Stand> stands{Stand::above};
  LawLists laws{kLawsOfStrikers};
  const std::vector<Place> places = read_places(group, kStrikers, structure);
  mass.read(group, "kg", petsc::positive(), "needed");
  gap.read(group, "m", petsc::non_negative(), "between striker and node at the start");
  velocity.read(group, "m/s", petsc::any(), "at the start, y up: -4.43 after a fall from 1 m");
  const bool side_given =
      group.choices<Stand>("-striker_side", stands, kStands, "on which side of the structure it is");
  restitution.read(group, "-", petsc::between(0.0, 1.0), "of the velocity between striker and node, v+ = -e v-");
  yield_speed.read(group, "m/s", petsc::positive_or_infinite(),
                   "speed above which restitution falls, e (v / v_y)^(-1/4); inf: it does not");
  laws.read(group);
  const std::size_t count = places.size();
  for (NumberList* list : {&mass, &gap, &velocity, &restitution, &yield_speed}) {
    if (count > 0 || list->given) {
      list->spread(count, kPerStriker);
    }
  }
  if (count > 0 || side_given) {
    stands = petsc::one_per("-striker_side", stands, count, kPerStriker);
  }
  laws.settle(count);
  if (count > 0 && !mass.given) {
    throw InputError{
        "option -striker_mass is needed with -striker_position, -striker_place and -striker_junction [kg]"};
  }
  std::pair<std::vector<Striker>, std::vector<Support>> read;
  for (std::size_t i = 0; i < count; ++i) {
    read.first.push_back({.place = places[i],
                          .mass = mass[i],
                          .gap = gap[i],
                          .velocity = velocity[i],
                          .below = stands[i] == Stand::below});
    Support& face = read.second.emplace_back(
        Support{.position = places[i].x, .restitution = restitution[i], .yield_speed = yield_speed[i]});
    face.strike = static_cast<PetscInt>(i);
    face.contact_law = laws.law(comm, i);
    if (face.contact_law) {
      refuse_impact_law(kLawsOfStrikers.law, "the law decides", restitution, yield_speed.key, face);
    }
  }
  return read;
}

}  // namespace udar::app
