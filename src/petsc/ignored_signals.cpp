#include "udar/petsc/ignored_signals.hpp"

#include <array>
#include <csignal>
#include <cstddef>

namespace udar::petsc {
namespace {

constexpr std::array kSignals{SIGHUP, SIGINT, SIGPIPE, SIGTERM, SIGUSR1, SIGUSR2};

std::array<bool, kSignals.size()> ignored{};  // plain values, which need no constructor

}  // namespace

void note_ignored_signals() noexcept {
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    struct sigaction action{};
    ignored[i] = ignored[i] || (sigaction(kSignals[i], nullptr, &action) == 0 && action.sa_handler == SIG_IGN);
  }
}

void ignore_noted_signals() noexcept {
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    if (ignored[i]) {
      std::signal(kSignals[i], SIG_IGN);
    }
  }
}

}  // namespace udar::petsc
