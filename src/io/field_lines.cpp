#include "io/field_lines.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

namespace udar::io {
namespace {

constexpr std::size_t kMostLines = 50;  // lines each way

/// Some of an axis, its ends among them: what lies between two places, and one more on either side.
std::vector<std::size_t> chosen_of(std::span<const double> axis, double from, double to) {
  const auto after = static_cast<std::size_t>(std::ranges::upper_bound(axis, from) - axis.begin());
  const auto before = static_cast<std::size_t>(std::ranges::lower_bound(axis, to) - axis.begin());
  const std::size_t last = std::min(before, axis.size() - 1);
  const std::size_t first = std::min(after > 0 ? after - 1 : 0, last);
  const std::size_t step = (last - first) / kMostLines + 1;
  std::vector<std::size_t> chosen;
  for (std::size_t i = first; i < last; i += step) {
    chosen.push_back(i);
  }
  chosen.push_back(last);
  return chosen;
}

}  // namespace

FieldGrid grid_of(const HeightGrid& field, const Region& around) {
  return {.columns = chosen_of(field.x(), around.from.x, around.to.x),
          .rows = chosen_of(field.z(), around.from.z, around.to.z)};
}

std::vector<std::vector<Place>> field_lines(const HeightGrid& field, double base, const Region& around) {
  const auto [columns, rows] = grid_of(field, around);
  std::vector<std::vector<Place>> lines;
  const auto add = [&](std::size_t column, std::size_t row) {
    const double height = field.height()[row * field.x().size() + column];
    if (std::isfinite(height)) {
      lines.back().push_back({.x = field.x()[column], .y = base + height, .z = field.z()[row]});
    } else if (!lines.back().empty()) {
      lines.emplace_back();
    }
  };
  for (const std::size_t row : rows) {
    lines.emplace_back();
    for (const std::size_t column : columns) {
      add(column, row);
    }
  }
  for (const std::size_t column : columns) {
    lines.emplace_back();
    for (const std::size_t row : rows) {
      add(column, row);
    }
  }
  std::erase_if(lines, [](const std::vector<Place>& line) { return line.empty(); });
  return lines;
}

}  // namespace udar::io
