#pragma once
/// @file
/// Standard output for one thing alone.

#include <petscsys.h>

#include <cstdio>

namespace udar::petsc {

/// @brief As long as it lives, what PETSc and udar print goes to standard error, if that is asked for.
class DivertedText {
 public:
  explicit DivertedText(bool divert) : before_{PETSC_STDOUT} {
    if (divert) {
      PETSC_STDOUT = stderr;
    }
  }
  DivertedText(const DivertedText&) = delete;
  DivertedText& operator=(const DivertedText&) = delete;
  ~DivertedText() { PETSC_STDOUT = before_; }

 private:
  FILE* before_;
};

}  // namespace udar::petsc
