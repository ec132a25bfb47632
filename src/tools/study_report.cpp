#include "tools/study_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/study_analysis.hpp"
#include "tools/study_plan.hpp"
#include "tools/study_quantities.hpp"

namespace udar::study {

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

Report::Report(std::vector<Series> series, std::vector<PlannedRun> runs, std::vector<Outcome> outcomes,
               std::string reference)
    : series_{std::move(series)},
      runs_{std::move(runs)},
      outcomes_{std::move(outcomes)},
      reference_{std::move(reference)} {
  for (const Outcome& outcome : outcomes_) {
    for (const Quantity& quantity : outcome.quantities) {
      if (std::ranges::find(quantities_, quantity.name, &Quantity::name) == quantities_.end()) {
        quantities_.push_back(quantity);
      }
      double& scale = scale_[quantity.unit];
      if (const auto value = quantity.compared ? outcome.value(quantity.name) : std::nullopt) {
        scale = std::max(scale, std::abs(*value));
        valued_.insert(quantity.name);
      }
    }
  }
  study_["reference"] = reference_;
  study_["quantities"] = Json::object();
  for (const Quantity& quantity : quantities_) {
    study_["quantities"][quantity.name] = {{"unit", quantity.unit}, {"compared", quantity.compared}};
  }
  for (const PlannedRun& run : runs_) {
    study_["runs"].push_back(describe(run));
  }
  for (std::size_t number = 0; number < series_.size(); ++number) {
    study_["series"].push_back(analyse(number));
  }
  work_precision();
}

std::string Report::csv() const {
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
      text += "," + axis_value(run, key);
    }
    for (const Quantity& quantity : quantities_) {
      const auto found = std::ranges::find(outcome.quantities, quantity.name, &Quantity::name);
      text += "," + (found != outcome.quantities.end() && found->value ? Json(*found->value).dump() : "");
    }
    std::string reason = outcome.reason;
    for (std::size_t i = reason.find('"'); i != std::string::npos; i = reason.find('"', i + 2)) {
      reason.insert(i, "\"");
    }
    text += reason.empty() ? ",\n" : ",\"" + reason + "\"\n";
  }
  return text;
}

std::string Report::tables() const {
  std::string text = run_table();
  if (valued_.empty()) {
    return text + "\n" + failures();
  }
  for (std::size_t number = 0; number < series_.size(); ++number) {
    text += trend_tables(number) + budget_table(number);
  }
  return text + precision_table() + "\n" + failures();
}

std::string Report::number(const std::optional<double>& value, const char* format) {
  if (!value) {
    return "-";
  }
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), format, *value);  // NOLINT(cert-err33-c): always fits
  return text.data();
}

std::string Report::number(const Json& value, const char* format) {
  return number(value.is_number() ? std::optional<double>{value.get<double>()} : std::nullopt, format);
}

std::string Report::aligned(const Rows& rows) {
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

std::string Report::axis_value(const PlannedRun& run, std::string_view key) const {
  const auto& axes = series_[run.series].axes;
  const auto found = std::ranges::find(axes, key, &Axis::key);
  return found == axes.end() ? "" : found->values[run.at[static_cast<std::size_t>(found - axes.begin())]];
}

std::vector<Quantity> Report::shown() const {
  std::vector<Quantity> all;
  for (const char* name : kShown) {
    const auto found = std::ranges::find(quantities_, std::string_view{name}, &Quantity::name);
    if (found != quantities_.end() && valued_.contains(name)) {
      all.push_back(*found);
    }
  }
  return all;
}

Json Report::describe(const PlannedRun& run) const {
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

std::vector<const PlannedRun*> Report::line(std::size_t series, std::size_t axis) const {
  const auto& axes = series_[series].axes;
  std::vector<const PlannedRun*> found;
  for (const PlannedRun& run : runs_) {
    bool on_line = run.series == series;
    for (std::size_t a = 0; a < axes.size() && on_line; ++a) {
      on_line = a == axis || run.at[a] + 1 == axes[a].values.size();
    }
    if (on_line) {
      found.push_back(&run);
    }
  }
  return found;
}

bool Report::on_a_line(const PlannedRun& run) const {
  const auto& axes = series_[run.series].axes;
  std::size_t coarse = 0;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    coarse += run.at[a] + 1 < axes[a].values.size() ? 1 : 0;
  }
  return coarse <= 1;
}

Json Report::analyse(std::size_t number) const {
  const Series& series = series_[number];
  const PlannedRun& finest = *line(number, series.axes.size()).front();
  Json json{{"name", series.name}, {"finest_run", finest.number}, {"axes", Json::array()}};
  for (const Axis& axis : series.axes) {
    json["axes"].push_back({{"key", axis.key}, {"values", axis.values}, {"sizes", axis.sizes}});
  }
  json["analysis"] = Json::object();
  for (const Quantity& quantity : quantities_) {
    if (!quantity.compared) {
      continue;
    }
    std::vector<Trend> trends;
    Json along = Json::object();
    for (std::size_t a = 0; a < series.axes.size(); ++a) {
      std::vector<double> sizes;
      std::vector<double> values;
      std::vector<std::size_t> numbers;
      for (const PlannedRun* run : line(number, a)) {
        if (const auto value = outcomes_[run->number].value(quantity.name)) {
          sizes.push_back(series.axes[a].sizes[run->at[a]]);
          values.push_back(*value);
          numbers.push_back(run->number);
        }
      }
      const Trend found = trend(sizes, values, scale_.at(quantity.unit));
      trends.push_back(found);
      Json orders = Json::array();
      std::ranges::transform(found.orders, std::back_inserter(orders), to_json);
      along[series.axes[a].key] = {{"verdict", name(found.verdict)},
                                   {"orders", orders},
                                   {"limit", to_json(found.limit)},
                                   {"error", error_json(found.error, found.bound)},
                                   {"error_is", name(found.bound)},
                                   {"runs", numbers},
                                   {"values", values}};
    }
    const auto value = outcomes_[finest.number].value(quantity.name);
    const Budget parts = value ? budget(*value, trends) : Budget{.bound = Bound::unknown};
    json["analysis"][quantity.name] = {{"finest", to_json(value)},
                                       {"limit", value ? Json(parts.limit) : Json(nullptr)},
                                       {"error", error_json(parts.sum, parts.bound)},
                                       {"error_is", name(parts.bound)},
                                       {"along", along}};
  }
  return json;
}

void Report::work_precision() {
  study_["work_precision"] = Json::array();
  for (const PlannedRun& run : runs_) {
    const Outcome& outcome = outcomes_[run.number];
    if (outcome.state != "finished") {
      continue;
    }
    const std::string& own = series_[run.series].name;
    const auto truth = std::ranges::find_if(study_["series"], [&](const Json& series) {
      return series["name"] == (reference_ == "own" ? own : reference_);
    });
    Json errors = Json::object();
    for (const Quantity& quantity : quantities_) {
      const auto value = outcome.value(quantity.name);
      if (quantity.compared && value) {
        const Json& limit = (*truth)["analysis"][quantity.name]["limit"];
        errors[quantity.name] = limit.is_number() ? Json(std::abs(*value - limit.get<double>())) : Json(nullptr);
      }
    }
    study_["work_precision"].push_back({{"run", run.number},
                                        {"series", own},
                                        {"line_solves", to_json(outcome.value("line_solves"))},
                                        {"wall_seconds", to_json(outcome.value("wall_seconds"))},
                                        {"errors", errors}});
  }
}

std::string Report::run_table() const {
  std::string text;
  for (std::size_t number = 0; number < series_.size(); ++number) {
    const Series& series = series_[number];
    Rows rows{{"run"}};
    for (const Axis& axis : series.axes) {
      rows[0].push_back(axis.key);
    }
    for (const Quantity& quantity : shown()) {
      rows[0].push_back(quantity.name);
    }
    const auto counted = {"impacts", "line_solves", "wall_seconds"};
    rows[0].insert(rows[0].end(), counted.begin(), counted.end());
    for (const PlannedRun& run : runs_) {
      if (run.series != number) {
        continue;
      }
      const Outcome& outcome = outcomes_[run.number];
      std::vector<std::string> row{std::to_string(run.number)};
      for (const Axis& axis : series.axes) {
        row.push_back(axis_value(run, axis.key));
      }
      if (outcome.state == "finished") {
        for (const Quantity& quantity : shown()) {
          row.push_back(number_of(outcome, quantity.name));
        }
        row.push_back(number_of(outcome, "impacts"));
        row.push_back(number_of(outcome, "line_solves", "%.0f"));
        row.push_back(number_of(outcome, "wall_seconds", "%.3g"));
      } else {
        row.push_back(outcome.state);
      }
      rows.push_back(std::move(row));
    }
    text += "\nruns of " + series.name + " (SI units)\n" + aligned(rows);
  }
  return text;
}

std::string Report::number_of(const Outcome& outcome, const char* name, const char* format) {
  return number(outcome.value(name), format);
}

std::string Report::number_of(const Outcome& outcome, const std::string& name) {
  return number_of(outcome, name.c_str());
}

std::string Report::trend_tables(std::size_t number) const {
  const Json& series = study_["series"][number];
  std::string text;
  for (const Json& axis : series["axes"]) {
    const std::string key = axis["key"];
    Rows rows{{"quantity", "finest", "orders", "limit", "error", "verdict"}};
    for (const Quantity& quantity : shown()) {
      const Json& entry = series["analysis"][quantity.name];
      const Json& along = entry["along"][key];
      std::string orders;
      for (const Json& order : along["orders"]) {
        orders += (orders.empty() ? "" : " ") + Report::number(order, "%.2f");
      }
      rows.push_back({label(quantity), Report::number(entry["finest"]), orders, Report::number(along["limit"]),
                      error_text(along), along["verdict"]});
    }
    text += "\n" + series_[number].name + " along " + key + " = " + joined(axis["values"]) + others(series, key) +
            "\n" + aligned(rows);
  }
  return text;
}

std::string Report::error_text(const Json& entry) {
  static const std::map<std::string, std::string> kMarks{{"estimate", ""}, {"changes", "~"}, {"at least", ">"}};
  const auto mark = kMarks.find(entry["error_is"]);
  return mark == kMarks.end() ? "?" : mark->second + number(entry["error"], "%.1e");
}

std::string Report::joined(const Json& words) {
  std::string text;
  for (const Json& word : words) {
    text += (text.empty() ? "" : ", ") + word.get<std::string>();
  }
  return text;
}

std::string Report::others(const Json& series, const std::string& key) {
  std::string text;
  for (const Json& axis : series["axes"]) {
    if (axis["key"] != key) {
      text += ", " + axis["key"].get<std::string>() + " = " + axis["values"].back().get<std::string>();
    }
  }
  return text;
}

std::string Report::budget_table(std::size_t number) const {
  const Json& series = study_["series"][number];
  if (series["axes"].empty()) {
    return "";
  }
  Rows rows{{"quantity", "finest"}};
  for (const Json& axis : series["axes"]) {
    rows[0].push_back("by " + axis["key"].get<std::string>());
  }
  rows[0].insert(rows[0].end(), {"sum", "limit"});
  std::set<std::string> unresolved;
  for (const Quantity& quantity : shown()) {
    const Json& entry = series["analysis"][quantity.name];
    std::vector<std::string> row{label(quantity), Report::number(entry["finest"])};
    for (const auto& [key, along] : entry["along"].items()) {
      row.push_back(error_text(along));
      if (!converged(along)) {
        unresolved.insert(key);
      }
    }
    row.push_back(error_text(entry));
    row.push_back(converged(entry) ? Report::number(entry["limit"]) : "none");
    rows.push_back(std::move(row));
  }
  std::string text = "\nerror budget of run " + std::to_string(series["finest_run"].get<std::size_t>()) +
                     ", the finest of " + series_[number].name + "\n" + aligned(rows);
  if (!unresolved.empty()) {
    std::string list;
    for (const std::string& key : unresolved) {
      list += (list.empty() ? "" : ", ") + key;
    }
    text += "not every quantity converges along: " + list +
            " (~: as large as the changes seen; >: larger; nothing is extrapolated there)\n";
  }
  return text;
}

std::string Report::precision_table() const {
  Rows rows{{"series", "run", "line_solves", "wall_seconds"}};
  const auto quantities = shown();
  for (const Quantity& quantity : quantities) {
    rows[0].push_back(quantity.name);
  }
  std::set<std::string> open;
  for (const Json& series : study_["series"]) {
    for (const Quantity& quantity : quantities) {
      if ((reference_ == "own" || series["name"] == reference_) && !converged(series["analysis"][quantity.name])) {
        open.insert(quantity.name);
      }
    }
  }
  for (const Json& entry : study_["work_precision"]) {
    if (!on_a_line(runs_[entry["run"].get<std::size_t>()])) {
      continue;  // of a grid, the table would say the same over and over
    }
    std::vector<std::string> row{entry["series"], std::to_string(entry["run"].get<std::size_t>()),
                                 number(entry["line_solves"], "%.0f"), number(entry["wall_seconds"], "%.3g")};
    for (const Quantity& quantity : quantities) {
      const Json& errors = entry["errors"];
      row.push_back(errors.contains(quantity.name) ? number(errors[quantity.name], "%.1e") : "-");
    }
    rows.push_back(std::move(row));
  }
  std::string text = "\nwork and error against the limit of " +
                     (reference_ == "own" ? std::string{"each series"} : reference_) + "\n" + aligned(rows);
  if (!open.empty()) {
    std::string list;
    for (const std::string& name : open) {
      list += (list.empty() ? "" : ", ") + name;
    }
    text += "no converged limit: " + list + "; what stands there is the distance to the finest value\n";
  }
  return text;
}

std::string Report::failures() const {
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
