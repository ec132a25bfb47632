#pragma once
/// @file
/// A case as the user states it: options and case file turned into plain, checked values.

#include <string>
#include <vector>

#include "udar/contact/support.hpp"
#include "udar/dynamics/model.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/structure/beam_chain.hpp"
#include "udar/structure/initial_state.hpp"
#include "udar/structure/load.hpp"

namespace udar::app {

/// @brief Where and how often a run writes.
struct OutputParameters {
  std::string directory = "udar-output";
  double interval = 1e-3;        ///< of gauges and energy [s]
  double field_interval = 1e-2;  ///< of fields [s]; 0: none
  double force_window = 0.0;     ///< forces of supports are means over at least this [s], not less than pi / wf
  bool overwrite = false;
  bool allow_large = false;  ///< more than 10^6 rows or 10 GB
};

/// @brief How a run continues another and may be continued.
struct RestartParameters {
  std::string file;       ///< empty: start from t = 0
  double interval = 0.0;  ///< simulated time between checkpoints [s]; 0: only at the end
};

/// @brief The filter as the user states it: a frequency, or what it must reach, and modes without filter.
struct FilterInput : FilterParameters {
  bool automatic = false;         ///< the frequency follows from the next three
  double accuracy = 0.01;         ///< largest relative error of a frequency that matters [-]
  PetscInt modes = 1;             ///< how many of the lowest flexible modes matter
  double band = 0.0;              ///< all frequencies up to this one matter [rad/s]; 0: by `modes`
  PetscInt correct_lowest = 0;    ///< so many of the lowest flexible modes are exact, unless above wf
  std::vector<PetscInt> correct;  ///< and these, counted from 1, wherever they are
};

/// @brief Everything `udar` reads from the options database, once, before anything is built.
struct Case {
  BeamParameters beam;
  FilterInput filter;
  double gravity = 9.81;  ///< [m/s^2]
  InitialState initial;
  std::vector<NodalLoad> loads;
  std::vector<Support> supports;  ///< the floor or ground, if any, is the last
  ContactParameters contact;
  Damping damping;
  std::vector<double> gauges;  ///< [m]
  OutputParameters output;
  RestartParameters restart;
  double end_time = 1.0;  ///< [s]
  bool view = false;

  /// What of it makes the model, its filter frequency chosen.
  [[nodiscard]] ModelParameters model() const;
};

/// @brief Reads -beam_* and -filter_*: what a line solve needs, for programs that do less than `udar`.
/// @note Collective. @throws InputError, FileError naming option, value, range and unit
[[nodiscard]] BeamParameters read_beam(MPI_Comm comm, Formulation& formulation);
[[nodiscard]] FilterInput read_filter(MPI_Comm comm, Formulation formulation);

/// @brief What `-output_force_window` stands for at the filter frequency of the case, known after `choose_frequency`.
/// @throws InputError if it is too short for impacts
void settle_force_window(Case& input);

/// @brief Reads every option of udar; prints their manual under `-help`.
/// @note Collective. @throws InputError, FileError naming option, value, range and unit
[[nodiscard]] Case read_case(MPI_Comm comm);

}  // namespace udar::app
