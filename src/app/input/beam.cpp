#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "app/input/readers.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/warnings.hpp"
#include "udar/structure/section.hpp"

namespace udar::app {
namespace {

using petsc::OptionGroup;

enum class SectionKind { circle, tube, rectangle, direct };
enum class Theory { euler_bernoulli, timoshenko };
enum class EndKind { free, pinned, clamped, spring };

constexpr std::array kSections{
    Names<SectionKind>{"circle", SectionKind::circle}, Names<SectionKind>{"tube", SectionKind::tube},
    Names<SectionKind>{"rectangle", SectionKind::rectangle}, Names<SectionKind>{"direct", SectionKind::direct}};
constexpr std::array kTheories{Names<Theory>{"euler_bernoulli", Theory::euler_bernoulli},
                               Names<Theory>{"timoshenko", Theory::timoshenko}};
constexpr std::array kEnds{Names<EndKind>{"free", EndKind::free}, Names<EndKind>{"pinned", EndKind::pinned},
                           Names<EndKind>{"clamped", EndKind::clamped}, Names<EndKind>{"spring", EndKind::spring}};
constexpr std::array kFormulations{Names<Formulation>{"mixed", Formulation::mixed},
                                   Names<Formulation>{"hermite", Formulation::hermite}};

/// One size of a cross-section: which section needs it, whether it was given, one value per segment.
struct Size {
  const char* key;
  SectionKind section;
  bool given = false;
  Numbers values;
};

/// Reads the sizes of the sections; every size a section needs must be there, every size given must be needed.
std::vector<Section> read_sections(OptionGroup& group, std::size_t count, double poisson_ratio) {
  std::vector<SectionKind> kinds{SectionKind::circle};
  group.choices<SectionKind>(
      "-beam_section", kinds, kSections,
      "cross-section: circle (-beam_radius), tube (-beam_radius, -beam_inner_radius), rectangle "
      "(-beam_width, -beam_height) or direct (-beam_area, -beam_inertia); one, or one per segment");
  kinds = petsc::one_per("-beam_section", kinds, count, "one per segment of -beam_length");
  Numbers radius{0.1};
  const bool radius_given =
      group.reals("-beam_radius", radius, "m", petsc::positive(), "outer radius of circle or tube");
  std::array sizes{
      Size{"-beam_inner_radius", SectionKind::tube, false, {}}, Size{"-beam_width", SectionKind::rectangle, false, {}},
      Size{"-beam_height", SectionKind::rectangle, false, {}}, Size{"-beam_area", SectionKind::direct, false, {}},
      Size{"-beam_inertia", SectionKind::direct, false, {}}};
  constexpr std::array kTexts{"inner radius of tube", "width of rectangle, across the plane of bending",
                              "height of rectangle, in the plane of bending", "cross-section area",
                              "second moment of area of the cross-section"};
  constexpr std::array kUnits{"m", "m", "m", "m^2", "m^4"};
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    sizes[i].given = group.reals(sizes[i].key, sizes[i].values, kUnits[i], petsc::positive(), kTexts[i]);
  }
  Numbers shear{};
  const bool shear_given =
      group.reals("-beam_shear_coefficient", shear, "-", petsc::positive(),
                  "Timoshenko's k in kGA; default by Cowper (1966) from the section, 5/6 for direct");
  radius = petsc::one_per("-beam_radius", radius, count, "one per segment of -beam_length");
  if (shear_given) {
    shear = petsc::one_per("-beam_shear_coefficient", shear, count, "one per segment of -beam_length");
  }
  const auto used = [&kinds](SectionKind kind) { return std::ranges::find(kinds, kind) != kinds.end(); };
  for (Size& size : sizes) {
    if (size.given && !used(size.section)) {
      throw InputError{std::string{"option "} + size.key + " does not belong to the -beam_section in use"};
    }
    if (!size.given && used(size.section)) {
      throw InputError{std::string{"option "} + size.key + " is needed by the -beam_section in use"};
    }
    if (size.given) {
      size.values = petsc::one_per(size.key, size.values, count, "one per segment of -beam_length");
    }
  }
  if (radius_given && !used(SectionKind::circle) && !used(SectionKind::tube)) {
    throw InputError{"option -beam_radius does not belong to the -beam_section in use"};
  }
  std::vector<Section> sections;
  for (std::size_t i = 0; i < count; ++i) {
    Section section;
    switch (kinds[i]) {
      case SectionKind::circle:
        section = circle_section(radius[i], poisson_ratio);
        break;
      case SectionKind::tube:
        if (!(sizes[0].values[i] < radius[i])) {
          throw InputError{"option -beam_inner_radius must be smaller than -beam_radius [m]"};
        }
        section = tube_section(radius[i], sizes[0].values[i], poisson_ratio);
        break;
      case SectionKind::rectangle:
        section = rectangle_section(sizes[1].values[i], sizes[2].values[i], poisson_ratio);
        break;
      case SectionKind::direct:
        section = {.area = sizes[3].values[i], .inertia = sizes[4].values[i], .shear_coefficient = 5.0 / 6.0};
        break;
    }
    if (shear_given) {
      section.shear_coefficient = shear[i];
    }
    sections.push_back(section);
  }
  return sections;
}

BeamEnd read_end(OptionGroup& group, const std::string& side) {
  const std::string key = "-beam_" + side;
  EndKind kind = EndKind::free;
  BeamEnd end;
  group.choice<EndKind>((key + "_end").c_str(), kind, kEnds, "how this end of the line is held");
  const bool spring_given = group.real((key + "_spring").c_str(), end.translational_stiffness, "N/m",
                                       petsc::non_negative(), "stiffness against displacement of a spring end");
  const bool rotational_given = group.real((key + "_rotational_spring").c_str(), end.rotational_stiffness, "N m/rad",
                                           petsc::non_negative(), "stiffness against rotation of a spring end");
  if ((spring_given || rotational_given) && kind != EndKind::spring) {
    throw InputError{"option " + key + "_spring needs " + key + "_end spring"};
  }
  if (kind == EndKind::pinned || kind == EndKind::clamped) {
    end.translational_stiffness = BeamEnd::kRigid;
    end.rotational_stiffness = kind == EndKind::clamped ? BeamEnd::kRigid : 0.0;
  }
  return end;
}

/// A value outside the range of all that beams are made of or look like is a slip of unit as a rule.
void suspect(MPI_Comm comm, const char* what, double value, double lowest, double highest, const char* unit,
             const char* hint) {
  if (!(value >= lowest && value <= highest)) {
    petsc::warn(comm, "%s of %g %s is outside of %g to %g %s; %s", what, value, unit, lowest, highest, unit, hint);
  }
}

/// Softest rubber to diamond; stiff foam to osmium; wires to ship hulls; beams to slabs.
void judge_material(MPI_Comm comm, double modulus, double density) {
  suspect(comm, "-beam_young_modulus", modulus, 1e6, 2e12, "Pa", "steel has 2.1e11 Pa, not 210 (GPa) or 2.1e5 (MPa)");
  suspect(comm, "-beam_density", density, 10.0, 2.5e4, "kg/m^3", "steel has 7850 kg/m^3, not 7.85 (t/m^3, g/cm^3)");
}

/// By the radius of gyration, half the radius of a circle.
void judge_section(MPI_Comm comm, const Section& section, double length) {
  constexpr double kLargest = 10.0;
  constexpr double kStubby = 10.0;
  const double gyration = std::sqrt(section.inertia / section.area);
  if (gyration > kLargest) {
    petsc::warn(comm, "a section with a radius of gyration of %g m is larger than a ship's; lengths are in metres",
                gyration);
  }
  if (length < kStubby * gyration) {
    petsc::warn(comm,
                "the beam is %g m long, only %.3g times the radius of gyration of its section, %g m; that is a block, "
                "not a beam: are both in metres?",
                length, length / gyration, gyration);
  }
}

}  // namespace

BeamInput read_beam(MPI_Comm comm) {
  OptionGroup group{
      comm,
      "Beam: one straight beam from x = 0, uniform or in segments (lists: one entry per segment, or one for all)"};
  BeamInput input;
  BeamParameters& beam = input.beam;
  Numbers length{10.0};
  std::vector<PetscInt> elements{20};
  Numbers modulus{2.1e11};
  Numbers density{7850.0};
  double poisson_ratio = 0.3;
  Theory theory = Theory::euler_bernoulli;
  Numbers bending;
  Numbers mass;
  Numbers shear;
  Numbers foundation{0.0};
  Numbers fibre;
  Numbers yield{0.0};
  group.reals("-beam_length", length, "m", petsc::positive(), "length of each segment");
  const std::size_t count = length.size();
  const char* per_segment = "one per segment of -beam_length";
  group.integers("-beam_elements", elements, petsc::at_least(1), "elements of each segment");
  group.reals("-beam_young_modulus", modulus, "Pa", petsc::positive(), "Young's modulus E");
  group.reals("-beam_density", density, "kg/m^3", petsc::positive(), "density");
  group.real("-beam_poisson_ratio", poisson_ratio, "-", petsc::between(0.0, 0.5),
             "Poisson's ratio; enters the shear stiffness only");
  group.choice<Theory>("-beam_theory", theory, kTheories, "bending alone, or bending and shear (kGA)");
  const std::vector<Section> sections = read_sections(group, count, poisson_ratio);
  const bool bending_given = group.reals("-beam_bending_stiffness", bending, "N m^2", petsc::positive(),
                                         "EI; default from section and modulus");
  const bool mass_given =
      group.reals("-beam_mass_per_length", mass, "kg/m", petsc::positive(), "rhoA; default from section and density");
  const bool shear_given = group.reals("-beam_shear_stiffness", shear, "N", petsc::positive(),
                                       "kGA for -beam_theory timoshenko; default from section and modulus");
  const bool fibre_given =
      group.reals("-beam_outer_fibre", fibre, "m", petsc::positive(),
                  "largest distance of the section from its neutral axis, for the bending stress; default from the "
                  "section, none for direct and with -beam_bending_stiffness");
  group.reals("-beam_yield_stress", yield, "Pa", petsc::non_negative(),
              "what the largest bending stress is compared with, utilisation 1; 0: nothing");
  group.reals("-beam_foundation", foundation, "N/m^2", petsc::non_negative(),
              "elastic foundation, force per length and displacement from the reference axis, both ways");
  group.real("-beam_tension", beam.tension, "N", petsc::non_negative(), "axial tension");
  beam.left = read_end(group, "left");
  beam.right = read_end(group, "right");
  Numbers gap;
  group.reals(
      "-beam_gap", gap, "m", petsc::non_negative(),
      "space between segments, one per joint or one for all; > 0: they are different beams with free ends there");
  Numbers line_position;
  Numbers line_stiffness{BeamEnd::kRigid};
  group.reals("-beam_line_support_position", line_position, "m", petsc::non_negative(),
              "where the line itself is held to the axis, both ways: the nearest node");
  const bool line_stiffness_given =
      group.reals("-beam_line_support_stiffness", line_stiffness, "N/m", petsc::non_negative_or_infinite(),
                  "springs there, one per position or one for all; inf: rigid");
  Numbers point_position;
  Numbers point_mass;
  group.reals("-beam_point_mass_position", point_position, "m", petsc::non_negative(),
              "where point masses sit: the nearest node");
  group.reals("-beam_point_mass", point_mass, "kg", petsc::positive(), "point masses, one per position or one for all");
  group.choice<Formulation>(
      "-beam_formulation", input.formulation, kFormulations,
      "unknowns of the line: displacement and moment (mixed), or displacement and rotation (hermite), "
      "which loses its digits on fine meshes");

  elements = petsc::one_per("-beam_elements", elements, count, per_segment);
  modulus = petsc::one_per("-beam_young_modulus", modulus, count, per_segment);
  density = petsc::one_per("-beam_density", density, count, per_segment);
  yield = petsc::one_per("-beam_yield_stress", yield, count, per_segment);
  foundation = petsc::one_per("-beam_foundation", foundation, count, per_segment);
  bending = bending_given ? petsc::one_per("-beam_bending_stiffness", bending, count, per_segment) : Numbers{};
  mass = mass_given ? petsc::one_per("-beam_mass_per_length", mass, count, per_segment) : Numbers{};
  fibre = fibre_given ? petsc::one_per("-beam_outer_fibre", fibre, count, per_segment) : Numbers(count, 0.0);
  const auto section_modulus = [&](std::size_t i) {  // I / c; 0: c is not known
    const double inertia = bending_given ? bending[i] / modulus[i] : sections[i].inertia;
    const double outer = fibre_given || bending_given ? fibre[i] : sections[i].outer_fibre;
    return outer > 0.0 ? inertia / outer : 0.0;
  };
  shear = shear_given ? petsc::one_per("-beam_shear_stiffness", shear, count, per_segment) : Numbers{};
  if (shear_given && theory != Theory::timoshenko) {
    throw InputError{"option -beam_shear_stiffness needs -beam_theory timoshenko"};
  }
  if (!gap.empty() && count == 1) {
    throw InputError{"option -beam_gap needs at least two segments in -beam_length"};
  }
  gap = gap.empty() ? Numbers(count - 1, 0.0)
                    : petsc::one_per("-beam_gap", gap, count - 1, "one per joint between segments of -beam_length");
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0 && gap[i - 1] > 0.0) {
      beam.segments.push_back({.length = gap[i - 1], .elements = 1});
    }
    if (!bending_given && !mass_given) {
      judge_material(comm, modulus[i], density[i]);
      judge_section(comm, sections[i], std::accumulate(length.begin(), length.end(), 0.0));
    }
    const double shear_modulus = modulus[i] / (2.0 * (1.0 + poisson_ratio));
    const double section_shear = sections[i].shear_coefficient * shear_modulus * sections[i].area;
    beam.segments.push_back({.length = length[i],
                             .elements = elements[i],
                             .bending_stiffness = bending_given ? bending[i] : modulus[i] * sections[i].inertia,
                             .mass_per_length = mass_given ? mass[i] : density[i] * sections[i].area,
                             .shear_stiffness = theory == Theory::euler_bernoulli
                                                    ? std::numeric_limits<double>::infinity()
                                                : shear_given ? shear[i]
                                                              : section_shear,
                             .foundation_stiffness = foundation[i],
                             .section_modulus = section_modulus(i),
                             .yield_stress = yield[i]});
    if (yield[i] > 0.0 && !(beam.segments.back().section_modulus > 0.0)) {
      throw InputError{"option -beam_yield_stress needs -beam_outer_fibre [m]: the section of segment " +
                       std::to_string(i) + " does not say how far its outermost fibre is from the neutral axis"};
    }
  }
  if (!line_position.empty() || line_stiffness_given) {
    line_stiffness = petsc::one_per("-beam_line_support_stiffness", line_stiffness, line_position.size(),
                                    "one per -beam_line_support_position");
  }
  for (std::size_t i = 0; i < line_position.size(); ++i) {
    beam.line_supports.push_back({.position = line_position[i], .stiffness = line_stiffness[i]});
  }
  if (!point_position.empty() || !point_mass.empty()) {
    point_mass =
        petsc::one_per("-beam_point_mass", point_mass, point_position.size(), "one per -beam_point_mass_position");
    for (std::size_t i = 0; i < point_position.size(); ++i) {
      beam.point_masses.push_back({.position = point_position[i], .mass = point_mass[i]});
    }
  }
  return input;
}

}  // namespace udar::app
