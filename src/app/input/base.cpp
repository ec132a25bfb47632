#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "app/input/readers.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"

namespace udar::app {

using petsc::OptionGroup;

namespace {

constexpr std::array kQuantities{Names<BaseQuantity>{"displacement", BaseQuantity::displacement},
                                 Names<BaseQuantity>{"velocity", BaseQuantity::velocity},
                                 Names<BaseQuantity>{"acceleration", BaseQuantity::acceleration}};

const char* column_of(BaseQuantity given) {
  return given == BaseQuantity::displacement ? "displacement [m]"
         : given == BaseQuantity::velocity   ? "velocity [m/s]"
                                             : "acceleration [m/s^2]";
}

BaseMotion read_base(MPI_Comm comm, const std::string& path, BaseQuantity given, double scale, const Place& direction) {
  const io::Table table = io::read_table(comm, "base motion", path, {.names = {"time [s]", column_of(given)}});
  const bool jumps = given == BaseQuantity::acceleration;
  require_ascending("-base_motion", path, column(table, 0), "times [s]", jumps);
  Numbers values = column(table, 1);
  for (double& value : values) {
    value *= scale;
  }
  return {given, column(table, 0), std::move(values), direction};
}

}  // namespace

std::vector<BaseMotion> read_base_motion(MPI_Comm comm) {
  OptionGroup group{comm, "Motion of the base (everything that holds the structure, and all supports, move with it)"};
  Strings paths;
  std::vector<BaseQuantity> given;
  Numbers direction{0.0, 1.0, 0.0};
  Numbers scale{1.0};
  const bool moves = group.strings(
      "-base_motion", paths,
      "CSV files of two columns, time [s] and what -base_motion_kind says; several are added up; places and velocities "
      "of a run are relative to the base");
  bool more = group.choices<BaseQuantity>(
      "-base_motion_kind", given, kQuantities,
      "what the second column is: an acceleration [m/s^2], linear between rows and none outside; a velocity [m/s], "
      "linear between rows and constant outside; a displacement [m], a cubic spline that rests outside; one per file "
      "or one for all");
  more |= group.reals("-base_motion_direction", direction, "-", petsc::any(),
                      "which way it moves, x,y,z, three numbers of any length per file or three for all; along y "
                      "unless told otherwise; a beam moves along y alone");
  more |= group.reals("-base_motion_scale", scale, "-", petsc::any(),
                      "what the second column is multiplied by, such as 9.81 for a record in g; one per file or one "
                      "for all");
  if (!moves) {
    if (more) {
      throw InputError{
          "options -base_motion_kind, -base_motion_direction and -base_motion_scale are not allowed without "
          "-base_motion"};
    }
    return {};
  }
  if (given.empty()) {
    throw InputError{
        "option -base_motion_kind: none given with -base_motion, expected displacement, velocity or acceleration"};
  }
  const std::size_t count = paths.size();
  given = petsc::one_per("-base_motion_kind", given, count, "one per -base_motion");
  scale = petsc::one_per("-base_motion_scale", scale, count, "one per -base_motion");
  if (direction.size() != 3 && direction.size() != 3 * count) {
    throw InputError{"option -base_motion_direction: " + std::to_string(direction.size()) +
                     " values given, expected 3, or 3 per -base_motion: x,y,z"};
  }
  std::vector<BaseMotion> motions;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t first = direction.size() == 3 ? 0 : 3 * i;
    if (scale[i] == 0.0) {
      throw InputError{"option -base_motion_scale: 0 is not allowed, expected another number [-]"};
    }
    motions.push_back(read_base(comm, paths[i], given[i], scale[i],
                                {.x = direction[first], .y = direction[first + 1], .z = direction[first + 2]}));
  }
  return motions;
}

}  // namespace udar::app
