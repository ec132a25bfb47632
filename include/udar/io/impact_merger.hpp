#pragma once
/// @file
/// Many impacts of a mass in a short time as one.

#include <mpi.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "udar/motion/motion_state.hpp"
#include "udar/motion/observer.hpp"

namespace udar::io {

/// @brief The impacts of one node on one support that come less than a window after the first of them.
struct MergedImpact {
  double time = 0.0;         ///< of the first [s]
  double last_time = 0.0;    ///< [s]
  PetscInt node = 0;         ///< as in `ImpactRecord`
  double x = 0.0;            ///< [m]
  PetscInt support = 0;      ///< as in `ImpactRecord`
  PetscInt impacts = 0;      ///< how many
  double speed_max = 0.0;    ///< largest size of `velocity_before` [m/s]
  double impulse = 0.0;      ///< sum, in order of time [N s], y up
  double energy_loss = 0.0;  ///< the same [J]
};

/// @brief Merges the impacts of this rank's masses as they come. It holds those of one window, not of the run: at most
/// one entry a mass and support, and what nobody has taken yet.
class ImpactMerger {
 public:
  /// @param first, points this rank's points: `first` is the global number of the first @param window > 0 [s]
  ImpactMerger(PetscInt first, std::size_t points, double window);

  /// @param[in] impacts those of a node in order of time, none before one that was given earlier
  void add(std::span<const ImpactRecord> impacts);
  /// How many wait, ready or not.
  [[nodiscard]] std::size_t size() const noexcept { return entries_.size(); }
  /// Time of the latest impact so far [s]; minus infinity without.
  [[nodiscard]] double latest() const noexcept { return latest_; }
  /// @brief Those that no impact from `time` on can join, in order of time, then node: no later call gives an earlier
  /// one. @param[in] time [s]; infinity: all
  [[nodiscard]] std::vector<MergedImpact> take(double time);

  /// @name What waits, as values of points @note Collective.
  /// @{
  void save(MPI_Comm comm, MotionState& state) const;
  void restore(const MotionState& state);
  /// @}

 private:
  struct Entry : MergedImpact {
    std::int64_t before = kNone;  ///< the entry of the same point that is next older
  };
  static constexpr std::int64_t kNone = -1;

  [[nodiscard]] std::size_t point_of(const MergedImpact& entry) const {
    return static_cast<std::size_t>(entry.node - first_);
  }
  void push(const MergedImpact& entry);

  PetscInt first_;
  double window_;
  double latest_ = -std::numeric_limits<double>::infinity();
  std::vector<Entry> entries_;        ///< in the order in which they began, of each point
  std::vector<std::int64_t> newest_;  ///< of each point, in `entries_`
};

}  // namespace udar::io
