#include "tools/contact_runs.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <vector>

#include "tools/study_quantities.hpp"
#include "tools/timing.hpp"
#include "udar/app/case.hpp"
#include "udar/app/program.hpp"
#include "udar/dynamics/impact_dynamics.hpp"
#include "udar/petsc/error.hpp"

namespace udar::bench {
namespace {

using study::Sample;
using study::Sampler;

/// Finds when the structure comes down on its supports after a flight: in the first row whose impulses have grown, at
/// the time to which the two rows before, still in flight, go on in a straight line.
class Landings final : public Observer {
 public:
  Landings(const Model& model, double interval)
      : comm_{model.structure->points().comm()},
        interval_{interval},
        field_{model.contact.surface == ContactSurface::line ? "line_position" : "mass_position"},
        sets_{model.contacts.sets},
        gap_(model.contacts.supports.size(), kFar) {}

  [[nodiscard]] double interval() const override { return interval_; }

  void snapshot(const Snapshot& state) override {
    const std::vector<double> gap = gaps(state);
    const std::vector<double> impulse{state.support_impulse.begin(), state.support_impulse.end()};
    if (!impulse_.empty() && impulse != impulse_) {
      if (landings_.empty() || state.time - touched_ > kFlight) {
        landings_.push_back({.touch = time_ + std::min(until_touch(impulse), state.time - time_)});
      }
      touched_ = state.time;
      landings_.back().left = state.time;
    }
    for (std::size_t i = 0; i < gap.size(); ++i) {
      closing_[i] = (gap_[i] - gap[i]) / (state.time - time_);
    }
    time_ = state.time;
    gap_ = gap;
    impulse_ = impulse;
  }

  /// From the first touch to the row in which the last ended [s].
  struct Landing {
    double touch = 0.0;
    double left = 0.0;
  };
  [[nodiscard]] const std::vector<Landing>& all() const noexcept { return landings_; }

 private:
  static constexpr double kFar = std::numeric_limits<double>::max();
  static constexpr double kFlight = 0.1;  // without any touch [s]: no pause between two touches of one landing

  /// The least distance from each support [m]. @note Collective.
  [[nodiscard]] std::vector<double> gaps(const Snapshot& state) const {
    const std::span<const double> position = state.values(field_);
    std::vector<double> gap(gap_.size(), kFar);
    for (const ContactSet& set : sets_) {
      double& least = gap[static_cast<std::size_t>(set.support)];
      for (std::size_t i = set.first; i < set.last; ++i) {
        least = std::min(least, set.side * (position[i] - set.height(i) - set.lift(state.time).height));
      }
    }
    MPI_Allreduce(MPI_IN_PLACE, gap.data(), static_cast<int>(gap.size()), MPI_DOUBLE, MPI_MIN, comm_);
    return gap;
  }

  /// From the last row on, over the supports that have pressed since [s].
  [[nodiscard]] double until_touch(std::span<const double> impulse) const {
    double least = kFar;
    for (std::size_t i = 0; i < gap_.size(); ++i) {
      if (impulse[i] != impulse_[i]) {
        least = std::min(least, closing_[i] > 0.0 ? std::max(0.0, gap_[i] / closing_[i]) : 0.0);
      }
    }
    return least;
  }

  MPI_Comm comm_;
  double interval_;
  const char* field_;
  std::vector<ContactSet> sets_;
  double time_ = -1.0;  // of the last row [s]
  std::vector<double> gap_;
  std::vector<double> closing_ = std::vector<double>(gap_.size());  // how fast [m/s]
  std::vector<double> impulse_;
  double touched_ = 0.0;  // the last row with contact [s]
  std::vector<Landing> landings_;
};

ContactCost cost_of(MPI_Comm comm, const app::Case& input) {
  ContactCost cost;
  const double begin = cpu_seconds(comm);
  Model model{comm, input};
  ImpactDynamics dynamics{model};
  const double built = cpu_seconds(comm);
  const PetscInt before = model.line.solves();
  dynamics.solve();
  cost.stepping = cpu_seconds(comm) - built;
  cost.set_up = built - begin;
  const auto tally = dynamics.tally();
  const auto of_modes = tally.find("setup_line_solves");  // by a line of their own
  cost.line_solves =
      static_cast<double>(model.line.solves() - before + (of_modes != tally.end() ? of_modes->second : 0));
  return cost;
}

ContactCost least_cost(MPI_Comm comm, const app::Case& input, long repeats) {
  constexpr double kEnough = 0.02;  // [s]
  ContactCost least = cost_of(comm, input);
  double spent = least.set_up + least.stepping;
  for (long repeat = 1; repeat < repeats && spent < kEnough; ++repeat) {
    const ContactCost one = cost_of(comm, input);
    least.set_up = std::min(least.set_up, one.set_up);
    least.stepping = std::min(least.stepping, one.stepping);
    spent += one.set_up + one.stepping;
  }
  return least;
}

/// How fast the centre of mass comes down at a landing [m/s].
double speed_at(std::span<const Sample> samples, double landing, double gravity) {
  const auto after = std::ranges::find_if(samples, [=](const Sample& row) { return row.time > landing; });
  const auto before = after == samples.begin() ? after : after - 1;
  return std::abs(before->velocity - gravity * (landing - before->time));
}

/// What the rows say of the first contact and of what follows.
void judge(const app::Case& input, std::span<const Sample> samples, std::span<const Landings::Landing> landings,
           ContactRun& run) {
  if (landings.empty()) {
    return;
  }
  const double first = landings.front().touch;
  if (landings.size() > 1) {
    run.second_landing = landings[1].touch - first;
  }
  if (const auto back = study::rebound(samples, first, input.gravity).velocity) {
    run.rebound = std::abs(*back) / speed_at(samples, first, input.gravity);
  }
  const auto begin = std::ranges::find_if(samples, [=](const Sample& row) { return row.time >= first; });
  const auto end =
      std::find_if(begin, samples.end(), [&](const Sample& row) { return row.time > landings.front().left; });
  for (std::size_t g = 0; g < run.gauges.size(); ++g) {
    run.lowest.push_back(-study::largest(std::span{begin, end}, [g](const Sample& row) { return -row.position[g]; }));
  }
  for (auto row = begin; row != samples.end(); ++row) {
    run.times.push_back(row->time);
    run.positions.push_back(row->position);
  }
}

}  // namespace

ContactRun run_contact(MPI_Comm comm, const petsc::Options& options, long repeats) {
  const petsc::ScopedOptions in_force{options};
  ContactRun run;
  run.refusal = app::failure_of(comm, [&] {
    const app::Case input = app::resolve(comm, app::read_case(comm));
    run.cost = least_cost(comm, input, repeats);
    Model model{comm, input};
    ImpactDynamics dynamics{model};
    Sampler sampler{input, model.structure->points()};
    Landings landings{model, input.output.interval};
    dynamics.add_observer(sampler);
    dynamics.add_observer(landings);
    dynamics.solve();
    std::ranges::transform(input.gauges, std::back_inserter(run.gauges), &Place::x);
    run.drift = dynamics.energy().drift();
    judge(input, sampler.samples(), landings.all(), run);
  });
  return run;
}

}  // namespace udar::bench
