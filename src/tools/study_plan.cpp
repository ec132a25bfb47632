#include "tools/study_plan.hpp"

#include <petscsys.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <ranges>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"

namespace udar::study {

std::string trimmed(std::string_view text) {
  constexpr const char* kSpace = " \t\n\r";
  const std::size_t first = text.find_first_not_of(kSpace);
  return first == std::string_view::npos ? ""
                                         : std::string{text.substr(first, text.find_last_not_of(kSpace) - first + 1)};
}

std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(separator, begin), text.size());
    parts.push_back(trimmed(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return parts;
}

std::string with_dash(const std::string& key) { return key.starts_with('-') ? key : "-" + key; }

Axis make_axis(const std::string& key, const std::string& list) {
  struct Entry {
    std::string text;
    double number;
  };
  std::vector<Entry> entries;
  std::string bare = list;
  std::erase_if(bare, [](char c) { return c == '[' || c == ']'; });
  for (const std::string& word : split(bare, ',')) {
    double number = 0.0;
    const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (status != std::errc{} || end != word.data() + word.size() || !(number > 0.0) || !std::isfinite(number)) {
      throw InputError{"option -" + key + ": '" + word +
                       "' is not allowed on an axis of a study, expected numbers > 0"};
    }
    entries.push_back({.text = word, .number = number});
  }
  const bool known = std::ranges::find(kAxisKeys, std::string_view{key}) != kAxisKeys.end();
  const bool grows = known ? !key.starts_with("ts_") : entries.back().number > entries.front().number;
  const auto size = [grows](const Entry& entry) { return grows ? 1.0 / entry.number : entry.number; };
  if (known) {
    std::ranges::sort(entries, std::ranges::greater{}, size);
  }
  if (std::ranges::adjacent_find(entries, std::ranges::less_equal{}, size) != entries.end()) {
    throw InputError{"option -" + key + ": the values of an axis must differ" +
                     (known ? "" : " and be listed from coarse to fine, all rising or all falling") + ", given " +
                     list};
  }
  Axis axis{.key = key, .values = {}, .sizes = {}};
  for (const Entry& entry : entries) {
    axis.values.push_back(entry.text);
    axis.sizes.push_back(size(entry));
  }
  return axis;
}

std::vector<Axis> find_axes(const Request& request) {
  const auto several = [](const std::string& key) {
    const auto value = option_value("-" + key);
    return value && value->find(',') != std::string::npos;
  };
  std::vector<std::string> keys{kAxisKeys.begin(), kAxisKeys.end()};
  for (const std::string& key : request.axes) {
    if (std::ranges::find(keys, key) == keys.end()) {
      keys.push_back(key);
    }
  }
  std::vector<Axis> axes;
  for (const std::string& key : keys) {
    if (!several(key)) {
      continue;
    }
    if (key == "beam_elements" && several("beam_length")) {
      if (std::ranges::find(request.axes, key) != request.axes.end()) {
        throw InputError{"option -study_axes: beam_elements is a list by segment here; give -study_refine 1,2,4"};
      }
      continue;
    }
    axes.push_back(make_axis(key, *option_value("-" + key)));
  }
  const auto has = [&axes](std::string_view key) { return std::ranges::find(axes, key, &Axis::key) != axes.end(); };
  if (has(kRefine) && has("beam_elements")) {
    throw InputError{"option -study_refine multiplies -beam_elements, which has several values already"};
  }
  return axes;
}

std::string refined(const std::string& factor) {
  const auto whole = [](const char* key, const std::string& word) {
    PetscInt value = 0;
    const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (status != std::errc{} || end != word.data() + word.size() || value < 1) {
      throw InputError{std::string{"option "} + key + ": '" + word +
                       "' is not allowed, expected whole numbers >= 1 for -study_refine"};
    }
    return value;
  };
  const PetscInt times = whole("-study_refine", factor);
  constexpr const char* kDefault = "20";  // of -beam_elements
  std::string list = option_value("-beam_elements").value_or(kDefault);
  std::erase_if(list, [](char c) { return c == '[' || c == ']'; });
  std::string result;
  for (const std::string& word : split(list, ',')) {
    const PetscInt elements = whole("-beam_elements", word);
    if (elements > std::numeric_limits<PetscInt>::max() / times) {
      throw InputError{"option -study_refine: " + factor + " times " + word + " elements are too many"};
    }
    result += (result.empty() ? "" : ",") + std::to_string(elements * times);
  }
  return result;
}

std::vector<Series> read_series(const std::string& text) {
  if (text.empty()) {
    return {{.name = "case", .options = {}, .axes = {}}};
  }
  std::vector<Series> all;
  for (const std::string& part : split(text, ';')) {
    if (part.empty()) {
      continue;
    }
    const std::size_t colon = part.find(':');
    const std::string name = trimmed(part.substr(0, colon));
    if (colon == std::string::npos || name.empty() || name.find_first_of(" \",") != std::string::npos) {
      throw InputError{"option -study_series: '" + part +
                       "' is not allowed, expected 'name: -key value ...' with ';' between series"};
    }
    if (std::ranges::find(all, name, &Series::name) != all.end() || name == "own") {
      throw InputError{"option -study_series: the name '" + name + "' is taken"};
    }
    Series series{.name = name, .options = {}, .axes = {}};
    const std::string options = trimmed(part.substr(colon + 1));
    if (!options.empty() && !options.starts_with('-')) {
      throw InputError{"option -study_series: '" + options + "' is not allowed, expected options like -key value"};
    }
    petsc::check_option_words(petsc::option_words(options), " in -study_series '" + name + "'");
    PetscOptions parsed = nullptr;
    UDAR_CALL(PetscOptionsCreate(&parsed));
    UDAR_CALL(PetscOptionsInsertString(parsed, options.c_str()));
    PetscInt count = 0;
    char** keys = nullptr;
    char** values = nullptr;
    UDAR_CALL(PetscOptionsLeftGet(parsed, &count, &keys, &values));  // all of them: nobody has read any
    for (PetscInt i = 0; i < count; ++i) {
      series.options.emplace_back(std::string{"-"} + keys[i],
                                  values[i] != nullptr ? std::optional<std::string>{values[i]} : std::nullopt);
    }
    UDAR_CALL(PetscOptionsLeftRestore(parsed, &count, &keys, &values));
    UDAR_CALL(PetscOptionsDestroy(&parsed));
    for (const auto& [key, value] : series.options) {
      if (key.starts_with("-study_") && key != std::string{"-"} + kRefine) {
        throw InputError{"option -study_series: " + key + " is not allowed in a series"};
      }
    }
    all.push_back(std::move(series));
  }
  if (all.empty()) {
    throw InputError{"option -study_series: no series in '" + text + "'"};
  }
  return all;
}

double expected_cost() {
  double cost = 1.0;
  const auto number = [](const std::string& word, double otherwise) {
    double value = 0.0;
    const auto status = std::from_chars(word.data(), word.data() + word.size(), value).ec;
    return status == std::errc{} && value > 0.0 && std::isfinite(value) ? value : otherwise;
  };
  double elements = 0.0;
  for (const std::string& word : split(option_value("-beam_elements").value_or("20"), ',')) {
    elements += number(word, 1.0);
  }
  cost *= elements * number(option_value("-filter_frequency").value_or(""), 1.0);
  return cost / number(option_value("-ts_dt").value_or(""), 1.0);
}

namespace {

/// Goes to the next point of the grid, the last axis fastest. @return whether there is one
bool go_on(const std::vector<Axis>& axes, std::vector<std::size_t>& at) {
  for (std::size_t a = at.size(); a-- > 0;) {
    if (++at[a] < axes[a].values.size()) {
      return true;
    }
    at[a] = 0;
  }
  return false;
}

/// Whether a point of the grid is run.
bool is_wanted(Design design, const std::vector<Axis>& axes, const std::vector<std::size_t>& at) {
  std::size_t coarse = 0;
  for (std::size_t a = 0; a < at.size(); ++a) {
    coarse += at[a] + 1 < axes[a].values.size() ? 1 : 0;
  }
  return design == Design::grid || coarse <= 1;
}

/// Adds to a run's options, those of its series so far, and finds what it costs.
void complete(PlannedRun& run, const Series& series, const std::string& folder) {
  std::erase_if(run.options, [](const auto& option) { return option.first == std::string{"-"} + kRefine; });
  for (std::size_t a = 0; a < run.at.size(); ++a) {
    const Axis& axis = series.axes[a];
    const bool refine = axis.key == kRefine;
    const std::string key = "-" + (refine ? std::string{"beam_elements"} : axis.key);
    std::erase_if(run.options, [&key](const auto& option) { return option.first == key; });
    run.options.emplace_back(key, refine ? refined(axis.values[run.at[a]]) : axis.values[run.at[a]]);
  }
  std::string digits = std::to_string(run.number);
  digits.insert(0, digits.size() < 3 ? 3 - digits.size() : 0, '0');
  run.options.emplace_back("-output_directory", folder + "/run-" + digits);
  const ScopedOptions of_run{run.options};
  run.cost = expected_cost();
}

/// The axes of a design study. @throws InputError if something else has several values
std::vector<Axis> design_axes(const Request& request) {
  if (const std::vector<Axis> others = find_axes(request); !others.empty()) {
    throw InputError{"option -study_vary: with it -" + others.front().key +
                     " must have one value, not several; or name it there"};
  }
  std::vector<Axis> axes;
  for (const Variable& variable : request.variables) {
    if (!request.samples_taken() && !variable.listed()) {
      throw InputError{"option -study_vary: " + variable.key +
                       " has a range, which needs -study_design latin or random and -study_samples"};
    }
    const Sampling sampling = request.design == Design::latin ? Sampling::latin : Sampling::random;
    axes.push_back({.key = variable.key,
                    .values = request.samples_taken()
                                  ? sampled(variable, sampling, static_cast<std::size_t>(request.samples),
                                            static_cast<std::uint64_t>(request.seed), axes.size())
                                  : variable.values,
                    .sizes = {}});
  }
  return axes;
}

/// Refuses what does not go together. @throws InputError
void require_design(const Request& request) {
  if (request.variables.empty() && request.samples_taken()) {
    throw InputError{"option -study_design: latin and random need -study_vary"};
  }
  if (!request.variables.empty() && request.design == Design::lines) {
    throw InputError{"option -study_design: lines is of convergence studies, -study_vary takes grid, latin or random"};
  }
  if (request.samples_taken() != (request.samples > 0)) {
    throw InputError{"option -study_samples: " + std::to_string(request.samples) +
                     " is not allowed, expected >= 1 with -study_design latin or random, and none else"};
  }
}

/// Which of the values of its axes each run of a series has.
std::vector<std::vector<std::size_t>> places(const Request& request, const std::vector<Axis>& axes) {
  std::vector<std::vector<std::size_t>> all;
  for (std::size_t i = 0; request.samples_taken() && i < static_cast<std::size_t>(request.samples); ++i) {
    all.emplace_back(axes.size(), i);
  }
  std::vector<std::size_t> at(axes.size());
  for (bool more = !request.samples_taken(); more; more = go_on(axes, at)) {
    if (is_wanted(request.design, axes, at)) {
      all.push_back(at);
    }
  }
  return all;
}

}  // namespace

std::vector<PlannedRun> plan(std::vector<Series>& all, const Request& request, const std::string& folder) {
  require_design(request);
  std::vector<PlannedRun> runs;
  for (std::size_t number = 0; number < all.size(); ++number) {
    Series& series = all[number];
    const ScopedOptions in_force{series.options};
    series.axes = request.variables.empty() ? find_axes(request) : design_axes(request);
    for (const std::vector<std::size_t>& at : places(request, series.axes)) {
      runs.push_back({.number = runs.size(), .series = number, .at = at, .options = series.options});
      complete(runs.back(), series, folder);
    }
  }
  for (const std::string& key : request.axes) {
    const bool found = std::ranges::any_of(all, [&key](const Series& series) {
      return std::ranges::find(series.axes, key, &Axis::key) != series.axes.end();
    });
    if (!found) {
      throw InputError{"option -study_axes: -" + key +
                       " has no list of several values, given to the study or a series"};
    }
  }
  return runs;
}

std::vector<std::vector<std::size_t>> deal(std::span<const PlannedRun> runs, std::size_t groups) {
  std::vector<std::size_t> order(runs.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    order[i] = i;
  }
  std::ranges::sort(order, {}, [&runs](std::size_t i) { return std::pair{-runs[i].cost, i}; });
  std::vector<std::vector<std::size_t>> dealt(groups);
  std::vector<double> load(groups);
  for (const std::size_t i : order) {
    const auto least = static_cast<std::size_t>(std::ranges::min_element(load) - load.begin());
    dealt[least].push_back(runs[i].number);
    load[least] += runs[i].cost;
  }
  return dealt;
}

}  // namespace udar::study
