#include "udar/io/support_forces.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "udar/motion/motion_state.hpp"
#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

// Of an interval: a multiple of it given in decimal is that multiple, and rows that far apart are one window apart.
constexpr double kRounding = 1e-6;
constexpr const char* kRows = "support_impulse_rows";
constexpr const char* kSamples = "support_impulse_samples";
constexpr const char* kPeaks = "support_force_peak";

}  // namespace

SupportForces::Window::Window(double interval, double shortest)
    : length{interval * std::max(1.0, std::ceil(shortest / interval - kRounding))}, slack{kRounding * interval} {}

std::vector<double> SupportForces::Window::mean(double time, std::span<const double> impulse) {
  rows.push_back({.time = time, .impulse = {impulse.begin(), impulse.end()}});
  while (rows.size() > 1 && rows[1].time <= time - length + slack) {
    rows.pop_front();
  }
  const Row& first = rows.front();
  const bool full = first.time <= time - length + slack;
  const double span = full ? time - first.time : length;
  std::vector<double> force(impulse.size());
  for (std::size_t support = 0; support < impulse.size(); ++support) {
    force[support] = (impulse[support] - (full ? first.impulse[support] : 0.0)) / span;
  }
  return force;
}

void SupportForces::Window::save(std::vector<double>& table) const {
  for (const Row& row : rows) {
    table.push_back(row.time);
    table.insert(table.end(), row.impulse.begin(), row.impulse.end());
  }
}

void SupportForces::Window::restore(std::span<const double> table, std::size_t supports) {
  const std::size_t columns = 1 + supports;
  if (table.size() % columns != 0) {
    throw InputError{"restart file: the rows of forces of supports are not of " + std::to_string(supports) +
                     " supports"};
  }
  for (std::size_t i = 0; i + columns <= table.size(); i += columns) {
    const std::span row = table.subspan(i, columns);
    rows.push_back({.time = row[0], .impulse = {row.begin() + 1, row.end()}});
  }
}

SupportForces::SupportForces(std::size_t supports, double interval, double shortest, double sampling)
    : rows_{interval, shortest}, samples_{sampling > 0.0 ? sampling : interval, shortest}, peak_(supports, 0.0) {}

/// Not a number stays.
void SupportForces::note(std::span<const double> force) {
  for (std::size_t support = 0; support < force.size(); ++support) {
    if (!(std::abs(force[support]) <= std::abs(peak_[support]))) {
      peak_[support] = force[support];
    }
  }
}

std::vector<double> SupportForces::add(double time, std::span<const double> impulse) {
  std::vector<double> force = rows_.mean(time, impulse);
  note(force);
  return force;
}

void SupportForces::sample(double time, std::span<const double> impulse) { note(samples_.mean(time, impulse)); }

void SupportForces::save(MotionState& state) const {
  rows_.save(state.tables[kRows]);
  if (!samples_.rows.empty()) {
    samples_.save(state.tables[kSamples]);
  }
  state.tables[kPeaks] = peak_;
}

void SupportForces::restore(const MotionState& state) {
  const std::vector<double>& peak = state.table(kPeaks);
  if (peak.size() != peak_.size()) {
    throw InputError{"restart file: the table '" + std::string{kPeaks} + "' has " + std::to_string(peak.size()) +
                     " numbers, expected " + std::to_string(peak_.size())};
  }
  peak_ = peak;
  rows_.restore(state.table(kRows), peak_.size());
  if (state.tables.contains(kSamples)) {
    samples_.restore(state.table(kSamples), peak_.size());
  }
}

}  // namespace udar::io
