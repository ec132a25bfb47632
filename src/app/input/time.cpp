#include <limits>

#include "app/input/readers.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/session.hpp"

namespace udar::app {

using petsc::OptionGroup;

/// The keys of PETSc's TS that every case needs: checked and explained here, read by the TS itself.
TimeInput read_time(MPI_Comm comm, bool step_needed) {
  OptionGroup group{comm, "Integration (PETSc's TS; all of its keys apply)"};
  TimeInput input;
  double rtol = 1e-8;
  double atol = 0.0;
  group.real("-ts_max_time", input.end, "s", petsc::positive(), "simulated time at which the run ends");
  group.real("-ts_rtol", rtol, "-", petsc::at_least(std::numeric_limits<double>::epsilon()),
             "relative error allowed per step; default 1e-14 for -ts_type chebyshev, 1e-7 for impact, else 1e-8");
  group.real("-ts_atol", atol, "m and m/s", petsc::positive(),
             "absolute error allowed per step; default rtol / 20 of the motion's own scale, for chebyshev and impact "
             "none besides rtol of it");
  const bool step_given = group.real("-ts_dt", input.step, "s", petsc::positive(),
                                     "first step, or every step with -ts_adapt_type none; default 0.1 / wf; for "
                                     "-ts_type moreau every step, shortened to divide -output_interval and the end");
  if (step_needed && !step_given && !petsc::Session::help_requested()) {
    throw InputError{"option -ts_dt is required with -filter_frequency none: a number > 0 [s]"};
  }
  return input;
}

}  // namespace udar::app
