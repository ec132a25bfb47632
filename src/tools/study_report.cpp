#include "tools/study_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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
#include "tools/study_runs.hpp"

namespace udar::study {

Report::Report(Runs runs, std::string reference) : all_{std::move(runs)}, reference_{std::move(reference)} {
  for (const PlannedRun& run : all_.planned()) {
    for (const Quantity& quantity : all_.outcome(run).quantities) {
      double& scale = scale_[quantity.unit];
      if (const auto value = quantity.compared ? all_.outcome(run).value(quantity.name) : std::nullopt) {
        scale = std::max(scale, std::abs(*value));
      }
    }
  }
  study_["reference"] = reference_;
  all_.add_to(study_);
  for (std::size_t number = 0; number < all_.series().size(); ++number) {
    study_["series"].push_back(analyse(number));
  }
  work_precision();
}

std::string Report::tables() const {
  constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
  const std::vector<Quantity> quantities = shown();
  std::string text;
  for (std::size_t number = 0; number < all_.series().size(); ++number) {
    text += all_.table(number, quantities, kAll);
  }
  if (quantities.empty()) {
    return text + "\n" + all_.failures();
  }
  for (std::size_t number = 0; number < all_.series().size(); ++number) {
    text += trend_tables(number) + budget_table(number);
  }
  return text + precision_table() + "\n" + all_.failures();
}

std::vector<const PlannedRun*> Report::line(std::size_t series, std::size_t axis) const {
  const auto& axes = all_.series()[series].axes;
  std::vector<const PlannedRun*> found;
  for (const PlannedRun& run : all_.planned()) {
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
  const auto& axes = all_.series()[run.series].axes;
  std::size_t coarse = 0;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    coarse += run.at[a] + 1 < axes[a].values.size() ? 1 : 0;
  }
  return coarse <= 1;
}

Json Report::analyse(std::size_t number) const {
  const Series& series = all_.series()[number];
  const PlannedRun& finest = *line(number, series.axes.size()).front();
  Json json{{"name", series.name}, {"finest_run", finest.number}, {"axes", Json::array()}};
  for (const Axis& axis : series.axes) {
    json["axes"].push_back({{"key", axis.key}, {"values", axis.values}, {"sizes", axis.sizes}});
  }
  json["analysis"] = Json::object();
  for (const Quantity& quantity : all_.quantities()) {
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
        if (const auto value = all_.outcome(*run).value(quantity.name)) {
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
    const auto value = all_.outcome(finest).value(quantity.name);
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
  for (const PlannedRun& run : all_.planned()) {
    const Outcome& outcome = all_.outcome(run);
    if (outcome.state != "finished") {
      continue;
    }
    const std::string& own = all_.series()[run.series].name;
    const auto truth = std::ranges::find_if(study_["series"], [&](const Json& series) {
      return series["name"] == (reference_ == "own" ? own : reference_);
    });
    Json errors = Json::object();
    for (const Quantity& quantity : all_.quantities()) {
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
        orders += (orders.empty() ? "" : " ") + study::number(order, "%.2f");
      }
      rows.push_back({label(quantity), study::number(entry["finest"]), orders, study::number(along["limit"]),
                      error_text(along), along["verdict"]});
    }
    text += "\n" + all_.series()[number].name + " along " + key + " = " + joined(axis["values"]) + others(series, key) +
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
    std::vector<std::string> row{label(quantity), study::number(entry["finest"])};
    for (const auto& [key, along] : entry["along"].items()) {
      row.push_back(error_text(along));
      if (!converged(along)) {
        unresolved.insert(key);
      }
    }
    row.push_back(error_text(entry));
    row.push_back(converged(entry) ? study::number(entry["limit"]) : "none");
    rows.push_back(std::move(row));
  }
  std::string text = "\nerror budget of run " + std::to_string(series["finest_run"].get<std::size_t>()) +
                     ", the finest of " + all_.series()[number].name + "\n" + aligned(rows);
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
    if (!on_a_line(all_.planned()[entry["run"].get<std::size_t>()])) {
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

}  // namespace udar::study
