#pragma once
/// @file
/// What writing and reading of HDF5 files share.

#include <petscsystypes.h>

#include <cstddef>

#include "udar/io/hdf5_file.hpp"

namespace udar::io {

/// HDF5 keeps attributes below 64 KiB.
constexpr std::size_t kAttributeBytesMax = 60000;

/// Text of a fixed length in UTF-8.
[[nodiscard]] Hdf5Id text_type(std::size_t length);

[[nodiscard]] inline hsize_t count_of(PetscInt value) { return static_cast<hsize_t>(value); }

}  // namespace udar::io
