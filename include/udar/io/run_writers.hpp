#pragma once
/// @file
/// The observers that write a run's files.

#include <memory>
#include <string>
#include <vector>

#include "udar/io/layout.hpp"
#include "udar/io/peaks.hpp"
#include "udar/io/support_forces.hpp"
#include "udar/motion/observer.hpp"

namespace udar::io {

/// @brief Time between samples of extremes [s]: the interval of the rows, or where that is longer than `longest`, the
/// largest part of it that is not. @param longest 0: rows will do
[[nodiscard]] double sampling_interval(double interval, double longest);

/// @brief Creates gauges.csv, energy.csv, impacts.csv, rests.csv, contact.csv, results.h5 and results.xdmf and returns
/// who fills them; the last row also makes envelope.csv, for beams of up to 100 000 nodes.
///
/// Tables reach the disk after 1, 2, 4, ... rows at first and every 256 rows later, events also when 65 536 of them
/// wait; fields, and all of results.h5, within about a second. `flush` brings the rest to the disk, the last `finish`
/// closes results.h5. A run that is killed leaves readable files that lack at most what came after the last of these.
/// @param[in] layout         what is written about; `layout.comm` must outlive the observers
/// @param[in] directory      made ready by `prepare_run_directory`
/// @param[in] interval       `-output_interval`, simulated time between rows of the tables [s], above 0
/// @param[in] field_interval `-output_field_interval`, between rows of the fields [s]; 0 for no fields and no
///                           results.xdmf
/// @param[in,out] forces     of the supports, made of the snapshots; must outlive the observers. Null: no contact.csv
/// @param[out] peaks         what the envelope comes to, known after `finish`; must outlive the observers, may be null
/// @return the observers; in any order, the same on every rank
/// @note Collective, as all calls of the observers. The spans of a snapshot must have one value per node of the rank.
/// @throws FileError on all ranks
/// @see docs/output.md
[[nodiscard]] std::vector<std::unique_ptr<Observer>> make_run_writers(const RunLayout& layout,
                                                                      const std::string& directory, double interval,
                                                                      double field_interval,
                                                                      SupportForces* forces = nullptr,
                                                                      Peaks* peaks = nullptr);

}  // namespace udar::io
