#include <cstddef>
#include <sstream>

#include "app/input/readers.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"

namespace udar::app {

using petsc::OptionGroup;

namespace {

TravellingLoad read_axles(MPI_Comm comm, const std::string& path, double speed, double start) {
  const io::Table table = io::read_table(comm, "load axles", path,
                                         {.names = {"distance [m]", "force [N]", "mass [kg]", "stiffness [N/m]"}});
  TravellingLoad load{.offset = column(table, 0), .force = column(table, 1), .speed = speed, .start = start};
  for (const double offset : load.offset) {
    if (offset < 0.0) {
      std::ostringstream message;
      message << "option -load_axles: '" << path << "': a distance of " << offset
              << " is not allowed, expected numbers >= 0 [m]";
      throw InputError{message.str()};
    }
  }
  const auto amounts = [&](std::size_t index, const char* quantity, const char* unit) {
    std::vector<double> values = table.columns > index ? column(table, index) : std::vector<double>{};
    for (const double value : values) {
      if (value < 0.0) {
        std::ostringstream message;
        message << "option -load_axles: '" << path << "': a " << quantity << " of " << value
                << " is not allowed, expected numbers >= 0 [" << unit << "], 0 for none";
        throw InputError{message.str()};
      }
    }
    return values;
  };
  load.mass = amounts(2, "mass", "kg");
  load.stiffness = amounts(3, "stiffness", "N/m");
  return load;
}

}  // namespace

std::vector<TravellingLoad> read_travelling_loads(MPI_Comm comm) {
  OptionGroup group{comm, "Forces and masses that travel along the beam"};
  Strings paths;
  Numbers speed;
  Numbers start{0.0};
  const bool given = group.strings(
      "-load_axles", paths,
      "CSV files distance behind the first axle [m], force [N, up]: forces that travel together, one file per train; "
      "between two nodes on both, with force and moment kept; a third column mass [kg], whose weight acts besides: the "
      "beam carries it; a fourth stiffness [N/m] of the spring that it stands on, 0 for none");
  bool more = group.reals("-load_axles_speed", speed, "m/s", petsc::any(),
                          "of the axles, to the right; negative: to the left from the right end; one per file or one "
                          "for all");
  more |= group.reals("-load_axles_start", start, "s", petsc::any(),
                      "when the first axle enters the beam; one per file or one for all");
  if (!given) {
    if (more) {
      throw InputError{"options -load_axles_speed and -load_axles_start are not allowed without -load_axles"};
    }
    return {};
  }
  speed = petsc::one_per("-load_axles_speed", speed, paths.size(), "one per -load_axles");
  start = petsc::one_per("-load_axles_start", start, paths.size(), "one per -load_axles");
  std::vector<TravellingLoad> loads;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (speed[i] == 0.0) {
      throw InputError{"option -load_axles_speed: 0 is not allowed, expected another number [m/s]"};
    }
    loads.push_back(read_axles(comm, paths[i], speed[i], start[i]));
  }
  return loads;
}

}  // namespace udar::app
