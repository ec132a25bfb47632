#include <limits>
#include <optional>
#include <string>

#include "app/input/readers.hpp"
#include "udar/integrators/ts_modal.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/scoped_options.hpp"
#include "udar/petsc/session.hpp"
#include "udar/petsc/warnings.hpp"

namespace udar::app {

using petsc::OptionGroup;

namespace {

/// Asked for, or chosen: where supports are to hold the line and there is neither a filter nor an integrator.
bool is_modal(bool filter_given) {
  const std::optional<std::string> type = petsc::option_value("-ts_type");
  if (!type && !filter_given && petsc::option_value("-contact_surface") == "line") {
    UDAR_CALL(PetscOptionsSetValue(nullptr, "-ts_type", kTsModal));
    return true;
  }
  return type == kTsModal;
}

}  // namespace

FilterInput read_filter(MPI_Comm comm, Formulation formulation) {
  OptionGroup group{
      comm, "Filter: the fictitious springs between masses and line (solver options: -filter_ksp_*, -filter_pc_*)"};
  FilterInput filter;
  filter.parameters.formulation = formulation;
  std::string word;
  const bool given = group.real_or_word(
      "-filter_frequency", filter.parameters.filter_frequency, word, {"auto", "none"}, "rad/s", petsc::positive(),
      "filter frequency wf: all frequencies of the model fall below it; auto: the least that keeps "
      "-filter_accuracy; none: the unfiltered beam, by -ts_type moreau with steps of -ts_dt; "
      "required but for -ts_type modal, which has none and is chosen where -contact_surface line comes without it");
  filter.modal = is_modal(given);
  if (word == "none" || filter.modal) {
    filter.parameters.filter_frequency = std::numeric_limits<double>::infinity();
  }
  group.boolean(
      "-modal_estimate", filter.modal_estimate,
      "for -ts_type modal: a second run with 1.4 times as many modes says how far the numbers of summary.json "
      "are off");
  filter.automatic = word == "auto" && !filter.modal;
  if (filter.modal && given && word != "none") {
    petsc::warn(comm, "-filter_frequency is not used: -ts_type modal has no filter");
  }
  const bool accuracy_given =
      group.real("-filter_accuracy", filter.accuracy, "-", {.lowest = 0.0, .highest = 0.5, .lowest_excluded = true},
                 "for -filter_frequency auto: how much the filter may lower a frequency that "
                 "matters, as a share of it");
  const bool modes_given = group.integer("-filter_modes", filter.modes, petsc::at_least(1),
                                         "for -filter_frequency auto: so many of the lowest flexible modes matter");
  const bool band_given = group.real("-filter_band", filter.band, "rad/s", petsc::positive(),
                                     "for -filter_frequency auto, instead of -filter_modes: all frequencies up to this "
                                     "one matter");
  group.integer("-filter_correct_modes", filter.exact.lowest, petsc::non_negative(),
                "so many of the lowest flexible modes vibrate at their unfiltered frequency, those above wf excepted; "
                "each costs a dot product and an axpy per line solve and 8 bytes per node, all together one reduction "
                "per line solve or batch of them");
  group.integers("-filter_correct_mode", filter.exact.named, petsc::at_least(1),
                 "the same for modes by their numbers, 1 the lowest flexible one; one above wf raises the largest "
                 "frequency, and shortens the time step, to its own");
  if (!filter.automatic && (accuracy_given || modes_given || band_given)) {
    throw InputError{std::string{"option "} +
                     (accuracy_given ? "-filter_accuracy" : (modes_given ? "-filter_modes" : "-filter_band")) +
                     " needs -filter_frequency auto"};
  }
  if (!filter.parameters.filtered() && filter.exact.any()) {
    throw InputError{
        "options -filter_correct_modes and -filter_correct_mode need a filter: -filter_frequency none and -ts_type "
        "modal have nothing to correct"};
  }
  if (modes_given && band_given) {
    throw InputError{
        "options -filter_modes and -filter_band exclude each other: give the number of modes that matter "
        "or the band they are in [rad/s]"};
  }
  group.integer("-filter_check_interval", filter.parameters.check_interval, petsc::non_negative(),
                "every so many line solves the residual is checked; 0: never");
  group.real("-filter_residual_tolerance", filter.parameters.residual_tolerance, "-", petsc::positive(),
             "largest backward error of a line solve that passes the check");
  PetscInt lanes = 0;
  group.integer("-filter_pc_chain_lanes", lanes, petsc::between(0.0, 8.0),
                "spans of line that the chain solver treats side by side in vector registers: 8, 4 or 1; 0: what "
                "the processor has");  // read by the preconditioner itself
  if (!given && !filter.modal && !petsc::Session::help_requested()) {
    throw InputError{"option -filter_frequency is required: a number > 0 [rad/s] or auto"};
  }
  return filter;
}

}  // namespace udar::app
