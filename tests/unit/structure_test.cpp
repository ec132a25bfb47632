// ranks: 1; size: short
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "support/steel_beam.hpp"
#include "support/world.hpp"

namespace udar {
namespace {

TEST(Section, OfATubeTendsToTheCircle) {
  const Section circle = circle_section(0.1, 0.3);
  const Section tube = tube_section(0.1, 1e-9, 0.3);
  EXPECT_NEAR(tube.area, circle.area, 1e-15);
  EXPECT_NEAR(tube.inertia, circle.inertia, 1e-18);
  EXPECT_NEAR(tube.shear_coefficient, circle.shear_coefficient, 1e-12);
  EXPECT_DOUBLE_EQ(circle.inertia, std::numbers::pi * 1e-4 / 4.0);
}

TEST(Section, OfARectangleHasCowpersShearCoefficient) {
  const Section section = rectangle_section(0.2, 0.3, 0.3);
  EXPECT_DOUBLE_EQ(section.area, 0.06);
  EXPECT_DOUBLE_EQ(section.inertia, 0.2 * 0.027 / 12.0);
  EXPECT_NEAR(section.shear_coefficient, 13.0 / 15.3, 1e-15);
}

BeamParameters two_segments() {
  BeamParameters beam = test::steel_beam(4);
  beam.segments.push_back(
      {.length = 2.0, .elements = 8, .bending_stiffness = 1e6, .mass_per_length = 50.0, .foundation_stiffness = 300.0});
  beam.point_masses = {{.position = 10.1, .mass = 7.0}, {.position = 3.0, .mass = 2.0}};
  return beam;
}

TEST(BeamChain, LumpsHalfOfEachElementAndPointMasses) {
  const BeamChain beam{PETSC_COMM_WORLD, two_segments()};
  const double first = 7850.0 * std::numbers::pi * 0.01;  // kg/m
  EXPECT_EQ(beam.elements(), 12);
  EXPECT_DOUBLE_EQ(beam.mass(0), 0.5 * 2.5 * first);
  EXPECT_DOUBLE_EQ(beam.mass(1), 2.5 * first + 2.0);
  EXPECT_DOUBLE_EQ(beam.mass(4), 0.5 * 2.5 * first + 0.5 * 0.25 * 50.0 + 7.0);
  EXPECT_DOUBLE_EQ(beam.mass(12), 0.5 * 0.25 * 50.0);
  double sum = 0.0;
  for (PetscInt node = 0; node < beam.nodes(); ++node) {
    sum += beam.mass(node);
  }
  EXPECT_NEAR(sum, beam.total_mass(), 1e-9);
}

TEST(BeamChain, YieldsWhereItHasAMomentByTheWeakerSide) {
  BeamParameters parameters = two_segments();
  EXPECT_FALSE(parameters.yields());
  parameters.segments[0].yield_moment = 5e3;
  parameters.segments[1].yield_moment = 8e3;
  parameters.left = test::kPinned;
  parameters.plasticity.tangent_ratio = 0.2;
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  const std::vector<PlasticHinge> hinges = beam.plastic_hinges();
  ASSERT_EQ(hinges.size(), 11U) << "all nodes but the pinned and the free end";
  EXPECT_EQ(hinges[0].node, 1);
  EXPECT_EQ(hinges[3].node, 4);
  EXPECT_EQ(hinges[3].moment, 5e3);
  EXPECT_EQ(hinges[4].moment, 8e3);
  const double give = 0.5 * (2.5 / parameters.segments[0].bending_stiffness + 0.25 / 1e6);
  EXPECT_DOUBLE_EQ(hinges[3].hardening, 0.25 / give);
}

TEST(BeamChain, HasHingesAtThePlacesThatAreGiven) {
  BeamParameters parameters = two_segments();
  parameters.segments[0].yield_moment = 5e3;
  parameters.plasticity.places = {{.position = 7.4, .hardening = 3.0}, {.position = 2.6, .hardening = 0.0}};
  const std::vector<PlasticHinge> hinges = BeamChain{PETSC_COMM_WORLD, parameters}.plastic_hinges();
  ASSERT_EQ(hinges.size(), 2U);
  EXPECT_EQ(hinges[0].node, 1);
  EXPECT_EQ(hinges[1].node, 3);
  EXPECT_EQ(hinges[1].hardening, 3.0);
  for (const double wrong : {0.0, 11.0, 13.0, 2.4}) {  // a free end, where nothing yields, beyond, a node taken
    parameters.plasticity.places = {{.position = 2.6, .hardening = 0.0}, {.position = wrong, .hardening = 0.0}};
    const BeamChain beam{PETSC_COMM_WORLD, parameters};
    EXPECT_THROW(static_cast<void>(beam.plastic_hinges()), InputError) << wrong;
  }
}

double mass_of(const BeamChain& beam, BeamChain::NodeRange nodes) {
  double sum = 0.0;
  for (PetscInt node = nodes.first; node <= nodes.last; ++node) {
    sum += beam.mass(node);
  }
  return sum;
}

TEST(MassPatch, HoldsTheMassOfItsLengthOnAnyMesh) {
  // Edges on nodes, between nodes, off the beam's end, across segments; narrower than the mesh.
  const std::vector<MassPatch> patches{{-0.5, 0.5}, {2.0, 3.0}, {4.55, 4.6}, {6.03, 7.28}, {9.3, 10.7}};
  for (const PetscInt elements : {20, 37, 80, 320}) {
    BeamParameters parameters = test::steel_beam(elements);
    parameters.segments.push_back({.length = 2.0, .elements = 8, .bending_stiffness = 1e6, .mass_per_length = 50.0});
    parameters.point_masses = {{.position = 4.0, .mass = 2.0}};
    parameters.mass_patches = patches;
    const BeamChain beam{PETSC_COMM_WORLD, parameters};
    const double density = 7850.0 * std::numbers::pi * 0.01;  // kg/m
    // Sums of some hundred masses, each rounded.
    const double tolerance = 1e-12 * beam.total_mass();
    EXPECT_NEAR(mass_of(beam, {0, beam.elements()}), beam.total_mass(), tolerance);
    EXPECT_NEAR(mass_of(beam, beam.nodes_within(-0.5, 0.5)), 0.5 * density, tolerance);
    EXPECT_NEAR(mass_of(beam, beam.nodes_within(2.0, 3.0)), density, tolerance);
    EXPECT_NEAR(mass_of(beam, beam.nodes_within(4.55, 4.6)), 0.05 * density, tolerance);
    EXPECT_NEAR(mass_of(beam, beam.nodes_within(6.03, 7.28)), 1.25 * density, tolerance);
    EXPECT_NEAR(mass_of(beam, beam.nodes_within(9.3, 10.7)), 0.7 * density + 0.7 * 50.0, tolerance);
    for (PetscInt node = 0; node < beam.nodes(); ++node) {
      EXPECT_GT(beam.mass(node), 0.0) << node;
    }
  }
}

TEST(MassPatch, MovesMassBesideItsEdgesOnly) {
  BeamParameters parameters = test::steel_beam(20);
  const BeamChain plain{PETSC_COMM_WORLD, parameters};
  parameters.mass_patches = {{1.4, 2.6}, {7.0, 8.0}};
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  const double density = 7850.0 * std::numbers::pi * 0.01;
  EXPECT_DOUBLE_EQ(beam.mass(2), 0.65 * density);   // 0.75 to 1.4
  EXPECT_DOUBLE_EQ(beam.mass(3), 0.35 * density);   // 1.4 to 1.75
  EXPECT_DOUBLE_EQ(beam.mass(13), 0.75 * density);  // an edge on the next node: 6.25 to 7
  EXPECT_DOUBLE_EQ(beam.mass(14), 0.25 * density);
  for (const PetscInt node : {0, 1, 4, 8, 15, 18, 20}) {
    EXPECT_EQ(beam.mass(node), plain.mass(node)) << node;
  }
}

TEST(MassPatch, MayLieOverOrBesideAnother) {
  BeamParameters parameters = test::steel_beam(40);
  parameters.mass_patches = {{2.0, 4.0}, {2.0, 4.0}, {3.0, 5.0}, {5.0, 6.0}};
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  const double density = 7850.0 * std::numbers::pi * 0.01;
  const auto over = beam.nodes_within(3.0, 5.0);
  EXPECT_NEAR(mass_of(beam, beam.nodes_within(2.0, 4.0)), 2.0 * density, 1e-9);
  EXPECT_NEAR(mass_of(beam, over), 2.0 * density, 1e-9);
  EXPECT_NEAR(mass_of(beam, beam.nodes_within(5.0, 6.0)), density, 1e-9);
  EXPECT_EQ(over.last, 20);  // the shared edge belongs to the left one
  EXPECT_EQ(beam.nodes_within(5.0, 6.0).first, 21);
}

TEST(MassPatch, RefusesAMeshWithoutANodeBetweenTwo) {
  BeamParameters parameters = test::steel_beam(20);
  parameters.mass_patches = {{1.5, 2.6}, {2.7, 3.5}};
  try {
    const BeamChain beam{PETSC_COMM_WORLD, parameters};
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string{error.what()}.find("beam elements: 20 is not allowed, expected at least 200"),
              std::string::npos)
        << error.what();
  }
  parameters.segments.front().elements = 200;
  EXPECT_NO_THROW((BeamChain{PETSC_COMM_WORLD, parameters}));
}

TEST(BeamChain, PlacesNodesAndFoundation) {
  BeamParameters parameters = two_segments();
  parameters.right = {.translational_stiffness = 11.0, .rotational_stiffness = 0.0};
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  EXPECT_DOUBLE_EQ(beam.position(3), 7.5);
  EXPECT_DOUBLE_EQ(beam.position(4), 10.0);
  EXPECT_DOUBLE_EQ(beam.position(6), 10.5);
  EXPECT_DOUBLE_EQ(beam.position(12), 12.0);
  EXPECT_DOUBLE_EQ(beam.ground_stiffness(3), 0.0);
  EXPECT_DOUBLE_EQ(beam.ground_stiffness(4), 0.5 * 0.25 * 300.0);
  EXPECT_DOUBLE_EQ(beam.ground_stiffness(5), 0.25 * 300.0);
  EXPECT_DOUBLE_EQ(beam.ground_stiffness(12), 0.5 * 0.25 * 300.0 + 11.0);
  EXPECT_EQ(beam.nearest_node(9.9), 4);
  EXPECT_EQ(beam.nearest_node(12.0), 12);
  EXPECT_EQ(beam.nearest_node(0.0), 0);
  const auto range = beam.nodes_within(7.5, 10.25);
  EXPECT_EQ(range.first, 3);
  EXPECT_EQ(range.last, 5);
}

TEST(BeamChain, RefusesWhatIsNoBeam) {
  BeamParameters beam = test::steel_beam(4);
  beam.segments[0].length = -1.0;
  EXPECT_THROW((BeamChain{PETSC_COMM_WORLD, beam}), InputError);
  beam = test::steel_beam(4);
  beam.segments[0].elements = 0;
  EXPECT_THROW((BeamChain{PETSC_COMM_WORLD, beam}), InputError);
  beam = test::steel_beam(4);
  beam.segments[0].mass_per_length = std::nan("");
  EXPECT_THROW((BeamChain{PETSC_COMM_WORLD, beam}), InputError);
  beam = test::steel_beam(4);
  beam.point_masses = {{.position = 11.0, .mass = 1.0}};
  EXPECT_THROW((BeamChain{PETSC_COMM_WORLD, beam}), InputError);
  beam = test::steel_beam(4);
  beam.segments[0].elements = std::numeric_limits<PetscInt>::max() / 2 + 1;
  EXPECT_THROW((BeamChain{PETSC_COMM_WORLD, beam}), InputError);
}

/// 4 elements of steel, a gap of 0.5 m, 8 elements of something light on a foundation.
BeamParameters two_beams() {
  BeamParameters beam = two_segments();
  beam.segments.insert(beam.segments.begin() + 1, {.length = 0.5, .elements = 1});
  beam.point_masses.clear();
  return beam;
}

TEST(BeamChain, OfTwoBeamsHasAGapWithoutMassOrStrength) {
  const BeamChain beam{PETSC_COMM_WORLD, two_beams()};
  const double first = 7850.0 * std::numbers::pi * 0.01;  // kg/m
  EXPECT_EQ(beam.elements(), 13);
  EXPECT_DOUBLE_EQ(beam.length(), 12.5);
  EXPECT_DOUBLE_EQ(beam.element(4).length, 0.5);
  EXPECT_TRUE(std::isinf(beam.element(4).flexural_compliance));
  EXPECT_TRUE(std::isfinite(beam.element(3).flexural_compliance));
  EXPECT_DOUBLE_EQ(beam.element(5).flexural_compliance, 1e-6);
  EXPECT_DOUBLE_EQ(beam.position(4), 10.0);
  EXPECT_DOUBLE_EQ(beam.position(5), 10.5);
  EXPECT_DOUBLE_EQ(beam.position(6), 10.75);
  EXPECT_DOUBLE_EQ(beam.mass(4), 0.5 * 2.5 * first);
  EXPECT_DOUBLE_EQ(beam.mass(5), 0.5 * 0.25 * 50.0);
  EXPECT_DOUBLE_EQ(beam.ground_stiffness(4), 0.0);
  EXPECT_DOUBLE_EQ(beam.ground_stiffness(5), 0.5 * 0.25 * 300.0);
  EXPECT_NEAR(beam.total_mass(), 10.0 * first + 100.0, 1e-9);
  EXPECT_EQ(beam.nearest_node(10.25), 4);
  EXPECT_EQ(beam.nearest_node(10.26), 5);
  const auto range = beam.nodes_within(10.0, 10.5);
  EXPECT_EQ(range.first, 4);
  EXPECT_EQ(range.last, 5);
  EXPECT_GT(beam.nodes_within(10.1, 10.4).first, beam.nodes_within(10.1, 10.4).last);
}

TEST(BeamChain, OfTwoBeamsHasFreeEndsAtTheGap) {
  BeamParameters parameters = two_beams();
  parameters.left = test::kClamped;
  parameters.right = test::kPinned;
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  for (PetscInt node = 0; node < beam.nodes(); ++node) {
    const bool is_end = node == 0 || node == 4 || node == 5 || node == 13;
    ASSERT_EQ(beam.end_at(node) != nullptr, is_end) << "node " << node;
    EXPECT_EQ(beam.fixed(node), node == 0 || node == 13) << "node " << node;
  }
  EXPECT_FALSE(beam.end_at(0)->moment_free());
  EXPECT_TRUE(beam.end_at(13)->moment_free());
  for (const PetscInt node : {4, 5}) {
    EXPECT_TRUE(beam.end_at(node)->moment_free());
    EXPECT_EQ(beam.end_at(node)->translational_stiffness, 0.0);
  }
}

TEST(BeamChain, RefusesAGapThatIsNotBetweenTwoBeams) {
  constexpr BeamSegment kGap{.length = 0.5, .elements = 1};
  const auto refuse = [](const BeamParameters& beam) {
    const std::string message =
        test::failure_of<InputError>([&] { static_cast<void>(BeamChain{PETSC_COMM_WORLD, beam}); });
    EXPECT_NE(message.find("a gap is one element between two segments"), std::string::npos) << message;
  };
  BeamParameters beam = two_segments();
  beam.segments.insert(beam.segments.begin(), kGap);
  refuse(beam);
  beam = two_segments();
  beam.segments.push_back(kGap);
  refuse(beam);
  beam = two_beams();
  beam.segments.insert(beam.segments.begin() + 1, kGap);
  refuse(beam);
  beam = two_beams();
  beam.segments[1].elements = 2;
  refuse(beam);
  beam = two_beams();
  beam.segments = {kGap};
  refuse(beam);
  // Only half a gap: a beam without stiffness, or without mass.
  beam = two_beams();
  beam.segments[1].mass_per_length = 1.0;
  EXPECT_THROW((BeamChain{PETSC_COMM_WORLD, beam}), InputError);
  beam = two_beams();
  beam.segments[1].bending_stiffness = 1.0;
  EXPECT_THROW((BeamChain{PETSC_COMM_WORLD, beam}), InputError);
}

TEST(BeamChain, AddsLineSupportsAtTheNearestNode) {
  BeamParameters parameters = two_segments();
  parameters.line_supports = {{.position = 10.6, .stiffness = 40.0},
                              {.position = 2.4},
                              {.position = 10.55, .stiffness = 2.0},
                              {.position = 12.0, .stiffness = 0.0}};
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  for (PetscInt node = 0; node < beam.nodes(); ++node) {
    EXPECT_EQ(beam.fixed(node), node == 1) << "node " << node;
    EXPECT_EQ(beam.end_at(node) != nullptr, node == 0 || node == 12) << "the line passes over a support";
  }
  EXPECT_DOUBLE_EQ(beam.ground_stiffness(1), 0.0);  // a rigid support is no stiffness
  EXPECT_DOUBLE_EQ(beam.ground_stiffness(5), 0.25 * 300.0);
  EXPECT_DOUBLE_EQ(beam.ground_stiffness(6), 0.25 * 300.0 + 42.0);
  EXPECT_DOUBLE_EQ(beam.ground_stiffness(12), 0.5 * 0.25 * 300.0);
}

TEST(BeamChain, RefusesLineSupportsOffTheBeamOrPushing) {
  for (const double position : {-0.1, 10.1, std::nan("")}) {
    BeamParameters beam = test::steel_beam(4);
    beam.line_supports = {{.position = 5.0}, {.position = position}};
    const std::string message =
        test::failure_of<InputError>([&] { static_cast<void>(BeamChain{PETSC_COMM_WORLD, beam}); });
    EXPECT_NE(message.find("beam line support position"), std::string::npos) << message;
    EXPECT_NE(message.find("from 0 to 10 [m]"), std::string::npos) << message;
  }
  for (const double stiffness : {-1.0, std::nan("")}) {
    BeamParameters beam = test::steel_beam(4);
    beam.line_supports = {{.position = 5.0, .stiffness = stiffness}};
    EXPECT_THROW((BeamChain{PETSC_COMM_WORLD, beam}), InputError);
  }
}

TEST(Loads, FollowTheirTablesAndHoldTheEnds) {
  const TimeTable table{{1.0, 2.0, 4.0}, {10.0, 30.0, -10.0}};
  const auto expect = [&](double time, double force, double rate) {
    const auto now = table.at(time);
    EXPECT_DOUBLE_EQ(now.value, force) << "t = " << time;
    EXPECT_DOUBLE_EQ(now.rate, rate) << "t = " << time;
  };
  expect(0.0, 10.0, 0.0);
  expect(1.0, 10.0, 20.0);
  expect(1.5, 20.0, 20.0);
  expect(2.0, 30.0, -20.0);
  expect(3.0, 10.0, -20.0);
  expect(5.0, -10.0, 0.0);
}

TEST(Loads, JumpBetweenTwoRowsOfOneTime) {
  const NodalLoad load{.position = 0.0, .table = time_table({0.0, 1.0, 1.0, 2.0}, {0.0, 2.0, -4.0, -4.0})};
  EXPECT_DOUBLE_EQ(load.table->at({1.0, 0.5}).value, 2.0);  // at the end of a step
  EXPECT_DOUBLE_EQ(load.table->at({1.0, 0.5}).rate, 2.0);
  EXPECT_DOUBLE_EQ(load.table->at(1.0).value, -4.0);
  EXPECT_DOUBLE_EQ(load.table->at(1.0).rate, 0.0);
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(4)};
  const Loads loads{beam.points(), 0.0, {load}};
  EXPECT_EQ(loads.kinks(), (std::vector<double>{0.0, 1.0, 2.0}));
  EXPECT_TRUE(loads.jumps_at(1.0));
  EXPECT_TRUE(loads.jumps_at(std::nextafter(1.0, 0.0)));
  EXPECT_FALSE(loads.jumps_at(2.0));
  std::vector<double> work;
  EXPECT_DOUBLE_EQ(loads.mean(0.5, 1.5, work)[0], 0.5 * 1.5 - 0.5 * 4.0);
}

TEST(Loads, BetweenNodesKeepForceAndMoment) {
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(4)};
  for (const double x : {0.0, 0.7, 2.5, 6.0, 10.0}) {
    const Loads loads{beam.points(), 0.0, {{.position = x, .table = time_table({0.0}, {8.0})}}};
    std::vector<double> work;
    double force = 0.0;
    double moment = 0.0;
    const auto values = loads.force(0.0, work);
    for (std::size_t i = 0; i < values.size(); ++i) {
      force += values[i];
      moment += values[i] * beam.position(static_cast<PetscInt>(i));
    }
    EXPECT_DOUBLE_EQ(force, 8.0);
    EXPECT_NEAR(moment, 8.0 * x, 1e-14 * 80.0) << x;
    EXPECT_EQ(std::ranges::count_if(values, [](double value) { return value != 0.0; }), x == 0.7 || x == 6.0 ? 2 : 1);
  }
}

TEST(BeamChain, EndsAreOnTheBeamWhateverRoundingDoesToTheirSum) {
  BeamParameters parameters = test::steel_beam(4);
  parameters.segments.push_back(parameters.segments[0]);
  parameters.segments[0].length = 0.1;
  parameters.segments[1].length = 0.7;  // 0.1 + 0.7 < 0.8
  parameters.point_masses = {{.position = 0.8, .mass = 1.0}};
  parameters.line_supports = {{.position = 0.8}};
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  EXPECT_LT(beam.length(), 0.8);
  EXPECT_TRUE(beam.fixed(8));
  EXPECT_NO_THROW((Loads{beam.points(), 0.0, {{.position = 0.8, .table = time_table({0.0}, {1.0})}}}));
  EXPECT_EQ(find_contacts(beam.points(), {{.position = 0.8}}).sets.size(), 0U);  // found, and fixed
  EXPECT_THROW(require_on("x", 0.8 + 1e-8, beam.points().extent()), InputError);
}

TEST(Loads, VisitThePiecesOfATableInATime) {
  const TimeTable table{{0.0, 1.0, 1.0, 2.0, 3.0}, {0.0, 2.0, -4.0, -4.0, 1.0}};
  const auto pieces = [&](double from, double to) {
    std::vector<std::pair<double, double>> all;
    table.each_piece(from, to, [&](double begin, double end) { all.emplace_back(begin, end); });
    return all;
  };
  using Pieces = std::vector<std::pair<double, double>>;
  EXPECT_EQ(pieces(-1.0, 2.5), (Pieces{{-1.0, 0.0}, {0.0, 1.0}, {1.0, 2.0}, {2.0, 2.5}}));
  EXPECT_EQ(pieces(1.0, 2.0), (Pieces{{1.0, 2.0}}));
  EXPECT_EQ(pieces(std::nextafter(1.0, 0.0), std::nextafter(2.0, 3.0)).size(), 1U) << "ends at rows, but for rounding";
  EXPECT_EQ(pieces(4.0, 5.0), (Pieces{{4.0, 5.0}}));
  EXPECT_EQ(table.jumps(), std::vector<double>{1.0});
}

TEST(Loads, SpreadOverALengthKeepForceAndMoment) {
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(8)};
  constexpr double kAll = std::numeric_limits<double>::infinity();
  for (const auto& [position, width] : {std::pair{5.0, kAll}, {3.3, 0.2}, {3.3, 4.0}, {2.5, 5.0}, {8.75, 2.5}}) {
    const Loads loads{beam.points(), 0.0, {{.position = position, .width = width, .table = time_table({0.0}, {8.0})}}};
    std::vector<double> work;
    double sum = 0.0;
    double moment = 0.0;
    std::size_t nodes = 0;
    const auto force = loads.force(0.0, work);
    for (std::size_t i = 0; i < force.size(); ++i) {
      sum += force[i];
      moment += force[i] * beam.position(static_cast<PetscInt>(i));
      nodes += force[i] > 0.0 ? 1 : 0;
    }
    EXPECT_NEAR(sum, 8.0, 1e-14) << position << ' ' << width;
    EXPECT_NEAR(moment, 8.0 * position, 1e-13) << position << ' ' << width;
    EXPECT_EQ(nodes, std::isinf(width) ? 9U : width < 1.0 ? 2U : width < 3.0 ? 3U : 5U) << position << ' ' << width;
  }
  for (const auto& [position, width] : {std::pair{9.0, 2.5}, {0.5, 1.1}, {5.0, -1.0}}) {
    EXPECT_THROW(
        (Loads{beam.points(), 0.0, {{.position = position, .width = width, .table = time_table({0.0}, {8.0})}}}),
        InputError);
  }
}

TEST(Loads, RefuseTablesThatDoNotAscend) {
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(4)};
  EXPECT_THROW(static_cast<void>(time_table({0.0, 0.0, 0.0}, {1.0, 2.0, 3.0})), InputError);
  EXPECT_THROW(static_cast<void>(time_table({0.0, 1.0, 0.5}, {1.0, 2.0, 3.0})), InputError);
  EXPECT_THROW(static_cast<void>(time_table({0.0, 1.0}, {1.0})), InputError);
  EXPECT_THROW(static_cast<void>(time_table({}, {})), InputError);
  EXPECT_THROW((Loads{beam.points(), 9.81, {{.position = 1.0, .table = nullptr}}}), InputError);
  EXPECT_THROW((Loads{beam.points(), 9.81, {{.position = 11.0, .table = time_table({0.0}, {1.0})}}}), InputError);
}

TEST(InitialMasses, FollowAxisRotationAndShapeButHeldEndsStay) {
  BeamParameters parameters = test::steel_beam(4);
  parameters.right = test::kPinned;
  const BeamChain beam{PETSC_COMM_WORLD, parameters};
  InitialState initial{.height = 1.0, .slope = 0.1, .velocity = -2.0, .angular_velocity = 0.5};
  initial.shape = {.x = {0.0, 5.0, 10.0}, .offset = {0.0, 0.4, 0.8}, .velocity = {1.0, 1.0, 1.0}};
  const MassState masses = initial_masses(beam.points(), initial);
  EXPECT_DOUBLE_EQ(masses.position[0], 0.5);
  EXPECT_DOUBLE_EQ(masses.position[1], 0.75 + 0.2);
  EXPECT_DOUBLE_EQ(masses.velocity[1], -2.0 - 1.25 + 1.0);
  EXPECT_DOUBLE_EQ(masses.position[4], 1.5);
  EXPECT_DOUBLE_EQ(masses.velocity[4], 0.0);
}

}  // namespace
}  // namespace udar
