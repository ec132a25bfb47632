#pragma once
/// @file
/// Networks of members from files.

#include <mpi.h>

#include <functional>
#include <string>

#include "udar/structure/network.hpp"

namespace udar::io {

/// Judges a network by its size, before anything is made that grows with its elements; throws on all ranks.
using AcceptSize = std::function<void(const NetworkParameters&)>;

/// @brief Reads a network.
/// @param file   YAML: sections, junctions, members and groups, or sections, groups and the name of a mesh; or, if its
/// name ends in `.msh`, a Gmsh mesh of lines
/// @param groups YAML with sections and groups of such a mesh; else empty
/// Relative paths are looked for from the working directory, then beside the file that names them, then beside the
/// options files. What keys there are, and what they mean: docs/networks.md
/// @note Collective; rank 0 reads, all get the network. @throws FileError if a file cannot be read, InputError naming
/// file, line and column, and what is wrong there, on all ranks. Geometry is judged by `Network`.
[[nodiscard]] NetworkParameters read_network(MPI_Comm comm, const std::string& file, const std::string& groups,
                                             const AcceptSize& accept = {});

}  // namespace udar::io
