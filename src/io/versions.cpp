#include "udar/io/versions.hpp"

#include <hdf5.h>
#include <metis.h>
#include <petscsys.h>
#include <slepcsys.h>

#include <array>

#include "udar/petsc/error.hpp"
#include "udar/version.hpp"
#include "udar_revision.hpp"

namespace udar::io {

std::map<std::string, std::string> library_versions() {
  const auto dotted = [](auto major, auto minor, auto patch) {
    return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch);
  };
  const std::string commit{kRevision};
  std::map<std::string, std::string> versions{{"udar", kVersion + (commit.empty() ? "" : " (git " + commit + ")")}};

  PetscInt petsc_major = 0;
  PetscInt petsc_minor = 0;
  PetscInt petsc_patch = 0;
  UDAR_CALL(PetscGetVersionNumber(&petsc_major, &petsc_minor, &petsc_patch, nullptr));
  versions["petsc"] = dotted(petsc_major, petsc_minor, petsc_patch);

  PetscInt slepc_major = 0;
  PetscInt slepc_minor = 0;
  PetscInt slepc_patch = 0;
  UDAR_CALL(SlepcGetVersionNumber(&slepc_major, &slepc_minor, &slepc_patch, nullptr));
  versions["slepc"] = dotted(slepc_major, slepc_minor, slepc_patch);

  versions["metis"] = dotted(METIS_VER_MAJOR, METIS_VER_MINOR, METIS_VER_SUBMINOR);

  unsigned hdf5_major = 0;
  unsigned hdf5_minor = 0;
  unsigned hdf5_patch = 0;
  H5get_libversion(&hdf5_major, &hdf5_minor, &hdf5_patch);
  versions["hdf5"] = dotted(hdf5_major, hdf5_minor, hdf5_patch);

  std::array<char, MPI_MAX_LIBRARY_VERSION_STRING> text{};
  int length = 0;
  MPI_Get_library_version(text.data(), &length);
  const std::string mpi{text.data()};
  versions["mpi"] = mpi.substr(0, mpi.find_first_of(",\n"));  // the rest says who packaged it
  return versions;
}

}  // namespace udar::io
