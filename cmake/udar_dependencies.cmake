# What udar links: MPI, PETSc (real, double), SLEPc, parallel HDF5, METIS, CHOLMOD, LAPACK, zlib, yaml-cpp,
# nlohmann_json and Boost's headers.
# All headers are SYSTEM.
include(CheckCSourceCompiles)

find_package(MPI REQUIRED COMPONENTS C)
find_package(PkgConfig REQUIRED)

# PETSC_DIR with PETSC_ARCH and SLEPC_DIR, of cmake or of the environment, name installations of one's own; without them
# pkg-config finds the system's. The installed package looks in the same places.
set(PETSC_ARCH "$ENV{PETSC_ARCH}" CACHE STRING "Subfolder of PETSC_DIR and SLEPC_DIR that holds the build, or empty")
set(UDAR_PKG_CONFIG_PATH "")
foreach(package PETSC:PETSc SLEPC:slepc)
  string(REGEX MATCH "(.*):(.*)" package ${package})
  set(variable ${CMAKE_MATCH_1}_DIR)
  set(file lib/pkgconfig/${CMAKE_MATCH_2}.pc)
  set(${variable} "$ENV{${variable}}" CACHE PATH "Installation with ${file}; empty: the system's")
  if(${variable})
    find_path(prefix ${file} PATHS ${${variable}}/${PETSC_ARCH} ${${variable}} NO_DEFAULT_PATH NO_CACHE)
    if(NOT prefix)
      message(FATAL_ERROR "${variable}: no ${file} in '${${variable}}' with PETSC_ARCH '${PETSC_ARCH}'")
    endif()
    cmake_path(APPEND prefix lib/pkgconfig)
    list(APPEND UDAR_PKG_CONFIG_PATH ${prefix})
    unset(prefix)
  endif()
endforeach()
if(NOT DEFINED UDAR_CONFIGURED_FOR)
  set(UDAR_CONFIGURED_FOR "${UDAR_PKG_CONFIG_PATH}" CACHE INTERNAL "UDAR_PKG_CONFIG_PATH of the first configuration")
endif()
if(NOT UDAR_CONFIGURED_FOR STREQUAL UDAR_PKG_CONFIG_PATH)
  message(FATAL_ERROR "this build folder was configured for another PETSC_DIR, PETSC_ARCH or SLEPC_DIR: "
                      "run cmake --fresh, or take another folder")
endif()
foreach(folder IN LISTS UDAR_PKG_CONFIG_PATH)
  set(ENV{PKG_CONFIG_PATH} "${folder}:$ENV{PKG_CONFIG_PATH}")
endforeach()

pkg_check_modules(UDAR_PETSC REQUIRED IMPORTED_TARGET PETSc>=3.18)
pkg_check_modules(UDAR_SLEPC REQUIRED IMPORTED_TARGET slepc>=3.18)
pkg_check_modules(UDAR_YAML REQUIRED IMPORTED_TARGET yaml-cpp>=0.6)
pkg_search_module(UDAR_HDF5 REQUIRED IMPORTED_TARGET hdf5-openmpi hdf5-mpich hdf5)
foreach(package UDAR_PETSC UDAR_SLEPC UDAR_HDF5)
  # Debian's .pc files carry the package's own build flags, among them _FORTIFY_SOURCE, which needs optimisation.
  set_property(TARGET PkgConfig::${package} PROPERTY INTERFACE_COMPILE_OPTIONS "")
endforeach()

find_package(nlohmann_json 3.10 REQUIRED)
find_package(LAPACK REQUIRED)
find_package(ZLIB REQUIRED)
find_package(Boost 1.74 REQUIRED CONFIG)

find_path(UDAR_METIS_INCLUDE_DIR metis.h)
find_library(UDAR_METIS_LIBRARY metis)
mark_as_advanced(UDAR_METIS_INCLUDE_DIR UDAR_METIS_LIBRARY)
if(NOT UDAR_METIS_INCLUDE_DIR OR NOT UDAR_METIS_LIBRARY)
  message(FATAL_ERROR "METIS not found (Debian: libmetis-dev); set UDAR_METIS_INCLUDE_DIR and UDAR_METIS_LIBRARY")
endif()
add_library(udar_metis INTERFACE)
target_include_directories(udar_metis SYSTEM INTERFACE ${UDAR_METIS_INCLUDE_DIR})
target_link_libraries(udar_metis INTERFACE ${UDAR_METIS_LIBRARY})

find_path(UDAR_CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse)
find_library(UDAR_CHOLMOD_LIBRARY cholmod)
mark_as_advanced(UDAR_CHOLMOD_INCLUDE_DIR UDAR_CHOLMOD_LIBRARY)
if(NOT UDAR_CHOLMOD_INCLUDE_DIR OR NOT UDAR_CHOLMOD_LIBRARY)
  message(FATAL_ERROR "CHOLMOD not found (Debian: libsuitesparse-dev); set UDAR_CHOLMOD_INCLUDE_DIR and "
                      "UDAR_CHOLMOD_LIBRARY")
endif()
# What draws and what tests are written in: the first python3 that has the modules, of the PATH or the system's.
function(udar_has_modules result interpreter)
  execute_process(COMMAND ${interpreter} -c "import h5py, jinja2, matplotlib" RESULT_VARIABLE code OUTPUT_QUIET
                                                                              ERROR_QUIET)
  if(NOT code EQUAL 0)
    set(${result} FALSE PARENT_SCOPE)
  endif()
endfunction()
find_program(UDAR_PYTHON python3 VALIDATOR udar_has_modules DOC "Python with h5py, jinja2 and matplotlib")
mark_as_advanced(UDAR_PYTHON)

# udar_require(VARIABLE SOURCE MESSAGE INCLUDES...): a configure error unless SOURCE compiles.
function(udar_require variable source message)
  set(CMAKE_REQUIRED_INCLUDES ${ARGN})
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
  ${UDAR_HDF5_INCLUDE_DIRS} ${MPI_C_INCLUDE_DIRS})
udar_require(
  UDAR_PETSC_IS_REAL
  "#include <petscsys.h>\n#if defined(PETSC_USE_COMPLEX) || !defined(PETSC_USE_REAL_DOUBLE)\n#error scalar\n#endif\n"
  "udar needs a PETSc built for real double scalars (Debian: libpetsc-real-dev); "
    "found another: ${UDAR_PETSC_INCLUDE_DIRS}"
  ${UDAR_PETSC_INCLUDE_DIRS} ${MPI_C_INCLUDE_DIRS})
