#pragma once
/// @file
/// SuiteSparse's CHOLMOD, started and ended with a scope.

#include <cholmod.h>

namespace udar {

/// @brief A CHOLMOD workspace that says nothing of its own accord.
class CholmodSession {
 public:
  CholmodSession() {
    cholmod_start(&common_);
    common_.print = 0;
  }
  CholmodSession(const CholmodSession&) = delete;
  CholmodSession& operator=(const CholmodSession&) = delete;
  ~CholmodSession() { cholmod_finish(&common_); }
  cholmod_common* get() noexcept { return &common_; }
  [[nodiscard]] int status() const noexcept { return common_.status; }

 private:
  cholmod_common common_{};
};

}  // namespace udar
