// ranks: 1; size: short
/// @file
/// A beam hinged at one end swings into a stop that gives way: SDNL32, a public test case of Code_Aster.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include "support/steel_beam.hpp"

namespace udar {
namespace {

/// Where its tip is at 1, 2, ... 12 ms [mm].
using Course = std::array<double, 12>;

/// SDNL32: a square bar of 14 mm and 0.783 m, E = 6.7e10 Pa, 2400 kg/m^3, hinged at the left, turns at -3.8 rad/s and
/// touches the stop at its tip at t = 0; no gravity, 1 % of critical damping in every flexible mode.
/// Source: Code_Aster, document V5.02.032 and astest/sdnl32a.comm (EDF R&D, www.code-aster.org): `reference` by the
/// commission VPCS, in three digits, `aster` by ten modes of ten Timoshenko elements and central differences.
struct Stop {
  double stiffness;  // [N/m]
  Course reference;
  Course aster;
};
constexpr std::array kStops{
    Stop{.stiffness = 18000.0,
         .reference = {-2.66, -4.33, -4.92, -4.78, -3.82, -2.87, -2.71, -3.09, -3.41, -3.36, -2.64, -0.742},
         .aster = {-2.6627590, -4.3350345, -4.9527613, -4.7819171, -3.8242004, -2.8745139, -2.7099552, -3.0877217,
                   -3.4066468, -3.3641584, -2.6422010, -0.7427363}},
    Stop{.stiffness = 45000.0,
         .reference = {-2.25, -2.66, -1.96, -1.15, -0.124, -0.364, -2.01, -2.74, -1.89, -0.352, 1.70, 4.99},
         .aster = {-2.2499139, -2.6571934, -1.9644468, -1.1558833, -0.1225388, -0.3634390, -2.0093063, -2.7406203,
                   -1.8936271, -0.3520425, 1.7043769, 4.9858101}}};

ModelParameters swinging(double stiffness) {
  constexpr double kLength = 0.783;
  constexpr double kSide = 0.014;
  constexpr double kSpin = -3.8;
  BeamParameters bar;
  bar.segments.push_back({.length = kLength,
                          .elements = 100,
                          .bending_stiffness = 6.7e10 * std::pow(kSide, 4) / 12.0,
                          .mass_per_length = 2400.0 * kSide * kSide});
  bar.left = test::kPinned;
  Support stop{.position = kLength};
  stop.stiffness = stiffness;
  return {.beam = std::move(bar),
          .filter = test::unfiltered(1e-4),
          .gravity = 0.0,
          .damping_ratio = {0.01},
          .initial = {.height = 0.0, .velocity = 0.5 * kSpin * kLength, .angular_velocity = kSpin},
          .supports = {stop}};
}

Course tip_of(double stiffness, const char* modes) {
  const test::Option type{"-ts_type", "modal"};
  const test::Option count{"-modal_modes", modes};
  const test::Option end{"-ts_max_time", "0.012"};
  const test::Option tolerance{"-ts_rtol", "2e-5"};  // ten times that may go in a period of the first bending mode
  test::Fall fall{swinging(stiffness)};
  test::Recorder rows{1e-3};
  fall.dynamics.add_observer(rows);
  fall.dynamics.solve();
  EXPECT_LT(rows.largest_drift(), 3e-4);
  EXPECT_GT(rows.energies.back().lost_in_dampers, 0.0);
  Course tip{};
  for (std::size_t k = 0; k < tip.size(); ++k) {
    tip[k] = 1e3 * rows.positions.at(k + 1).back();
  }
  return tip;
}

TEST(HingedBeam, SwingsIntoAStopAsCodeAsterSays) {
  for (const Stop& stop : kStops) {
    // Deepest in the spring, within the rows.
    const double peak = -*std::ranges::min_element(stop.reference);
    for (const char* modes : {"5", "8", "16"}) {
      const Course tip = tip_of(stop.stiffness, modes);
      double off_reference = 0.0;
      double off_aster = 0.0;
      for (std::size_t k = 0; k < tip.size(); ++k) {
        off_reference = std::max(off_reference, std::abs(tip[k] - stop.reference[k]));
        off_aster = std::max(off_aster, std::abs(tip[k] - stop.aster[k]));
      }
      EXPECT_LT(off_reference, 0.01 * peak) << stop.stiffness << " N/m, " << modes << " modes";
      EXPECT_LT(off_aster, 0.01 * peak) << stop.stiffness << " N/m, " << modes << " modes";
    }
  }
}

}  // namespace
}  // namespace udar
