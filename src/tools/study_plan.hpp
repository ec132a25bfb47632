#pragma once
/// @file
/// Which runs a study makes: series of options, axes within them, runs dealt to groups of ranks.

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/study_design.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/scoped_options.hpp"

namespace udar::study {

using petsc::option_value;
using petsc::Options;
using petsc::ScopedOptions;

std::string trimmed(std::string_view text);

/// Every part between separators, empty ones too.
std::vector<std::string> split(std::string_view text, char separator);

std::string with_dash(const std::string& key);

/// @brief One key with several values: coarse to fine, or those of a design, of samples one for each run.
struct Axis {
  std::string key;                  ///< without dash
  std::vector<std::string> values;  ///< as given
  std::vector<double> sizes;        ///< of the discretisation, descending: the value, or one over it; else none
};

/// @brief Some options that belong together, under a name; the study runs them over their axes.
struct Series {
  std::string name;
  Options options;
  std::vector<Axis> axes;
};

/// @brief One run of the study.
struct PlannedRun {
  std::size_t number = 0;       ///< in the order of the table
  std::size_t series = 0;       ///< index
  std::vector<std::size_t> at;  ///< index into the values of each axis of the series
  Options options;              ///< on top of those of the command line
  double cost = 0.0;            ///< expected, any unit
};

/// @brief Which combinations of the values are run.
enum class Design {
  grid,    ///< all
  lines,   ///< those the analysis needs: each axis with the others at their finest
  latin,   ///< of a design study: samples, each stratum of each variable once
  random,  ///< of a design study: samples by chance
};

/// @brief What all series share.
struct Request {
  std::vector<std::string> axes;  ///< keys besides `kAxisKeys` that are axes
  Design design = Design::grid;
  std::vector<Variable> variables{};  ///< of a design study, which has no other axes; empty: a convergence study
  PetscInt samples = 0;               ///< of a design that takes them
  PetscInt seed = 1;                  ///< of these

  [[nodiscard]] bool samples_taken() const { return design == Design::latin || design == Design::random; }
};

inline constexpr const char* kRefine = "study_refine";
inline constexpr std::array kAxisKeys{"filter_frequency", "beam_elements", kRefine, "modal_modes", "ts_rtol", "ts_dt"};

/// Sorts the values of an axis from coarse to fine. @throws InputError
Axis make_axis(const std::string& key, const std::string& list);

/// The axes of a series whose options are in force.
std::vector<Axis> find_axes(const Request& request);

/// -beam_elements times a factor, entry by entry.
std::string refined(const std::string& factor);

/// @brief Reads the series: `name: -key value ...; name: ...`; an empty text gives one series of no options.
/// @note Collective over `PETSC_COMM_WORLD` if the text names options files. @throws InputError
std::vector<Series> read_series(const std::string& text);

/// Products of the numbers that the options in force ask for: masses times filter frequency, over the step.
double expected_cost();

/// @brief All runs: every series over the grid of its axes. Finds the axes of the series first.
/// @param[in] folder of the study; run 3 writes into folder/run-003
/// @throws InputError
std::vector<PlannedRun> plan(std::vector<Series>& all, const Request& request, const std::string& folder);

/// @brief Who runs what: the dearest run first, each to the group with the least to do. @return run numbers per group
std::vector<std::vector<std::size_t>> deal(std::span<const PlannedRun> runs, std::size_t groups);

}  // namespace udar::study
