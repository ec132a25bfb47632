#include "udar/io/run_writers.hpp"

#include <algorithm>
#include <cmath>

#include "io/writers.hpp"

namespace udar::io {
namespace {

/// Looks for peaks of forces between rows.
class ForceSampler final : public Observer {
 public:
  ForceSampler(SupportForces& forces, double interval) : forces_{&forces}, interval_{interval} {}

  [[nodiscard]] double interval() const override { return interval_; }
  void snapshot(const Snapshot& state) override { forces_->sample(state.time, state.support_impulse); }

 private:
  SupportForces* forces_;
  double interval_;
};

}  // namespace

std::unique_ptr<Observer> make_force_sampler(SupportForces& forces, double interval) {
  return std::make_unique<ForceSampler>(forces, interval);
}

double sampling_interval(double interval, double longest) {
  constexpr double kRounding = 1e-6;  // of a part: decimal fractions that rounding has touched
  return longest > 0.0 ? interval / std::max(1.0, std::ceil(interval / longest - kRounding)) : interval;
}

std::vector<std::unique_ptr<Observer>> make_run_writers(const RunLayout& layout, const std::string& directory,
                                                        double interval, double field_interval, SupportForces* forces,
                                                        Peaks* peaks) {
  const std::string folder = directory + "/";
  const double sampling = sampling_interval(interval, layout.longest_sample);
  auto results = std::make_shared<ResultsFile>(layout, folder + kResults);
  std::vector<std::unique_ptr<Observer>> writers;
  writers.push_back(make_gauge_writer(layout, folder, interval));
  const auto strikes = layout.points->strikes();
  if (!strikes.empty() && !strikes.front().of_nodes()) {  // strikers are the first
    writers.push_back(make_striker_writer(layout, folder, interval));
  }
  if (layout.places > 0) {
    writers.push_back(make_place_writer(layout, folder, interval));
  }
  if (!layout.points->riders().empty()) {
    writers.push_back(make_axle_writer(layout, folder, interval));
  }
  writers.push_back(make_energy_writer(layout, folder, results, interval));
  writers.push_back(make_event_writer(layout, folder, results, interval));
  if (forces != nullptr && forces->supports() > 0) {
    writers.push_back(make_contact_writer(layout, folder, results, interval, *forces));
    if (sampling < interval) {
      writers.push_back(make_force_sampler(*forces, sampling));
    }
  }
  writers.push_back(make_envelope_writer(layout, folder, results, sampling, peaks));
  writers.push_back(make_field_writer(layout, folder, results, field_interval));
  return writers;
}

}  // namespace udar::io
