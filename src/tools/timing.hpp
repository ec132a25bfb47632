#pragma once
/// @file
/// Timing of things in turn, on all ranks at once.

#include <mpi.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

namespace udar::bench {

/// One thing to time: seconds of a call on the slowest rank, sample by sample.
struct Timed {
  std::function<void()> body;
  int calls = 1;  // in one sample
  std::vector<double>
      samples{};  // NOLINT(readability-redundant-member-init): else GCC warns of designated initializers

  [[nodiscard]] double best() const { return *std::ranges::min_element(samples); }
  [[nodiscard]] double worst() const { return *std::ranges::max_element(samples); }
  [[nodiscard]] double median() const {
    std::vector<double> sorted = samples;
    std::ranges::sort(sorted);
    const std::size_t half = sorted.size() / 2;
    return sorted.size() % 2 != 0 ? sorted[half] : 0.5 * (sorted[half - 1] + sorted[half]);
  }
};

/// CPU time that all ranks together have spent so far, start of the program included [s]. @note Collective.
[[nodiscard]] double cpu_seconds(MPI_Comm comm);

/// Takes samples of all in turn, so that they meet the same state of the machine.
/// @param shortest seconds of a sample: well above the clock's and the barrier's; where ranks share cores, above the
/// slices the kernel gives them
void sample(MPI_Comm comm, const std::vector<Timed*>& all, long repeats, double shortest = 2e-5);

/// a = b + s c over vectors of the given length on every rank: 24 bytes a number (reading a before it is overwritten is
/// not counted, as in STREAM).
struct Triad {
  std::vector<double> a, b, c;
  Timed timed;

  explicit Triad(std::size_t length) : a(length), b(length, 1.0), c(length, 2.0) {
    timed.body = [this] {
      const double s = a[0];
      for (std::size_t i = 0; i < a.size(); ++i) {
        a[i] = b[i] + s * c[i];
      }
    };
  }
  Triad(const Triad&) = delete;
  Triad& operator=(const Triad&) = delete;
  ~Triad() = default;

  /// Bytes that all ranks move in one call.
  [[nodiscard]] double bytes(MPI_Comm comm) const {
    double bytes = 24.0 * static_cast<double>(a.size());
    MPI_Allreduce(MPI_IN_PLACE, &bytes, 1, MPI_DOUBLE, MPI_SUM, comm);
    return bytes;
  }
  [[nodiscard]] double bandwidth(MPI_Comm comm) const { return bytes(comm) / timed.best(); }
};

}  // namespace udar::bench
