#include "app/monitor_table.hpp"

#include <petscsys.h>

#include <cstdio>
#include <numeric>

#include "udar/petsc/error.hpp"

namespace udar::app {

void MonitorTable::snapshot(const Snapshot& state) {
  if (!headed_) {
    UDAR_CALL(PetscPrintf(comm_, "#%11s %12s %12s %14s %12s %15s %8s\n", "time [s]", "kinetic [J]", "strain [J]",
                          "potential [J]", "lost [J]", "supports [N s]", "drift"));
    headed_ = true;
  }
  const EnergyLedger& energy = state.energy;
  UDAR_CALL(PetscPrintf(comm_, "%12.6g %12.5g %12.5g %14.5g %12.5g %15.6g %8.0e\n", state.time, energy.kinetic,
                        energy.line_strain + energy.fictitious_springs + energy.support_springs,
                        energy.load_potential - energy.initial_potential,
                        energy.lost_in_impacts + energy.lost_in_dampers + energy.lost_in_hinges + energy.radiated,
                        std::reduce(state.support_impulse.begin(), state.support_impulse.end() - inner_),
                        energy.drift()));
  std::fflush(PETSC_STDOUT);
}

}  // namespace udar::app
