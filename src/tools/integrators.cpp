#include "tools/integrators.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "udar/dynamics/impact_dynamics.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/log.hpp"

namespace udar::bench {
namespace {

/// How a beam falls, at wf = 100 rad/s; times are for the steel beam of example 01 (10 m, radius 0.1 m).
struct Motion {
  const char* name;
  PetscInt elements = 20;
  std::vector<Support>
      supports{};  // NOLINT(readability-redundant-member-init): else GCC warns of designated initializers
  InitialState initial{.height = 1.0};
  double gravity = 9.81;
  double end = 0.6;
};

struct Method {
  std::string name;
  std::vector<std::pair<std::string, std::string>> options{};  // NOLINT(readability-redundant-member-init): as above
  double leapfrog = 0.0;                                       ///< wf h of the collision leapfrog instead
};

struct Result {
  std::vector<double> positions;  ///< of this rank's masses at all samples [m]
  double solves = 0.0;            ///< without those of the samples
  double seconds = 0.0;
  double drift = 0.0;
  double impacts = 0.0;
  double steps = 0.0;
  petsc::EventTotals local{};
  petsc::EventTotals line{};
};

/// Keeps the masses' positions.
class Samples final : public Observer {
 public:
  Samples(double interval, std::vector<double>& positions) : interval_{interval}, positions_{&positions} {}
  [[nodiscard]] double interval() const override { return interval_; }
  void snapshot(const Snapshot& state) override {
    const std::span<const double> now = state.values("mass_position");
    positions_->insert(positions_->end(), now.begin(), now.end());
  }

 private:
  double interval_;
  std::vector<double>* positions_;
};

constexpr double kFilter = 100.0;
constexpr int kSamples = 10;

/// Fixed steps, half kicks; a mass found below its support with a velocity towards it is reversed.
void leapfrog(const Motion& motion, Equations& equations, double angle, Result& result) {
  MassState masses = initial_masses(equations.points(), motion.initial);
  const auto sets = find_contacts(equations.points(), motion.supports).sets;
  const auto steps = static_cast<int>(std::ceil(motion.end * kFilter / angle / kSamples)) * kSamples;
  const double h = motion.end / steps;
  LineState line;
  equations.evaluate(0.0, masses.position, line);
  result.positions = masses.position;
  for (int step = 1; step <= steps; ++step) {
    const auto kick = [&] {
      for (std::size_t i = 0; i < masses.velocity.size(); ++i) {
        masses.velocity[i] += 0.5 * h * kFilter * kFilter * line.stretch[i];
      }
    };
    kick();
    for (std::size_t i = 0; i < masses.position.size(); ++i) {
      masses.position[i] += h * masses.velocity[i];
    }
    for (const ContactSet& set : sets) {
      for (std::size_t i = set.first; i < set.last; ++i) {
        if (set.side * (masses.position[i] - set.height(i)) < 0.0 && set.side * masses.velocity[i] < 0.0) {
          masses.velocity[i] *= -set.law.restitution;
          result.impacts += 1.0;
        }
      }
    }
    equations.evaluate(step * h, masses.position, line);
    kick();
    if (step % (steps / kSamples) == 0) {
      result.positions.insert(result.positions.end(), masses.position.begin(), masses.position.end());
    }
  }
  result.steps = steps;
  result.solves = steps;
}

Result run(const Bench& bench, const Motion& motion, const Method& method) {
  ModelParameters parameters{.beam = bench.beam,
                             .filter = {.filter_frequency = kFilter},
                             .gravity = motion.gravity,
                             .initial = motion.initial,
                             .supports = motion.supports};
  parameters.beam.segments[0].elements = motion.elements;
  Model model{bench.comm, parameters};
  Result result;
  const auto& events = petsc::log_events();
  const auto since = [](petsc::EventTotals now, petsc::EventTotals before) {
    return petsc::EventTotals{.seconds = now.seconds - before.seconds, .calls = now.calls - before.calls};
  };
  const auto local = petsc::event_totals(events.local_motion);
  const auto solve = petsc::event_totals(events.solve);
  const auto begin = std::chrono::steady_clock::now();
  if (method.leapfrog > 0.0) {
    leapfrog(motion, model.equations, method.leapfrog, result);
  } else {
    auto options = method.options;
    options.emplace_back("-ts_max_time", std::to_string(motion.end));
    for (const auto& [key, value] : options) {
      UDAR_CALL(PetscOptionsSetValue(nullptr, key.c_str(), value.c_str()));
    }
    {
      ImpactDynamics dynamics{model};
      Samples samples{motion.end / kSamples, result.positions};
      dynamics.add_observer(samples);
      dynamics.solve();
      result.drift = dynamics.energy().drift();
      result.impacts = dynamics.counts().impacts;
      result.steps = dynamics.counts().steps;
    }
    for (const auto& [key, value] : options) {
      UDAR_CALL(PetscOptionsClearValue(nullptr, key.c_str()));
    }
    result.solves = model.line.solves() - kSamples - 1;
  }
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  result.local = since(petsc::event_totals(events.local_motion), local);
  result.line = since(petsc::event_totals(events.solve), solve);
  return result;
}

/// Root of the mean square difference of the positions over all masses and samples [m].
double difference(const Bench& bench, const Result& a, const Result& b) {
  std::array<double, 2> sums{0.0, static_cast<double>(a.positions.size())};
  for (std::size_t i = 0; i < a.positions.size(); ++i) {
    sums[0] += (a.positions[i] - b.positions[i]) * (a.positions[i] - b.positions[i]);
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), 2, MPI_DOUBLE, MPI_SUM, bench.comm);
  return std::sqrt(sums[0] / sums[1]);
}

Method of_type(const std::string& type, const std::string& rtol) {
  Method method{.name = type + " rtol " + rtol, .options = {{"-ts_type", type}, {"-ts_rtol", rtol}}};
  if (type == "5dp" || type == "3bs" || type == "8vr") {
    method.options[0].second = "rk";
    method.options.emplace_back("-ts_rk_type", type);
  }
  return method;
}

void print_head(const Bench& bench, const char* title) {
  UDAR_CALL(PetscPrintf(bench.comm, "\n%s\n%-25s %8s %8s %9s %11s %9s %10s\n", title, "method", "impacts", "steps",
                        "solves", "error [m]", "drift", "seconds"));
}

void print_row(const Bench& bench, const std::string& name, const Result& result, double error) {
  UDAR_CALL(PetscPrintf(bench.comm, "%-25s %8.0f %8.0f %9.0f %11.1e %9.0e %10.4f\n", name.c_str(), result.impacts,
                        result.steps, result.solves, error, result.drift, result.seconds));
}

/// Error against work, with `-ts_type chebyshev` at 1e-14 as the exact motion.
void work_precision(const Bench& bench, const Motion& base) {
  for (const double restitution : {1.0, 0.5, 0.0}) {
    Motion motion = base;
    for (Support& support : motion.supports) {
      support.restitution = restitution;
    }
    const std::string title = std::string{base.name} + ", N = " + std::to_string(motion.elements) +
                              ", e = " + std::to_string(restitution).substr(0, 3);
    print_head(bench, title.c_str());
    const Result exact = run(bench, motion, of_type("chebyshev", "1e-14"));
    print_row(bench, "chebyshev rtol 1e-14", exact, 0.0);
    std::vector<Method> methods;
    for (const auto& [type, tolerances] :
         std::vector<std::pair<std::string, std::vector<std::string>>>{{"chebyshev", {"1e-8", "1e-10"}},
                                                                       {"impact", {"1e-3", "1e-5", "1e-7", "1e-9"}},
                                                                       {"5dp", {"1e-4", "1e-6", "1e-8", "1e-10"}},
                                                                       {"3bs", {"1e-5", "1e-7"}},
                                                                       {"8vr", {"1e-6", "1e-9"}}}) {
      for (const std::string& tolerance : tolerances) {
        methods.push_back(of_type(type, tolerance));
        if (type == "impact" && tolerance == "1e-3") {
          methods.back().options.emplace_back("-ts_impact_moments", "3");
          methods.back().name += ", 3 terms";
        }
      }
    }
    for (const double angle : {0.2, 0.05, 0.0125}) {
      methods.push_back({.name = "leapfrog wf h " + std::to_string(angle).substr(0, 6), .leapfrog = angle});
    }
    for (const Method& method : methods) {
      const Result result = run(bench, motion, method);
      print_row(bench, method.name, result, difference(bench, result, exact));
    }
  }
}

Motion tilted(PetscInt elements) {
  return {.name = "tilted fall on a floor",
          .elements = elements,
          .supports = {Support::floor(0.0, 1.0)},
          .initial = {.height = 1.0, .slope = 0.1},
          .end = 0.5};
}

/// Solves per unit wf t and nanoseconds per node and unit wf t of a free vibration.
void free_vibration(const Bench& bench) {
  Motion motion{.name = "free vibration", .gravity = 0.0, .end = 1.0};
  for (int i = 0; i <= 100; ++i) {
    motion.initial.shape.x.push_back(0.1 * i);
    motion.initial.shape.offset.push_back(0.1 * std::cos(0.2 * std::numbers::pi * i) +
                                          0.05 * std::cos(0.05 * std::numbers::pi * i));
  }
  UDAR_CALL(PetscPrintf(bench.comm, "\nfree vibration and flight: per unit wf t\n%8s %-24s %9s %11s %16s\n", "N",
                        "method", "solves", "error [m]", "ns per node"));
  for (const auto& [elements, end] : {std::pair<PetscInt, double>{1000, 1.0}, {100000, 0.4}}) {
    motion.elements = elements;
    motion.end = end;
    const Result exact = run(bench, motion, of_type("chebyshev", "1e-14"));
    for (const Method& method : {of_type("chebyshev", "1e-9"), of_type("chebyshev", "1e-11"),
                                 of_type("chebyshev", "1e-14"), of_type("5dp", "1e-10"), of_type("5dp", "1e-12")}) {
      const Result result = run(bench, motion, method);
      const double units = kFilter * motion.end;
      UDAR_CALL(PetscPrintf(bench.comm, "%8lld %-24s %9.2f %11.1e %16.1f\n", static_cast<long long>(elements),
                            method.name.c_str(), result.solves / units, difference(bench, result, exact),
                            result.seconds * 1e9 / units / static_cast<double>(elements)));
    }
  }
}

/// Solves, error and time of `-ts_type impact` while the number of impacts grows with the mesh.
void independence(const Bench& bench) {
  print_head(bench, "tilted fall on a floor: impact at rtol 1e-4 against impact at 1e-9");
  for (const PetscInt elements : {100, 1000, 10000, 100000}) {
    const Result exact = run(bench, tilted(elements), of_type("impact", "1e-9"));
    const Result result = run(bench, tilted(elements), of_type("impact", "1e-4"));
    print_row(bench, "N = " + std::to_string(elements), result, difference(bench, result, exact));
  }
}

/// Nanoseconds per mass of one sweep's local motion, and of its line solves.
void local_motion(const Bench& bench) {
  constexpr PetscInt kElements = 1000000;
  UDAR_CALL(PetscPrintf(bench.comm, "\nlocal motion, N = 1e6: nanoseconds per mass and sweep\n%-24s %8s %10s %12s\n",
                        "masses", "sweeps", "local", "line solves"));
  const auto row = [&](const char* name, const Motion& motion) {
    Method method = of_type("impact", "1e-5");
    method.options.emplace_back("-ts_adapt_dt_max",
                                std::to_string(1.5 / kFilter));  // its longest: no flight in one step
    const Result result = run(bench, motion, method);
    const double terms = 4.0;
    const auto nodes = static_cast<double>(motion.elements + 1);
    const auto sweeps = static_cast<double>(result.local.calls);  // one more of them a step predicts
    UDAR_CALL(PetscPrintf(bench.comm, "%-24s %8.0f %10.2f %12.2f\n", name, sweeps,
                          result.local.seconds * 1e9 / nodes / sweeps,
                          result.line.seconds * 1e9 / nodes / (result.solves + kSamples + 1) * terms));
  };
  row("free", {.name = "", .elements = kElements, .end = 0.1});
  row("near the floor", {.name = "", .elements = kElements, .supports = {Support::floor(0.0, 1.0)}, .end = 0.1});
  row("resting", {.name = "",
                  .elements = kElements,
                  .supports = {Support::floor(0.0, 0.0)},
                  .initial = {.height = 0.0},
                  .end = 0.1});
}

void energy(const Bench& bench) {
  print_head(bench, "energy at default tolerance: drift at the end");
  const Motion points{.name = "", .supports = {{.position = 2.0}, {.position = 8.0}}, .end = 3.5};
  const Result by_series = run(bench, points, {.name = "", .options = {{"-ts_type", "chebyshev"}}});
  print_row(bench, "chebyshev, points", by_series, 0.0);
  for (const double restitution : {1.0, 0.5}) {
    Motion floor = tilted(1000);
    floor.end = 0.55;
    floor.supports[0].restitution = restitution;
    const Result result = run(bench, floor, {.name = "", .options = {{"-ts_type", "impact"}}});
    print_row(bench, "impact, floor, e = " + std::to_string(restitution).substr(0, 3), result, 0.0);
  }
}

}  // namespace

void integrators(const Bench& bench, bool quick) {
  work_precision(bench, {.name = "fall on two points", .supports = {{.position = 2.0}, {.position = 8.0}}});
  if (quick) {
    return;
  }
  work_precision(bench, {.name = "fall on two supports of 1 m",
                         .elements = 200,
                         .supports = {{.position = 2.0, .width = 1.0}, {.position = 8.0, .width = 1.0}}});
  work_precision(bench, tilted(1000));
  free_vibration(bench);
  independence(bench);
  local_motion(bench);
  energy(bench);
}

}  // namespace udar::bench
