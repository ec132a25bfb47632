#include "tools/design_report.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

namespace udar::study {
namespace {

/// Of each value among all, from 1; of equal ones the mean.
std::vector<double> ranks_of(std::span<const double> values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return std::pair{values[i], i}; });
  std::vector<double> ranks(values.size());
  for (std::size_t first = 0, next = 0; first < order.size(); first = next) {
    while (next < order.size() && values[order[next]] == values[order[first]]) {
      ++next;
    }
    for (std::size_t i = first; i < next; ++i) {
      ranks[order[i]] = 0.5 * static_cast<double>(first + 1 + next);
    }
  }
  return ranks;
}

/// Of a value that is one number.
std::optional<double> as_number(const std::string& text) {
  double value = 0.0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  return status == std::errc{} && end == text.data() + text.size() ? std::optional{value} : std::nullopt;
}

}  // namespace

std::optional<double> rank_correlation(std::span<const double> a, std::span<const double> b) {
  const std::vector<double> of_a = ranks_of(a);
  const std::vector<double> of_b = ranks_of(b);
  const double middle = 0.5 * static_cast<double>(a.size() + 1);
  double both = 0.0;
  double own_a = 0.0;
  double own_b = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    both += (of_a[i] - middle) * (of_b[i] - middle);
    own_a += (of_a[i] - middle) * (of_a[i] - middle);
    own_b += (of_b[i] - middle) * (of_b[i] - middle);
  }
  return own_a > 0.0 && own_b > 0.0 ? std::optional{both / std::sqrt(own_a * own_b)} : std::nullopt;
}

DesignReport::DesignReport(Runs runs) : all_{std::move(runs)} {
  all_.add_to(study_);
  study_["design"] = Json::array();
  for (std::size_t number = 0; number < all_.series().size(); ++number) {
    const Series& series = all_.series()[number];
    Json of_series{{"series", series.name}, {"variables", Json::array()}, {"spread", Json::object()}};
    for (const Axis& axis : series.axes) {
      of_series["variables"].push_back(axis.key);
    }
    for (const Quantity& quantity : all_.quantities()) {
      of_series["spread"][quantity.name] = spread(number, quantity);
    }
    study_["design"].push_back(std::move(of_series));
  }
}

std::vector<const PlannedRun*> DesignReport::finished(std::size_t series) const {
  std::vector<const PlannedRun*> all;
  for (const PlannedRun& run : all_.planned()) {
    if (run.series == series && all_.outcome(run).state == "finished") {
      all.push_back(&run);
    }
  }
  return all;
}

Json DesignReport::spread(std::size_t series, const Quantity& quantity) const {
  std::vector<const PlannedRun*> known;
  std::vector<double> values;
  for (const PlannedRun* run : finished(series)) {
    if (const auto value = all_.outcome(*run).value(quantity.name); value && std::isfinite(*value)) {
      known.push_back(run);
      values.push_back(*value);
    }
  }
  if (values.empty()) {
    return {{"runs", 0}};
  }
  const auto [least, most] = std::ranges::minmax_element(values);
  const auto count = static_cast<double>(values.size());
  const double mean = std::reduce(values.begin(), values.end()) / count;
  double square = 0.0;
  for (const double value : values) {
    square += (value - mean) * (value - mean);
  }
  Json follows = Json::object();
  for (const Axis& axis : all_.series()[series].axes) {
    std::vector<double> variable;
    for (const PlannedRun* run : known) {
      if (const auto value = as_number(all_.axis_value(*run, axis.key))) {
        variable.push_back(*value);
      }
    }
    follows[axis.key] = to_json(variable.size() == values.size() ? rank_correlation(variable, values) : std::nullopt);
  }
  return {{"runs", values.size()},
          {"least", *least},
          {"least_run", known[static_cast<std::size_t>(least - values.begin())]->number},
          {"largest", *most},
          {"largest_run", known[static_cast<std::size_t>(most - values.begin())]->number},
          {"mean", mean},
          {"deviation", values.size() > 1 ? Json(std::sqrt(square / (count - 1.0))) : Json(nullptr)},
          {"rank_correlation", follows}};
}

std::string DesignReport::spread_table(std::size_t series) const {
  Rows rows{{"quantity", "least", "run", "largest", "run", "mean", "deviation"}};
  for (const Axis& axis : all_.series()[series].axes) {
    rows[0].push_back("by " + axis.key);
  }
  for (const Quantity& quantity : all_.known(kShown)) {
    const Json& entry = study_["design"][series]["spread"][quantity.name];
    if (entry["runs"] == 0) {
      continue;
    }
    std::vector<std::string> row{quantity.name + " [" + quantity.unit + "]",
                                 number(entry["least"]),
                                 entry["least_run"].dump(),
                                 number(entry["largest"]),
                                 entry["largest_run"].dump(),
                                 number(entry["mean"]),
                                 number(entry["deviation"], "%.3g")};
    for (const auto& [key, follows] : entry["rank_correlation"].items()) {
      row.push_back(number(follows, "%+.2f"));
    }
    rows.push_back(std::move(row));
  }
  return "\n" + all_.series()[series].name + ", " + std::to_string(finished(series).size()) +
         " finished runs; by: rank correlation with the variable, from -1 to 1\n" + aligned(rows);
}

std::string DesignReport::tables() const {
  constexpr std::size_t kMostRows = 40;
  std::string text;
  for (std::size_t number = 0; number < all_.series().size(); ++number) {
    text += all_.table(number, all_.known(kShown), kMostRows) + spread_table(number);
  }
  return text + "\n" + all_.failures();
}

}  // namespace udar::study
