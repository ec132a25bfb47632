#include <array>
#include <charconv>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
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

constexpr const char* kBase = "base";  ///< all of it

/// What a word of -base_motion_place means; nothing: the whole base.
std::optional<HeldPlace> held_place(const std::string& word, const std::optional<NetworkParameters>& network) {
  if (word == kBase) {
    return std::nullopt;
  }
  if (network) {
    for (std::size_t i = 0; i < network->junctions.size(); ++i) {
      if (network->junctions[i].name == word) {
        return HeldPlace{.kind = HeldKind::junction, .number = i};
      }
    }
    throw InputError{"option -base_motion_place: '" + word +
                     "' is not allowed, expected base or the name of a junction"};
  }
  if (word == "left" || word == "right") {
    return HeldPlace{.kind = word == "left" ? HeldKind::left_end : HeldKind::right_end};
  }
  constexpr std::string_view kSupport = "line_support_";
  std::size_t number = 0;
  if (const std::string_view text = word; text.starts_with(kSupport)) {
    const auto [end, failure] = std::from_chars(text.data() + kSupport.size(), text.data() + text.size(), number);
    if (failure == std::errc{} && end == text.data() + text.size()) {
      return HeldPlace{.kind = HeldKind::line_support, .number = number};
    }
  }
  throw InputError{
      "option -base_motion_place: '" + word +
      "' is not allowed, expected base, left, right or line_support_0, ... of -beam_line_support_position"};
}

}  // namespace

BaseInput read_base_motion(MPI_Comm comm, const std::optional<NetworkParameters>& network) {
  OptionGroup group{comm, "Motion of the base (everything that holds the structure, and all supports, move with it)"};
  Strings paths;
  std::vector<BaseQuantity> given;
  Numbers direction{0.0, 1.0, 0.0};
  Numbers scale{1.0};
  Strings places{kBase};
  double accuracy = 1e-4;
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
  more |= group.strings("-base_motion_place", places,
                        "what moves so: base, all of it; or one place that holds the structure, rigidly or by a "
                        "spring, while others stay: left, right (the ends of a beam), line_support_0 (the first of "
                        "-beam_line_support_position), ..., or the name of a junction of a network; one per file or "
                        "one for all");
  more |= group.real("-base_motion_accuracy", accuracy, "-", petsc::positive(),
                     "of single places: the largest error of their displacement, linear between rows that are made so "
                     "close, as a share of the largest");
  if (!moves) {
    if (more) {
      throw InputError{
          "options -base_motion_kind, -base_motion_direction, -base_motion_scale, -base_motion_place and "
          "-base_motion_accuracy are not allowed without -base_motion"};
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
  places = petsc::one_per("-base_motion_place", places, count, "one per -base_motion");
  if (direction.size() != 3 && direction.size() != 3 * count) {
    throw InputError{"option -base_motion_direction: " + std::to_string(direction.size()) +
                     " values given, expected 3, or 3 per -base_motion: x,y,z"};
  }
  BaseInput motions;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t first = direction.size() == 3 ? 0 : 3 * i;
    if (scale[i] == 0.0) {
      throw InputError{"option -base_motion_scale: 0 is not allowed, expected another number [-]"};
    }
    BaseMotion motion = read_base(comm, paths[i], given[i], scale[i],
                                  {.x = direction[first], .y = direction[first + 1], .z = direction[first + 2]});
    if (const std::optional<HeldPlace> place = held_place(places[i], network)) {
      motions.held.push_back({.place = *place, .motion = std::move(motion), .accuracy = accuracy});
    } else {
      motions.base.push_back(std::move(motion));
    }
  }
  return motions;
}

}  // namespace udar::app
