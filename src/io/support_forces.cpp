#include "udar/io/support_forces.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "udar/dynamics/stepper.hpp"
#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

// Of an interval: a multiple of it given in decimal is that multiple, and rows that far apart are one window apart.
constexpr double kRounding = 1e-6;
constexpr const char* kRows = "support_impulse_rows";
constexpr const char* kPeaks = "support_force_peak";

const std::vector<double>& table(const MotionState& state, const char* name) {
  const auto found = state.tables.find(name);
  if (found == state.tables.end()) {
    throw InputError{std::string{"option -restart_file: the table '"} + name + "' is missing"};
  }
  return found->second;
}

}  // namespace

SupportForces::SupportForces(std::size_t supports, double interval, double shortest)
    : window_{interval * std::max(1.0, std::ceil(shortest / interval - kRounding))},
      slack_{kRounding * interval},
      peak_(supports, 0.0) {}

std::vector<double> SupportForces::add(double time, std::span<const double> impulse) {
  rows_.push_back({.time = time, .impulse = {impulse.begin(), impulse.end()}});
  while (rows_.size() > 1 && rows_[1].time <= time - window_ + slack_) {
    rows_.pop_front();
  }
  const Row& first = rows_.front();
  const bool full = first.time <= time - window_ + slack_;
  const double span = full ? time - first.time : window_;
  std::vector<double> force(impulse.size());
  for (std::size_t support = 0; support < impulse.size(); ++support) {
    force[support] = (impulse[support] - (full ? first.impulse[support] : 0.0)) / span;
    if (std::abs(force[support]) > std::abs(peak_[support])) {
      peak_[support] = force[support];
    }
  }
  return force;
}

void SupportForces::save(MotionState& state) const {
  auto& rows = state.tables[kRows];
  for (const Row& row : rows_) {
    rows.push_back(row.time);
    rows.insert(rows.end(), row.impulse.begin(), row.impulse.end());
  }
  state.tables[kPeaks] = peak_;
}

void SupportForces::restore(const MotionState& state) {
  peak_ = table(state, kPeaks);
  const std::vector<double>& rows = table(state, kRows);
  const std::size_t columns = 1 + peak_.size();
  for (std::size_t i = 0; i + columns <= rows.size(); i += columns) {
    const std::span row = std::span{rows}.subspan(i, columns);
    rows_.push_back({.time = row[0], .impulse = {row.begin() + 1, row.end()}});
  }
}

}  // namespace udar::io
