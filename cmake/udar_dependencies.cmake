# What udar links: MPI, PETSc (real, double), SLEPc, parallel HDF5, METIS, LAPACK, zlib, nlohmann_json.
# All headers are SYSTEM.
include(CheckCSourceCompiles)

find_package(MPI REQUIRED COMPONENTS C)
find_package(PkgConfig REQUIRED)
pkg_check_modules(UDAR_PETSC REQUIRED IMPORTED_TARGET PETSc>=3.18)
pkg_check_modules(UDAR_SLEPC REQUIRED IMPORTED_TARGET slepc>=3.18)
pkg_search_module(UDAR_HDF5 REQUIRED IMPORTED_TARGET hdf5-openmpi hdf5-mpich hdf5)
foreach(package UDAR_PETSC UDAR_SLEPC UDAR_HDF5)
  # Debian's .pc files carry the package's own build flags, among them _FORTIFY_SOURCE, which needs optimisation.
  set_property(TARGET PkgConfig::${package} PROPERTY INTERFACE_COMPILE_OPTIONS "")
endforeach()

find_package(nlohmann_json 3.10 REQUIRED)
find_package(LAPACK REQUIRED)
find_package(ZLIB REQUIRED)

find_path(UDAR_METIS_INCLUDE_DIR metis.h)
find_library(UDAR_METIS_LIBRARY metis)
mark_as_advanced(UDAR_METIS_INCLUDE_DIR UDAR_METIS_LIBRARY)
if(NOT UDAR_METIS_INCLUDE_DIR OR NOT UDAR_METIS_LIBRARY)
  message(FATAL_ERROR "METIS not found (Debian: libmetis-dev); set UDAR_METIS_INCLUDE_DIR and UDAR_METIS_LIBRARY")
endif()
add_library(udar_metis INTERFACE)
target_include_directories(udar_metis SYSTEM INTERFACE ${UDAR_METIS_INCLUDE_DIR})
target_link_libraries(udar_metis INTERFACE ${UDAR_METIS_LIBRARY})

# udar_require(VARIABLE SOURCE MESSAGE LIBRARIES...): a configure error unless SOURCE compiles.
function(udar_require variable source message)
  set(CMAKE_REQUIRED_LIBRARIES ${ARGN})
  set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
  set(CMAKE_REQUIRED_QUIET ON)
  check_c_source_compiles("${source}" ${variable})
  if(NOT ${variable})
    unset(${variable} CACHE)
    message(FATAL_ERROR "${message}")
  endif()
endfunction()
udar_require(
  UDAR_HDF5_IS_PARALLEL
  "#include <hdf5.h>\n#ifndef H5_HAVE_PARALLEL\n#error serial\n#endif\n"
  "udar writes results from all ranks and needs a parallel HDF5 (Debian: libhdf5-openmpi-dev); "
    "found a serial one: ${UDAR_HDF5_INCLUDE_DIRS}"
  PkgConfig::UDAR_HDF5 MPI::MPI_C)
udar_require(
  UDAR_PETSC_IS_REAL
  "#include <petscsys.h>\n#if defined(PETSC_USE_COMPLEX) || !defined(PETSC_USE_REAL_DOUBLE)\n#error scalar\n#endif\n"
  "udar needs a PETSc built for real double scalars (Debian: libpetsc-real-dev); "
    "found another: ${UDAR_PETSC_INCLUDE_DIRS}"
  PkgConfig::UDAR_PETSC MPI::MPI_C)
