#include "udar/structure/travelling_load.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <sstream>
#include <string>
#include <utility>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// When a force is at the node before, at the node itself and at the next one [s]; infinite: there is none.
struct Passing {
  double before;
  double here;
  double after;

  /// The share of the force that the node has just before a time, or just after it.
  [[nodiscard]] double share(double time, bool just_after) const {
    if (time < here || (time == here && !just_after)) {
      return time > before ? (time - before) / (here - before) : 0.0;
    }
    return time < after && !std::isinf(after) ? (after - time) / (after - here) : 0.0;
  }
};

}  // namespace

void require_sound(const TravellingLoad& load, std::size_t nodes) {
  const auto finite = [](double value) { return std::isfinite(value); };
  if (load.offset.empty() || load.offset.size() != load.force.size() || !std::ranges::all_of(load.offset, finite) ||
      !std::ranges::all_of(load.force, finite) || std::ranges::min(load.offset) < 0.0) {
    throw InputError{"load axles: expected at least one row of distance behind the first >= 0 [m] and force [N]"};
  }
  if (!finite(load.speed) || load.speed == 0.0 || !finite(load.start)) {
    throw InputError{"load axles speed: " + std::to_string(load.speed) +
                     " is not allowed, expected a number other than 0 [m/s]"};
  }
  const auto amount = [&](double value) { return finite(value) && value >= 0.0; };
  const auto fits = [&](const std::vector<double>& values) {
    return values.empty() || (values.size() == load.offset.size() && std::ranges::all_of(values, amount));
  };
  if (!fits(load.mass) || !fits(load.stiffness)) {
    throw InputError{"load axles: expected a mass >= 0 [kg] and a stiffness >= 0 [N/m] for each axle, or none"};
  }
  constexpr double kMost = 1e6;  // of axles on nodes: each is up to four rows of a table, on every rank
  if (static_cast<double>(nodes) * static_cast<double>(load.offset.size()) > kMost) {
    std::ostringstream message;
    message << "load axles: " << load.offset.size() << " axles over " << nodes
            << " nodes are not allowed, expected a product of at most " << kMost;
    throw InputError{message.str()};
  }
}

std::vector<std::shared_ptr<const TimeTable>> node_tables(const TravellingLoad& load, std::span<const double> x) {
  require_sound(load, x.size());
  const std::size_t count = x.size();
  const bool rightward = load.speed > 0.0;
  const auto arrival = [&](std::size_t node, double offset) {
    const double way = rightward ? x[node] - x.front() : x.back() - x[node];
    return arrival_of(load.start, offset + way, load.speed);
  };
  std::vector<std::shared_ptr<const TimeTable>> tables;
  tables.reserve(count);
  for (std::size_t node = 0; node < count; ++node) {
    std::vector<Passing> axles;
    std::vector<double> times;
    for (const double offset : load.offset) {
      const double left = node > 0 ? arrival(node - 1, offset) : kNever;
      const double right = node + 1 < count ? arrival(node + 1, offset) : kNever;
      axles.push_back(
          {.before = rightward ? left : right, .here = arrival(node, offset), .after = rightward ? right : left});
      for (const double time : {axles.back().before, axles.back().here, axles.back().after}) {
        if (std::isfinite(time)) {
          times.push_back(time);
        }
      }
    }
    std::ranges::sort(times);
    times.erase(std::ranges::unique(times).begin(), times.end());
    std::vector<double> rows;
    std::vector<double> values;
    for (const double time : times) {
      double before = 0.0;
      double after = 0.0;
      for (std::size_t axle = 0; axle < axles.size(); ++axle) {
        before += load.force[axle] * axles[axle].share(time, false);
        after += load.force[axle] * axles[axle].share(time, true);
      }
      rows.push_back(time);
      values.push_back(before);
      if (after != before) {
        rows.push_back(time);
        values.push_back(after);
      }
    }
    tables.push_back(time_table(std::move(rows), std::move(values)));
  }
  return tables;
}

}  // namespace udar
