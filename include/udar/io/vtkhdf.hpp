#pragma once
/// @file
/// results.vtkhdf: the rows of the fields as VTK reads them, the numbers left in results.h5.

#include <mpi.h>

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "udar/io/layout.hpp"

namespace udar::io {

/// @brief The file results.vtkhdf: an unstructured grid with time steps, of three parts: the line in its cells, the
/// masses as points, the supports as lines or points, of a structure in space as outlines of what they cover, of a
/// field of heights as lines along x and z. Points stand at their place, at height 0 if all of the structure move along
/// y, a support at its height; the point data `displacement` [m] moves them to where they are, and every field that has
/// rows is data of the points of its part, or of the cells of the line. Where cells have one, there is their `radius`
/// [m], of points and of cells, and of members their number `member`.
///
/// All fields are virtual datasets: HDF5 takes them from results.h5 in the same folder.
/// For the VTKHDF readers of VTK 9.3, ParaView 5.12 and later; earlier ones show the first row.
/// @note All calls are collective; rank 0 writes.
/// @see https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
class VtkHdfFile {
 public:
  /// @param[in] path    the file to write; not touched before `write`
  /// @param[in] results name of the HDF5 file in the same folder
  VtkHdfFile(const RunLayout& layout, std::string path, std::string results);

  /// @brief Writes the file anew; it appears whole or not at all.
  /// @param[in] times of all rows that are in results.h5 [s]
  /// @throws FileError on all ranks
  void write(std::span<const double> times) const;

 private:
  void place_supports(const RunLayout& layout, const Region& around);

  MPI_Comm comm_;
  std::string path_;
  std::string results_;
  PetscInt nodes_;
  PetscInt cells_;
  Topology::Shape shape_;
  bool upright_;
  bool tubes_;
  bool members_;
  std::array<std::string, 3> axes_;  ///< datasets of places along x, y, z; empty: zeros
  std::vector<FileField> fields_;
  std::vector<std::int64_t> support_sizes_;           ///< points of each
  std::vector<double> support_points_;                ///< x, y, z of all [m]
  std::vector<std::function<double(double)>> lifts_;  ///< of each support [m] at a time [s]; empty: it does not move
};

}  // namespace udar::io
