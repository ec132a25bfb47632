#pragma once
/// @file
/// What all ranks learn from one sweep of the impact integrator.

#include <mpi.h>

#include <algorithm>
#include <array>
#include <cstddef>

namespace udar {

/// Bins of a step in which momentum is added up.
inline constexpr std::size_t kBins = 8;

/// @brief Maxima, then sums, then minima; reduced in one go.
struct Tally {
  enum Maximum : std::size_t { change, rate, kink, last_term, term_before, broken, speed, extent, maxima };
  std::array<double, maxima> most{};
  std::array<double, kBins> kick{};
  std::array<double, kBins> first{};

  Tally() { first.fill(2.0); }
};
static_assert(sizeof(Tally) == (Tally::maxima + 2 * kBins) * sizeof(double));

/// @brief The reduction of a tally over the ranks.
class TallyReduction {
 public:
  TallyReduction();
  TallyReduction(const TallyReduction&) = delete;
  TallyReduction& operator=(const TallyReduction&) = delete;
  ~TallyReduction();

  /// @note Collective: one reduction.
  void operator()(Tally& tally, MPI_Comm comm) const;

 private:
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
  MPI_Op op_ = MPI_OP_NULL;
};

}  // namespace udar
