#pragma once
/// @file
/// Which libraries computed a result.

#include <map>
#include <string>

namespace udar::io {

/// @brief Versions of `udar`, `petsc`, `hdf5` and `mpi` in use, as each reports its own at run time.
[[nodiscard]] std::map<std::string, std::string> library_versions();

}  // namespace udar::io
