#pragma once
/// @file
/// Forces over time that are given by a formula.

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "udar/structure/time_table.hpp"

namespace udar {

/// @brief What a law is, with t counted from its start.
enum class Course : std::uint8_t {
  harmonic,     ///< amplitude sin(2 pi (f t + (g - f) t^2 / (2 T)) + phase), swept from f to g over its time T
  random,       ///< sum of cosines with the variances that a one-sided power spectral density has, and random phases
  friedlander,  ///< amplitude (1 - t / duration) exp(-decay t / duration)
};

/// @brief A force over time by a formula: none before its start and after its end, where it may jump.
/// Source: docs/theory.md, "Loads by a formula"
struct TimeLaw {
  static constexpr double kNever = std::numeric_limits<double>::infinity();

  Course course = Course::harmonic;
  double start = 0.0;           ///< [s], >= 0
  double until = kNever;        ///< [s], > start
  double amplitude = 0.0;       ///< of harmonic; the peak of friedlander [N]
  double frequency = 0.0;       ///< of harmonic [Hz], > 0
  double last_frequency = 0.0;  ///< of harmonic at its end, which must be finite [Hz]; 0: that at its start
  double phase = 0.0;           ///< of harmonic [rad]
  double duration = 0.0;        ///< of the positive phase of friedlander [s], > 0
  double decay = 0.0;           ///< b of friedlander [-], >= 0
  std::vector<double> at{};     ///< of random: frequencies of the spectrum [Hz], >= 0, strictly ascending, at least two
  std::vector<double> density{};  ///< as many, linear between them, 0 outside [N^2/Hz], >= 0
  std::uint64_t seed = 1;         ///< of the phases of random
  double period = 0.0;            ///< after which random repeats itself: its lines are 1 / period apart [s], > 0
  double accuracy = 1e-4;         ///< largest error of the table, of the amplitude; of random both as root mean squares

  bool operator==(const TimeLaw&) const = default;
};

/// @brief A law as a table: rows at even times, linear between them, with the law's mean over every piece but for terms
/// of fourth order. Its rows up to a time do not depend on `end`.
/// @param end of the run: there are no more rows than needed up to it [s]
/// @note Cost of random: rows times lines.
/// @throws InputError if a number is out of range, or there were too many rows, before they are made
[[nodiscard]] std::shared_ptr<const TimeTable> law_table(const TimeLaw& law, double end);

}  // namespace udar
