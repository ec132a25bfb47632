#include "udar/structure/describe.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace udar {

void describe(Description& all, const BeamParameters& beam) {
  const auto& [segments, left, right, tension, point_masses, line_supports, mass_patches, plasticity] = beam;
  // Stresses follow the motion and do not shape it.
  const auto part = [&](std::string_view name, std::size_t index) {
    all.add_each(name, segments, [index](const BeamSegment& segment) {
      const auto& [length, elements, bending, mass, shear, foundation, modulus_unused, stress_unused, yields] = segment;
      static_cast<void>(modulus_unused);
      static_cast<void>(stress_unused);
      return std::array{length, static_cast<double>(elements), bending, mass, shear, foundation, yields}.at(index);
    });
  };
  part("beam lengths [m]", 0);
  part("beam elements", 1);
  part("bending stiffness EI [N m^2]", 2);
  part("mass per length rhoA [kg/m]", 3);
  part("shear stiffness kGA [N]", 4);
  part("foundation [N/m^2]", 5);
  all.add("tension [N]", tension);
  const auto& [left_spring, left_rotation] = left;
  const auto& [right_spring, right_rotation] = right;
  all.add("ends, stiffness against displacement [N/m]", std::array{left_spring, right_spring});
  all.add("ends, stiffness against rotation [N m/rad]", std::array{left_rotation, right_rotation});
  const auto pairs = [&all](std::string_view first, std::string_view second, const auto& things) {
    for (const bool of_first : {true, false}) {
      all.add_each(of_first ? first : second, things, [of_first](const auto& thing) {
        const auto& [one, other] = thing;
        return of_first ? one : other;
      });
    }
  };
  pairs("point masses, positions [m]", "point masses [kg]", point_masses);
  pairs("line supports, positions [m]", "line supports, stiffness [N/m]", line_supports);
  pairs("weighted patches, begin [m]", "weighted patches, end [m]", mass_patches);
  if (beam.yields()) {
    const auto& [places, tangent_ratio] = plasticity;
    part("yield moments [N m]", 6);
    all.add("stiffness after yielding over EI", tangent_ratio);
    pairs("hinges, positions [m]", "hinges, hardening [N m/rad]", places);
  }
}

void describe(Description& all, const InitialState& initial) {
  const auto& [height, slope, velocity, angular_velocity, velocity_x, velocity_z, spin, pivot, shape] = initial;
  static_cast<void>(velocity);
  static_cast<void>(angular_velocity);
  static_cast<void>(velocity_x);
  static_cast<void>(velocity_z);
  static_cast<void>(spin);
  static_cast<void>(pivot);
  static_cast<void>(shape);
  all.add("initial height [m]", height);
  all.add("initial slope", slope);
}

void describe(Description& all, std::span<const NodalLoad> loads) {
  const auto list = [&](std::string_view name, bool times) {
    all.add_all(name, loads, [times](const NodalLoad& load) {
      const auto& [position, width, table] = load;
      static_cast<void>(position);
      static_cast<void>(width);
      return times ? table->time() : table->value();
    });
  };
  all.add_each("loads, positions [m]", loads, [](const NodalLoad& load) { return load.position; });
  if (std::ranges::any_of(loads, [](const NodalLoad& load) { return load.width != 0.0; })) {
    all.add_each("loads, widths [m]", loads, [](const NodalLoad& load) { return load.width; });
  }
  list("loads, times [s]", true);
  list("loads, forces [N]", false);
}

void describe(Description& all, std::span<const TravellingLoad> loads) {
  const auto each = [&](std::string_view name, std::size_t index) {
    all.add_each(name, loads, [index](const TravellingLoad& load) {
      const auto& [offset_below, force_below, speed, start] = load;
      static_cast<void>(offset_below);
      static_cast<void>(force_below);
      return index == 0 ? speed : start;
    });
  };
  all.add_all("axles, distances behind the first [m]", loads,
              [](const TravellingLoad& load) { return std::span<const double>{load.offset}; });
  all.add_all("axles, forces [N]", loads,
              [](const TravellingLoad& load) { return std::span<const double>{load.force}; });
  each("axles, speeds [m/s]", 0);
  each("axles, starts [s]", 1);
}

void describe(Description& all, std::span<const BaseMotion> base) {
  std::vector<double> directions;
  for (const BaseMotion& motion : base) {
    const auto& [x, y, z] = motion.direction();
    directions.insert(directions.end(), {x, y, z});
  }
  all.add("base motion, directions", directions);
  all.add_all("base motion, times [s]", base, [](const BaseMotion& motion) { return motion.acceleration()->time(); });
  all.add_all("base motion, accelerations [m/s^2]", base,
              [](const BaseMotion& motion) { return motion.acceleration()->value(); });
}

void describe(Description& all, std::span<const Striker> strikers) {
  const auto each = [&](std::string_view name, std::size_t index) {
    all.add_each(name, strikers, [index](const Striker& striker) {
      const auto& [position, mass, gap, velocity, below] = striker;
      static_cast<void>(gap);  // starts
      static_cast<void>(velocity);
      return std::array{position, mass, below ? -1.0 : 1.0}.at(index);
    });
  };
  each("strikers, positions [m]", 0);
  each("strikers, masses [kg]", 1);
  each("strikers, sides (1 above, -1 below)", 2);
}

}  // namespace udar
