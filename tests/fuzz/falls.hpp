#pragma once
/// @file
/// Some small falls, each with what its restart file holds after a few steps.

#include <memory>
#include <string>
#include <vector>

#include "fuzz/harness.hpp"
#include "udar/app/case.hpp"
#include "udar/app/run.hpp"
#include "udar/dynamics/impact_dynamics.hpp"
#include "udar/dynamics/model.hpp"
#include "udar/io/support_forces.hpp"

namespace udar::fuzz {

struct Fall {
  std::string yaml;
  app::Case input;
  std::unique_ptr<Model> model;
  MotionState saved;

  [[nodiscard]] io::SupportForces forces() const {
    return {input.supports.size(), input.output.interval, input.output.force_window, 0.0};
  }
};

inline Fall make_fall(const std::string& keys) {
  Fall fall;
  fall.yaml =
      "beam_length: 4\nbeam_elements: 6\ninitial_height: 0.002\noutput_interval: 0.002\nts_max_time: 0.06\n" + keys;
  insert_case(fall.yaml + "ts_max_steps: 20\n");
  fall.input = app::resolve(PETSC_COMM_WORLD, app::read_case(PETSC_COMM_WORLD));
  fall.model = std::make_unique<Model>(PETSC_COMM_WORLD, fall.input);
  ImpactDynamics dynamics{*fall.model};
  dynamics.solve();
  fall.saved = dynamics.save();
  io::SupportForces forces = fall.forces();
  for (int row = 1; row < 4; ++row) {
    static_cast<void>(forces.add(fall.input.output.interval * row, dynamics.support_impulses()));
  }
  forces.save(fall.saved);
  fall.yaml += "ts_max_steps: 24\n";
  return fall;
}

/// One for each integrator and kind of contact.
inline std::vector<Fall>& falls() {
  static std::vector<Fall> all = [] {
    app::register_types();
    std::vector<Fall> made;
    for (const char* keys :
         {"filter_frequency: 100\nfloor: true\nts_type: impact\ncontact_restitution: 0\n",
          "filter_frequency: 100\nfloor: true\nts_type: impact\ndamping_stiffness: 1e-4\n",
          "filter_frequency: 100\nsupport_position: [1, 3]\nsupport_width: 1\nsupport_stiffness: 1e6\n"
          "support_damping: 100\nts_type: rk\n",
          "filter_frequency: 100\nsupport_position: [1, 3]\nts_type: chebyshev\n",
          "filter_frequency: 100\nsupport_position: [1, 3]\ncontact_surface: line\nts_type: rk\n",
          "filter_frequency: 100\nsupport_position: [1, 3]\nsupport_width: 1\ncontact_surface: line\n"
          "contact_line_dense_max: 0\nts_type: rk\n",
          "filter_frequency: none\nfloor: true\nts_type: moreau\nts_dt: 1e-3\n"}) {
      made.push_back(make_fall(keys));
    }
    return made;
  }();
  return all;
}

}  // namespace udar::fuzz
