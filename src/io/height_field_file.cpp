#include "udar/io/height_field_file.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "io/input_file.hpp"
#include "io/text_fields.hpp"
#include "udar/io/table_file.hpp"
#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

constexpr double kNoHeight = std::numeric_limits<double>::quiet_NaN();

std::string lower_case(std::string_view word) {
  std::string text{word};
  std::ranges::transform(text, text.begin(), [](unsigned char letter) { return std::tolower(letter); });
  return text;
}

/// An ESRI ASCII grid, line by line.
class EsriGrid {
 public:
  /// @throws Complaint
  explicit EsriGrid(std::string_view text) {
    for (; !text.empty(); ++line_) {
      const std::size_t length = std::min(text.find('\n'), text.size());
      const std::string_view line = trimmed(text.substr(0, length));
      text.remove_prefix(std::min(length + 1, text.size()));
      if (line.empty()) {
        continue;
      }
      const std::vector<std::string_view> fields = fields_of(line, false);
      if (height_.empty() && !fields[0].empty() && std::isalpha(static_cast<unsigned char>(fields[0][0])) != 0 &&
          lower_case(fields[0]) != "nan") {
        add_key(fields);
      } else {
        add_row(fields);
      }
    }
    if (const std::size_t rows = whole("nrows"); height_.size() != rows * whole("ncols")) {
      throw Complaint{" has " + std::to_string(height_.size() / whole("ncols")) +
                      " rows of heights, expected nrows = " + std::to_string(rows)};
    }
  }

  /// @throws Complaint
  [[nodiscard]] HeightGrid grid() && {
    const double size = number("cellsize");
    if (!(size > 0.0)) {
      std::ostringstream text;
      text << " has cellsize " << size << ", expected a number > 0 [m]";
      throw Complaint{text.str()};
    }
    std::vector<double> x(whole("ncols"));
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] = middle("xll", size) + static_cast<double>(i) * size;
    }
    std::vector<double> z(whole("nrows"));
    for (std::size_t i = 0; i < z.size(); ++i) {
      z[i] = -(middle("yll", size) + static_cast<double>(z.size() - 1 - i) * size) + 0.0;  // no -0
    }
    return {std::move(x), std::move(z), std::move(height_)};
  }

 private:
  [[nodiscard]] std::string where() const { return ", line " + std::to_string(line_); }

  void add_key(const std::vector<std::string_view>& fields) {
    constexpr std::array kKeys{"ncols",     "nrows",     "xllcorner", "xllcenter",
                               "yllcorner", "yllcenter", "cellsize",  "nodata_value"};
    const std::string key = lower_case(fields[0]);
    if (std::ranges::find(kKeys, key) == kKeys.end() || fields.size() != 2 || keys_.contains(key)) {
      throw Complaint{where() + ": '" + std::string{fields[0]} +
                      "' is not allowed, expected each once, with one number: ncols, nrows, xllcorner or xllcenter, "
                      "yllcorner or yllcenter, cellsize and, if need be, NODATA_value, then the heights"};
    }
    double value = 0.0;
    if (read_number(fields[1], false, value) != Reading::number) {
      throw Complaint{where() + ": '" + std::string{fields[1]} + "' is not a number"};
    }
    keys_[key] = value;
  }

  void add_row(const std::vector<std::string_view>& fields) {
    constexpr double kUsual = -9999.0;
    const std::size_t columns = whole("ncols");
    const double no_data = keys_.contains("nodata_value") ? keys_.at("nodata_value") : kUsual;
    if (fields.size() != columns) {
      throw Complaint{where() + " has " + std::to_string(fields.size()) +
                      " height(s), expected ncols = " + std::to_string(columns)};
    }
    for (const std::string_view field : fields) {
      double value = 0.0;
      const std::string wrong = read_finite(field, false, value);
      const bool none = value == no_data || (std::isnan(value) && std::isnan(no_data));
      if (!wrong.empty() && !none) {
        throw Complaint{where() + ": " + wrong};
      }
      height_.push_back(none ? kNoHeight : value);
    }
  }

  [[nodiscard]] double number(const std::string& key) const {
    const auto found = keys_.find(key);
    if (found == keys_.end() || !std::isfinite(found->second)) {
      throw Complaint{" has no number " + key + " before its heights"};
    }
    return found->second;
  }
  [[nodiscard]] std::size_t whole(const std::string& key) const {
    constexpr double kMost = 1e6;
    const double value = number(key);
    if (!(value >= 2.0 && value <= kMost && value == std::floor(value))) {
      std::ostringstream text;
      text << " has " << key << " " << value << ", expected a whole number from 2 to " << kMost;
      throw Complaint{text.str()};
    }
    return static_cast<std::size_t>(value);
  }
  /// Of the first cell, along x or y. @param side "xll" or "yll"
  [[nodiscard]] double middle(const std::string& side, double size) const {
    const std::string centre = side + "center";
    return keys_.contains(centre) ? number(centre) : number(side + "corner") + 0.5 * size;
  }

  std::size_t line_ = 1;
  std::map<std::string, double> keys_;
  std::vector<double> height_;
};

/// All values of a column once, ascending.
std::vector<double> axis_of(const Table& table, std::size_t column) {
  std::vector<double> values(table.rows());
  for (std::size_t row = 0; row < values.size(); ++row) {
    values[row] = table.at(row, column);
  }
  std::ranges::sort(values);
  const auto rest = std::ranges::unique(values);
  values.erase(rest.begin(), rest.end());
  return values;
}

/// @throws Complaint
HeightGrid grid_of(const Table& table) {
  std::vector<double> x = axis_of(table, 0);
  std::vector<double> z = axis_of(table, 1);
  std::ostringstream text;
  if (x.size() < 2 || z.size() < 2 || x.size() * z.size() != table.rows()) {
    text << " is no grid: " << table.rows() << " rows of " << x.size() << " different x and " << z.size()
         << " different z, expected two or more of each, and a row for every pair";
    throw Complaint{text.str()};
  }
  std::vector<double> height(table.rows(), kNoHeight);
  const auto index_of = [](const std::vector<double>& axis, double value) {
    return static_cast<std::size_t>(std::ranges::lower_bound(axis, value) - axis.begin());
  };
  for (std::size_t row = 0; row < table.rows(); ++row) {
    double& value = height[index_of(z, table.at(row, 1)) * x.size() + index_of(x, table.at(row, 0))];
    if (!std::isnan(value)) {
      text << " has two rows for x = " << table.at(row, 0) << ", z = " << table.at(row, 1) << " m";
      throw Complaint{text.str()};
    }
    value = table.at(row, 2);
  }
  return {std::move(x), std::move(z), std::move(height)};
}

}  // namespace

std::shared_ptr<const HeightGrid> read_height_field(MPI_Comm comm, const std::string& quantity,
                                                    const std::string& path) {
  const std::string text = share_file(comm, quantity, path);
  try {
    if (lower_case(trimmed(text).substr(0, 5)) == "ncols") {
      return std::make_shared<const HeightGrid>(EsriGrid{text}.grid());
    }
    return std::make_shared<const HeightGrid>(
        grid_of(read_table(comm, quantity, path, {.names = {"x [m]", "z [m]", "height [m]"}, .needed = 3})));
  } catch (const Complaint& complaint) {
    throw FileError{quantity + ": '" + path + "'" + complaint.text};
  }
}

}  // namespace udar::io
