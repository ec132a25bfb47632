#pragma once
/// @file
/// The largest values of a run.

#include <map>
#include <string>

namespace udar::io {

/// @brief The largest value of a quantity over structure and time, and where and when it was.
struct Peak {
  double value = 0.0;
  double x = 0.0;     ///< [m] along the beam
  double time = 0.0;  ///< [s]
};

/// @brief By name, as `RunLayout::peaks` lists them: |M| / W [Pa] as "stress". Those that are not known are left out.
using Peaks = std::map<std::string, Peak>;

}  // namespace udar::io
