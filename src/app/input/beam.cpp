#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
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

constexpr const char* kPerSegment = "one per segment of -beam_length";

/// What is given for each segment.
class SegmentLists {
 public:
  void read(OptionGroup& group) {
    length_.read(group, "m", petsc::positive(), "length of each segment");
    group.integers("-beam_elements", elements_, petsc::at_least(1), "elements of each segment");
    modulus_.read(group, "Pa", petsc::positive(), "Young's modulus E");
    density_.read(group, "kg/m^3", petsc::positive(), "density");
    group.real("-beam_poisson_ratio", poisson_ratio_, "-", petsc::between(0.0, 0.5),
               "Poisson's ratio; enters the shear stiffness only");
    group.choice<Theory>("-beam_theory", theory_, kTheories, "bending alone, or bending and shear (kGA)");
    sections_ = read_sections(group, count(), poisson_ratio_);
    bending_.read(group, "N m^2", petsc::positive(), "EI; default from section and modulus");
    mass_.read(group, "kg/m", petsc::positive(), "rhoA; default from section and density");
    shear_.read(group, "N", petsc::positive(), "kGA for -beam_theory timoshenko; default from section and modulus");
    fibre_.read(group, "m", petsc::positive(),
                "largest distance of the section from its neutral axis, for the bending stress; default from the "
                "section, none for direct and with -beam_bending_stiffness");
    yield_.read(group, "Pa", petsc::non_negative(),
                "what the largest bending stress is compared with, utilisation 1; 0: nothing");
    yield_moment_.read(group, "N m", petsc::positive_or_infinite(),
                       "moment at which the beam yields, its plastic moment; inf: it stays elastic. By -ts_type moreau "
                       "and, at up to 8 hinges, chebyshev");
    shape_factor_.read(
        group, "-", petsc::positive(),
        "in place of -beam_yield_moment: plastic over elastic moment of the section, 1.5 of a rectangle, "
        "16/(3 pi) of a circle; it yields at this times -beam_yield_stress times I/c");
    foundation_.read(group, "N/m^2", petsc::non_negative(),
                     "elastic foundation, force per length and displacement from the reference axis, both ways");
  }

  /// One entry per segment in each list; those without default stay empty if they were not given.
  void settle() {
    elements_ = petsc::one_per("-beam_elements", elements_, count(), kPerSegment);
    for (NumberList* list : {&modulus_, &density_, &yield_, &foundation_}) {
      list->spread(count(), kPerSegment);
    }
    if (yield_moment_.given && shape_factor_.given) {
      throw InputError{"options -beam_yield_moment and -beam_shape_factor exclude each other"};
    }
    for (NumberList* list : {&bending_, &mass_, &fibre_, &shear_, &yield_moment_, &shape_factor_}) {
      if (list->given) {
        list->spread(count(), kPerSegment);
      }
    }
    if (shear_.given && theory_ != Theory::timoshenko) {
      throw InputError{"option -beam_shear_stiffness needs -beam_theory timoshenko"};
    }
  }

  [[nodiscard]] std::size_t count() const noexcept { return length_.values.size(); }

  [[nodiscard]] BeamSegment segment(std::size_t i) const {
    const double modulus = section_modulus(i);
    if (yield_[i] > 0.0 && !(modulus > 0.0)) {
      throw InputError{"option -beam_yield_stress needs -beam_outer_fibre [m]: the section of segment " +
                       std::to_string(i) + " does not say how far its outermost fibre is from the neutral axis"};
    }
    return {.length = length_[i],
            .elements = elements_[i],
            .bending_stiffness = bending_.given ? bending_[i] : modulus_[i] * sections_[i].inertia,
            .mass_per_length = mass_.given ? mass_[i] : density_[i] * sections_[i].area,
            .shear_stiffness = shear_stiffness(i),
            .foundation_stiffness = foundation_[i],
            .section_modulus = modulus,
            .yield_stress = yield_[i],
            .yield_moment = yield_moment(i, modulus),
            .radius = radius(i)};
  }

  /// Warns of what looks like a slip of unit where material and section say what the beam is.
  void judge(MPI_Comm comm) const {
    const double length = std::accumulate(length_.values.begin(), length_.values.end(), 0.0);
    for (std::size_t i = 0; i < count() && !bending_.given && !mass_.given; ++i) {
      judge_material(comm, modulus_[i], density_[i]);
      judge_section(comm, sections_[i], length);
    }
  }

 private:
  [[nodiscard]] double yield_moment(std::size_t i, double modulus) const {
    if (shape_factor_.given && !(yield_[i] > 0.0)) {
      throw InputError{"option -beam_shape_factor needs -beam_yield_stress above 0 [Pa]"};
    }
    const double given = yield_moment_.given ? yield_moment_[i] : std::numeric_limits<double>::infinity();
    return shape_factor_.given ? shape_factor_[i] * modulus * yield_[i] : given;
  }

  [[nodiscard]] double shear_stiffness(std::size_t i) const {
    if (theory_ == Theory::euler_bernoulli) {
      return std::numeric_limits<double>::infinity();
    }
    const double shear_modulus = modulus_[i] / (2.0 * (1.0 + poisson_ratio_));
    return shear_.given ? shear_[i] : sections_[i].shear_coefficient * shear_modulus * sections_[i].area;
  }

  /// c; 0: not known.
  [[nodiscard]] double outer_fibre(std::size_t i) const {
    const double of_section = bending_.given ? 0.0 : sections_[i].outer_fibre;
    return fibre_.given ? fibre_[i] : of_section;
  }

  /// I / c; 0: c is not known.
  [[nodiscard]] double section_modulus(std::size_t i) const {
    const double inertia = bending_.given ? bending_[i] / modulus_[i] : sections_[i].inertia;
    const double outer = outer_fibre(i);
    return outer > 0.0 ? inertia / outer : 0.0;
  }

  /// As far as the section reaches, or of a circle of its area; 0: not known.
  [[nodiscard]] double radius(std::size_t i) const {
    const double of_area = bending_.given ? 0.0 : std::sqrt(sections_[i].area / std::numbers::pi);
    return outer_fibre(i) > 0.0 ? outer_fibre(i) : of_area;
  }

  NumberList length_{"-beam_length", {10.0}};
  std::vector<PetscInt> elements_{20};
  NumberList modulus_{"-beam_young_modulus", {2.1e11}};
  NumberList density_{"-beam_density", {7850.0}};
  double poisson_ratio_ = 0.3;
  Theory theory_ = Theory::euler_bernoulli;
  std::vector<Section> sections_;
  NumberList bending_{"-beam_bending_stiffness"};
  NumberList mass_{"-beam_mass_per_length"};
  NumberList shear_{"-beam_shear_stiffness"};
  NumberList fibre_{"-beam_outer_fibre"};
  NumberList yield_{"-beam_yield_stress", {0.0}};
  NumberList yield_moment_{"-beam_yield_moment"};
  NumberList shape_factor_{"-beam_shape_factor"};
  NumberList foundation_{"-beam_foundation", {0.0}};
};

/// Things at places along the beam: pairs of a place and a value.
template <class Thing>
std::vector<Thing> paired(const NumberList& places, NumberList values, const char* per_place) {
  std::vector<Thing> things;
  things.reserve(places.values.size());
  if (!places.values.empty() || values.given) {
    values.spread(places.values.size(), per_place);
  }
  for (std::size_t i = 0; i < places.values.size(); ++i) {
    things.push_back({places[i], values[i]});
  }
  return things;
}

/// Where a beam with a yield moment yields.
class PlasticityLists {
 public:
  void read(OptionGroup& group) {
    position_.read(group, "m", petsc::non_negative(),
                   "plastic hinges of a beam with a yield moment: the nearest nodes; default: every node");
    hardening_.read(group, "N m/rad", petsc::non_negative(),
                    "kinematic hardening of these hinges: how the moment grows with the plastic rotation; one per "
                    "-beam_hinge_position or one for all");
    ratio_given_ = group.real("-beam_yield_hardening", ratio_, "-", petsc::between(0.0, 1.0),
                              "kinematic hardening of a beam that yields at every node: its bending stiffness after "
                              "yielding over EI, below 1");
  }
  [[nodiscard]] BeamPlasticity settled(const BeamParameters& beam) const {
    if ((position_.given || ratio_given_) && !beam.yields()) {
      throw InputError{
          "options -beam_hinge_position and -beam_yield_hardening need -beam_yield_moment [N m] or -beam_shape_factor"};
    }
    if (position_.given && ratio_given_) {
      throw InputError{
          "option -beam_yield_hardening is not for hinges at -beam_hinge_position, expected -beam_hinge_hardening "
          "[N m/rad]"};
    }
    if (hardening_.given && !position_.given) {
      throw InputError{"option -beam_hinge_hardening needs -beam_hinge_position [m]"};
    }
    if (ratio_ == 1.0) {
      throw InputError{"option -beam_yield_hardening: 1 is not allowed, expected a number >= 0 and < 1 [-]"};
    }
    return {.places = paired<HingePlace>(position_, hardening_, "one per -beam_hinge_position"),
            .tangent_ratio = ratio_};
  }

 private:
  NumberList position_{"-beam_hinge_position"};
  NumberList hardening_{"-beam_hinge_hardening", {0.0}};
  bool ratio_given_ = false;
  double ratio_ = 0.0;
};

}  // namespace

BeamInput read_beam(MPI_Comm comm) {
  OptionGroup group{
      comm,
      "Beam: one straight beam from x = 0, uniform or in segments (lists: one entry per segment, or one for all)"};
  BeamInput input;
  BeamParameters& beam = input.beam;
  SegmentLists segments;
  segments.read(group);
  PlasticityLists plasticity;
  plasticity.read(group);
  group.real("-beam_tension", beam.tension, "N", petsc::non_negative(), "axial tension");
  beam.left = read_end(group, "left");
  beam.right = read_end(group, "right");
  NumberList gap{"-beam_gap"};
  gap.read(group, "m", petsc::non_negative(),
           "space between segments, one per joint or one for all; > 0: they are different beams with free ends there");
  NumberList line_position{"-beam_line_support_position"};
  line_position.read(group, "m", petsc::non_negative(),
                     "where the line itself is held to the axis, both ways: the nearest node");
  NumberList line_stiffness{"-beam_line_support_stiffness", {BeamEnd::kRigid}};
  line_stiffness.read(group, "N/m", petsc::non_negative_or_infinite(),
                      "springs there, one per position or one for all; inf: rigid");
  NumberList point_position{"-beam_point_mass_position"};
  point_position.read(group, "m", petsc::non_negative(), "where point masses sit: the nearest node");
  NumberList point_mass{"-beam_point_mass"};
  point_mass.read(group, "kg", petsc::positive(), "point masses, one per position or one for all");
  group.choice<Formulation>(
      "-beam_formulation", input.formulation, kFormulations,
      "unknowns of the line: displacement and moment (mixed), or displacement and rotation (hermite), "
      "which loses its digits on fine meshes");

  segments.settle();
  const std::size_t count = segments.count();
  if (gap.given && count == 1) {
    throw InputError{"option -beam_gap needs at least two segments in -beam_length"};
  }
  gap.values = gap.given ? gap.values : Numbers{0.0};
  if (count > 1) {
    gap.spread(count - 1, "one per joint between segments of -beam_length");
  }
  segments.judge(comm);
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0 && gap[i - 1] > 0.0) {
      beam.segments.push_back({.length = gap[i - 1], .elements = 1});
    }
    beam.segments.push_back(segments.segment(i));
  }
  beam.line_supports = paired<LineSupport>(line_position, line_stiffness, "one per -beam_line_support_position");
  beam.point_masses = paired<PointMass>(point_position, point_mass, "one per -beam_point_mass_position");
  beam.plasticity = plasticity.settled(beam);
  return input;
}

}  // namespace udar::app
