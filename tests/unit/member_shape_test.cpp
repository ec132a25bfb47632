// ranks: 1; size: short
// Cross-sections of members from their shapes, and regular networks.
#include "udar/structure/member_shape.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace udar {
namespace {

using Kind = MemberShape::Kind;

MemberSection steel() {
  return {.name = "steel", .youngs_modulus = 2.1e11, .shear_modulus = 2.1e11 / 2.6, .density = 7850.0};
}

TEST(MemberShape, RectangleHasTheTorsionConstantOfTheSeries) {
  // Timoshenko and Goodier, section 109, table 6: k1 a b^3, four digits; here by the plain series, 100 000 terms of it,
  // summed exactly.
  MemberSection section = steel();
  give_shape(section, {.kind = Kind::rectangle, .width = 1.0, .height = 1.0}, false);
  EXPECT_NEAR(section.torsion_constant, 0.14057701495515365, 1e-15);
  for (const bool upright : {false, true}) {
    give_shape(section, {.kind = Kind::rectangle, .width = upright ? 1.0 : 2.0, .height = upright ? 2.0 : 1.0}, false);
    EXPECT_NEAR(section.torsion_constant, 0.45736335423914154, 1e-15);
  }
  give_shape(section, {.kind = Kind::rectangle, .width = 1e4, .height = 1.0}, false);
  EXPECT_NEAR(section.torsion_constant, 1e4 / 3.0 * (1.0 - 0.6302e-4),
              1e-3);  // a b^3 / 3 (1 - 0.6302 b / a): four digits
}

TEST(MemberShape, RectangleBendsMoreEasilyAboutItsLongSide) {
  MemberSection section = steel();
  give_shape(section, {.kind = Kind::rectangle, .width = 0.1, .height = 0.2}, false);
  EXPECT_NEAR(section.area, 0.02, 1e-17);
  EXPECT_NEAR(section.inertia[0], 0.1 * 0.008 / 12.0, 1e-19);  // in the plane of the height
  EXPECT_NEAR(section.inertia[1], 0.2 * 0.001 / 12.0, 1e-19);
  EXPECT_EQ(section.shear_factor[0], 0.0);
  give_shape(section, {.kind = Kind::rectangle, .width = 0.1, .height = 0.2}, true);
  EXPECT_NEAR(section.shear_factor[0], 13.0 / (12.0 + 3.3), 1e-15);  // Cowper, nu = 0.3
}

TEST(MemberShape, RoundSectionsTwistByTheirPolarInertia) {
  MemberSection section = steel();
  give_shape(section, {.kind = Kind::tube, .radius = 0.1, .inner_radius = 0.09}, false);
  EXPECT_NEAR(section.torsion_constant, std::numbers::pi / 2.0 * (1e-4 - 0.6561e-4), 1e-18);
  EXPECT_EQ(section.inertia[0], section.inertia[1]);
  EXPECT_EQ(section.radius, 0.1);
  give_shape(section, {.kind = Kind::circle, .radius = 0.1}, false);
  EXPECT_NEAR(section.torsion_constant, std::numbers::pi / 2.0 * 1e-4, 1e-18);
}

TEST(GradedSpacing, IsAGeometricProgression) {
  EXPECT_TRUE(graded_spacing(5, 1.0).empty());
  EXPECT_TRUE(graded_spacing(1, 3.0).empty());
  const std::vector<double> spacing = graded_spacing(4, 8.0);
  ASSERT_EQ(spacing.size(), 4U);
  for (std::size_t i = 0; i < spacing.size(); ++i) {
    EXPECT_NEAR(spacing[i], std::exp2(static_cast<double>(i)), 1e-14);
  }
}

TEST(RegularNetwork, JoinsNeighboursAlongTheAxes) {
  const NetworkParameters network =
      regular_network({.junctions = {3, 1, 2}, .spacing = {2.0, 1.0, 0.5}, .elements = 4, .section = steel()});
  EXPECT_EQ(regular_network({.junctions = {2, 1, 1}, .elements = 3, .grading = 4.0}).members[0].spacing,
            graded_spacing(3, 4.0));
  ASSERT_EQ(network.junctions.size(), 6U);
  ASSERT_EQ(network.members.size(), 2U * 2U + 3U);
  EXPECT_EQ(network.junctions.back().name, "2 0 1");
  EXPECT_EQ(network.junctions.back().place.x, 4.0);
  EXPECT_EQ(network.junctions.back().place.z, 0.5);
  for (const Member& member : network.members) {
    const Place& from = network.junctions[member.ends[0].junction].place;
    const Place& to = network.junctions[member.ends[1].junction].place;
    const double along_x = to.x - from.x;
    const double along_z = to.z - from.z;
    EXPECT_TRUE((along_x == 2.0 && along_z == 0.0) || (along_x == 0.0 && along_z == 0.5)) << member.name;
    EXPECT_EQ(member.elements, 4U);
    EXPECT_TRUE(member.spacing.empty());
  }
}

}  // namespace
}  // namespace udar
