#pragma once
/// @file
/// Scoped access to the local values of a `Vec`.

#include <petscvec.h>

#include "udar/petsc/error.hpp"

namespace udar::petsc {

/// @brief Local values of a `Vec` for reading.
class ReadArray {
 public:
  explicit ReadArray(Vec vector) : vector_{vector} { UDAR_CALL(VecGetArrayRead(vector_, &values_)); }
  ReadArray(const ReadArray&) = delete;
  ReadArray& operator=(const ReadArray&) = delete;
  ~ReadArray() { VecRestoreArrayRead(vector_, &values_); }
  [[nodiscard]] const double* values() const noexcept { return values_; }

 private:
  Vec vector_;
  const double* values_ = nullptr;
};

/// @brief Local values of a `Vec` for reading and writing.
class WriteArray {
 public:
  explicit WriteArray(Vec vector) : vector_{vector} { UDAR_CALL(VecGetArray(vector_, &values_)); }
  WriteArray(const WriteArray&) = delete;
  WriteArray& operator=(const WriteArray&) = delete;
  ~WriteArray() { VecRestoreArray(vector_, &values_); }
  [[nodiscard]] double* values() const noexcept { return values_; }

 private:
  Vec vector_;
  double* values_ = nullptr;
};

}  // namespace udar::petsc
