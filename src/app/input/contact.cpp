#include <array>
#include <limits>
#include <memory>
#include <sstream>

#include "app/input/readers.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"

namespace udar::app {
namespace {

using petsc::OptionGroup;

enum class Weighting { tributary, inclusive };

constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr std::array kSides{Names<SupportSide>{"below", SupportSide::below},
                            Names<SupportSide>{"above", SupportSide::above}};
constexpr std::array kSurfaces{Names<ContactSurface>{"mass", ContactSurface::mass},
                               Names<ContactSurface>{"line", ContactSurface::line}};
constexpr std::array kWeightings{Names<Weighting>{"tributary", Weighting::tributary},
                                 Names<Weighting>{"inclusive", Weighting::inclusive}};

std::shared_ptr<const SupportMotion> read_motion(MPI_Comm comm, const std::string& path) {
  const io::Table table =
      io::read_table(comm, "support motion", path, {.names = {"time [s]", "height [m]", "velocity [m/s]"}});
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

}  // namespace

ContactInput read_contact(MPI_Comm comm) {
  ContactInput input;
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
      input.mass_patches.push_back({.from = support.from(), .to = support.to()});
    }
  }
  if (floor) {
    input.supports.push_back(Support::floor(floor_height, restitution.back()));
  }
  if (!ground_file.empty()) {
    const io::Table table = io::read_table(comm, "ground profile", ground_file, {.names = {"x [m]", "height [m]"}});
    require_ascending("-ground_profile", ground_file, column(table, 0), "positions [m]");
    input.supports.push_back(Support::floor(0.0, restitution.back()));
    input.supports.back().profile = {.x = column(table, 0), .height = column(table, 1)};
  }
  if (all > count) {
    input.supports.back().yield_speed = yield_speed.back();
  }
  return input;
}

}  // namespace udar::app
