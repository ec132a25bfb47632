// ranks: 1; size: short
/// @file
/// Masses of the impact integrator that meet a floor, against closed forms.

#include "udar/integrators/touching_masses.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/steel_beam.hpp"
#include "udar/local/step_maps.hpp"

namespace udar {
namespace {

/// One step of a flat beam above or on a floor at zero, whose line stays where it is: every mass is an oscillator about
/// its own start.
struct FlatStep {
  static constexpr double kRestitution = 0.5;
  BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(10)};
  std::vector<double> mass;
  std::vector<double> start;
  std::vector<double> end;
  std::vector<double> axis;
  Contacts contacts;
  ContactState contact;
  Sweep sweep;

  FlatStep(double height, double speed)
      : mass{[this] {
          std::vector<double> all;
          for (PetscInt i = beam.begin(); i < beam.end(); ++i) {
            all.push_back(beam.mass(i));
          }
          return all;
        }()},
        start(2 * mass.size(), height),
        end(start),
        axis(mass.size(), 0.0),
        contacts{find_contacts(beam.points(), {Support::floor(0.0, kRestitution)})},
        contact{beam.points(), contacts, {}} {
    std::fill(start.begin() + static_cast<std::ptrdiff_t>(mass.size()), start.end(), speed);
    sweep.count = mass.size();
    sweep.frequency = 100.0;
    sweep.step = 1e-3;
    sweep.predict = true;
    sweep.start = start.data();
    sweep.end = end.data();
    sweep.axis = axis;
    sweep.mass = mass;
    for (std::size_t j = 0; j < sweep.terms; ++j) {
      sweep.moment_rows[j].assign(sweep.count, 0.0);
      sweep.series.rows[j].assign(sweep.count, 0.0);
    }
    sweep.series.steady[0].assign(sweep.count, 0.0);
    sweep.map = dense_map(sweep.scale(), sweep.terms);
    sweep.reach = response_bounds(sweep.scale(), sweep.terms);
  }

  /// @return how many masses it took on
  std::size_t move() {
    FilteredStructure line{beam, {.filter_frequency = sweep.frequency}};
    TouchingMasses touching{sweep, contact, line};
    Tally tally;
    SweepMaxima largest;
    touching.begin(tally);
    const double* const free = touching.take_out(0, sweep.count, largest);
    std::size_t taken = 0;
    for (std::size_t i = 0; i < sweep.count; ++i) {
      taken += free[i] == 0.0 ? 1 : 0;
    }
    touching.move(0, largest);
    touching.finish(largest);
    touching.write_journal();
    return taken;
  }
};

TEST(TouchingMasses, BounceInLanesAndAlone) {
  const double height = 1e-3;
  const double speed = -2.0;
  FlatStep flat{height, speed};  // 11 masses: eight side by side, three in a batch that is not full
  EXPECT_EQ(flat.move(), flat.sweep.count);
  const double w = flat.sweep.frequency;
  const double impact = std::asin(-w * height / speed) / w;
  const double left = flat.sweep.step - impact;
  const double after = -FlatStep::kRestitution * speed * std::cos(w * impact);
  for (std::size_t i = 0; i < flat.sweep.count; ++i) {
    // Rounding of a series of some 15 terms, and of the root.
    EXPECT_NEAR(flat.end[i], height - height * std::cos(w * left) + after / w * std::sin(w * left), 1e-16);
    EXPECT_NEAR(flat.end[flat.sweep.count + i], w * height * std::sin(w * left) + after * std::cos(w * left), 1e-13);
  }
  EXPECT_EQ(flat.contact.journal().impacts().size(), flat.sweep.count);
  EXPECT_NEAR(flat.contact.journal().impacts()[0].time, impact, 1e-17);
}

TEST(TouchingMasses, AreNoneWhereBoundsExcludeTheFloor) {
  FlatStep flat{1e-2, -2.0};  // 2 mm of way in the step
  EXPECT_EQ(flat.move(), 0);
  EXPECT_TRUE(flat.contact.journal().impacts().empty());
}

}  // namespace
}  // namespace udar
