#pragma once
/// @file
/// Signals that ask a run to end in order.

#include <csignal>
#include <vector>

namespace udar::app {

/// @brief While one of these lives, SIGINT, SIGTERM, SIGHUP (a closed terminal), SIGUSR1 and SIGUSR2 (a batch system's
/// warnings) are remembered instead of ending the process.
///
/// One that the process was started to ignore, as `nohup` does with SIGHUP, stays ignored. Within a second a signal may
/// come several times, from the shell and from the terminal; a later one ends the process at once.
/// They may be nested: the outermost takes the signals and gives back what was there before.
class StopSignals {
 public:
  StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;
  ~StopSignals();

  /// The one that came first to this process, 0 for none.
  [[nodiscard]] static int received() noexcept;

 private:
  struct Earlier {
    int signal;
    struct sigaction action;
  };
  std::vector<Earlier> earlier_;
};

}  // namespace udar::app
