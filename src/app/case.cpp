#include "udar/app/case.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <numeric>
#include <sstream>
#include <utility>

#include "udar/io/table_file.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/session.hpp"
#include "udar/petsc/warnings.hpp"
#include "udar/structure/section.hpp"

namespace udar::app {
namespace {

using petsc::OptionGroup;
using Strings = std::vector<std::string>;
using Numbers = std::vector<double>;

enum class SectionKind { circle, tube, rectangle, direct };
enum class Theory { euler_bernoulli, timoshenko };
enum class EndKind { free, pinned, clamped, spring };
enum class Weighting { tributary, inclusive };

template <class T>
using Names = std::pair<const char*, T>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr std::array kSections{
    Names<SectionKind>{"circle", SectionKind::circle}, Names<SectionKind>{"tube", SectionKind::tube},
    Names<SectionKind>{"rectangle", SectionKind::rectangle}, Names<SectionKind>{"direct", SectionKind::direct}};
constexpr std::array kTheories{Names<Theory>{"euler_bernoulli", Theory::euler_bernoulli},
                               Names<Theory>{"timoshenko", Theory::timoshenko}};
constexpr std::array kEnds{Names<EndKind>{"free", EndKind::free}, Names<EndKind>{"pinned", EndKind::pinned},
                           Names<EndKind>{"clamped", EndKind::clamped}, Names<EndKind>{"spring", EndKind::spring}};
constexpr std::array kFormulations{Names<Formulation>{"mixed", Formulation::mixed},
                                   Names<Formulation>{"hermite", Formulation::hermite}};
constexpr std::array kSides{Names<SupportSide>{"below", SupportSide::below},
                            Names<SupportSide>{"above", SupportSide::above}};
constexpr std::array kSurfaces{Names<ContactSurface>{"mass", ContactSurface::mass},
                               Names<ContactSurface>{"line", ContactSurface::line}};
constexpr std::array kWeightings{Names<Weighting>{"tributary", Weighting::tributary},
                                 Names<Weighting>{"inclusive", Weighting::inclusive}};

Numbers column(const io::Table& table, std::size_t index) {
  Numbers values(table.rows());
  for (std::size_t row = 0; row < values.size(); ++row) {
    values[row] = table.at(row, index);
  }
  return values;
}

/// @param jumps whether two equal values are a jump
void require_ascending(const char* option, const std::string& path, const Numbers& values, const char* what,
                       bool jumps = false) {
  auto found = std::ranges::adjacent_find(values, std::ranges::greater_equal{});
  while (jumps && found != values.end() && found[1] == found[0] && (values.end() - found < 3 || found[2] > found[1])) {
    found = std::adjacent_find(found + 1, values.end(), std::ranges::greater_equal{});
  }
  if (found != values.end()) {
    std::ostringstream message;
    message << "option " << option << ": '" << path << "': the " << what << " in column 1 must be "
            << (jumps ? "ascending, with at most two equal ones for a jump, " : "strictly ascending, ") << found[1]
            << " follows " << found[0];
    throw InputError{message.str()};
  }
}

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

}  // namespace

namespace {

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

BeamParameters read_beam(MPI_Comm comm, Formulation& formulation) {
  OptionGroup group{
      comm,
      "Beam: one straight beam from x = 0, uniform or in segments (lists: one entry per segment, or one for all)"};
  BeamParameters beam;
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
      "-beam_formulation", formulation, kFormulations,
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
  return beam;
}

FilterInput read_filter(MPI_Comm comm, Formulation formulation) {
  OptionGroup group{
      comm, "Filter: the fictitious springs between masses and line (solver options: -filter_ksp_*, -filter_pc_*)"};
  FilterInput filter;
  filter.formulation = formulation;
  std::string word;
  const bool given = group.real_or_word(
      "-filter_frequency", filter.filter_frequency, word, {"auto", "none"}, "rad/s", petsc::positive(),
      "filter frequency wf: all frequencies of the model fall below it; auto: the least that keeps "
      "-filter_accuracy; none: the unfiltered beam, by -ts_type moreau with steps of -ts_dt; "
      "required");
  filter.unfiltered = word == "none";
  filter.automatic = word == "auto";
  const bool accuracy_given =
      group.real("-filter_accuracy", filter.accuracy, "-", {.lowest = 0.0, .highest = 0.5, .lowest_excluded = true},
                 "for -filter_frequency auto: how much the filter may lower a frequency that "
                 "matters, as a share of it");
  const bool modes_given = group.integer("-filter_modes", filter.modes, petsc::at_least(1),
                                         "for -filter_frequency auto: so many of the lowest flexible modes matter");
  const bool band_given = group.real("-filter_band", filter.band, "rad/s", petsc::positive(),
                                     "for -filter_frequency auto, instead of -filter_modes: all frequencies up to this "
                                     "one matter");
  group.integer("-filter_correct_modes", filter.correct_lowest, petsc::non_negative(),
                "so many of the lowest flexible modes vibrate at their unfiltered frequency, those above wf excepted; "
                "each costs a dot product and an axpy per line solve and 8 bytes per node, all together one reduction "
                "per line solve or batch of them");
  group.integers("-filter_correct_mode", filter.correct, petsc::at_least(1),
                 "the same for modes by their numbers, 1 the lowest flexible one; one above wf raises the largest "
                 "frequency, and shortens the time step, to its own");
  if (!filter.automatic && (accuracy_given || modes_given || band_given)) {
    throw InputError{std::string{"option "} +
                     (accuracy_given ? "-filter_accuracy" : (modes_given ? "-filter_modes" : "-filter_band")) +
                     " needs -filter_frequency auto"};
  }
  if (filter.unfiltered && (filter.correct_lowest > 0 || !filter.correct.empty())) {
    throw InputError{
        "options -filter_correct_modes and -filter_correct_mode need a filter: -filter_frequency none has "
        "nothing to correct"};
  }
  if (modes_given && band_given) {
    throw InputError{
        "options -filter_modes and -filter_band exclude each other: give the number of modes that matter "
        "or the band they are in [rad/s]"};
  }
  group.integer("-filter_check_interval", filter.check_interval, petsc::non_negative(),
                "every so many line solves the residual is checked; 0: never");
  group.real("-filter_residual_tolerance", filter.residual_tolerance, "-", petsc::positive(),
             "largest backward error of a line solve that passes the check");
  PetscInt lanes = 0;
  group.integer("-filter_pc_chain_lanes", lanes, petsc::between(0.0, 8.0),
                "stretches of line that the chain solver treats side by side in vector registers: 8, 4 or 1; 0: what "
                "the processor has");  // read by the preconditioner itself
  if (!given && !petsc::Session::help_requested()) {
    throw InputError{"option -filter_frequency is required: a number > 0 [rad/s] or auto"};
  }
  return filter;
}

namespace {

void read_initial(MPI_Comm comm, Case& input) {
  OptionGroup group{comm,
                    "Start and loads (y points up; the axis is the straight line on which springs are unstressed)"};
  input.initial.height = 1.0;
  std::string shape;
  Numbers load_position;
  Strings load_table;
  group.real("-gravity", input.gravity, "m/s^2", petsc::any(), "acceleration downward; acts on the line");
  group.real("-initial_height", input.initial.height, "m", petsc::any(),
             "height of the axis at mid-length above y = 0");
  group.real("-initial_slope", input.initial.slope, "-", petsc::any(), "slope of the axis");
  group.real("-initial_velocity", input.initial.velocity, "m/s", petsc::any(), "velocity of all masses, up");
  group.real("-initial_angular_velocity", input.initial.angular_velocity, "rad/s", petsc::any(),
             "about mid-length, counter-clockwise");
  group.string(
      "-initial_shape", shape,
      "CSV file x [m], offset from the axis [m] and, if there is a third column, velocity [m/s]; linear between rows");
  group.reals("-load_position", load_position, "m", petsc::non_negative(),
              "where forces act; between two nodes on both, with force and moment kept");
  group.strings("-load_table", load_table,
                "CSV files time [s], force [N, up], one per -load_position or one for all; linear between rows, a jump "
                "between two rows of one time, constant outside");
  group.real("-damping_mass", input.damping.mass, "1/s", petsc::non_negative(),
             "alpha of Rayleigh damping: a force -alpha M Ym'; ratio alpha / (2 lambda) of a mode lambda; for -ts_type "
             "impact and rk");
  group.real("-damping_stiffness", input.damping.stiffness, "s", petsc::non_negative(),
             "beta of Rayleigh damping: a force beta wf^2 M d(Ym'), d(Ym') the stretch that these velocities alone "
             "give the line; ratio beta lambda / 2 of a mode lambda; the same, with -contact_surface mass");
  if (!shape.empty()) {
    const io::Table table =
        io::read_table(comm, "-initial_shape", shape, {.names = {"x [m]", "offset [m]", "velocity [m/s]"}});
    input.initial.shape.x = column(table, 0);
    input.initial.shape.offset = column(table, 1);
    if (table.columns > 2) {
      input.initial.shape.velocity = column(table, 2);
    }
    require_ascending("-initial_shape", shape, input.initial.shape.x, "positions [m]");
  }
  if (!load_position.empty() || !load_table.empty()) {
    load_table = petsc::one_per("-load_table", load_table, load_position.size(), "one per -load_position");
    for (std::size_t i = 0; i < load_position.size(); ++i) {
      const io::Table table = io::read_table(comm, "-load_table", load_table[i], {.names = {"time [s]", "force [N]"}});
      require_ascending("-load_table", load_table[i], column(table, 0), "times [s]", true);
      input.loads.push_back({.position = load_position[i], .time = column(table, 0), .force = column(table, 1)});
    }
  }
}

/// The longest step, at most `wished`, that divides the interval between rows and the end of the run, if such a one
/// exists without many steps for every row, else the end alone.
double even_step(double wished, double interval, double end) {
  constexpr double kWhole = 1e-9;  // far from an integer by less: decimal fractions that rounding has touched
  constexpr int kMany = 20;
  double whole = end;
  for (int parts = kMany; parts > 0; --parts) {
    const double rows = end / interval * parts;
    whole = std::abs(rows - std::round(rows)) < kWhole * rows ? interval / parts : whole;
  }
  return whole / std::ceil(whole / wished * (1.0 - kWhole));
}

/// The keys of PETSc's TS that every case needs: checked and explained here, read by the TS itself.
void read_integration(MPI_Comm comm, Case& input) {
  OptionGroup group{comm, "Integration (PETSc's TS; all of its keys apply)"};
  double& end = input.end_time;
  double rtol = 1e-8;
  double atol = 0.0;
  double step = 0.0;
  group.real("-ts_max_time", end, "s", petsc::positive(), "simulated time at which the run ends");
  group.real("-ts_rtol", rtol, "-", petsc::at_least(std::numeric_limits<double>::epsilon()),
             "relative error allowed per step; default 1e-14 for -ts_type chebyshev, 1e-7 for impact, else 1e-8");
  group.real("-ts_atol", atol, "m and m/s", petsc::positive(),
             "absolute error allowed per step; default rtol / 20 of the motion's own scale, for chebyshev and impact "
             "none besides rtol of it");
  const bool step_given = group.real("-ts_dt", step, "s", petsc::positive(),
                                     "first step, or every step with -ts_adapt_type none; default 0.1 / wf; for "
                                     "-ts_type moreau every step, shortened to divide -output_interval and the end");
  if (input.filter.unfiltered) {
    if (!step_given && !petsc::Session::help_requested()) {
      throw InputError{"option -ts_dt is required with -filter_frequency none: a number > 0 [s]"};
    }
    input.filter.filter_frequency = 2.0 / even_step(step, input.output.interval, end);
  }
}

std::shared_ptr<const SupportMotion> read_motion(MPI_Comm comm, const std::string& path) {
  const io::Table table =
      io::read_table(comm, "-support_motion", path, {.names = {"time [s]", "height [m]", "velocity [m/s]"}});
  require_ascending("-support_motion", path, column(table, 0), "times [s]");
  return std::make_shared<SupportMotion>(column(table, 0), column(table, 1),
                                         table.columns > 2 ? column(table, 2) : Numbers{});
}

/// Refuses an impact law for a support on springs; a restitution of 1 in a list for others passes.
void given_with_spring(bool restitution_given, double restitution, double yield_speed) {
  if (yield_speed < kInfinity || (restitution_given && restitution != 1.0)) {
    std::ostringstream message;
    message << "option " << (yield_speed < kInfinity ? "-support_yield_speed" : "-contact_restitution") << ": "
            << (yield_speed < kInfinity ? yield_speed : restitution)
            << " is not allowed with -support_stiffness, expected " << (yield_speed < kInfinity ? "inf" : "1")
            << ": spring and damper decide how a mass leaves [-]";
    throw InputError{message.str()};
  }
}

void read_contact(MPI_Comm comm, Case& input) {
  OptionGroup group{comm, "Supports and contact (lists: one entry per support, or one for all)"};
  Numbers position;
  Numbers width{0.0};
  Numbers height{0.0};
  Numbers restitution{1.0};
  std::vector<SupportSide> side{SupportSide::below};
  Weighting weighting = Weighting::tributary;
  bool floor = false;
  double floor_height = 0.0;
  std::string ground_file;
  Numbers yield_speed{kInfinity};
  Strings motion{"none"};
  Numbers stiffness{kInfinity};
  Numbers damping{0.0};
  group.reals("-support_position", position, "m", petsc::any(), "centres of the rigid supports");
  const bool width_given = group.reals("-support_width", width, "m", petsc::non_negative(),
                                       "width along the beam; 0: the nearest node alone");
  group.choice<Weighting>("-support_weighting", weighting, kWeightings,
                          "what the nodes within a width carry: tributary, together the mass of the width at any mesh, "
                          "or inclusive, each its whole lumped mass, edges included");
  const bool height_given =
      group.reals("-support_height", height, "m", petsc::any(), "height of the contact face above y = 0");
  const bool side_given =
      group.choices<SupportSide>("-support_side", side, kSides, "on which side of the beam the support stands");
  group.boolean("-floor", floor, "a rigid floor under the whole beam");
  const bool floor_height_given =
      group.real("-floor_height", floor_height, "m", petsc::any(), "height of the floor above y = 0");
  group.string("-ground_profile", ground_file,
               "CSV file x [m], height [m]: an uneven ground under the whole beam in place of -floor; linear between "
               "rows, constant outside");
  const bool restitution_given =
      group.reals("-contact_restitution", restitution, "-", petsc::between(0.0, 1.0),
                  "restitution e in v+ = -e v-; one, or one per support (floor or ground after the last support)");
  group.reals("-support_yield_speed", yield_speed, "m/s", petsc::positive_or_infinite(),
              "impact speed v_y above which restitution falls, e (v / v_y)^(-1/4); one, or one per support (floor or "
              "ground after the last support); inf: it does not");
  group.choice<ContactSurface>("-contact_surface", input.contact.surface, kSurfaces,
                               "who touches the supports: the masses, by the impact law, or the line, held off by "
                               "contact forces without any restitution");
  group.integer(
      "-contact_line_dense_max", input.contact.line_dense_max, petsc::at_least(0.0),
      "contact nodes of the line under one support up to which (and to 2000 in all) their compliance is a matrix "
      "on every rank; more go to an interior point method (TAO, prefix contact_)");
  group.real("-contact_tolerance", input.contact.hop_tolerance, "m", petsc::positive(),
             "a mass whose next hop would stay lower than this rests on its support; default 1e-10 of the motion's own "
             "scale");
  const bool motion_given = group.strings(
      "-support_motion", motion,
      "CSV files time [s], height [m] added to -support_height and, if there is a third column, velocity [m/s], "
      "one per -support_position, one for all; none: at rest. Cubic between rows, at rest beside them; "
      "without velocities no height leaves the range of the two rows around it");
  const bool stiffness_given =
      group.reals("-support_stiffness", stiffness, "N/m", petsc::positive_or_infinite(),
                  "spring of a support, shared by the masses it touches; it only presses; inf: rigid");
  const bool damping_given =
      group.reals("-support_damping", damping, "N s/m", petsc::non_negative(),
                  "damper beside that spring, for all of the support; pressing alone; none on -contact_surface line");
  const std::size_t count = position.size();
  const auto per_support = [count](const char* key, const auto& values, bool given) {
    return count > 0 || given ? petsc::one_per(key, values, count, "one per -support_position") : values;
  };
  width = per_support("-support_width", width, width_given);
  height = per_support("-support_height", height, height_given);
  side = per_support("-support_side", side, side_given);
  stiffness = per_support("-support_stiffness", stiffness, stiffness_given);
  damping = per_support("-support_damping", damping, damping_given);
  if (motion_given) {
    motion = petsc::one_per("-support_motion", motion, count, "one per -support_position");
  }
  if (!ground_file.empty() && (floor || floor_height_given)) {
    throw InputError{"option -ground_profile: '" + ground_file +
                     "' is not allowed together with -floor or -floor_height, expected one ground [m]"};
  }
  const std::size_t all = count + (floor || !ground_file.empty() ? 1 : 0);
  if (all > 0) {
    restitution = petsc::one_per("-contact_restitution", restitution, all, "one per support, floor or ground included");
    yield_speed = petsc::one_per("-support_yield_speed", yield_speed, all, "one per support, floor or ground included");
  }
  if (input.contact.surface == ContactSurface::line) {
    for (const double e : restitution) {
      if (e != 1.0) {
        std::ostringstream message;
        message << "option -contact_restitution: " << e
                << " is not allowed with -contact_surface line, expected 1: forces hold the massless line off, nothing "
                   "hits and no coefficient applies";
        throw InputError{message.str()};
      }
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    input.supports.push_back({.position = position[i],
                              .width = width[i],
                              .height = height[i],
                              .restitution = restitution[i],
                              .side = side[i],
                              .yield_speed = yield_speed[i],
                              .stiffness = stiffness[i],
                              .damping = damping[i]});
    if (motion_given && motion[i] != "none") {
      input.supports.back().motion = read_motion(comm, motion[i]);
    }
    if (damping[i] > 0.0 && !input.supports.back().elastic()) {
      throw InputError{"option -support_damping: " + std::to_string(damping[i]) +
                       " is not allowed without -support_stiffness, expected 0: a rigid support has no damper [N s/m]"};
    }
    if (input.supports.back().elastic() && (restitution_given || yield_speed[i] < kInfinity)) {
      given_with_spring(restitution_given, restitution[i], yield_speed[i]);
    }
    const Support& support = input.supports.back();
    if (weighting == Weighting::tributary && support.width > 0.0) {
      input.beam.mass_patches.push_back({.from = support.from(), .to = support.to()});
    }
  }
  if (floor) {
    input.supports.push_back(Support::floor(floor_height, restitution.back()));
  }
  if (!ground_file.empty()) {
    const io::Table table = io::read_table(comm, "-ground_profile", ground_file, {.names = {"x [m]", "height [m]"}});
    require_ascending("-ground_profile", ground_file, column(table, 0), "positions [m]");
    input.supports.push_back(Support::floor(0.0, restitution.back()));
    input.supports.back().profile = {.x = column(table, 0), .height = column(table, 1)};
  }
  if (all > count) {
    input.supports.back().yield_speed = yield_speed.back();
  }
}

void read_output(MPI_Comm comm, Case& input) {
  OptionGroup group{comm, "Output and restart"};
  group.reals("-gauge_position", input.gauges, "m", petsc::any(), "where gauges read: the nearest node");
  group.string("-output_directory", input.output.directory, "folder for everything a run writes");
  group.boolean("-output_overwrite", input.output.overwrite, "replace the run that is there");
  group.real("-output_interval", input.output.interval, "s", petsc::positive(),
             "simulated time between rows of gauges.csv, energy.csv and contact.csv; peak forces and envelope.csv are "
             "sampled every pi / (4 wf) at least");
  group.real("-output_field_interval", input.output.field_interval, "s", petsc::non_negative(),
             "simulated time between fields in results.h5; 0: none");
  group.boolean("-output_allow_large", input.output.allow_large,
                "write more than 1e6 rows or 10 GB, which is refused else: as a rule an interval is in the wrong unit");
  group.real("-output_force_window", input.output.force_window, "s", petsc::non_negative(),
             "forces of supports in contact.csv are means over this time, rounded up to rows; with impacts at least pi "
             "/ wf; 0: "
             "that");
  group.string("-restart_file", input.restart.file, "continue from this restart.h5");
  group.real("-restart_interval", input.restart.interval, "s", petsc::non_negative(),
             "simulated time between checkpoints; 0: only when the run ends or is stopped");
  group.boolean("-udar_view", input.view, "print case, sizes, frequencies and supports before the run");
  for (const double gauge : input.gauges) {
    require_on_beam("-gauge_position", gauge, input.beam.length());
  }
}

}  // namespace

void settle_force_window(Case& input) {
  // Impacts come as often as the fastest springs swing: over less than half a period of these a mean says nothing.
  // Contact on the line has forces of its own, and the unfiltered beam one in every step.
  const double resolved = std::numbers::pi / input.filter.filter_frequency;
  const bool impacts = input.contact.surface == ContactSurface::mass && !input.filter.unfiltered;
  if (impacts && input.output.force_window > 0.0 && input.output.force_window < resolved) {
    std::ostringstream message;
    message << "option -output_force_window: " << input.output.force_window
            << " is not allowed, expected a number >= pi / -filter_frequency = " << resolved
            << " [s], the shortest time over which impacts make a force";
    throw InputError{message.str()};
  }
  input.output.force_window = input.output.force_window > 0.0 ? input.output.force_window : resolved;
}

Case read_case(MPI_Comm comm) {
  Case input;
  Formulation formulation = Formulation::mixed;
  input.beam = read_beam(comm, formulation);
  input.filter = read_filter(comm, formulation);
  read_initial(comm, input);
  read_contact(comm, input);
  read_output(comm, input);
  read_integration(comm, input);
  if (input.contact.surface == ContactSurface::line &&
      (input.filter.correct_lowest > 0 || !input.filter.correct.empty())) {
    throw InputError{
        "options -filter_correct_modes and -filter_correct_mode are not for -contact_surface line: in these modes the "
        "line is tied rigidly to the masses and would hit with them"};
  }
  return input;
}

}  // namespace udar::app
