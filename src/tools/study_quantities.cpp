#include "tools/study_quantities.hpp"

#include <mpi.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "udar/app/case.hpp"
#include "udar/app/places.hpp"
#include "udar/app/run.hpp"
#include "udar/structure/striker.hpp"

namespace udar::study {

namespace {

/// Of this rank's strikers and masses that travel [J].
double striking_energy(const MassPoints& points, std::span<const double> velocity) {
  double energy = 0.0;
  each_own(points, [&](const Strike& strike, std::size_t centre, std::size_t gap) {
    if (strike.of_nodes()) {
      return;
    }
    const double speed = strike.other_of(velocity[centre], velocity[gap]);
    energy += 0.5 * strike.share * points.mass()[centre] * speed * speed;
  });
  for (const Rider& rider : points.riders()) {
    if (points.owns(rider.point)) {
      const double speed = velocity[static_cast<std::size_t>(rider.point - points.begin())];
      energy += 0.5 * rider.mass * speed * speed;
    }
  }
  return energy;
}

}  // namespace

Sampler::Sampler(const app::Case& input, const MassPoints& points)
    : points_{&points}, interval_{input.output.interval}, mass_{node_masses(points)} {
  std::array<double, 3> moments{};
  const auto count = mass_.size();
  for (std::size_t i = 0; i < count; ++i) {
    const double up = points.nodes().axis(i).y;
    mass_[i] *= up;
    x_.push_back(points.place(i).x);
    moments[0] += up * mass_[i];
    moments[1] += up * mass_[i] * x_[i];
  }
  MPI_Allreduce(MPI_IN_PLACE, moments.data(), 2, MPI_DOUBLE, MPI_SUM, points.comm());
  total_ = moments[0];
  const double centre = moments[1] / total_;
  for (std::size_t i = 0; i < count; ++i) {
    x_[i] -= centre;
    moments[2] += points.nodes().axis(i).y * mass_[i] * x_[i] * x_[i];
  }
  MPI_Allreduce(MPI_IN_PLACE, &moments[2], 1, MPI_DOUBLE, MPI_SUM, points.comm());
  inertia_ = moments[2];
  for (const Place& gauge : input.gauges) {
    const PetscInt node = points.nearest(gauge);
    std::vector<std::pair<std::size_t, double>>& own = gauge_.emplace_back();
    for (const auto& [point, share] : points.height_of(node)) {
      if (points.owns(point)) {
        own.emplace_back(static_cast<std::size_t>(point - points.begin()), share);
      }
    }
    gauge_x_.push_back(app::place_of(points, node).x - centre);
  }
}

void Sampler::snapshot(const Snapshot& state) {
  const std::vector<double> position = node_values(*points_, state.values("mass_position"));
  const std::vector<double> velocity = node_values(*points_, state.values("mass_velocity"));
  const std::vector<double> nodes = node_values(*points_, state.values("line_position"));
  const std::span<const double> line = state.values("line_position");  // which gauges read
  std::vector<double> sums(5 + gauge_.size());
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    sums[0] += mass_[i] * position[i];
    sums[1] += mass_[i] * velocity[i];
    sums[2] += mass_[i] * nodes[i];
    sums[3] += mass_[i] * x_[i] * nodes[i];
  }
  sums[4] = striking_energy(*points_, state.values("mass_velocity"));
  for (std::size_t g = 0; g < gauge_.size(); ++g) {
    for (const auto& [point, share] : gauge_[g]) {
      sums[5 + g] += share * line[point];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, points_->comm());
  Sample sample{.time = state.time,
                .height = sums[0] / total_,
                .velocity = sums[1] / total_,
                .position = {sums.begin() + 5, sums.end()},
                .deflection = {},
                .striking = sums[4],
                .energy = state.energy};
  for (std::size_t g = 0; g < gauge_.size(); ++g) {
    sample.deflection.push_back(sample.position[g] - sums[2] / total_ - sums[3] / inertia_ * gauge_x_[g]);
  }
  samples_.push_back(std::move(sample));
}

app::Rebound rebound(std::span<const Sample> samples, double first_contact, double gravity) {
  app::ReboundSearch search{gravity};
  for (const Sample& row : samples) {
    search.add({.time = row.time, .height = row.height, .velocity = row.velocity}, first_contact);
  }
  return search.found();
}

namespace {

/// Of all supports [N].
std::optional<double> largest_force(const io::Summary& summary) {
  std::optional<double> most;
  for (const double force : summary.contact.peak_support_force) {
    most = std::max(most.value_or(0.0), std::abs(force));
  }
  return most;
}

/// Under which key the largest deflection stands.
const char* summary_sag(const io::Summary& summary) {
  const bool held =
      std::ranges::any_of(summary.peaks, [](const auto& peak) { return peak.first == "max_displacement"; });
  return held ? "max_displacement" : "max_deflection";
}

}  // namespace

std::vector<Quantity> quantities(const app::Case& input, const io::Summary& summary, const Sampler& sampler) {
  const std::span<const Sample> samples{sampler.samples()};
  std::vector<Quantity> all;
  const auto add = [&all](std::string name, const char* unit, std::optional<double> value, bool compared = true) {
    all.push_back({.name = std::move(name), .unit = unit, .value = value, .compared = compared});
  };
  double impulse = 0.0;  // of what stands outside; a striker gives what it has
  for (std::size_t i = 0; i < summary.contact.support_impulse.size(); ++i) {
    impulse += input.supports[i].strike < 0 ? summary.contact.support_impulse[i] : 0.0;
  }
  const app::Rebound back = summary.contact.first_contact_time && input.strikers.empty() && input.pairs.empty()
                                ? rebound(samples, *summary.contact.first_contact_time, input.gravity)
                                : app::Rebound{};
  add("impulse", "N s", impulse);
  add("rebound_velocity", "m/s", back.velocity);
  add("contact_time", "s", back.contact_time, false);  // known to a row of the output
  add("penetration", "m",
      summary.contact.min_line_gap ? std::optional{std::max(0.0, -*summary.contact.min_line_gap)} : std::nullopt);
  std::vector<double> up;
  std::vector<double> down;
  for (std::size_t g = 0; g < input.gauges.size() && !samples.empty(); ++g) {
    up.push_back(largest(samples, [g](const Sample& row) { return row.deflection[g]; }));
    down.push_back(-largest(samples, [g](const Sample& row) { return -row.deflection[g]; }));
  }
  const bool gauges = !up.empty();
  add("deflection_down", "m", gauges ? std::optional{*std::ranges::min_element(down)} : std::nullopt);
  add("deflection_up", "m", gauges ? std::optional{*std::ranges::max_element(up)} : std::nullopt);
  if (!samples.empty()) {
    const Sample& end = samples.back();
    const double centre = 0.5 * sampler.mass() * end.velocity * end.velocity;
    add("energy_centre", "J", centre);
    add("energy_vibration", "J",
        end.energy.kinetic - end.striking - centre + end.energy.line_strain + end.energy.radiated);
    add("energy_springs", "J", end.energy.fictitious_springs);
    add("energy_lost", "J", end.energy.lost_in_impacts);
  }
  for (std::size_t i = 0; i < summary.contact.support_impulse.size(); ++i) {
    add("impulse_" + std::to_string(i), "N s", summary.contact.support_impulse[i]);
  }
  for (std::size_t g = 0; g < up.size(); ++g) {
    const std::string gauge = "gauge_" + std::to_string(g);
    add(gauge + "_lowest", "m", -largest(samples, [g](const Sample& row) { return -row.position[g]; }));
    add(gauge + "_down", "m", down[g]);
    add(gauge + "_up", "m", up[g]);
  }
  add("peak_force", "N", largest_force(summary), false);  // what follows is known to a row
  for (const auto& [name, unit, key] : {std::array{"max_moment", "N m", "max_moment"},
                                        {"max_shear", "N", "max_shear"},
                                        {"max_stress", "Pa", "max_bending_stress"},
                                        {"utilisation", "-", "max_utilisation"},
                                        {"sag", "m", summary_sag(summary)}}) {
    const auto peak = std::ranges::find(summary.peaks, key, &decltype(summary.peaks)::value_type::first);
    add(name, unit, peak != summary.peaks.end() && peak->second ? std::optional{peak->second->value} : std::nullopt,
        false);
  }
  add("impacts", "-", static_cast<double>(summary.counts.impacts), false);
  add("steps", "-", static_cast<double>(summary.counts.steps), false);
  const auto set_up = summary.integrator_counts.find("setup_line_solves");
  const PetscInt before = set_up != summary.integrator_counts.end() ? set_up->second : 0;  // modes need them, not steps
  const PetscInt stepping = summary.counts.stepping_line_solves - summary.counts.row_line_solves;
  add("line_solves", "-", static_cast<double>(before + stepping), false);
  add("energy_drift", "-", summary.energy.drift(), false);
  add("wall_seconds", "s", summary.costs.wall_seconds.at("stepping"), false);
  return all;
}

}  // namespace udar::study
