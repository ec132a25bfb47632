#include "udar/structure/describe.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace udar {

void describe(Description& all, const BeamParameters& beam) {
  const auto& [segments, left, right, tension, point_masses, line_supports, mass_patches, plasticity] = beam;
  static_cast<void>(segments);
  // Stresses follow the motion and do not shape it.
  const auto part = [&](std::string_view name, std::size_t index) {
    all.add_each(name, beam.segments, [index](const BeamSegment& segment) {
      const auto& [length, elements, bending, mass, shear, foundation, modulus_unused, stress_unused, yields,
                   radius_unused] = segment;
      static_cast<void>(modulus_unused);
      static_cast<void>(stress_unused);
      static_cast<void>(radius_unused);
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
  const auto& [height, slope, velocity, angular_velocity, velocity_x, velocity_z, spin, pivot, shape, parts,
               held_below] = initial;
  static_cast<void>(held_below);
  static_cast<void>(velocity);
  static_cast<void>(angular_velocity);
  static_cast<void>(velocity_x);
  static_cast<void>(velocity_z);
  static_cast<void>(spin);
  static_cast<void>(pivot);
  static_cast<void>(shape);
  static_cast<void>(parts);
  all.add("initial height [m]", height);
  all.add("initial slope", slope);
}

namespace {

/// Those of the laws of loads, one number after the other.
void describe_laws(Description& all, std::span<const NodalLoad> loads) {
  std::vector<TimeLaw> laws;
  for (const NodalLoad& load : loads) {
    if (load.law) {
      laws.push_back(*load.law);
    }
  }
  if (laws.empty()) {
    return;
  }
  const auto each = [&](std::string_view name, std::size_t index) {
    all.add_each(name, laws, [index](const TimeLaw& law) {
      const auto& [course, start, until, amplitude, frequency, last_frequency, phase, duration, decay, at_below,
                   density_below, seed, period, accuracy] = law;
      static_cast<void>(at_below);
      static_cast<void>(density_below);
      return std::array{
          static_cast<double>(course), start,  until,   amplitude, frequency, last_frequency, phase, duration, decay,
          static_cast<double>(seed),   period, accuracy}
          .at(index);
    });
  };
  constexpr std::array kNames{"laws of loads (0 harmonic, 1 random, 2 friedlander)",
                              "laws of loads, starts [s]",
                              "laws of loads, ends [s]",
                              "laws of loads, amplitudes [N]",
                              "laws of loads, frequencies [Hz]",
                              "laws of loads, last frequencies [Hz]",
                              "laws of loads, phases [rad]",
                              "laws of loads, durations [s]",
                              "laws of loads, decays",
                              "laws of loads, seeds",
                              "laws of loads, periods [s]",
                              "laws of loads, accuracies"};
  for (std::size_t index = 0; index < kNames.size(); ++index) {
    each(kNames.at(index), index);
  }
  all.add_all("laws of loads, spectra, frequencies [Hz]", laws,
              [](const TimeLaw& law) { return std::span<const double>{law.at}; });
  all.add_all("laws of loads, spectra, densities [N^2/Hz]", laws,
              [](const TimeLaw& law) { return std::span<const double>{law.density}; });
}

}  // namespace

/// A table that a law makes is as long as the run: the law is told in its place.
void describe(Description& all, std::span<const NodalLoad> loads) {
  const auto list = [&](std::string_view name, bool times) {
    all.add_all(name, loads, [times](const NodalLoad& load) {
      const auto& [position, width, table, breadth, y, z, direction, law] = load;
      for (const double below : {position, width, breadth, y, z, direction.x}) {
        static_cast<void>(below);
      }
      return law ? std::span<const double>{} : times ? table->time() : table->value();
    });
  };
  const auto some = [&](std::string_view name, const auto& value, double usual) {
    if (std::ranges::any_of(loads, [&](const NodalLoad& load) { return value(load) != usual; })) {
      all.add_each(name, loads, value);
    }
  };
  all.add_each("loads, positions [m]", loads, [](const NodalLoad& load) { return load.position; });
  some("loads, widths [m]", [](const NodalLoad& load) { return load.width; }, 0.0);
  some("loads, breadths [m]", [](const NodalLoad& load) { return load.breadth; }, 0.0);
  some("loads, y [m]", [](const NodalLoad& load) { return load.y; }, 0.0);
  some("loads, z [m]", [](const NodalLoad& load) { return load.z; }, 0.0);
  some("loads, directions, x", [](const NodalLoad& load) { return load.direction.x; }, 0.0);
  some("loads, directions, y", [](const NodalLoad& load) { return load.direction.y; }, 1.0);
  some("loads, directions, z", [](const NodalLoad& load) { return load.direction.z; }, 0.0);
  list("loads, times [s]", true);
  list("loads, forces [N]", false);
  describe_laws(all, loads);
}

void describe(Description& all, std::span<const TravellingLoad> loads) {
  const auto each = [&](std::string_view name, std::size_t index) {
    all.add_each(name, loads, [index](const TravellingLoad& load) {
      const auto& [offset_below, force_below, speed, start, mass_below, stiffness_below] = load;
      static_cast<void>(offset_below);
      static_cast<void>(force_below);
      static_cast<void>(mass_below);
      static_cast<void>(stiffness_below);
      return index == 0 ? speed : start;
    });
  };
  all.add_all("axles, distances behind the first [m]", loads,
              [](const TravellingLoad& load) { return std::span<const double>{load.offset}; });
  all.add_all("axles, forces [N]", loads,
              [](const TravellingLoad& load) { return std::span<const double>{load.force}; });
  if (std::ranges::any_of(loads, [](const TravellingLoad& load) { return !load.mass.empty(); })) {
    all.add_all("axles, masses [kg]", loads,
                [](const TravellingLoad& load) { return std::span<const double>{load.mass}; });
    all.add_all("axles, stiffnesses of springs [N/m]", loads,
                [](const TravellingLoad& load) { return std::span<const double>{load.stiffness}; });
  }
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

void describe(Description& all, std::span<const HeldMotion> held) {
  all.add_each("motion of places, kinds", held,
               [](const HeldMotion& motion) { return static_cast<int>(motion.place.kind); });
  all.add_each("motion of places, numbers", held,
               [](const HeldMotion& motion) { return static_cast<double>(motion.place.number); });
  all.add_each("motion of places, starts [m]", held,
               [](const HeldMotion& motion) { return motion.motion.at(0.0).displacement; });
  all.add_each("motion of places, speeds at the start [m/s]", held,
               [](const HeldMotion& motion) { return motion.motion.at(0.0).velocity; });
  all.add_each("motion of places, accuracies", held, [](const HeldMotion& motion) { return motion.accuracy; });
  std::vector<double> directions;
  for (const HeldMotion& motion : held) {
    const auto& [x, y, z] = motion.motion.direction();
    directions.insert(directions.end(), {x, y, z});
  }
  all.add("motion of places, directions", directions);
  all.add_all("motion of places, times [s]", held,
              [](const HeldMotion& motion) { return motion.motion.acceleration()->time(); });
  all.add_all("motion of places, accelerations [m/s^2]", held,
              [](const HeldMotion& motion) { return motion.motion.acceleration()->value(); });
}

void describe(Description& all, std::span<const Striker> strikers) {
  const auto each = [&](std::string_view name, std::size_t index) {
    all.add_each(name, strikers, [index](const Striker& striker) {
      const auto& [place, mass, gap, velocity, below] = striker;
      static_cast<void>(gap);  // starts
      static_cast<void>(velocity);
      return std::array{place.x, mass, below ? -1.0 : 1.0, place.y, place.z}.at(index);
    });
  };
  each("strikers, positions [m]", 0);
  each("strikers, masses [kg]", 1);
  each("strikers, sides (1 above, -1 below)", 2);
  if (std::ranges::any_of(strikers, [](const Striker& striker) { return in_space(striker.place); })) {
    each("strikers, places along y [m]", 3);
    each("strikers, places along z [m]", 4);
  }
}

void describe(Description& all, std::span<const NodePair> pairs) {
  const auto each = [&](std::string_view name, const auto& value_of) {
    std::vector<double> values;
    for (const NodePair& pair : pairs) {
      const auto& [x, y, z] = value_of(pair);
      values.insert(values.end(), {x, y, z});
    }
    all.add(name, values);
  };
  each("pairs of nodes, places of the first [m]", [](const NodePair& pair) { return pair.from; });
  each("pairs of nodes, places of the second [m]", [](const NodePair& pair) { return pair.to; });
  each("pairs of nodes, normals", [](const NodePair& pair) { return pair.normal; });
  all.add_each("pairs of nodes, gaps [m]", pairs, [](const NodePair& pair) { return pair.gap; });
}

}  // namespace udar
