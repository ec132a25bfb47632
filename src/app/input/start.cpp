#include <string>

#include "app/input/readers.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"

namespace udar::app {

using petsc::OptionGroup;

namespace {

void read_pivot(OptionGroup& group, InitialState& initial) {
  Numbers pivot;
  if (!group.reals("-initial_pivot", pivot, "m", petsc::any(),
                   "about which the structure turns at the start as a rigid body, such as a hinge at its end: x of a "
                   "beam, x,y,z of a network, in its own axes; nothing that is held may move")) {
    return;
  }
  if (pivot.size() != 1 && pivot.size() != 3) {
    throw InputError{"option -initial_pivot: " + std::to_string(pivot.size()) +
                     " values given, expected 1, x, or 3, x,y,z [m]"};
  }
  if (initial.angular_velocity == 0.0 && !initial.spins()) {
    throw InputError{
        "option -initial_pivot is not allowed without -initial_angular_velocity or -initial_spin, expected one that is "
        "not 0 [rad/s]"};
  }
  pivot.resize(3, 0.0);
  initial.pivot = Place{.x = pivot[0], .y = pivot[1], .z = pivot[2]};
}

/// @return whether there are some
bool read_parts(OptionGroup& group, InitialState& initial) {
  constexpr std::size_t kBox = 6;
  Numbers box;
  Numbers velocity;
  group.reals(
      "-initial_part", box, "m", petsc::any(),
      "for networks: boxes in their own axes, six numbers each, from and to along x, y and z, whose masses have "
      "a velocity of their own besides");
  const bool moves = group.reals("-initial_part_velocity", velocity, "m/s", petsc::any(),
                                 "of each -initial_part, three numbers along x, y and z, or three for all of them");
  const std::size_t count = box.size() / kBox;
  if (box.size() % kBox != 0) {
    throw InputError{"option -initial_part: " + std::to_string(box.size()) +
                     " numbers are not allowed, expected six for each part, from and to along x, y and z [m]"};
  }
  if (moves != (count > 0) || (moves && velocity.size() != 3 && velocity.size() != 3 * count)) {
    throw InputError{"option -initial_part_velocity: " + std::to_string(velocity.size()) + " numbers for " +
                     std::to_string(count) +
                     " boxes of -initial_part are not allowed, expected three for each, or three for all [m/s]"};
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double* const ends = &box[kBox * i];
    const double* const of = &velocity[velocity.size() == 3 ? 0 : 3 * i];
    initial.parts.push_back({.region = {.from = {.x = ends[0], .y = ends[2], .z = ends[4]},
                                        .to = {.x = ends[1], .y = ends[3], .z = ends[5]}},
                             .velocity = {.x = of[0], .y = of[1], .z = of[2]}});
  }
  return count > 0;
}

}  // namespace

StartInput read_start(MPI_Comm comm) {
  StartInput input;
  OptionGroup group{
      comm, "Start, gravity and damping (y points up; the axis is the straight line on which springs are unstressed)"};
  std::string shape;
  group.real("-gravity", input.gravity, "m/s^2", petsc::any(), "acceleration downward; acts on the line");
  group.real("-initial_height", input.initial.height, "m", petsc::any(),
             "height of the axis at mid-length above y = 0");
  group.real("-initial_slope", input.initial.slope, "-", petsc::any(), "slope of the axis");
  group.real("-initial_velocity", input.initial.velocity, "m/s", petsc::any(), "velocity of all masses, up");
  group.real("-initial_angular_velocity", input.initial.angular_velocity, "rad/s", petsc::any(),
             "about mid-length or -initial_pivot, counter-clockwise");
  input.in_space = group.real("-initial_velocity_x", input.initial.velocity_x, "m/s", petsc::any(),
                              "for networks: velocity of all masses along x");
  input.in_space |= group.real("-initial_velocity_z", input.initial.velocity_z, "m/s", petsc::any(),
                               "for networks: velocity of all masses along z");
  Numbers spin;
  if (group.reals("-initial_spin", spin, "rad/s", petsc::any(),
                  "for networks: angular velocities about x, y, z through the centre of mass or -initial_pivot, three "
                  "numbers")) {
    if (spin.size() != 3) {
      throw InputError{"option -initial_spin: " + std::to_string(spin.size()) +
                       " values given, expected three: about x, y and z [rad/s]"};
    }
    input.initial.spin = {.x = spin[0], .y = spin[1], .z = spin[2]};
    input.in_space = true;
  }
  input.in_space |= read_parts(group, input.initial);
  read_pivot(group, input.initial);
  group.string(
      "-initial_shape", shape,
      "CSV file x [m], offset from the axis [m] and, if there is a third column, velocity [m/s]; linear between rows");
  group.real("-damping_mass", input.damping.mass, "1/s", petsc::non_negative(),
             "alpha of Rayleigh damping: a force -alpha M Ym'; ratio alpha / (2 lambda) of a mode lambda; for -ts_type "
             "impact and rk");
  group.real("-damping_stiffness", input.damping.stiffness, "s", petsc::non_negative(),
             "beta of Rayleigh damping: a force beta wf^2 M d(Ym'), d(Ym') the stretch that these velocities alone "
             "give the line; ratio beta lambda / 2 of a mode lambda; the same, with -contact_surface mass");
  group.reals("-damping_ratio", input.damping_ratio, "-", petsc::non_negative(),
              "of each flexible mode, the last for all that follow; for -ts_type modal");
  if (!shape.empty()) {
    const io::Table table =
        io::read_table(comm, "initial shape", shape, {.names = {"x [m]", "offset [m]", "velocity [m/s]"}});
    input.initial.shape.x = column(table, 0);
    input.initial.shape.offset = column(table, 1);
    if (table.columns > 2) {
      input.initial.shape.velocity = column(table, 2);
    }
    require_ascending("-initial_shape", shape, input.initial.shape.x, "positions [m]");
  }
  return input;
}

}  // namespace udar::app
