#pragma once
/// @file
/// How much a run is going to write.

#include "udar/app/case.hpp"

namespace udar::app {

/// @brief Rows and bytes of a whole run, events and checkpoints left out: nobody knows before how many there will be.
struct OutputSize {
  double rows = 0.0;        ///< of each of gauges.csv, energy.csv and contact.csv
  double field_rows = 0.0;  ///< of the fields in results.h5
  double bytes = 0.0;       ///< of all files, from above
};

[[nodiscard]] OutputSize output_size(const Case& input);

/// @brief Refuses what was hardly meant: more than 10^6 rows or 10 GB, unless the case says `-output_allow_large`; more
/// rows than are counted in any case.
/// @throws InputError naming option, rows, bytes and a way out
void refuse_large_output(const Case& input);

}  // namespace udar::app
