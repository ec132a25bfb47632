#include "udar/app/program.hpp"
#include "udar/app/run.hpp"
#include "udar/app/stop_signals.hpp"

namespace {

constexpr const char* kHelp =
    "udar: impact of elastic beams on rigid supports by the filter method\n"
    "\n"
    "usage:  udar case.yaml [-key value ...]\n"
    "        mpirun -n 4 udar case.yaml -filter_frequency 100 -output_directory run\n"
    "\n"
    "A beam with lumped masses falls on rigid supports. The masses are tied to the massless elastic line by springs "
    "of\n"
    "stiffness wf^2 m; every frequency of the model then lies below the filter frequency wf. Each mass meets the\n"
    "supports alone. Units are SI throughout. Every key below can stand in the case file (YAML) or on the command\n"
    "line, which wins. Integrator options start with -ts_ (default: -ts_type chebyshev where at most ten\n"
    "nodes can touch a support, else impact; -ts_type rk is -ts_rk_type 5dp), solver options with -filter_ksp_ and\n"
    "-filter_pc_.\n"
    "Each line reads: key <value now>, what it takes [unit], range; then what it means.\n"
    "-help support shows the keys with that word alone, -help ts and -help pc those of PETSc; -version who is who.\n"
    "Exit codes: 0 the run reached its end; 1 an error; 3 ended by -ts_max_steps; 4 ended by -wall_limit; 128 and its\n"
    "number: stopped by a signal.\n";

int run_case(MPI_Comm comm) {
  const udar::app::StopSignals signals;
  return udar::app::run(comm, {.stop_signal = udar::app::StopSignals::received}).exit_code;
}

}  // namespace

int main(int argc, char** argv) { return udar::app::guarded_main(argc, argv, kHelp, run_case); }
