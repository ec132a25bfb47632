#pragma once
/// @file
/// When loads and supports change their course.

#include <vector>

#include "udar/contact/support.hpp"
#include "udar/structure/load.hpp"

namespace udar {

/// How far two times may differ and still be the same instant [s].
[[nodiscard]] double time_resolution(double time);

/// @brief The times at which a load or a moving support of the whole structure has a kink; equal on every rank.
class Kinks {
 public:
  Kinks(const Loads& loads, const std::vector<Support>& supports);

  /// The first of them after a time [s]; infinite: none.
  [[nodiscard]] double after(double time) const;
  /// @brief Since when everything goes as it does just before a time in a step [s].
  /// @param step_begin of the step [s]: no earlier kink counts
  [[nodiscard]] double piece_begin(double step_begin, double time) const;

 private:
  std::vector<double> times_;  // ascending [s]
};

}  // namespace udar
