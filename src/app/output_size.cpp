#include "udar/app/output_size.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

#include "udar/petsc/error.hpp"

namespace udar::app {
namespace {

// A day of reading CSV, without the row at the start, and what fits beside other runs on a laptop's disk.
constexpr double kMostRows = 1e6;
constexpr double kMostBytes = 1e10;
constexpr auto kCountable = static_cast<double>(std::numeric_limits<PetscInt>::max());

// A number in a CSV file with its comma, as 17 digits, sign, point and exponent at the longest; in results.h5.
constexpr double kText = 25.0;
constexpr double kBinary = 8.0;
// Columns of energy.csv; those of contact.csv before the supports'; of a support there, and of a gauge.
constexpr double kEnergyColumns = 13.0;
constexpr double kZoneColumns = 4.0;
constexpr double kSupportColumns = 2.0;
constexpr double kGaugeColumns = 3.0;
// Five fields and two bytes of a node in a row of fields; of some fields each by itself.
constexpr double kNodeBytes = 5.0 * kBinary + 2.0;

double rows_of(double interval, double end) { return interval > 0.0 ? end / interval + 1.0 : 0.0; }

/// Of a node; a network has three for each of its nodes, and its vectors three numbers.
double field_bytes(const Case& input) {
  const std::vector<std::string>& fields = input.output.content.fields;
  return fields.empty() ? kNodeBytes : std::min(kNodeBytes, kBinary * static_cast<double>(fields.size()));
}

/// How much of a beam the region has; of other structures, whose nodes may all be in it, the whole.
double share_of(const Case& input) {
  const io::RowChoice& rows = input.output.rows;
  if (rows.everywhere || input.network || input.imported) {
    return 1.0;
  }
  const double length = input.beam.length();
  const double from = std::max(0.0, rows.region.from.x);
  return std::clamp((std::min(length, rows.region.to.x) - from) / length, 0.0, 1.0);
}

}  // namespace

OutputSize output_size(const Case& input) {
  double nodes = input.imported ? static_cast<double>(input.imported->places.size()) : 0.0;  // as many, or unknown
  if (input.network) {
    nodes = 3.0 * static_cast<double>(input.network->junctions.size());
    for (const Member& member : input.network->members) {
      nodes += 3.0 * (static_cast<double>(member.elements) - 1.0);
    }
  }
  for (const BeamSegment& segment : input.beam.segments) {
    nodes += static_cast<double>(segment.elements) + 1.0;
  }
  const double contact = kZoneColumns + kSupportColumns * static_cast<double>(input.supports.size());
  const double absolute = input.base_motion.empty() ? 1.0 : 2.0;  // these beside those relative to the base
  const double gauges = absolute * kGaugeColumns * static_cast<double>(input.gauges.size());
  OutputSize size{.rows = rows_of(input.output.interval, input.end_time),
                  .field_rows = rows_of(input.output.field_interval, input.end_time)};
  size.bytes =
      size.rows * (kText * (1.0 + gauges) + (kText + kBinary) * (kEnergyColumns + contact)) +
      size.field_rows * field_bytes(input) * nodes * share_of(input) / static_cast<double>(input.output.rows.stride);
  return size;
}

void refuse_large_output(const Case& input) {
  const OutputSize size = output_size(input);
  const bool fields = size.field_rows > size.rows || size.rows <= kMostRows + 1.0;
  const double rows = fields ? size.field_rows : size.rows;
  const bool countable = size.rows < kCountable && size.field_rows < kCountable;
  const bool small = size.rows <= kMostRows + 1.0 && size.field_rows <= kMostRows + 1.0 && size.bytes <= kMostBytes;
  if (small || (countable && input.output.allow_large)) {
    return;
  }
  std::array<char, 320> text{};
  std::snprintf(
      text.data(), text.size(),
      "option %s: %g is not allowed, it asks for %.3g rows up to -ts_max_time %g s, and for some %.2g GB in all; "
      "expected a longer interval [s]%s",
      fields ? "-output_field_interval" : "-output_interval",
      fields ? input.output.field_interval : input.output.interval, rows, input.end_time, size.bytes / 1e9,
      countable ? ", or -output_allow_large true for more than 1e6 rows or 10 GB" : ": so many rows are not counted");
  throw InputError{text.data()};
}

}  // namespace udar::app
