#include "tools/contact_table.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "tools/contact_runs.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/scoped_options.hpp"
#include "udar/petsc/session.hpp"

namespace udar::bench {
namespace {

using Json = nlohmann::ordered_json;
using petsc::Options;

/// A method by its options; the rest are those of the case.
struct MethodRow {
  const char* name = nullptr;
  ContactMethod method = ContactMethod::modal;
  const char* parameter = nullptr;  ///< key of what is refined
  const char* type = nullptr;
  const char* surface = nullptr;
  const char* tolerance = nullptr;  ///< null: the type's own
};
constexpr std::array kMethods{
    MethodRow{"masses-rk", ContactMethod::masses_rk, "-filter_frequency", "rk", "mass"},
    MethodRow{"masses-chebyshev", ContactMethod::masses_chebyshev, "-filter_frequency", "chebyshev", "mass", "1e-8"},
    MethodRow{"masses-impact", ContactMethod::masses_impact, "-filter_frequency", "impact", "mass"},
    MethodRow{"line-impact", ContactMethod::line_impact, "-filter_frequency", "impact", "line"},
    MethodRow{"line-chebyshev", ContactMethod::line_chebyshev, "-filter_frequency", "chebyshev", "line", "1e-4"},
    MethodRow{"unfiltered", ContactMethod::unfiltered, "-ts_dt", "moreau"},
    MethodRow{"modal", ContactMethod::modal, "-modal_modes", "modal"}};

/// What a case needs that does not say it.
const Options kCase{{"-beam_elements", "160"},
                    {"-initial_height", "1"},
                    {"-gauge_position", "0,5"},
                    {"-ts_max_time", "1.352"},
                    {"-output_interval", "1e-4"}};
const Options kSupports{{"-support_position", "2,8"}};  // where there is no ground, either

std::string text_of(double value, const char* format = "%.10g") {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), format, value);  // NOLINT(cert-err33-c): always fits
  return text.data();
}

bool is_given(const std::string& key) {
  PetscBool given = PETSC_FALSE;
  UDAR_CALL(PetscOptionsHasName(nullptr, nullptr, key.c_str(), &given));
  return given == PETSC_TRUE;
}

Options missing(const Options& wanted) {
  Options found;
  std::ranges::copy_if(wanted, std::back_inserter(found), [](const auto& option) { return !is_given(option.first); });
  return found;
}

void refuse_what_lists_stand_for() {
  for (const auto& [key, list] : {std::pair{"-filter_frequency", "-bench_frequencies"},
                                  {"-ts_dt", "-bench_steps"},
                                  {"-modal_modes", "-bench_modes"},
                                  {"-support_stiffness", "-bench_stiffness"},
                                  {"-ts_type", "-bench_methods"},
                                  {"-contact_surface", "-bench_methods"}}) {
    if (const auto value = petsc::option_value(key)) {
      throw InputError{std::string{"option "} + key + ": " + *value +
                       " is not allowed with -bench_kind contact, expected " + list};
    }
  }
}

/// A number that the options in force have. @throws InputError
double number_of(const std::string& key) {
  const std::string text = petsc::option_value(key).value_or("");
  double value = 0.0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc{} || end != text.data() + text.size() || !(value > 0.0)) {
    throw InputError{"option " + key + ": '" + text + "' is not allowed, expected a number > 0"};
  }
  return value;
}

Options options_of(const MethodRow& method, double value) {
  Options options{{"-ts_type", method.type}, {method.parameter, text_of(value, "%.17g")}};
  if (method.method == ContactMethod::unfiltered) {
    options.emplace_back("-filter_frequency", "none");
    // Rows as near to those of the others as an even number of steps each allows, so that all show ends of steps.
    constexpr double kWhole = 1e-9;
    const double interval = number_of("-output_interval");
    const double end = number_of("-ts_max_time");
    const double steps = std::max(1.0, std::round(interval / value));  // in a row
    const double rows = std::ceil(end / (steps * value) * (1.0 - kWhole));
    options[1].second = text_of(end / rows / steps, "%.17g");
    options.emplace_back("-output_interval", text_of(end / rows, "%.17g"));
  }
  if (method.surface != nullptr) {
    options.emplace_back("-contact_surface", method.surface);
  }
  if (method.tolerance != nullptr && !is_given("-ts_rtol")) {
    options.emplace_back("-ts_rtol", method.tolerance);
  }
  return options;
}

std::vector<double> values_of(const MethodRow& method, const ContactLists& lists) {
  switch (method.method) {
    case ContactMethod::unfiltered:
      return lists.steps;
    case ContactMethod::modal:
      return {lists.modes.begin(), lists.modes.end()};
    default:
      return lists.frequencies;
  }
}

/// A little finer than a value, the more so the farther the neighbour.
double neighbour_of(const MethodRow& method, double value, PetscInt number) {
  constexpr double kFiner = 0.02;
  const double factor = 1.0 + kFiner * static_cast<double>(number);
  switch (method.method) {
    case ContactMethod::unfiltered:
      return value / factor;
    case ContactMethod::modal:
      return value + 2.0 * static_cast<double>(number);
    default:
      return value * factor;
  }
}

/// What is compared of a run, in one row: the gauges' lowest positions [m], rebound [-], second landing [s].
std::vector<std::optional<double>> compared(const ContactRun& run) {
  std::vector<std::optional<double>> all{run.lowest.begin(), run.lowest.end()};
  all.resize(run.gauges.size());
  all.push_back(run.rebound);
  all.push_back(run.second_landing);
  return all;
}

/// What counts as true: the mean over several numbers of modes, and how far the farthest of them is from it.
struct Reference {
  std::vector<std::optional<double>> value;
  std::vector<double> scatter;
  ContactRun finest;
};

Reference reference(MPI_Comm comm, const std::vector<PetscInt>& modes) {
  Reference found;
  std::vector<std::vector<std::optional<double>>> all;
  for (const PetscInt count : modes) {
    found.finest = run_contact(comm, {{"-ts_type", "modal"}, {"-modal_modes", std::to_string(count)}}, 1);
    if (!found.finest.refusal.empty()) {
      throw InputError{"option -bench_reference: " + std::to_string(count) + " is not allowed, " +
                       found.finest.refusal};
    }
    all.push_back(compared(found.finest));
  }
  for (std::size_t i = 0; i < all.front().size(); ++i) {
    double sum = 0.0;
    bool known = true;
    for (const auto& one : all) {
      known = known && one[i].has_value();
      sum += one[i].value_or(0.0);
    }
    const double mean = sum / static_cast<double>(all.size());
    found.value.push_back(known ? std::optional{mean} : std::nullopt);
    double scatter = 0.0;
    for (const auto& one : all) {
      scatter = std::max(scatter, std::abs(one[i].value_or(mean) - mean));
    }
    found.scatter.push_back(scatter);
  }
  return found;
}

/// Position of a gauge at a time, between rows in a straight line [m].
double position_at(const ContactRun& run, std::size_t gauge, double time) {
  const auto after = std::ranges::lower_bound(run.times, time);
  const auto row = static_cast<std::size_t>(after - run.times.begin());
  if (after == run.times.begin() || *after == time) {
    return run.positions[row][gauge];
  }
  const double share = (time - run.times[row - 1]) / (run.times[row] - run.times[row - 1]);
  return (1.0 - share) * run.positions[row - 1][gauge] + share * run.positions[row][gauge];
}

/// Root of the mean square distance of the gauges from those of another run, over all rows between the first landing
/// and that run's second [m].
std::optional<double> distance(const ContactRun& run, const ContactRun& truth) {
  const double until =
      truth.times.empty() ? 0.0 : truth.times.front() + truth.second_landing.value_or(truth.times.back());
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t row = 0; row < run.times.size(); ++row) {
    if (truth.times.empty() || run.times[row] > std::min(until, truth.times.back())) {
      break;
    }
    for (std::size_t g = 0; g < run.gauges.size(); ++g) {
      const double off = run.positions[row][g] - position_at(truth, g, run.times[row]);
      sum += off * off;
      count += 1.0;
    }
  }
  return count > 0.0 ? std::optional{std::sqrt(sum / count)} : std::nullopt;
}

Json number(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? Json(*value) : Json(nullptr);
}

/// Names of what is compared.
std::vector<std::string> names_of(const ContactRun& run) {
  std::vector<std::string> names;
  std::ranges::transform(run.gauges, std::back_inserter(names),
                         [](double gauge) { return "lowest_at_" + text_of(gauge); });
  names.insert(names.end(), {"rebound", "second_landing"});
  return names;
}

/// Root of the mean square of what is known.
class RootMeanSquare {
 public:
  void add(double value) {
    sum_ += value * value;
    count_ += 1.0;
  }
  [[nodiscard]] std::optional<double> value() const {
    return count_ > 0.0 ? std::optional{std::sqrt(sum_ / count_)} : std::nullopt;
  }

 private:
  double sum_ = 0.0;
  double count_ = 0.0;
};

/// A run and its neighbours: errors are root mean squares over all of them, the rest is that of the run itself.
/// @param[in] runs the run is the first
Json row_of(const MethodRow& method, double value, const std::vector<ContactRun>& runs, const Reference& truth) {
  const ContactRun& run = runs.front();
  Json row{{"method", method.name}, {"parameter", text_of(value)}, {"refusal", run.refusal}};
  const bool done = run.refusal.empty();
  const std::vector<std::string> names = names_of(truth.finest);
  const auto own = done ? compared(run) : std::vector<std::optional<double>>(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    RootMeanSquare error;
    for (const ContactRun& one : runs) {
      const auto found = one.refusal.empty() ? compared(one)[i] : std::nullopt;
      if (found && truth.value[i]) {
        error.add(*found - *truth.value[i]);
      }
    }
    row[names[i]] = number(own[i]);
    row["error_of_" + names[i]] = number(error.value());
  }
  RootMeanSquare off;
  for (const ContactRun& one : runs) {
    if (const auto found = distance(one, truth.finest)) {
      off.add(*found);
    }
  }
  row["distance"] = number(off.value());
  const auto put = [&row, done](const char* name, double found) { row[name] = done ? Json(found) : Json(nullptr); };
  put("energy_drift", run.drift);
  put("line_solves", run.cost.line_solves);
  put("set_up_cpu_seconds", run.cost.set_up);
  put("stepping_cpu_seconds", run.cost.stepping);
  return row;
}

Json reference_json(const Reference& truth, const std::vector<PetscInt>& modes) {
  Json json{{"modes", modes}};
  const std::vector<std::string> names = names_of(truth.finest);
  for (std::size_t i = 0; i < names.size(); ++i) {
    json[names[i]] = number(truth.value[i]);
    json["scatter_of_" + names[i]] = truth.scatter[i];
  }
  return json;
}

/// A number of a table, or a dash.
std::string cell(const Json& value, double unit, const char* format, int width) {
  std::string text = value.is_number() ? text_of(value.get<double>() / unit, format) : "-";
  text.insert(0, text.size() < static_cast<std::size_t>(width) ? static_cast<std::size_t>(width) - text.size() : 0,
              ' ');
  return text;
}

constexpr double kCentimetre = 1e-2;
constexpr double kMilli = 1e-3;
constexpr double kPercent = 1e-2;

/// Gauges and rebound with errors in per cent of the true value, the landing with one in milliseconds.
std::string line_of(const Json& row, const Json& truth, const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) {
    const bool length = name.starts_with("lowest");
    const bool landing = name == "second_landing";
    text += cell(row[name], length ? kCentimetre : 1.0, length ? "%.3f" : landing ? "%.5f" : "%.4f", 10);
    const Json& error = row["error_of_" + name];
    const bool relative = !landing && truth[name].is_number();
    const double unit = landing ? kMilli : kPercent * (relative ? std::abs(truth[name].get<double>()) : 1.0);
    text += cell(error, unit, "%.2g", 9);
  }
  text += cell(row["distance"], kMilli, "%.2g", 10) + cell(row["line_solves"], 1.0, "%.0f", 9);
  text += cell(row["set_up_cpu_seconds"], kMilli, "%.3g", 9) + cell(row["stepping_cpu_seconds"], kMilli, "%.3g", 9);
  return text;
}

std::string head_of(const std::vector<std::string>& names) {
  std::string text = "method             parameter";
  for (const std::string& name : names) {
    const bool landing = name == "second_landing";
    const std::string label = landing                       ? "landing"
                              : name.starts_with("lowest_") ? "y(" + name.substr(std::string{"lowest_at_"}.size()) + ")"
                                                            : name;
    text += std::string(label.size() < 10 ? 10 - label.size() : 0, ' ') + label + (landing ? "  +- [ms]" : "   +- [%]");
  }
  return text + "  rms [mm]   solves  set-up  stepping [ms CPU]";
}

std::string padded(std::string text, std::size_t width) {
  text.resize(std::max(width, text.size()), ' ');
  return text;
}

/// The table of one stiffness. @return what of it is written
Json table(MPI_Comm comm, const ContactLists& lists, double stiffness, long repeats) {
  const bool rigid = std::isinf(stiffness);
  const petsc::ScopedOptions support{rigid ? Options{} : Options{{"-support_stiffness", text_of(stiffness)}}};
  const Reference truth = reference(comm, lists.reference);
  const std::vector<std::string> names = names_of(truth.finest);
  Json found{{"stiffness", rigid ? Json(nullptr) : Json(stiffness)},
             {"reference", reference_json(truth, lists.reference)},
             {"rows", Json::array()}};
  const Json& mean = found["reference"];
  UDAR_CALL(PetscPrintf(comm, "\n%s; reference: mean by modal with %s modes, +- the farthest of them\n%s\n",
                        rigid ? "rigid supports" : ("supports of " + text_of(stiffness, "%g") + " N/m").c_str(),
                        Json(lists.reference).dump().c_str(), head_of(names).c_str()));
  Json shown = mean;
  for (const std::string& name : names) {
    shown["error_of_" + name] = mean["scatter_of_" + name];
  }
  UDAR_CALL(PetscPrintf(comm, "%s%s\n", padded("reference", 28).c_str(), line_of(shown, mean, names).c_str()));
  for (const ContactMethod asked : lists.methods) {
    const MethodRow& method = *std::ranges::find(kMethods, asked, &MethodRow::method);
    std::string told;
    for (const double value : values_of(method, lists)) {
      std::vector<ContactRun> runs{run_contact(comm, options_of(method, value), repeats)};
      for (PetscInt other = 1; other <= lists.neighbours && runs.front().refusal.empty(); ++other) {
        runs.push_back(run_contact(comm, options_of(method, neighbour_of(method, value, other)), 1));
      }
      found["rows"].push_back(row_of(method, value, runs, truth));
      const std::string& refusal = runs.front().refusal;
      const std::string refused = refusal == told ? " refused" : " refused: " + refusal;
      told = refusal;
      UDAR_CALL(PetscPrintf(comm, "%s%s%s\n", padded(method.name, 19).c_str(), padded(text_of(value), 9).c_str(),
                            refusal.empty() ? line_of(found["rows"].back(), mean, names).c_str() : refused.c_str()));
    }
  }
  return found;
}

std::string csv_of(const Json& tables) {
  std::string text;
  for (const Json& one : tables) {
    for (const Json& row : one["rows"]) {
      if (text.empty()) {
        text = "stiffness";
        for (const auto& [key, value] : row.items()) {
          text += "," + key;
        }
        text += "\n";
      }
      text += one["stiffness"].is_null() ? "inf" : text_of(one["stiffness"].get<double>());
      for (const auto& [key, value] : row.items()) {
        text += "," + (value.is_null() || value == Json("") ? "" : value.dump());
      }
      text += "\n";
    }
  }
  return text;
}

std::string write_file(const std::string& path, const std::string& text) {
  std::ofstream file{path};
  file << text << std::flush;
  return file.good() ? "" : "option -bench_directory: cannot write '" + path + "'";
}

}  // namespace

void ContactLists::read(petsc::OptionGroup& group) {
  std::vector<std::pair<const char*, ContactMethod>> names;
  std::ranges::transform(kMethods, std::back_inserter(names),
                         [](const MethodRow& method) { return std::pair{method.name, method.method}; });
  group.choices<ContactMethod>("-bench_methods", methods, names,
                               "contact: masses or the line that touch by an integrator, the unfiltered beam, modes");
  group.reals("-bench_stiffness", stiffness, "N/m", petsc::positive_or_infinite(),
              "contact: of each support, one table for each");
  group.reals("-bench_frequencies", frequencies, "rad/s", petsc::positive(), "contact: filter frequencies");
  group.reals("-bench_steps", steps, "s", petsc::positive(), "contact: steps of the unfiltered beam");
  group.integers("-bench_modes", modes, petsc::at_least(1), "contact: numbers of modes");
  group.integers("-bench_reference", reference, petsc::at_least(1),
                 "contact: numbers of modes; the mean of these runs counts as true, their scatter is told");
  group.integer("-bench_neighbours", neighbours, petsc::non_negative(),
                "contact: so many runs beside each, at filter frequencies and steps finer by 2 % each, with two modes "
                "more each; errors are root mean squares over all, so that none is a lucky run's");
}

void contact(MPI_Comm comm, const ContactLists& lists, const std::string& directory, long repeats) {
  refuse_what_lists_stand_for();
  const petsc::ScopedOptions open{missing(kCase)};
  const bool ground = is_given("-floor") || is_given("-ground_profile");
  const petsc::ScopedOptions supports{ground ? Options{} : missing(kSupports)};
  Json tables = Json::array();
  for (const double stiffness : lists.stiffness) {
    tables.push_back(table(comm, lists, stiffness, repeats));
  }
  std::string failure;
  if (petsc::Session::on_first_rank()) {
    failure = write_file(directory + "/contact.json", Json{{"tables", tables}}.dump(2) + "\n");
    failure = failure.empty() ? write_file(directory + "/contact.csv", csv_of(tables)) : failure;
  }
  throw_together<FileError>(comm, failure);
}

}  // namespace udar::bench
