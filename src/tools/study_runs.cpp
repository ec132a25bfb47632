#include "tools/study_runs.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace udar::study {
namespace {

/// As CSV has it.
std::string quoted(std::string text) {
  for (std::size_t i = text.find('"'); i != std::string::npos; i = text.find('"', i + 2)) {
    text.insert(i, "\"");
  }
  return "\"" + text + "\"";
}

}  // namespace

Json to_json(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? Json(*value) : Json(nullptr);
}

Json packed(std::size_t number, const Outcome& outcome) {
  Json json{{"number", number}, {"state", outcome.state}, {"reason", outcome.reason}, {"quantities", Json::array()}};
  for (const Quantity& quantity : outcome.quantities) {
    json["quantities"].push_back({quantity.name, quantity.unit, to_json(quantity.value), quantity.compared});
  }
  return json;
}

Outcome unpacked(const Json& json) {
  Outcome outcome{.state = json["state"], .reason = json["reason"], .quantities = {}};
  for (const Json& entry : json["quantities"]) {
    outcome.quantities.push_back({.name = entry[0],
                                  .unit = entry[1],
                                  .value = entry[2].is_null() ? std::nullopt : std::optional<double>{entry[2]},
                                  .compared = entry[3]});
  }
  return outcome;
}

std::string number(const std::optional<double>& value, const char* format) {
  if (!value) {
    return "-";
  }
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), format, *value);  // NOLINT(cert-err33-c): always fits
  return text.data();
}

std::string number(const Json& value, const char* format) {
  return number(value.is_number() ? std::optional<double>{value.get<double>()} : std::nullopt, format);
}

std::string aligned(const Rows& rows) {
  std::vector<std::size_t> width;
  for (const auto& row : rows) {
    width.resize(std::max(width.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) {
      width[i] = std::max(width[i], row[i].size());
    }
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line = row.front() + std::string(width.front() - row.front().size(), ' ');
    for (std::size_t i = 1; i < row.size(); ++i) {
      line += std::string(2 + width[i] - row[i].size(), ' ') + row[i];
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

Runs::Runs(std::vector<Series> series, std::vector<PlannedRun> runs, std::vector<Outcome> outcomes)
    : series_{std::move(series)}, runs_{std::move(runs)}, outcomes_{std::move(outcomes)} {
  for (const Outcome& outcome : outcomes_) {
    for (const Quantity& quantity : outcome.quantities) {
      if (std::ranges::find(quantities_, quantity.name, &Quantity::name) == quantities_.end()) {
        quantities_.push_back(quantity);
      }
    }
  }
}

std::vector<Quantity> Runs::known(std::span<const char* const> names) const {
  std::vector<Quantity> all;
  for (const char* name : names) {
    const auto found = std::ranges::find(quantities_, std::string_view{name}, &Quantity::name);
    if (found != quantities_.end() &&
        std::ranges::any_of(outcomes_, [&](const Outcome& outcome) { return outcome.value(name).has_value(); })) {
      all.push_back(*found);
    }
  }
  return all;
}

std::string Runs::axis_value(const PlannedRun& run, std::string_view key) const {
  const auto& axes = series_[run.series].axes;
  const auto found = std::ranges::find(axes, key, &Axis::key);
  return found == axes.end() ? "" : found->values[run.at[static_cast<std::size_t>(found - axes.begin())]];
}

std::string Runs::csv() const {
  std::vector<std::string> keys;
  for (const Series& series : series_) {
    for (const Axis& axis : series.axes) {
      if (std::ranges::find(keys, axis.key) == keys.end()) {
        keys.push_back(axis.key);
      }
    }
  }
  std::string text = "run,series,state";
  for (const std::string& key : keys) {
    text += "," + key;
  }
  for (const Quantity& quantity : quantities_) {
    text += "," + quantity.name;
  }
  text += ",reason\n";
  for (const PlannedRun& run : runs_) {
    const Outcome& outcome = outcomes_[run.number];
    text += std::to_string(run.number) + "," + series_[run.series].name + "," + outcome.state;
    for (const std::string& key : keys) {
      const std::string value = axis_value(run, key);
      text += "," + (value.find(',') != std::string::npos ? quoted(value) : value);
    }
    for (const Quantity& quantity : quantities_) {
      const auto found = std::ranges::find(outcome.quantities, quantity.name, &Quantity::name);
      text += "," + (found != outcome.quantities.end() && found->value ? Json(*found->value).dump() : "");
    }
    text += "," + (outcome.reason.empty() ? "" : quoted(outcome.reason)) + "\n";
  }
  return text;
}

Json Runs::describe(const PlannedRun& run) const {
  const Outcome& outcome = outcomes_[run.number];
  Json json{{"number", run.number},
            {"directory", run.options.back().second.value_or("")},
            {"series", series_[run.series].name},
            {"state", outcome.state},
            {"reason", outcome.reason.empty() ? Json(nullptr) : Json(outcome.reason)},
            {"axes", Json::object()},
            {"quantities", Json::object()}};
  for (const Axis& axis : series_[run.series].axes) {
    json["axes"][axis.key] = axis_value(run, axis.key);
  }
  for (const Quantity& quantity : outcome.quantities) {
    json["quantities"][quantity.name] = to_json(quantity.value);
  }
  return json;
}

void Runs::add_to(Json& study) const {
  study["quantities"] = Json::object();
  for (const Quantity& quantity : quantities_) {
    study["quantities"][quantity.name] = {{"unit", quantity.unit}, {"compared", quantity.compared}};
  }
  for (const PlannedRun& run : runs_) {
    study["runs"].push_back(describe(run));
  }
}

std::vector<std::string> Runs::row(const PlannedRun& run, const std::vector<Quantity>& shown) const {
  const Outcome& outcome = outcomes_[run.number];
  std::vector<std::string> row{std::to_string(run.number)};
  for (const Axis& axis : series_[run.series].axes) {
    row.push_back(axis_value(run, axis.key));
  }
  if (outcome.state != "finished") {
    row.push_back(outcome.state);
    return row;
  }
  for (const Quantity& quantity : shown) {
    row.push_back(number(outcome.value(quantity.name)));
  }
  row.push_back(number(outcome.value("impacts")));
  row.push_back(number(outcome.value("line_solves"), "%.0f"));
  row.push_back(number(outcome.value("wall_seconds"), "%.3g"));
  return row;
}

std::string Runs::table(std::size_t series, const std::vector<Quantity>& shown, std::size_t most) const {
  Rows rows{{"run"}};
  for (const Axis& axis : series_[series].axes) {
    rows[0].push_back(axis.key);
  }
  for (const Quantity& quantity : shown) {
    rows[0].push_back(quantity.name);
  }
  rows[0].insert(rows[0].end(), {"impacts", "line_solves", "wall_seconds"});
  std::size_t left = 0;
  for (const PlannedRun& run : runs_) {
    if (run.series == series && rows.size() <= most) {
      rows.push_back(row(run, shown));
    } else {
      left += run.series == series ? 1 : 0;
    }
  }
  return "\nruns of " + series_[series].name + " (SI units)\n" + aligned(rows) +
         (left > 0 ? std::to_string(left) + " more, in study.csv\n" : "");
}

std::string Runs::failures() const {
  std::string text;
  for (const PlannedRun& run : runs_) {
    const Outcome& outcome = outcomes_[run.number];
    if (outcome.state != "finished") {
      text += "run " + std::to_string(run.number) + " " + outcome.state +
              (outcome.reason.empty() ? "" : ": " + outcome.reason) + "\n";
    }
  }
  return text;
}

}  // namespace udar::study
