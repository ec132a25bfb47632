#pragma once
/// @file
/// A case in two steps: what the user asked for, and what is run; plain, checked values, const once they are there.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "udar/contact/support.hpp"
#include "udar/dynamics/guards.hpp"
#include "udar/dynamics/model.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/io/output_choice.hpp"
#include "udar/structure/base_motion.hpp"
#include "udar/structure/beam_chain.hpp"
#include "udar/structure/held_motion.hpp"
#include "udar/structure/initial_state.hpp"
#include "udar/structure/load.hpp"
#include "udar/structure/striker.hpp"
#include "udar/structure/travelling_load.hpp"

namespace udar::app {

/// @brief What a run says of itself on the terminal when it is over.
enum class PageForm : std::uint8_t { text, json, none };

/// @brief Where and how often a run writes.
struct OutputParameters {
  std::string directory = "udar-output";
  double interval = 1e-3;        ///< of gauges and energy [s]
  double field_interval = 1e-2;  ///< of fields [s]; 0: none
  double force_window = 0.0;     ///< forces of supports are means over at least this [s]; 0, asked for: pi / wf
  bool overwrite = false;
  bool allow_large = false;       ///< more than 10^6 rows or 10 GB
  double monitor_interval = 0.0;  ///< of rows on the terminal [s]; 0: none
  io::ContentChoice content{};
  std::vector<std::string> members;  ///< of a network: those that have rows in the files, names or groups; empty: all
  io::RowChoice rows{};              ///< the same of nodes, but for these members
  PageForm page = PageForm::text;
};

/// @brief How a run continues another and may be continued.
struct RestartParameters {
  std::string file;            ///< empty: start from t = 0
  bool in_place = false;       ///< go on in the files of the run that wrote it, or that never began
  double interval = 0.0;       ///< simulated time between checkpoints [s]; 0: by the clock alone
  double wall_minutes = 10.0;  ///< wall time between checkpoints [min]; 0: by `interval` alone
};

/// @brief Modes that vibrate at their unfiltered frequency.
struct ModeChoice {
  PetscInt lowest = 0;          ///< so many of the lowest flexible modes are exact, unless above wf
  std::vector<PetscInt> named;  ///< and these, counted from 1, wherever they are

  [[nodiscard]] bool any() const noexcept { return lowest > 0 || !named.empty(); }
};

/// @brief The filter as the user states it: a frequency, or what it must reach.
struct FilterInput {
  FilterParameters parameters;  ///< its frequency may still be 0
  bool automatic = false;       ///< the frequency follows from the next three
  bool modal_estimate = true;   ///< a second run with more modes says how far numbers are off
  bool modal = false;           ///< nothing but modes is integrated: no filter, and no step
  double accuracy = 0.01;       ///< largest relative error of a frequency that matters [-]
  PetscInt modes = 1;           ///< how many of the lowest flexible modes matter
  double band = 0.0;            ///< all frequencies up to this one matter [rad/s]; 0: by `modes`
  ModeChoice exact{};
};

/// @brief The beam, and how its line is to be discretised.
struct BeamInput {
  BeamParameters beam;
  Formulation formulation = Formulation::mixed;
};

/// @brief What takes the beam's place, if anything does.
struct StructureInput {
  std::optional<ImportParameters> imported;
  std::optional<NetworkParameters> network;
  double memory = 0.0;  ///< that a run may take by estimate, over all ranks [bytes]; 0: what the machines have
  std::string write;    ///< where a beam's own matrices go, the beginning of the names of files; empty: nowhere

  [[nodiscard]] bool beam() const noexcept { return !imported && !network; }
};

/// @brief Start and loads.
struct StartInput {
  double gravity = 9.81;  ///< [m/s^2]
  InitialState initial{.height = 1.0};
  bool in_space = false;  ///< some velocity is not along y
  std::vector<NodalLoad> loads;
  std::vector<TravellingLoad> travelling_loads;
  std::vector<BaseMotion> base_motion;
  std::vector<HeldMotion> held_motion;
  Damping damping;
  std::vector<double> damping_ratio;
};

/// @brief Supports and who touches them.
struct ContactInput {
  std::vector<Support> supports;        ///< the floor or ground, if any, is the last but for faces of strikers, pairs
  std::vector<Striker> strikers;        ///< whose faces are the last supports but for those of pairs
  std::vector<NodePair> pairs;          ///< whose faces are the last supports
  bool faces_in_space = false;          ///< some normal, or place along y or z, was given
  bool tributary = false;               ///< `mass_patches` were asked for
  double field_tolerance = 0.0;         ///< see `Case`
  std::vector<MassPatch> mass_patches;  ///< parts of the beam whose nodes carry the mass of a support's width
  ContactParameters contact;
};

/// @brief What is written, and what is gone on from.
struct OutputInput {
  std::vector<Place> gauges;  ///< [m]
  OutputParameters output;
  RestartParameters restart;
  double wall_limit = 0.0;  ///< [s] of wall time; 0: none
  GuardMode guard = GuardMode::warn;
  bool view = false;
};

/// @brief Of the time stepper what the case itself needs.
struct TimeInput {
  double end = 1.0;   ///< [s]
  double step = 0.0;  ///< [s]; 0: not given
};

/// @brief What was asked for: everything `udar` reads from the options database, once, before anything is built.
struct CaseInput {
  StructureInput structure;
  BeamInput beam;
  FilterInput filter;
  StartInput start;
  ContactInput contact;
  OutputInput output;
  TimeInput time;
};

/// @brief What is run: the filter frequency chosen, forces averaged over a time that makes sense.
struct Case : ModelParameters {
  std::string write{};  ///< see `StructureInput`
  ModeChoice exact{};
  bool modal = false;           ///< modes are integrated, and neither filter nor steps
  bool modal_estimate = true;   ///< see `FilterInput`
  std::vector<Place> gauges{};  ///< [m]
  /// How far planes may be off the height field that they stand for [m]; 0: 1 % of the motion's scale.
  double field_tolerance = 0.0;
  OutputParameters output{};
  RestartParameters restart{};
  GuardMode guard = GuardMode::warn;
  double wall_limit = 0.0;  ///< [s] of wall time; 0: none
  double end_time = 1.0;    ///< [s]
  bool view = false;

  /// Which striker a support is the face of, which pair of nodes; none of others.
  [[nodiscard]] std::optional<std::size_t> striker_of(const Support& support) const;
  [[nodiscard]] std::optional<std::size_t> pair_of(const Support& support) const;
};

/// @brief Reads -beam_* and -filter_*: what a line solve needs, for programs that do less than `udar`.
/// @note Collective. @throws InputError, FileError naming option, value, range and unit
[[nodiscard]] BeamInput read_beam(MPI_Comm comm);
[[nodiscard]] FilterInput read_filter(MPI_Comm comm, Formulation formulation);

/// @brief Reads every option of udar; prints their manual under `-help`.
/// @note Collective. @throws InputError, FileError naming option, value, range and unit
[[nodiscard]] CaseInput read_case(MPI_Comm comm);

/// @brief From what was asked to what is run. Under `-help` any filter frequency will do: only the solvers' own help is
/// wanted.
/// @note Collective: `-filter_frequency auto` computes modes. @throws InputError naming option, value, range and unit
[[nodiscard]] Case resolve(MPI_Comm comm, const CaseInput& input);

}  // namespace udar::app
