#include "io/network_keys.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "udar/structure/member_shape.hpp"

namespace udar::io {
namespace {

using petsc::positive;

constexpr std::array kEnds{"from", "to"};

/// A number that must be there.
double needed(YamlThing& thing, const char* key, const char* unit) {
  const auto given = thing.number(key, unit, positive());
  if (!given) {
    thing.miss(std::string{key} + " [" + unit + "]");
  }
  return given->value;
}

void read_material(YamlThing& thing, MemberSection& section) {
  constexpr double kSteelModulus = 2.1e11;
  constexpr double kSteelPoisson = 0.3;
  constexpr double kSteelDensity = 7850.0;
  const auto modulus = thing.number("young_modulus", "Pa", positive());
  const auto shear = thing.number("shear_modulus", "Pa", positive());
  const auto poisson = thing.number("poisson_ratio", "-", petsc::between(0.0, 0.5));
  const auto density = thing.number("density", "kg/m^3", positive());
  if (shear && poisson) {
    thing.refuse(poisson->mark, "poisson_ratio besides shear_modulus, expected one of them");
  }
  section.youngs_modulus = modulus ? modulus->value : kSteelModulus;
  section.shear_modulus =
      shear ? shear->value : section.youngs_modulus / (2.0 * (1.0 + (poisson ? poisson->value : kSteelPoisson)));
  section.density = density ? density->value : kSteelDensity;
}

/// @param word "circle", "tube" or "rectangle"
void read_shape(YamlThing& thing, const Given<std::string>& word, MemberSection& section) {
  MemberShape shape;
  if (word.value == "circle") {
    shape = {.kind = MemberShape::Kind::circle, .radius = needed(thing, "radius", "m")};
  } else if (word.value == "tube") {
    shape.kind = MemberShape::Kind::tube;
    shape.radius = needed(thing, "radius", "m");
    const auto inner = thing.number("inner_radius", "m", positive());
    if (!inner) {
      thing.miss("inner_radius [m]");
    }
    if (!(inner->value < shape.radius)) {
      thing.refuse(inner->mark, "inner_radius must be smaller than radius [m]");
    }
    shape.inner_radius = inner->value;
  } else if (word.value == "rectangle") {
    shape.kind = MemberShape::Kind::rectangle;
    shape.width = needed(thing, "width", "m");
    shape.height = needed(thing, "height", "m");
  } else {
    thing.refuse(word.mark, "shape: '" + word.value + "' is not allowed, expected circle, tube or rectangle");
  }
  const auto theory = thing.text("theory");
  if (theory && theory->value != "euler_bernoulli" && theory->value != "timoshenko") {
    thing.refuse(theory->mark,
                 "theory: '" + theory->value + "' is not allowed, expected euler_bernoulli or timoshenko");
  }
  give_shape(section, shape, theory && theory->value == "timoshenko");
}

void read_numbers(YamlThing& thing, MemberSection& section) {
  section.area = needed(thing, "area", "m^2");
  const auto inertia = thing.numbers("inertia", "m^4", positive(), 2);
  if (!inertia) {
    thing.miss("inertia [m^4], of bending in the planes xy and xz");
  }
  std::ranges::copy(inertia->value, section.inertia.begin());
  section.torsion_constant = needed(thing, "torsion_constant", "m^4");
  if (const auto shear = thing.numbers("shear_factor", "-", petsc::non_negative(), 2)) {
    std::ranges::copy(shear->value, section.shear_factor.begin());
  }
  if (const auto radius = thing.number("radius", "m", positive())) {
    section.radius = radius->value;
  }
}

/// Stiffness of the joints at one end: given, and 0 about the axes of hinges.
std::optional<Given<std::array<double, 3>>> read_joint(YamlThing& thing, const std::string& end) {
  const std::string joint_key = "joint_" + end;
  const std::string hinge_key = "hinge_" + end;
  const auto joint = thing.numbers(joint_key.c_str(), "N m/rad", petsc::non_negative_or_infinite(), 3);
  const auto hinge = thing.words(hinge_key.c_str());
  if (!joint && (!hinge || hinge->empty())) {
    return std::nullopt;
  }
  Given<std::array<double, 3>> given{MemberEnd{}.joint, joint ? joint->mark : hinge->front().mark};
  if (joint) {
    std::ranges::copy(joint->value, given.value.begin());
  }
  for (const Given<std::string>& axis : hinge ? *hinge : std::vector<Given<std::string>>{}) {
    if (axis.value != "x" && axis.value != "y" && axis.value != "z") {
      thing.refuse(axis.mark, hinge_key + ": '" + axis.value +
                                  "' is not allowed, expected axes of the member, x, y or z, about which it turns");
    }
    double& stiffness = given.value.at(static_cast<std::size_t>(axis.value[0] - 'x'));
    if (joint && stiffness != 0.0) {
      thing.refuse(axis.mark, hinge_key + ": '" + axis.value + "' is not allowed with another stiffness about it in " +
                                  joint_key + ", expected 0 there: a hinge turns freely");
    }
    stiffness = 0.0;
  }
  return given;
}

std::optional<Given<Division>> read_division(YamlThing& thing) {
  std::optional<Given<Division>> found;
  const auto take = [&](Division division, const YAML::Mark& mark, const char* key) {
    if (found) {
      thing.refuse(mark, std::string{key} +
                             " besides another of elements, element_length, element_lengths, expected one of them");
    }
    found = Given<Division>{std::move(division), mark};
  };
  if (const auto elements = thing.count("elements")) {
    take({.elements = elements->value}, elements->mark, "elements");
  }
  if (const auto length = thing.number("element_length", "m", positive())) {
    take({.length = length->value}, length->mark, "element_length");
  }
  if (const auto lengths = thing.numbers("element_lengths", "m", positive(), 0)) {
    take({.elements = lengths->value.size(), .lengths = lengths->value}, lengths->mark, "element_lengths");
  }
  return found;
}

template <class T>
void add(std::optional<Given<T>>& keys, const std::optional<Given<T>>& group, const YamlThing& thing) {
  if (keys && group) {
    thing.refuse(group->mark, "says what another group of the same thing says on line " +
                                  std::to_string(keys->mark.line + 1) + ", expected one of them");
  }
  keys = group ? group : keys;
}

/// Calls `each` for all pairs of the same key.
template <class Each>
void pairs(MemberKeys& left, const MemberKeys& right, const Each& each) {
  each(left.section, right.section);
  each(left.division, right.division);
  each(left.grading, right.grading);
  each(left.orientation, right.orientation);
  for (std::size_t end = 0; end < 2; ++end) {
    each(left.joint.at(end), right.joint.at(end));
    each(left.offset.at(end), right.offset.at(end));
  }
}

template <class Each>
void pairs(JunctionKeys& left, const JunctionKeys& right, const Each& each) {
  each(left.held, right.held);
  each(left.stiffness, right.stiffness);
  each(left.mass, right.mass);
}

template <class Keys>
void add_all(Keys& keys, const Keys& group, const YamlThing& thing) {
  pairs(keys, group, [&](auto& to, const auto& from) { add(to, from, thing); });
}

template <class Keys>
void fill_all(Keys& own, const Keys& group) {
  pairs(own, group, [](auto& to, const auto& from) { to = to ? to : from; });
}

}  // namespace

void NameTable::add(const YamlThing& thing, const Given<std::string>& name) {
  if (!numbers_.emplace(name.value, numbers_.size()).second) {
    thing.refuse(name.mark, "there is another " + what_ + " of this name");
  }
}

std::size_t NameTable::find(const YamlThing& thing, const Given<std::string>& name) const {
  const auto found = numbers_.find(name.value);
  if (found != numbers_.end()) {
    return found->second;
  }
  constexpr std::size_t kShown = 8;
  std::string some;
  std::size_t shown = 0;
  for (const auto& [other, number] : numbers_) {
    some += shown == kShown ? ", ..." : shown < kShown ? (shown > 0 ? ", " : "") + other : "";
    ++shown;
  }
  thing.refuse(name.mark,
               "unknown " + what_ + " '" + name.value + "', " + (some.empty() ? "there is none" : "there are " + some));
}

MemberSection read_section(YamlThing& thing) {
  MemberSection section;
  read_material(thing, section);
  if (const auto shape = thing.text("shape")) {
    read_shape(thing, *shape, section);
  } else {
    read_numbers(thing, section);
  }
  return section;
}

std::optional<Given<Place>> read_place(YamlThing& thing, const char* key) {
  const auto numbers = thing.numbers(key, "m", petsc::any(), 3);
  if (!numbers) {
    return std::nullopt;
  }
  return Given<Place>{{.x = numbers->value[0], .y = numbers->value[1], .z = numbers->value[2]}, numbers->mark};
}

MemberKeys read_member_keys(YamlThing& thing, const NameTable& sections, bool of_mesh) {
  MemberKeys keys;
  if (const auto section = thing.text("section")) {
    keys.section = {sections.find(thing, *section), section->mark};
  }
  keys.orientation = read_place(thing, "orientation");
  if (keys.orientation) {
    const auto& [x, y, z] = keys.orientation->value;
    if (x == 0.0 && y == 0.0 && z == 0.0) {
      thing.refuse(keys.orientation->mark, "orientation: a vector of length 0 is not allowed; leave the key out");
    }
  }
  if (of_mesh) {
    return keys;
  }
  keys.division = read_division(thing);
  keys.grading = thing.number("grading", "-", positive());
  for (std::size_t end = 0; end < 2; ++end) {
    keys.joint.at(end) = read_joint(thing, kEnds.at(end));
    keys.offset.at(end) = read_place(thing, (std::string{"offset_"} + kEnds.at(end)).c_str());
  }
  return keys;
}

JunctionKeys read_junction_keys(YamlThing& thing) {
  constexpr std::array<std::string_view, 6> kWays{"ux", "uy", "uz", "rx", "ry", "rz"};
  JunctionKeys keys;
  if (const auto words = thing.words("held")) {
    std::array<bool, 6> held{};
    for (const Given<std::string>& word : *words) {
      const auto* const way = std::ranges::find(kWays, word.value);
      if (word.value == "clamped" || word.value == "pinned") {
        std::fill_n(held.begin(), word.value == "clamped" ? 6 : 3, true);
      } else if (way != kWays.end()) {
        held.at(static_cast<std::size_t>(way - kWays.begin())) = true;
      } else {
        thing.refuse(word.mark, "held: '" + word.value +
                                    "' is not allowed, expected clamped, pinned, or some of ux, uy, uz, rx, ry, rz");
      }
    }
    keys.held = {held, words->empty() ? thing.mark() : words->front().mark};
  }
  if (const auto stiffness = thing.numbers("stiffness", "N/m, N m/rad", petsc::non_negative(), 6)) {
    keys.stiffness = {{}, stiffness->mark};
    std::ranges::copy(stiffness->value, keys.stiffness->value.begin());
  }
  keys.mass = thing.number("mass", "kg", petsc::non_negative());
  return keys;
}

void add_group(MemberKeys& keys, const MemberKeys& group, const YamlThing& thing) { add_all(keys, group, thing); }
void add_group(JunctionKeys& keys, const JunctionKeys& group, const YamlThing& thing) { add_all(keys, group, thing); }
void fill(MemberKeys& own, const MemberKeys& group) { fill_all(own, group); }
void fill(JunctionKeys& own, const JunctionKeys& group) { fill_all(own, group); }

void apply(Junction& junction, const JunctionKeys& keys) {
  junction.held = keys.held ? keys.held->value : junction.held;
  junction.stiffness = keys.stiffness ? keys.stiffness->value : junction.stiffness;
  junction.mass = keys.mass ? keys.mass->value : junction.mass;
}

void apply(Member& member, const MemberKeys& keys) {
  member.section = keys.section ? keys.section->value : member.section;
  member.orientation = keys.orientation ? keys.orientation->value : member.orientation;
  for (std::size_t end = 0; end < 2; ++end) {
    MemberEnd& at = member.ends.at(end);
    at.joint = keys.joint.at(end) ? keys.joint.at(end)->value : at.joint;
    at.offset = keys.offset.at(end) ? keys.offset.at(end)->value : at.offset;
  }
}

}  // namespace udar::io
