#pragma once
/// @file
/// The largest values of a run.

#include <mpi.h>

#include <cstdint>
#include <map>
#include <string>

namespace udar::io {

/// @brief The largest value of a quantity over structure and time, and where and when it was.
struct Peak {
  double value = 0.0;
  /// @name Place where the structure stands unstrained [m]; along a beam x alone
  /// @{
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  /// @}
  double time = 0.0;         ///< [s]
  std::int64_t member = -1;  ///< of a network, in the user's numbers, that it is in; negative: none is known
};

/// @brief The largest of all ranks' peaks, the first rank's of equal ones. @note Collective.
[[nodiscard]] Peak largest_of_all(MPI_Comm comm, const Peak& own);

/// @brief By name: of fields with extremes by that of the field, "moment", and of what `RunLayout::peaks` lists, |M| /
/// W [Pa] as "stress". Those that are not known are left out.
using Peaks = std::map<std::string, Peak>;

}  // namespace udar::io
