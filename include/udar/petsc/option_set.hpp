#pragma once
/// @file
/// Options of one case beside those of the process.

#include <petscsys.h>

#include "udar/petsc/option_sources.hpp"

namespace udar::petsc {

/// @brief A database of options of its own, for programs that have several cases at a time, or options of their own.
/// @note Not collective.
class OptionSet {
 public:
  OptionSet();
  OptionSet(const OptionSet&) = delete;
  OptionSet& operator=(const OptionSet&) = delete;
  ~OptionSet();

  /// @brief While it lives everything that reads or sets options takes this set, and nothing of what was in force
  /// before. One at a time of a set.
  class InForce {
   public:
    explicit InForce(OptionSet& set);
    InForce(const InForce&) = delete;
    InForce& operator=(const InForce&) = delete;
    ~InForce();

   private:
    OptionSet* set_;
  };

 private:
  PetscOptions options_ = nullptr;
  OptionOrigins origins_;
};

}  // namespace udar::petsc
