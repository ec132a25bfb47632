#pragma once
/// @file
/// The largest bending stress of a run.

#include <optional>

namespace udar::io {

/// @brief The largest value of a quantity over beam and time, and where and when it was.
struct Peak {
  double value = 0.0;
  double x = 0.0;     ///< [m] along the beam
  double time = 0.0;  ///< [s]
};

/// @brief What the moments of a run come to in the outermost fibres; empty where sections or yield stress are unknown.
struct BendingPeaks {
  std::optional<Peak> stress;       ///< |M| / W [Pa]
  std::optional<Peak> utilisation;  ///< of the yield stress [-]
};

}  // namespace udar::io
