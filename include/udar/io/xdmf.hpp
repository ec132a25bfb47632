#pragma once
/// @file
/// results.xdmf: how ParaView finds its way through results.h5.

#include <mpi.h>
#include <petscsys.h>

#include <memory>
#include <string>
#include <vector>

#include "udar/io/layout.hpp"

namespace udar::io {

class TextFile;

/// @brief The file results.xdmf: for each row of the fields the line, with all other fields, first those of the line,
/// then those of the masses. Points that move along y alone stand where the line is; else they stand at their places,
/// with a vector `displacement`. Where cells have one, there is their `radius`, of points and of cells, and of members
/// their number `member`. The numbers stay
/// in results.h5, of which it names the rows.
/// For ParaView's "XDMF Reader"; its Xdmf3 readers do not read rows of datasets and show nothing.
/// @note All calls are collective; rank 0 writes. The file is whole after each call.
/// @see https://www.xdmf.org/index.php/XDMF_Model_and_Format
class XdmfFile {
 public:
  /// @param[in] path    the file to create, or to go on in
  /// @param[in] results name of the HDF5 file in the same folder
  /// @param[in] points  file and path of an array of points, the structure's before others
  /// @throws FileError on all ranks
  XdmfFile(const RunLayout& layout, const std::string& path, std::string results, std::string points);
  ~XdmfFile();
  XdmfFile(const XdmfFile&) = delete;
  XdmfFile& operator=(const XdmfFile&) = delete;

  /// @brief Adds the next row, which must already be in the HDF5 file.
  /// @param[in] time of the row [s]
  /// @throws FileError on all ranks
  void append(double time);
  /// Brings all to the disk.
  void sync();
  /// Rows so far.
  [[nodiscard]] PetscInt rows() const noexcept { return rows_; }
  /// @brief Where the file stands, for who goes on in it.
  void save(MotionState& state) const;

 private:
  [[nodiscard]] std::string row_of(const FileField& field) const;
  [[nodiscard]] std::string attribute(const std::string& name, const FileField& field) const;
  [[nodiscard]] std::string constants() const;
  [[nodiscard]] std::string geometry(const FileField* height) const;

  std::unique_ptr<TextFile> file_;
  std::string results_;
  std::string points_;
  PetscInt nodes_;
  PetscInt cells_;
  Topology::Shape shape_;
  bool tubes_;
  bool members_;
  std::vector<FileField> fields_;  ///< those that have rows
  PetscInt rows_ = 0;
};

}  // namespace udar::io
