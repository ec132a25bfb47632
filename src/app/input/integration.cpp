#include <cmath>
#include <limits>

#include "app/input/readers.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/session.hpp"

namespace udar::app {
namespace {

using petsc::OptionGroup;

/// The longest step, at most `wished`, that divides the interval between rows and the end of the run, if such a one
/// exists without many steps for every row, else the end alone.
double even_step(double wished, double interval, double end) {
  constexpr double kWhole = 1e-9;  // far from an integer by less: decimal fractions that rounding has touched
  constexpr int kMany = 20;
  double whole = end;
  for (int parts = kMany; parts > 0; --parts) {
    const double rows = end / interval * parts;
    whole = std::abs(rows - std::round(rows)) < kWhole * rows ? interval / parts : whole;
  }
  return whole / std::ceil(whole / wished * (1.0 - kWhole));
}

}  // namespace

/// The keys of PETSc's TS that every case needs: checked and explained here, read by the TS itself.
void read_integration(MPI_Comm comm, Case& input) {
  OptionGroup group{comm, "Integration (PETSc's TS; all of its keys apply)"};
  double& end = input.end_time;
  double rtol = 1e-8;
  double atol = 0.0;
  double step = 0.0;
  group.real("-ts_max_time", end, "s", petsc::positive(), "simulated time at which the run ends");
  group.real("-ts_rtol", rtol, "-", petsc::at_least(std::numeric_limits<double>::epsilon()),
             "relative error allowed per step; default 1e-14 for -ts_type chebyshev, 1e-7 for impact, else 1e-8");
  group.real("-ts_atol", atol, "m and m/s", petsc::positive(),
             "absolute error allowed per step; default rtol / 20 of the motion's own scale, for chebyshev and impact "
             "none besides rtol of it");
  const bool step_given = group.real("-ts_dt", step, "s", petsc::positive(),
                                     "first step, or every step with -ts_adapt_type none; default 0.1 / wf; for "
                                     "-ts_type moreau every step, shortened to divide -output_interval and the end");
  if (input.filter.unfiltered) {
    if (!step_given && !petsc::Session::help_requested()) {
      throw InputError{"option -ts_dt is required with -filter_frequency none: a number > 0 [s]"};
    }
    input.filter.filter_frequency = 2.0 / even_step(step, input.output.interval, end);
  }
}

}  // namespace udar::app
