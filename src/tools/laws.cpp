#include "tools/laws.hpp"

#include <petscsys.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tools/timing.hpp"
#include "udar/contact/loading_curve.hpp"
#include "udar/contact/power_law.hpp"
#include "udar/local/local_motion.hpp"
#include "udar/petsc/error.hpp"

namespace udar::bench {
namespace {

constexpr double kMass = 1.0;   // kg
constexpr double kStep = 1e-3;  // s
constexpr double kSpeed = 1.0;  // m/s
// With it a spring keeps a mass for half a step.
constexpr double kStiffness = kMass * (2.0 * std::numbers::pi / kStep) * (2.0 * std::numbers::pi / kStep);
constexpr double kDepth = kSpeed * kStep / (2.0 * std::numbers::pi);  // to which it presses that spring [m]

/// Laws that stop the mass where the spring would, about.
std::vector<std::pair<std::string, std::unique_ptr<ContactLaw>>> all_laws() {
  const double hertz = 1.25 * kMass * kSpeed * kSpeed / std::pow(kDepth, 2.5);
  const double plateau = 0.5 * kStiffness * kDepth;
  std::vector<std::pair<std::string, std::unique_ptr<ContactLaw>>> all;
  all.emplace_back("hertz", std::make_unique<PowerLaw>(PowerLaw::Parameters{.stiffness = hertz}));
  all.emplace_back("hunt_crossley",
                   std::make_unique<PowerLaw>(PowerLaw::Parameters{.stiffness = hertz, .damping = 0.2}));
  all.emplace_back("bilinear", std::make_unique<LoadingCurve>(LoadingCurve::bilinear(kStiffness, 4.0 * kStiffness)));
  all.emplace_back("crush", std::make_unique<LoadingCurve>(LoadingCurve::crush({.stiffness = 4.0 * kStiffness,
                                                                                .plateau = plateau,
                                                                                .bottoming = 10.0 * kDepth,
                                                                                .bottoming_stiffness = kStiffness})));
  all.emplace_back("table", std::make_unique<LoadingCurve>(LoadingCurve::table(
                                {0.0, 0.2 * kDepth, 0.6 * kDepth, 2.0 * kDepth},
                                {0.0, 0.3 * plateau, 0.8 * plateau, 3.0 * plateau}, 4.0 * kStiffness)));
  return all;
}

/// Masses a little above a stop, each with a speed of its own, on filter springs that turn by 0.1 in a step.
std::vector<local::Problem> problems(const local::Stop& stop) {
  constexpr std::size_t kMasses = 1024;
  std::mt19937_64 generator{1};
  const auto uniform = [&generator] {
    return static_cast<double>(generator()) / static_cast<double>(std::mt19937_64::max());
  };
  std::vector<local::Problem> all(kMasses);
  for (local::Problem& problem : all) {
    problem.angle = 0.1;
    problem.terms = 3;
    problem.powers = local::powers_for(problem.angle);
    problem.velocity = -kSpeed * kStep * (0.8 + 0.4 * uniform());
    problem.line = {0.0, 0.1 * problem.velocity, 0.0};
    problem.stops[0] = stop;
    problem.stops[0].at = 0.2 * uniform() * problem.velocity;
    problem.hop_tolerance = 1e-12;
  }
  return all;
}

}  // namespace

void laws(MPI_Comm comm, PetscInt repeats) {
  std::vector<std::pair<std::string, local::Stop>> stops{
      {"none", {}},
      {"rigid", {.restitution = 0.5, .present = true}},
      {"spring", {.present = true, .stiffness = kStiffness / kMass * kStep * kStep}}};
  const auto held = all_laws();
  for (const auto& [name, law] : held) {
    stops.emplace_back(name, local::Stop{.present = true, .contact_law = law.get(), .carried = kMass, .step = kStep});
  }
  std::vector<double> back(stops.size());  // velocity of the masses in the mean [m/s]
  std::vector<Timed> times;
  times.reserve(stops.size());
  for (const auto& [name, stop] : stops) {
    times.push_back({.body = [all = problems(stop), &own = back[times.size()]] {
      double sum = 0.0;
      for (const local::Problem& problem : all) {
        sum += local::advance(problem).velocity;
      }
      own = sum / kStep / static_cast<double>(all.size());
    }});
  }
  std::vector<Timed*> order;
  order.reserve(times.size());
  for (Timed& timed : times) {
    order.push_back(&timed);
  }
  sample(comm, order, repeats);
  nlohmann::ordered_json result;
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const auto masses = static_cast<double>(problems({}).size());
    result["nanoseconds_per_mass_and_sweep"][stops[i].first] = 1e9 * times[i].best() / masses;
    result["median"][stops[i].first] = 1e9 * times[i].median() / masses;
    result["mean_velocity_at_the_end"][stops[i].first] = back[i];
  }
  UDAR_CALL(PetscPrintf(comm, "%s\n", result.dump(2).c_str()));
}

}  // namespace udar::bench
