#pragma once
/// @file
/// The steel beam of example 01, and the pieces a run on it needs.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "udar/dynamics/impact_dynamics.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/section.hpp"

namespace udar::test {

constexpr double kGravity = 9.81;  // [m/s^2]

/// 10 m, solid circle of radius 0.1 m, E = 2.1e11 Pa, 7850 kg/m^3, both ends free.
inline BeamParameters steel_beam(PetscInt elements) {
  const Section section = circle_section(0.1, 0.3);
  BeamParameters beam;
  beam.segments.push_back({.length = 10.0,
                           .elements = elements,
                           .bending_stiffness = 2.1e11 * section.inertia,
                           .mass_per_length = 7850.0 * section.area});
  return beam;
}

/// Without filter, in steps of this length [s].
inline FilterParameters unfiltered(double step) {
  return {.filter_frequency = std::numeric_limits<double>::infinity(), .step = step};
}

constexpr BeamEnd kPinned{.translational_stiffness = BeamEnd::kRigid, .rotational_stiffness = 0.0};
constexpr BeamEnd kClamped{.translational_stiffness = BeamEnd::kRigid, .rotational_stiffness = BeamEnd::kRigid};

/// A whole run: build, then set PETSc options that shape the integration, then `solve`.
struct Fall : Model {
  const BeamChain& beam = *structure->chain();
  ImpactDynamics dynamics;

  explicit Fall(const ModelParameters& parameters, const std::function<void(FilteredStructure&)>& prepare = {})
      : Model{PETSC_COMM_WORLD, parameters, prepare}, dynamics{*this} {}

  Fall(BeamParameters bar, double filter_frequency, double gravity, const InitialState& at_start,
       std::vector<Support> under, ContactParameters touching = {}, const std::vector<NodalLoad>& nodal = {},
       const Damping& damping = {})
      : Fall{{.beam = std::move(bar),
              .filter = {.filter_frequency = filter_frequency},
              .gravity = gravity,
              .loads = nodal,
              .damping = damping,
              .initial = at_start,
              .supports = std::move(under),
              .contact = touching}} {}
};

/// Of the masses at the end of a run [kg m/s], on every rank.
inline double momentum_of(const FilteredStructure& line, const ImpactDynamics& dynamics) {
  double momentum = 0.0;
  const MassState masses = dynamics.masses();
  for (std::size_t i = 0; i < masses.velocity.size(); ++i) {
    momentum += line.mass()[i] * masses.velocity[i];
  }
  MPI_Allreduce(MPI_IN_PLACE, &momentum, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return momentum;
}

/// The tip mass of a cantilever of one element: an oscillator.
struct TipMass {
  double filter_frequency = 0.0;  // [rad/s]
  BeamParameters beam = [] {
    BeamParameters parameters = steel_beam(1);
    parameters.left = kClamped;
    return parameters;
  }();
  /// Its frequency under the filter, wf w / sqrt(wf^2 + w^2) [rad/s].
  [[nodiscard]] double lambda() const {
    const double stiffness = 3.0 * beam.segments[0].bending_stiffness / 1000.0;
    const double mass = 0.5 * beam.segments[0].mass_per_length * 10.0;
    const double w = std::sqrt(stiffness / mass);
    return filter_frequency * w / std::hypot(filter_frequency, w);
  }
};

/// Sets a PETSc option for the life of the object.
class Option {
 public:
  Option(const char* key, const char* value) : key_{key} { UDAR_CALL(PetscOptionsSetValue(nullptr, key, value)); }
  Option(const Option&) = delete;
  Option& operator=(const Option&) = delete;
  ~Option() { PetscOptionsClearValue(nullptr, key_); }

 private:
  const char* key_;
};

/// Keeps what this rank hears.
class Recorder final : public Observer {
 public:
  explicit Recorder(double interval = 0.0) : interval_{interval} {}
  [[nodiscard]] double interval() const override { return interval_; }
  void snapshot(const Snapshot& state) override {
    times.push_back(state.time);
    const auto keep = [&state](std::vector<std::vector<double>>& all, const char* name) {
      const std::span<const double> values = state.values(name);
      all.emplace_back(values.begin(), values.end());
    };
    keep(positions, "mass_position");
    keep(velocities, "mass_velocity");
    keep(lines, "line_position");
    keep(moments, "moment");
    keep(shears, "shear");
    energies.push_back(state.energy);
    support_impulses.emplace_back(state.support_impulse.begin(), state.support_impulse.end());
    zones.push_back(state.zone);
  }
  void events(const StepRecords<ImpactRecord>& hits, const StepRecords<RestRecord>& stops,
              const EventCounts& /*all*/) override {
    const auto add = [](auto& kept, const auto& more) {
      const auto old = static_cast<std::ptrdiff_t>(kept.size());
      kept.insert(kept.end(), more.begin(), more.end());
      std::sort(kept.begin() + old, kept.end(),
                [](const auto& a, const auto& b) { return a.time < b.time || (a.time == b.time && a.node < b.node); });
    };
    add(impacts, hits);
    add(rests, stops);
  }

  std::vector<double> times;
  std::vector<std::vector<double>> positions;
  std::vector<std::vector<double>> velocities;
  std::vector<std::vector<double>> lines;
  std::vector<EnergyLedger> energies;
  std::vector<std::vector<double>> moments;
  std::vector<std::vector<double>> shears;
  std::vector<std::vector<double>> support_impulses;
  std::vector<ContactZone> zones;
  std::vector<ImpactRecord> impacts;
  std::vector<RestRecord> rests;

  /// Largest error of the energy balance in any row.
  [[nodiscard]] double largest_drift() const {
    double largest = 0.0;
    for (const EnergyLedger& energy : energies) {
      largest = std::max(largest, std::abs(energy.drift()));
    }
    return largest;
  }

 private:
  double interval_;
};

}  // namespace udar::test
