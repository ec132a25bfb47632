#pragma once
/// @file
/// What runs of a study came to, kept run by run, so that a study that was stopped or killed goes on.

#include <mpi.h>

#include <cstddef>
#include <map>
#include <span>
#include <string>

#include "tools/study_runs.hpp"

namespace udar::study {

/// @brief Finished runs of a folder, by all options that they ran with but for where they wrote.
class FinishedRuns {
 public:
  /// @param folder of the study @param group who adds to it: groups have files of their own
  FinishedRuns(std::string folder, int group) : folder_{std::move(folder)}, group_{group} {}

  /// Forgets what an earlier study left. Of one rank.
  void clear() const;
  /// What earlier programs have kept of these runs, by their numbers; a line that was cut short counts as none.
  /// @note Collective: read by the first rank.
  [[nodiscard]] std::map<std::size_t, Outcome> among(MPI_Comm comm, std::span<const PlannedRun> runs) const;
  /// Keeps one, at once. Of one rank of the group. @throws FileError
  void add(const PlannedRun& run, const Outcome& outcome) const;

 private:
  std::string folder_;
  int group_;
};

}  // namespace udar::study
