#include "udar/app/stop_signals.hpp"

#include <array>
#include <csignal>
#include <cstdint>
#include <ctime>

namespace udar::app {
namespace {

constexpr std::array kAskToStop{SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2};

volatile std::sig_atomic_t signal_received = 0;
volatile std::sig_atomic_t tenth_received = 0;  // of a second, of the monotonic clock, modulo what fits
// mpirun passes on what the terminal has sent already, and what it got twice.
constexpr std::sig_atomic_t kSameOne = 3;

std::sig_atomic_t now() noexcept {
  constexpr long kTenth = 100'000'000;
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);  // allowed in a handler
  return static_cast<std::sig_atomic_t>((10 * time.tv_sec + time.tv_nsec / kTenth) % SIG_ATOMIC_MAX);
}

extern "C" void remember_signal(int number) {
  if (signal_received == 0) {
    signal_received = number;
    tenth_received = now();
  } else if (now() - tenth_received > kSameOne) {
    std::signal(number, SIG_DFL);
    std::raise(number);  // pending until this returns
  }
}

}  // namespace

StopSignals::StopSignals() {
  signal_received = 0;
  struct sigaction remember{};
  remember.sa_handler = remember_signal;
  remember.sa_flags = SA_RESTART;
  sigemptyset(&remember.sa_mask);
  for (const int signal : kAskToStop) {
    struct sigaction before{};
    sigaction(signal, nullptr, &before);
    if (before.sa_handler != SIG_IGN) {
      sigaction(signal, &remember, nullptr);
      earlier_.push_back({.signal = signal, .action = before});
    }
  }
}

StopSignals::~StopSignals() {
  for (const Earlier& earlier : earlier_) {
    sigaction(earlier.signal, &earlier.action, nullptr);
  }
}

int StopSignals::received() noexcept { return signal_received; }

}  // namespace udar::app
