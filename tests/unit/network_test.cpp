// ranks: 1; size: medium
/// @file
/// Networks of members against closed forms, and what is refused.

#include "udar/structure/network.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "support/small_frame.hpp"
#include "support/steel_beam.hpp"
#include "support/world.hpp"
#include "udar/filter/modes.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/member_shape.hpp"
#include "udar/structure/network_place.hpp"

namespace udar {
namespace {

using test::member_between;
using test::small_house;
using test::steel_section;
using test::Turn;
using test::turned_beam;

constexpr Turn kTurn{.about_z = 0.7, .about_x = -0.4};
constexpr double kLength = 3.0;

std::array<double, 3> numbers(const Place& place) { return {place.x, place.y, place.z}; }

/// A force or a moment at a junction: of each freedom, as `Network::row` has them.
struct Load {
  std::size_t junction = 0;
  Place force{};
  Place moment{};
};

/// What the junctions of a held network do under loads, by a direct solve.
class Statics {
 public:
  explicit Statics(NetworkParameters parameters) : network_{PETSC_COMM_WORLD, std::move(parameters)} {
    UDAR_CALL(MatCreateVecs(network_.stiffness(), solution_.put(), load_.put()));
    UDAR_CALL(MatSetOption(network_.stiffness(), MAT_SPD, PETSC_TRUE));
    UDAR_CALL(KSPCreate(PETSC_COMM_WORLD, solver_.put()));
    UDAR_CALL(KSPSetOperators(solver_, network_.stiffness(), network_.stiffness()));
    UDAR_CALL(KSPSetType(solver_, KSPPREONLY));
    PC factor = nullptr;
    UDAR_CALL(KSPGetPC(solver_, &factor));
    UDAR_CALL(PCSetType(factor, PCCHOLESKY));
    UDAR_CALL(PCFactorSetMatSolverType(factor, MATSOLVERCHOLMOD));
  }

  void solve(const Load& load) {
    UDAR_CALL(VecSet(load_, 0.0));
    {
      const petsc::WriteArray values{load_};
      for (std::size_t c = 0; c < 3; ++c) {
        values.values()[row(load.junction, c)] = numbers(load.force).at(c);
        values.values()[row(load.junction, 3 + c)] = numbers(load.moment).at(c);
      }
    }
    UDAR_CALL(KSPSolve(solver_, load_, solution_));
    KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
    UDAR_CALL(KSPGetConvergedReason(solver_, &reason));
    ASSERT_GT(reason, 0);
  }
  [[nodiscard]] Place moved(std::size_t junction) const { return value(junction, 0); }
  [[nodiscard]] Place turned(std::size_t junction) const { return value(junction, 3); }

 private:
  [[nodiscard]] PetscInt row(std::size_t junction, std::size_t freedom) const {
    return network_.row(network_.junction_node(junction), freedom);
  }
  [[nodiscard]] Place value(std::size_t junction, std::size_t first) const {
    const petsc::ReadArray values{solution_};
    return {.x = values.values()[row(junction, first)],
            .y = values.values()[row(junction, first + 1)],
            .z = values.values()[row(junction, first + 2)]};
  }

  Network network_;
  petsc::LinearSolver solver_;
  petsc::Vector load_;
  petsc::Vector solution_;
};

double along(const Place& a, const Place& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

Place times(double factor, const Place& a) { return {.x = factor * a.x, .y = factor * a.y, .z = factor * a.z}; }

/// A cantilever in any direction: the tip moves as beam theory says, whatever the mesh.
TEST(Network, CantileverBendsTwistsAndStretches) {
  for (const std::size_t elements : {1U, 2U, 7U}) {
    for (const std::array<double, 2> shear : {std::array{0.0, 0.0}, {0.85, 0.4}}) {
      const MemberSection section = steel_section(shear);
      NetworkParameters beam = turned_beam(kLength, elements, kTurn, section);
      beam.junctions[0].held.fill(true);
      Statics statics{beam};
      const Place x = kTurn({.x = 1.0});
      const double force = 700.0;
      for (const std::size_t plane : {0U, 1U}) {
        const Place deflected = kTurn(plane == 0 ? Place{.y = 1.0} : Place{.z = 1.0});
        statics.solve({.junction = 1, .force = times(force, deflected)});
        const double expected = force * std::pow(kLength, 3) / (3.0 * section.bending(plane)) +
                                force * kLength * section.shear_compliance(plane);
        EXPECT_NEAR(along(statics.moved(1), deflected), expected, 1e-9 * expected);
        EXPECT_NEAR(along(statics.moved(1), x), 0.0, 1e-9 * expected);
        const Place about = kTurn(plane == 0 ? Place{.z = 1.0} : Place{.y = -1.0});
        EXPECT_NEAR(along(statics.turned(1), about), force * kLength * kLength / (2.0 * section.bending(plane)),
                    1e-9 * expected);
      }
      statics.solve({.junction = 1, .force = times(force, x), .moment = times(force, x)});
      EXPECT_NEAR(along(statics.moved(1), x), force * kLength / section.axial(),
                  1e-9 * force * kLength / section.axial());
      EXPECT_NEAR(along(statics.turned(1), x), force * kLength / section.torsion(),
                  1e-9 * force * kLength / section.torsion());
    }
  }
}

/// Two cantilevers that meet in a hinge share its load; it does not share their rotation.
TEST(Network, HingeCarriesNoMoment) {
  const MemberSection section = steel_section();
  for (const std::size_t elements : {1U, 3U}) {
    NetworkParameters gerber{
        .sections = {section},
        .junctions = {{}, test::junction_at({.x = kLength}), test::junction_at({.x = 2.0 * kLength})},
        .members = {member_between(0, 1, elements), member_between(1, 2, elements)}};
    gerber.junctions[0].held.fill(true);
    gerber.junctions[2].held.fill(true);
    gerber.members[1].ends[0].joint[2] = 0.0;
    const double force = 900.0;
    const double load = force * std::pow(kLength, 3) / 3.0;
    Statics statics{gerber};
    statics.solve({.junction = 1, .force = {.y = force}});
    EXPECT_NEAR(statics.moved(1).y, 0.5 * load / section.bending(0), 1e-9 * load / section.bending(0));
    // The first cantilever's own rotation: the junction is rigidly its end.
    EXPECT_NEAR(statics.turned(1).z, 0.25 * force * kLength * kLength / section.bending(0), 1e-9);
    // In the other plane it is a clamped beam of twice the length.
    statics.solve({.junction = 1, .force = {.z = force}});
    EXPECT_NEAR(statics.moved(1).z, force * std::pow(2.0 * kLength, 3) / (192.0 * section.bending(1)), 1e-10);
  }
}

/// A soft joint at the root turns by F L / k, about each axis by its own stiffness.
TEST(Network, JointTurnsByItsMoment) {
  const MemberSection section = steel_section();
  for (const std::size_t elements : {1U, 4U}) {
    for (const std::size_t end : {0U, 1U}) {
      NetworkParameters beam = turned_beam(kLength, elements, kTurn);
      beam.junctions[end].held.fill(true);
      beam.members[0].ends.at(end).joint = {3e4, 5e4, 8e4};
      Statics statics{beam};
      const double force = 100.0;
      for (const std::size_t plane : {0U, 1U}) {
        const Place deflected = kTurn(plane == 0 ? Place{.y = 1.0} : Place{.z = 1.0});
        statics.solve({.junction = 1 - end, .force = times(force, deflected)});
        const double expected = force * std::pow(kLength, 3) / (3.0 * section.bending(plane)) +
                                force * kLength * kLength / (plane == 0 ? 8e4 : 5e4);
        EXPECT_NEAR(along(statics.moved(1 - end), deflected), expected, 1e-9 * expected);
      }
      const Place x = kTurn({.x = 1.0});
      statics.solve({.junction = 1 - end, .moment = times(force, x)});
      const double expected = force * kLength / section.torsion() + force / 3e4;
      EXPECT_NEAR(along(statics.turned(1 - end), x), expected, 1e-9 * expected);
    }
  }
}

/// A force at the end of an arm bends the member by a moment and moves the arm's end with its rotation.
TEST(Network, OffsetIsARigidArm) {
  const MemberSection section = steel_section();
  const double arm = 0.4;
  const double force = 5000.0;
  for (const std::size_t elements : {1U, 3U}) {
    NetworkParameters beam = turned_beam(kLength, elements, kTurn);
    beam.junctions[0].held.fill(true);
    beam.junctions[1].place = kTurn({.x = kLength, .y = arm});
    beam.members[0].ends[1].offset = kTurn({.y = -arm});
    Statics statics{beam};
    const Place x = kTurn({.x = 1.0});
    statics.solve({.junction = 1, .force = times(force, x)});
    const double expected = force * kLength * (1.0 / section.axial() + arm * arm / section.bending(0));
    EXPECT_NEAR(along(statics.moved(1), x), expected, 1e-9 * expected);
    // Out of the plane of the arm the member twists, too.
    const Place z = kTurn({.z = 1.0});
    statics.solve({.junction = 1, .force = times(force, z)});
    const double across =
        force * (std::pow(kLength, 3) / (3.0 * section.bending(1)) + arm * arm * kLength / section.torsion());
    EXPECT_NEAR(along(statics.moved(1), z), across, 1e-9 * across);
  }
}

TEST(Network, SpringsTieJunctionsToTheGround) {
  NetworkParameters beam = turned_beam(kLength, 2, kTurn);
  beam.junctions[0].stiffness = {1e5, 2e5, 3e5, 1e6, 2e6, 3e6};
  const Network network{PETSC_COMM_WORLD, beam};
  EXPECT_TRUE(network.grounded());
  EXPECT_TRUE(network.notes().empty());
  Statics statics{beam};
  statics.solve({.junction = 0, .force = {.x = 10.0, .y = 20.0, .z = 30.0}, .moment = {.x = 1.0, .y = 2.0, .z = 3.0}});
  for (const double moved : numbers(statics.moved(0))) {
    EXPECT_NEAR(moved, 1e-4, 1e-12);
  }
  for (const double turned : numbers(statics.turned(0))) {
    EXPECT_NEAR(turned, 1e-6, 1e-14);
  }
}

/// Frequencies of the mesh itself: a simply supported beam with masses in its nodes, k half waves. Moments of the
/// discrete beam are a cubic spline's.
double bending_frequency(const MemberSection& section, std::size_t plane, double length, std::size_t elements, int k) {
  const double h = length / static_cast<double>(elements);
  const double angle = k * std::numbers::pi / static_cast<double>(elements);
  const double bend = 2.0 - 2.0 * std::cos(angle);
  const double compliance =
      h * (4.0 + 2.0 * std::cos(angle)) / (6.0 * section.bending(plane)) + bend * section.shear_compliance(plane) / h;
  return std::sqrt(bend * bend / (h * h * compliance * section.mass_per_length() * h));
}

/// The same of a bar with one free end, k quarter waves.
double axial_frequency(const MemberSection& section, double length, std::size_t elements, int k) {
  const double h = length / static_cast<double>(elements);
  const double speed = std::sqrt(section.axial() / section.mass_per_length());
  return 2.0 * speed / h * std::sin(0.25 * k * std::numbers::pi / static_cast<double>(elements));
}

/// Simply supported in both planes, free at one end along its axis.
NetworkParameters simple_beam(std::size_t elements, const MemberSection& section) {
  NetworkParameters beam = turned_beam(kLength, elements, {}, section);
  beam.junctions[0].held = {true, true, true, true, false, false};
  beam.junctions[1].held = {false, true, true, false, false, false};
  return beam;
}

std::vector<double> frequencies(const NetworkParameters& parameters, PetscInt count) {
  const Network network{PETSC_COMM_WORLD, parameters};
  std::vector<double> found;
  for (const Mode& mode : exact_modes(network, {.filter_frequency = 100.0}, count)) {
    found.push_back(mode.frequency);
  }
  return found;
}

TEST(Network, SimplySupportedBeamHasTheFrequenciesOfItsMesh) {
  for (const std::array<double, 2> shear : {std::array{0.0, 0.0}, {0.85, 0.4}}) {
    const MemberSection section = steel_section(shear);
    const std::size_t elements = 24;
    std::vector<double> expected;
    for (int k = 1; k < 12; ++k) {
      expected.push_back(bending_frequency(section, 0, kLength, elements, k));
      expected.push_back(bending_frequency(section, 1, kLength, elements, k));
      expected.push_back(axial_frequency(section, kLength, elements, 2 * k - 1));
    }
    std::ranges::sort(expected);
    const std::vector<double> found = frequencies(simple_beam(elements, section), 8);
    ASSERT_EQ(found.size(), 8U);
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_NEAR(found[i], expected[i], 1e-7 * expected[i]) << "mode " << i + 1;
    }
  }
}

/// Against the continuous beam the error goes down with h^2 at least.
TEST(Network, FrequenciesConvergeWithTheMesh) {
  const MemberSection section = steel_section();
  const double wave = std::pow(1.8751040687119611 / kLength, 2.0);
  const double expected = wave * std::sqrt(section.bending(1) / section.mass_per_length());  // the softer plane
  const auto error = [&](std::size_t elements) {
    NetworkParameters beam = turned_beam(kLength, elements, kTurn);
    beam.junctions[0].held.fill(true);
    return std::abs(frequencies(beam, 1).front() / expected - 1.0);
  };
  const double coarse = error(8);
  const double fine = error(16);
  EXPECT_LT(coarse, 0.01);
  EXPECT_LT(fine, coarse / 3.9);
}

/// Of graded elements, too: a clamped beam in both planes, a bar with one free end.
TEST(Network, FrequenciesOfGradedElementsConverge) {
  const MemberSection section = steel_section();
  const double bend = std::pow(4.7300407448627038 / kLength, 2.0);
  std::vector<double> expected;
  for (const std::size_t plane : {0U, 1U}) {
    expected.push_back(bend * std::sqrt(section.bending(plane) / section.mass_per_length()));
  }
  expected.push_back(0.5 * std::numbers::pi / kLength * std::sqrt(section.axial() / section.mass_per_length()));
  std::ranges::sort(expected);
  const auto errors = [&](std::size_t elements) {
    NetworkParameters beam = turned_beam(kLength, elements);
    beam.members[0].spacing = graded_spacing(elements, 4.0);
    beam.junctions[0].held.fill(true);
    beam.junctions[1].held = {false, true, true, true, true, true};
    const std::vector<double> found = frequencies(beam, 10);
    std::vector<double> off;
    for (const double frequency : expected) {  // others lie between
      const double near = *std::ranges::min_element(found, {}, [&](double w) { return std::abs(w - frequency); });
      off.push_back(std::abs(near / frequency - 1.0));
    }
    return off;
  };
  const std::vector<double> coarse = errors(24);
  const std::vector<double> fine = errors(48);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_LT(coarse[i], 0.01) << i;
    EXPECT_LT(fine[i], coarse[i] / 3.8) << i;
  }
}

/// A straight beam along x, one member or four: whatever it falls on, it moves as the beam does.
TEST(Network, FallsAsTheBeamDoes) {
  const test::Option end{"-ts_max_time", "0.55"};
  constexpr std::size_t kElements = 20;
  const std::vector<Support> under{{.position = 2.0}, {.position = 8.0}};
  const auto parameters = [&](std::size_t members) {
    NetworkParameters beam{.sections = {test::round_section()}, .junctions = {{}}, .members = {}};
    for (std::size_t i = 0; i < members; ++i) {
      beam.junctions.push_back(
          test::junction_at({.x = 10.0 * static_cast<double>(i + 1) / static_cast<double>(members)}));
      beam.members.push_back(member_between(i, i + 1, kElements / members));
    }
    return beam;
  };
  const InitialState initial{.height = 1.0};
  for (const double wf : {50.0, 100.0}) {
    test::Fall fall{test::steel_beam(kElements), wf, test::kGravity, initial, under};
    fall.dynamics.solve();
    const std::vector<double> expected = fall.dynamics.masses().position;
    for (const std::size_t members : {1U, 4U}) {
      Model model{PETSC_COMM_WORLD,
                  {.network = parameters(members),
                   .filter = {.filter_frequency = wf},
                   .gravity = test::kGravity,
                   .initial = initial,
                   .supports = under}};
      ImpactDynamics dynamics{model};
      dynamics.solve();
      EXPECT_EQ(dynamics.counts().impacts, fall.dynamics.counts().impacts);
      const std::vector<double> found = dynamics.masses().position;
      const MassPoints& points = model.structure->points();
      for (std::size_t point = 0; point < found.size(); ++point) {
        if (points.direction(point) == Direction::y) {
          const auto node = static_cast<std::size_t>(std::lround(points.place(point).x * kElements / 10.0));
          EXPECT_NEAR(found[point], expected[node], 1e-8) << "node " << node << " of " << members << " members";
        } else {
          EXPECT_NEAR(found[point], 0.0, 1e-12);
        }
      }
    }
  }
}

/// A held network hangs where it is; a beam clamped at a wall sags under its weight.
TEST(Network, CantileverStaysAtItsWall) {
  const double wf = 400.0;
  NetworkParameters beam = turned_beam(kLength, 6);
  beam.junctions[0].held.fill(true);
  const Network network{PETSC_COMM_WORLD, beam};
  FilteredStructure line{network, {.filter_frequency = wf, .check_interval = 1}};
  const MassPoints& points = network.points();
  std::vector<double> displacement(points.coordinates(), 0.0);
  std::vector<double> force(points.coordinates(), 0.0);
  std::vector<double> stretch(points.coordinates());
  std::vector<double> internal(2 * points.coordinates());  // rotations, then places of the line
  displacement[0] = 0.5;                                   // the root's own mass, along y
  force[0] = 100.0;
  line.solve(displacement, force, stretch, internal);
  EXPECT_TRUE(points.fixed(0));
  EXPECT_EQ(stretch[0], -0.5);
  EXPECT_EQ(internal[0], 0.0);
  EXPECT_EQ(internal[points.coordinates()], 0.0);
  for (std::size_t i = 1; i < stretch.size(); ++i) {
    EXPECT_EQ(stretch[i], 0.0) << "point " << i;
  }
}

TEST(Network, SaysWhatTurnsFreely) {
  const Network line{PETSC_COMM_WORLD, turned_beam(kLength, 4, kTurn)};
  ASSERT_EQ(line.notes().size(), 1U);
  EXPECT_NE(line.notes()[0].find("1 straight line of members has a rotation about its own axis"), std::string::npos)
      << line.notes()[0];
  EXPECT_NE(line.notes()[0].find("junction 'root'"), std::string::npos) << line.notes()[0];
  ASSERT_EQ(line.rotation_springs().size(), 1U);
  EXPECT_NEAR(std::abs(along(line.rotation_springs()[0].axis, kTurn({.x = 1.0}))), 1.0, 1e-14);
  EXPECT_EQ(line.connected_parts(), 1U);
  EXPECT_FALSE(line.grounded());

  // A triangle of bars between ball joints: what a junction has left is a rotation of its own.
  NetworkParameters truss{.sections = {steel_section()},
                          .junctions = {{}, test::junction_at({.x = 1.0}), test::junction_at({.x = 0.3, .y = 0.8})},
                          .members = {member_between(0, 1, 3), member_between(1, 2, 1), member_between(2, 0, 2)}};
  for (Member& member : truss.members) {
    member.ends[0].joint.fill(0.0);
    member.ends[1].joint.fill(0.0);
  }
  const Network ball{PETSC_COMM_WORLD, truss};
  EXPECT_EQ(ball.rotation_springs().size(), 9U);
  ASSERT_EQ(ball.notes().size(), 1U);
  EXPECT_NE(ball.notes()[0].find("3 junctions have rotations"), std::string::npos) << ball.notes()[0];
  FilteredStructure solvable{ball, {.filter_frequency = 100.0}};
  EXPECT_EQ(lowest_modes(solvable, 1).size(), 1U);

  NetworkParameters two = turned_beam(kLength, 2);
  two.junctions.push_back(test::junction_at({.z = 1.0}));
  two.junctions.push_back(test::junction_at({.x = 1.0, .z = 1.0}));
  two.members.push_back(member_between(2, 3, 2));
  const Network parts{PETSC_COMM_WORLD, two};
  EXPECT_EQ(parts.connected_parts(), 2U);
  EXPECT_EQ(parts.rigid_modes(), 12);
  EXPECT_EQ(parts.rotation_springs().size(), 2U);
  ASSERT_EQ(parts.notes().size(), 2U);
  EXPECT_NE(parts.notes()[0].find("2 parts that no member connects"), std::string::npos);
}

/// The spring that holds what turns freely changes nothing: d is that of a line which the ground holds at its other
/// end.
TEST(Network, FreeRotationCostsNothing) {
  const auto stretch_of = [](double ground) {
    NetworkParameters beam = turned_beam(kLength, 5);
    beam.junctions[1].stiffness[3] = ground;  // about the beam's own axis
    const Network network{PETSC_COMM_WORLD, beam};
    EXPECT_EQ(network.rotation_springs().size(), ground > 0.0 ? 0U : 1U);
    FilteredStructure line{network, {.filter_frequency = 200.0}};
    std::vector<double> given(network.points().coordinates());
    for (std::size_t i = 0; i < given.size(); ++i) {
      given[i] = std::sin(1.0 + static_cast<double>(i * i));
    }
    std::vector<double> stretch(given.size());
    line.solve(given, {}, stretch, {});
    return stretch;
  };
  const std::vector<double> free = stretch_of(0.0);
  const std::vector<double> held = stretch_of(3e4);
  for (std::size_t i = 0; i < free.size(); ++i) {
    EXPECT_NEAR(free[i], held[i], 1e-12);  // of order one
  }
}

TEST(Network, WarnsOfMembersOnEachOther) {
  NetworkParameters beam = turned_beam(kLength, 2, kTurn);
  EXPECT_TRUE(Network(PETSC_COMM_WORLD, beam).warnings().empty());
  beam.members.push_back(member_between(1, 0, 3));
  const Network twice{PETSC_COMM_WORLD, beam};
  ASSERT_EQ(twice.warnings().size(), 1U);
  EXPECT_NE(twice.warnings()[0].find("member 0 (counted from 0) and member 1 (counted from 0) lie on each other"),
            std::string::npos)
      << twice.warnings()[0];
  // One within the other, without a junction between.
  beam.members.pop_back();
  beam.junctions.push_back(test::junction_at(kTurn({.x = 1.0})));
  beam.junctions.push_back(test::junction_at(kTurn({.x = 4.0})));
  beam.members.push_back(member_between(2, 3, 3));
  EXPECT_EQ(Network(PETSC_COMM_WORLD, beam).warnings().size(), 1U);
  // One behind the other, and one with an arm beside it.
  beam.junctions[2].place = kTurn({.x = kLength + 0.5});
  beam.members.push_back(member_between(0, 1, 2));
  beam.members.back().ends[0].offset = kTurn({.z = 0.1});
  beam.members.back().ends[1].offset = kTurn({.z = 0.1});
  EXPECT_TRUE(Network(PETSC_COMM_WORLD, beam).warnings().empty());
}

struct Bad {
  std::function<void(NetworkParameters&)> spoil;
  std::string message;
};

void expect_refused(const std::vector<Bad>& all) {
  for (const Bad& bad : all) {
    NetworkParameters house = small_house();
    bad.spoil(house);
    const std::string message = test::failure_of<InputError>([&] { const Network network{PETSC_COMM_WORLD, house}; });
    EXPECT_NE(message.find(bad.message), std::string::npos) << message << "\nexpected: " << bad.message;
  }
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Network, RefusesBadSectionsAndJunctionsByName) {
  expect_refused({
      {[](auto& n) { n.sections[0].youngs_modulus = -1.0; },
       "network section 'bar', Young's modulus: -1 is not allowed, expected a number > 0 [Pa]"},
      {[](auto& n) { n.sections[0].shear_modulus = kNan; }, "section 'bar', shear modulus: nan is not allowed"},
      {[](auto& n) { n.sections[0].density = 0.0; }, "density: 0 is not allowed, expected a number > 0 [kg/m^3]"},
      {[](auto& n) { n.sections[0].area = 0.0; }, "area: 0 is not allowed, expected a number > 0 [m^2]"},
      {[](auto& n) { n.sections[0].inertia[0] = 0.0; }, "inertia of bending in the plane xy: 0 is not allowed"},
      {[](auto& n) { n.sections[0].inertia[1] = -2.0; }, "inertia of bending in the plane xz: -2 is not allowed"},
      {[](auto& n) { n.sections[0].torsion_constant = 0.0; }, "torsion constant: 0 is not allowed"},
      {[](auto& n) { n.sections[0].shear_factor[1] = -0.1; }, "shear factor along z: -0.1 is not allowed"},
      {[](auto& n) { n.sections[0].radius = -0.1; }, "radius: -0.1 is not allowed, expected a number >= 0 [m]"},
      {[](auto& n) { n.junctions[2].place.z = kNan; }, "junction 'j2', place: ("},
      {[](auto& n) { n.junctions[2].mass = -3.0; },
       "junction 'j2', mass: -3 is not allowed, expected a number >= 0 [kg]"},
      {[](auto& n) { n.junctions[2].stiffness[1] = -3.0; }, "stiffness of a spring: -3 is not allowed"},
      {[](auto& n) { n.junctions[2].stiffness[4] = -3.0; }, "expected a number >= 0 [N m/rad]"},
      {[](auto& n) { n.junctions[3].place = n.junctions[2].place; },
       "network junction 'j2' and junction 'j3' are both at (3.2, 0, 2.5) [m]"},
      {[](auto& n) { n.junctions.push_back(test::junction_at({.x = 9.0})); },
       "network junction 8 (counted from 0): no member ends there"},
  });
}

TEST(Network, RefusesBadMembersByName) {
  expect_refused({
      {[](auto& n) { n.members.clear(); }, "network: no members, expected one at least"},
      {[](auto& n) { n.members[1].section = 2; },
       "network member 1 (counted from 0), section: 2 is not allowed, expected a number below 2"},
      {[](auto& n) { n.members[1].ends[1].junction = 8; }, "junction: 8 is not allowed, expected a number below 8"},
      {[](auto& n) { n.members[1].elements = 0; }, "elements: 0 is not allowed, expected a number >= 1"},
      {[](auto& n) { n.members[1].spacing = {1.0, 2.0}; },
       "network member 1 (counted from 0), spacing: of 2 elements is not allowed, expected one of 3"},
      {[](auto& n) { n.members[1].spacing = {1.0, 0.0, 2.0}; }, "spacing: 0 is not allowed, expected a number > 0"},
      {[](auto& n) { n.members[1].ends[1].junction = n.members[1].ends[0].junction; },
       "both ends are at junction 'j4', expected two junctions"},
      {[](auto& n) { n.members[1].ends[0].joint[2] = -1.0; },
       "stiffness of a joint: -1 is not allowed, expected a number >= 0, or infinity"},
      {[](auto& n) { n.members[1].ends[0].joint[0] = kNan; }, "stiffness of a joint: nan is not allowed"},
      {[](auto& n) { n.members[1].ends[0].offset.x = kNan; }, "offset: ("},
      {[](auto& n) { n.members[1].orientation.y = kNan; }, "orientation: ("},
      {[](auto& n) { n.members[0].ends[0].offset.y = 2.0; }, "network member 0 (counted from 0), length: 0 is not"},
      {[](auto& n) { n.members[0].orientation = {.y = -3.0}; },
       "orientation: (0, -3, 0) is not allowed, expected a direction that is not that of the member, (0, 2, 0)"},
  });
}

/// Joints that leave bending nothing to hold, with torsion between them: three junctions turn together.
TEST(Network, RefusesMechanismsWithoutMass) {
  NetworkParameters chain{
      .sections = {steel_section()},
      .junctions = {{.name = "a"}, {.name = "b", .place = {.x = 1.0}}, {.name = "c", .place = {.x = 1.7, .y = 0.7}}},
      .members = {member_between(0, 1, 2), member_between(1, 2, 2)}};
  for (Member& member : chain.members) {
    for (MemberEnd& end : member.ends) {
      end.joint = {MemberEnd::kRigid, 0.0, 0.0};
    }
  }
  const std::string message = test::failure_of<InputError>([&] { const Network network{PETSC_COMM_WORLD, chain}; });
  EXPECT_NE(message.find("network junction '"), std::string::npos) << message;
  EXPECT_NE(message.find("it can turn, with others, and nothing resists"), std::string::npos) << message;
}

/// Members that differ by place alone are of one kind; they stand in packs of eight.
TEST(Network, SortsMembersByKind) {
  NetworkParameters row{.sections = {steel_section(), steel_section()}, .junctions = {{}}, .members = {}};
  for (std::size_t i = 0; i < 10; ++i) {
    row.junctions.push_back(test::junction_at({.x = 0.1 * static_cast<double>(i + 1)}));
    row.members.push_back(member_between(i, i + 1, 3));
  }
  row.members[4].elements = 2;
  const Network network{PETSC_COMM_WORLD, row};
  ASSERT_EQ(network.kinds().size(), 2U);
  ASSERT_EQ(network.packs().packs().size(), 3U);
  EXPECT_EQ(network.packs().packs()[0].lanes, 8U);
  EXPECT_EQ(network.packs().packs()[1].lanes, 1U);
  EXPECT_EQ(network.packs().packs()[1].member[7], 9U);
  EXPECT_EQ(network.packs().packs()[2].kind, 1U);
  EXPECT_EQ(network.packs().packs()[1].first, 11U + 16U);
  EXPECT_EQ(network.nodes(), 11U + 19U);
  EXPECT_EQ(network.node(1, 2).local, 11U + 8U + 1U);
  const auto at = network.points().place(static_cast<std::size_t>(network.point(network.node(9, 1), 2)));
  EXPECT_NEAR(at.x, 0.9 + 0.1 / 3.0, 1e-15);
  // 1 node, 2 nodes, ... before member 9: 3 * (11 + 17) + z
  EXPECT_EQ(network.points().number(static_cast<std::size_t>(network.point(network.node(9, 1), 2))), 3 * (11 + 17) + 2);
  row.members[3].section = 1;
  EXPECT_EQ(Network(PETSC_COMM_WORLD, row).kinds().size(), 3U);
}

/// Unequal elements share the member's length; half of each goes to the nodes at its ends.
TEST(Network, TakesUnequalElements) {
  NetworkParameters row{.sections = {steel_section()}, .junctions = {{}}, .members = {}};
  for (std::size_t i = 0; i < 4; ++i) {
    row.junctions.push_back(test::junction_at({.x = 0.7 * static_cast<double>(i + 1)}));
    row.members.push_back(member_between(i, i + 1, 3));
  }
  row.members[0].spacing = {1.0, 2.0, 4.0};
  row.members[1].spacing = {0.1, 0.2, 0.4};
  row.members[2].spacing = {4.0, 2.0, 1.0};
  row.members[3].spacing = {3.0, 3.0, 3.0};
  const Network network{PETSC_COMM_WORLD, row};
  EXPECT_EQ(network.kinds().size(), 3U);
  EXPECT_EQ(network.kind(0), network.kind(1));
  EXPECT_TRUE(network.kinds()[network.kind(3)].equal_elements());
  const double per_length = row.sections[0].mass_per_length();
  const auto expect = [&](const Network::Node& node, double x, double length) {
    const auto point = static_cast<std::size_t>(network.point(node, 1));
    EXPECT_NEAR(network.points().place(point).x, x, 1e-15);
    EXPECT_NEAR(network.points().mass()[point], length * per_length, 1e-14 * per_length);
  };
  expect(network.node(0, 0), 0.0, 0.05);
  expect(network.node(0, 1), 0.1, 0.15);
  expect(network.node(0, 2), 0.3, 0.3);
  expect(network.node(1, 0), 0.7, 0.25);
  expect(network.node(1, 1), 0.8, 0.15);
  expect(network.node(2, 0), 1.4, 0.4);
  expect(network.node(2, 2), 2.0, 0.15);
  EXPECT_NEAR(network.points().total_mass(), 2.8 * per_length, 1e-13 * per_length);
  const std::vector<Place> places = node_places(row);  // junctions, then two inner nodes of each member
  ASSERT_EQ(places.size(), 5U + 4U * 2U);
  for (std::size_t member = 0; member < 4; ++member) {
    for (std::size_t i = 1; i < 3; ++i) {
      const auto point = static_cast<std::size_t>(network.point(network.node(member, i), 1));
      EXPECT_EQ(places[5 + 2 * member + i - 1].x, network.points().place(point).x);
    }
  }
  const double ratio = 24.0 * row.sections[0].bending(0) / (per_length * std::pow(0.1, 4.0));  // of the shortest
  EXPECT_NEAR(network.largest_ratio(), ratio, 1e-12 * ratio);
}

/// Few members are cut; every inner node stands somewhere, and no two at one place.
TEST(MemberPacks, GiveEachInnerNodeItsPlace) {
  const std::vector<MemberPacks::Kind> kinds{{.elements = 5, .members = {0, 2}},
                                             {.elements = 1003, .members = {1, 5, 7}},
                                             {.elements = 1, .members = {3}},
                                             {.elements = 100, .members = {}},
                                             {.elements = 64, .members = {4}},
                                             {.elements = 30000, .members = {6}},
                                             {.elements = 900, .members = {8}, .equal = false},
                                             {.elements = 900, .members = {9, 10, 11, 12}, .equal = false}};
  constexpr std::size_t kFirst = 9;
  const MemberPacks packs{kinds, 13, kFirst};
  EXPECT_EQ(packs.cut(0).spans, 1U);
  EXPECT_EQ(packs.cut(3).spans, 1U);
  EXPECT_GT(packs.cut(1).spans, 2U);
  EXPECT_EQ(packs.cut(4).spans, 2U);
  EXPECT_EQ(packs.cut(5).length, 30000U / 8);
  EXPECT_EQ(packs.cut(6).spans, 9U);  // of 112 elements and 4
  EXPECT_EQ(packs.cut(7).spans, 1U);
  std::vector<std::size_t> places;
  std::size_t cut_nodes = 0;
  for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
    const auto& [elements, members, equal] = kinds[kind];
    const MemberCut& cut = packs.cut(kind);
    EXPECT_LT((cut.spans - 1) * cut.length, elements);
    EXPECT_GE(cut.spans * cut.length, elements);
    for (const std::size_t member : members) {
      for (std::size_t i = 1; i < elements; ++i) {
        places.push_back(packs.node(member, kind, i));
      }
      cut_nodes += cut.spans - 1;
      for (std::size_t span = 1; span < cut.spans; ++span) {
        EXPECT_LT(packs.node(member, kind, span * cut.length), kFirst + packs.cut_nodes());
      }
    }
  }
  EXPECT_EQ(packs.cut_nodes(), cut_nodes);
  std::ranges::sort(places);
  for (std::size_t i = 0; i < places.size(); ++i) {
    ASSERT_EQ(places[i], kFirst + i);
  }
  for (const MemberPack& pack : packs.packs()) {
    const MemberCut& cut = packs.cut(pack.kind);
    for (std::size_t lane = 0; lane < pack.lanes && pack.elements > 1; ++lane) {
      EXPECT_EQ(packs.node(pack.member.at(lane), pack.kind, pack.span.at(lane) * cut.length + 1), pack.first + lane);
    }
  }
}

}  // namespace
}  // namespace udar
