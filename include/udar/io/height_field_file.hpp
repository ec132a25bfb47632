#pragma once
/// @file
/// Heights over a grid that the user gives as a file.

#include <mpi.h>

#include <memory>
#include <string>

#include "udar/numerics/height_grid.hpp"

namespace udar::io {

/// @brief Reads heights over x and z [m], a table with the columns x, z, height and a row for each point of the grid in
/// any order (`read_table`), or an ESRI ASCII grid, whose first word is `ncols`.
///
/// Of the latter x is to the east and z to the south, so that y is up: its rows, from north to south, ascend in z, and
/// z = -y of its map. Heights belong to the middles of its cells; one that is NODATA_value is none. A row is a line.
/// @param[in] quantity what it is for, for the messages @param[in] path as in `read_table`
/// @note Collective. All ranks get all of it.
/// @throws FileError on all ranks, naming quantity, file and what is wrong where
[[nodiscard]] std::shared_ptr<const HeightGrid> read_height_field(MPI_Comm comm, const std::string& quantity,
                                                                  const std::string& path);

}  // namespace udar::io
