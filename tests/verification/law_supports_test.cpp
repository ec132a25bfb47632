// ranks: 1 2 3; size: medium
/// @file
/// Beams that fall on supports with a law of contact, and that start pressed by them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "support/steel_beam.hpp"
#include "support/world.hpp"
#include "udar/contact/loading_curve.hpp"
#include "udar/contact/power_law.hpp"

namespace udar {
namespace {

struct Named {
  const char* name;
  std::shared_ptr<const ContactLaw> law;
  bool loses;
};

/// Laws that stop the beam within some millimetres to centimetres.
std::vector<Named> all_laws() {
  const auto curve = [](LoadingCurve::Parameters parameters) {
    return std::make_shared<LoadingCurve>(std::move(parameters));
  };
  return {
      {"hertz", std::make_shared<PowerLaw>(PowerLaw::Parameters{.stiffness = 2e7}), false},
      {"hunt_crossley",
       std::make_shared<PowerLaw>(PowerLaw::Parameters{.stiffness = 2e7, .exponent = 1.3, .damping = 0.4}), true},
      {"bilinear", curve(LoadingCurve::bilinear(1e6, 3e6)), true},
      {"crush",
       curve(LoadingCurve::crush({.stiffness = 4e6, .plateau = 2e4, .bottoming = 0.03, .bottoming_stiffness = 1e6})),
       true},
      {"table", curve(LoadingCurve::table({0.0, 0.01, 0.02, 0.03}, {0.0, 8e3, 1e4, 4e4}, 5e6)), true}};
}

class OnLaws : public testing::TestWithParam<std::size_t> {
 protected:
  [[nodiscard]] static Named tested() { return all_laws().at(GetParam()); }
};
INSTANTIATE_TEST_SUITE_P(All, OnLaws, testing::Range<std::size_t>(0, 5),
                         [](const auto& tested) { return std::string{all_laws().at(tested.param).name}; });

Support with_law(Support support, std::shared_ptr<const ContactLaw> law) {
  support.contact_law = std::move(law);
  return support;
}

/// Tilted, on a point and on a pad: many contacts, none at once.
TEST_P(OnLaws, TiltedFallKeepsEnergyAndMomentum) {
  const test::Option end{"-ts_max_time", "0.3"};
  const test::Option tolerance{"-ts_rtol", "1e-12"};
  const auto [name, law, loses] = tested();
  test::Fall fall{test::steel_beam(20),
                  60.0,
                  test::kGravity,
                  {.height = 0.08, .slope = 0.01, .velocity = -1.0},
                  {with_law({.position = 2.0}, law), with_law({.position = 8.0, .width = 1.0}, law)}};
  test::Recorder record{2e-3};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  EXPECT_LT(record.largest_drift(), 1e-9) << name;
  double stored = 0.0;
  for (std::size_t k = 1; k < record.energies.size(); ++k) {
    stored = std::max(stored, record.energies[k].support_springs);
    EXPECT_GE(record.energies[k].lost_in_dampers, record.energies[k - 1].lost_in_dampers) << record.times[k];
  }
  const double kinetic = 0.5 * fall.beam.total_mass();
  EXPECT_GT(stored, 0.02 * kinetic);
  EXPECT_EQ(record.energies.back().lost_in_dampers > 0.02 * kinetic, loses);
  EXPECT_EQ(record.energies.back().lost_in_impacts, 0.0);
  double given = -test::kGravity * fall.beam.total_mass() * 0.3;
  for (const double impulse : fall.dynamics.support_impulses()) {
    given += impulse;
    EXPECT_GT(impulse, 0.0);
  }
  const double start = -fall.beam.total_mass();
  EXPECT_NEAR(test::momentum_of(fall.line, fall.dynamics) - start, given, 1e-9 * fall.beam.total_mass());
}

/// On a support that moves, from above: work comes in through the law.
TEST_P(OnLaws, ShakenFromAboveKeepsTheLedger) {
  const test::Option end{"-ts_max_time", "0.4"};
  const test::Option tolerance{"-ts_rtol", "1e-12"};
  const auto [name, law, loses] = tested();
  Support above{.position = 5.0, .height = 0.02, .side = SupportSide::above};
  above.motion = std::make_shared<SupportMotion>(std::vector<double>{0.0, 0.1, 0.2, 0.4},
                                                 std::vector<double>{0.0, -0.06, 0.0, -0.05});
  BeamParameters beam = test::steel_beam(20);
  beam.left = test::kPinned;
  beam.right = test::kPinned;
  test::Fall fall{beam, 60.0, 0.0, {.height = 0.0}, {with_law(above, law)}};
  test::Recorder record{4e-3};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  EXPECT_LT(record.largest_drift(), 1e-8) << name;  // within steps; on a linear spring 4e-9
  EXPECT_LT(std::abs(record.energies.back().drift()), 1e-10) << name;
  EXPECT_GT(std::abs(record.energies.back().support_work), 1.0);
}

/// On a floor on which all masses land at once the line stays straight, and each does what a ball does.
TEST(ContactLaws, FlatFallIsThatOfABall) {
  const test::Option end{"-ts_max_time", "0.2"};
  const test::Option tolerance{"-ts_rtol", "1e-11"};
  const auto law = std::make_shared<LoadingCurve>(LoadingCurve::bilinear(4e6, 9e6));
  test::Fall fall{test::steel_beam(10),
                  40.0,
                  0.0,
                  {.height = 0.1, .velocity = -1.0},
                  {with_law({.position = 5.0, .width = 20.0}, law)}};
  test::Recorder record{0.01};
  fall.dynamics.add_observer(record);
  fall.dynamics.solve();
  const MassState masses = fall.dynamics.masses();
  const double set = law->permanent_set(std::sqrt(fall.beam.total_mass() / 4e6));
  const double lands = 0.1 + 0.5 * std::numbers::pi * (1.0 + 2.0 / 3.0) * std::sqrt(fall.beam.total_mass() / 4e6);
  for (std::size_t i = 0; i < masses.velocity.size(); ++i) {
    EXPECT_NEAR(masses.velocity[i], 2.0 / 3.0, 1e-10);
    EXPECT_NEAR(masses.position[i], 2.0 / 3.0 * (0.2 - lands) - set, 1e-10);
  }
  EXPECT_LT(record.largest_drift(), 1e-9);
}

/// Pressed from the start by a face that is in the beam, and damped until it is at rest: springs in a row.
TEST(ContactLaws, InterferenceSettlesWhereForcesBalance) {
  const test::Option end{"-ts_max_time", "6"};
  constexpr double kInside = 0.02;  // [m]
  BeamParameters beam = test::steel_beam(6);
  beam.left = test::kPinned;
  beam.right = test::kPinned;
  const double wf = 60.0;
  const double of_beam = 48.0 * beam.segments[0].bending_stiffness / 1000.0;
  const double of_filter = wf * wf * beam.segments[0].mass_per_length * 10.0 / 6.0;
  const double in_row = of_beam * of_filter / (of_beam + of_filter);
  for (const auto& [name, law, loses] : all_laws()) {
    test::Fall fall{beam, wf, 0.0,          {.height = 0.0}, {with_law({.position = 5.0, .height = kInside}, law)},
                    {},   {}, {.mass = 8.0}};
    test::Recorder record{0.5};
    fall.dynamics.add_observer(record);
    fall.dynamics.solve();
    // Where the force of the beam is that of the law: unloading from the start, as the beam gives way.
    double low = 0.0;
    double high = kInside;
    for (int turn = 0; turn < 100; ++turn) {
      const double d = 0.5 * (low + high);
      (law->force({.compression = d, .rate = -1e-300}, kInside) < in_row * (kInside - d) ? low : high) = d;
    }
    const double expected = kInside - low;
    for (PetscInt node = fall.beam.begin(); node < fall.beam.end(); ++node) {
      if (node == 3) {
        EXPECT_NEAR(fall.dynamics.masses().position[static_cast<std::size_t>(node - fall.beam.begin())], expected, 1e-7)
            << name;
      }
    }
    EXPECT_GT(record.energies.front().support_springs, 1.0) << name;
    EXPECT_LT(record.largest_drift(), 1e-6) << name;
  }
}

}  // namespace
}  // namespace udar
