#include "udar/app/progress_line.hpp"

#include <fcntl.h>
#include <petscsys.h>
#include <unistd.h>

#include <cstdio>
#include <string>

namespace udar::app {
namespace {

/// Whether somebody watches standard output. A launcher such as mpirun gives its ranks terminals of their own, none of
/// which controls them, even when its output goes to a file: there the launcher's own output counts, that of the parent
/// process of rank 0 on the same machine.
bool output_is_watched() {
  if (isatty(STDOUT_FILENO) == 0) {
    return false;
  }
  if (tcgetpgrp(STDOUT_FILENO) != -1) {
    return true;
  }
  const int parent = open(("/proc/" + std::to_string(getppid()) + "/fd/1").c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC);
  const bool watched = parent >= 0 && isatty(parent) != 0;
  if (parent >= 0) {
    close(parent);
  }
  return watched;
}

}  // namespace

ProgressLine::ProgressLine(MPI_Comm comm) : begin_{Clock::now()}, last_{begin_} {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  visible_ = rank == 0 && PETSC_STDOUT == stdout && output_is_watched();
}

void ProgressLine::step(const Progress& progress) {
  if (!visible_) {
    return;
  }
  using namespace std::chrono_literals;
  const Clock::time_point now = Clock::now();
  if (first_time_ < 0.0) {
    first_time_ = progress.time;
    begin_ = now;
  }
  if (now - last_ < 200ms) {
    return;
  }
  last_ = now;
  printed_ = true;
  const double done = progress.time - first_time_;
  const double elapsed = std::chrono::duration<double>(now - begin_).count();
  const double left = done > 0.0 ? elapsed * (progress.end_time - progress.time) / done : 0.0;
  std::printf("\r t %.5g / %.5g s  step %lld  impacts %lld  resting %lld  energy drift %+.1e  left %.0f s \033[K",
              progress.time, progress.end_time, static_cast<long long>(progress.steps),
              static_cast<long long>(progress.impacts), static_cast<long long>(progress.resting), progress.energy_drift,
              left);
  std::fflush(stdout);
}

void ProgressLine::finish() {
  if (printed_) {
    std::printf("\n");
    std::fflush(stdout);
    printed_ = false;
  }
}

}  // namespace udar::app
