#pragma once
/// @file
/// results.xdmf: how ParaView finds its way through results.h5.

#include <mpi.h>
#include <petscsys.h>

#include <memory>
#include <string>

namespace udar::io {

class TextFile;

/// @brief The file results.xdmf: for each row of the fields the beam line as a polyline, with moment, mass position,
/// mass velocity and resting on its nodes. The numbers stay in results.h5, of which it names the rows.
/// For ParaView's "XDMF Reader"; its Xdmf3 readers do not read rows of datasets and show nothing.
/// @note All calls are collective; rank 0 writes. The file is whole after each call.
/// @see https://www.xdmf.org/index.php/XDMF_Model_and_Format
class XdmfFile {
 public:
  /// @param[in] path    the file to create
  /// @param[in] results name of the HDF5 file in the same folder
  /// @param[in] points  file and path of an array of points in the plane z = 0, at least as many as nodes
  /// @param[in] nodes   over all ranks
  /// @throws FileError on all ranks
  XdmfFile(MPI_Comm comm, const std::string& path, std::string results, std::string points, PetscInt nodes);
  ~XdmfFile();
  XdmfFile(const XdmfFile&) = delete;
  XdmfFile& operator=(const XdmfFile&) = delete;

  /// @brief Adds the next row, which must already be in the HDF5 file.
  /// @param[in] time of the row [s]
  /// @throws FileError on all ranks
  void append(double time);

 private:
  std::unique_ptr<TextFile> file_;
  std::string results_;
  std::string zeros_;
  PetscInt nodes_;
  PetscInt rows_ = 0;
};

}  // namespace udar::io
