#pragma once
/// @file
/// First zeros of what the series of a motion tell.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include "udar/integrators/free_motion.hpp"
#include "udar/motion/kinks.hpp"
#include "udar/numerics/roots.hpp"
#include "udar/numerics/step_polynomial.hpp"

namespace udar {

/// @brief Where the series are summed, in units of 1 / (highest frequency): coarse points tell whether something comes
/// near zero, and where it does, a quintic through fine points is off by less than 1e-10 of its rate in these units
/// (docs/theory.md).
inline constexpr double kCoarse = 0.5;
inline constexpr std::size_t kFine = 4;

/// @brief Weights of displacement, velocity and acceleration at one time of the search.
struct SeriesSample {
  double time = 0.0;  ///< since the start of the step [s]
  std::array<FreeMotion::Weights, 3> weights;
};

/// When a value would turn negative if its second derivative stayed [s]; infinite: never.
[[nodiscard]] double guessed_closing(const Kinematics& start);
/// @brief Whether a value could reach zero between two samples that resolve it: it changes by less than twice the
/// larger end rate times their distance.
[[nodiscard]] bool comes_near(const Kinematics& start, const Kinematics& end, double length);

[[nodiscard]] SeriesSample sample(const FreeMotion& motion, double time);
/// Samples at the borders of `count` equal parts of the time between two.
[[nodiscard]] std::vector<SeriesSample> samples_between(const FreeMotion& motion, double from, double to,
                                                        std::size_t count);
/// Parts of a time so long, `density` of them for each unit of 1 / `frequency`; a rigid motion needs no more than few.
[[nodiscard]] std::size_t parts_of(const FreeMotion& motion, double length, double density);

/// @brief Newton's method for the time at which a falling value is zero, kept between two times.
/// @param value of a sample: the value and its rate @param resolution of times [s]
template <class Value>
[[nodiscard]] double polished(const FreeMotion& motion, double time, double from, double to, double resolution,
                              const Value& value) {
  constexpr int kNewtonSteps = 20;
  for (int i = 0; i < kNewtonSteps && time > 0.0; ++i) {
    const auto [now, slope] = value(sample(motion, time));
    if (!(slope < 0.0)) {
      break;
    }
    const double next = std::clamp(time - now / slope, from, to);
    const double change = std::abs(next - time);
    time = next;
    if (change <= resolution || change <= 1e-15 * time) {
      break;
    }
  }
  return time;
}

/// @brief When a value turns negative first between two samples, if it does. One that begins the step at zero and does
/// not fall there has a root at the start, which is divided out.
/// @param value of a sample: the value, its rate and its second derivative @param resolution of times [s]
template <class Value>
[[nodiscard]] std::optional<double> first_closing(const FreeMotion& motion, const SeriesSample& from,
                                                  const SeriesSample& to, double resolution, const Value& value) {
  Kinematics start = value(from);
  int touching = 0;
  if (from.time == 0.0 && start.position <= 0.0 && start.velocity >= 0.0) {
    start.position = 0.0;
    touching = 1;
    if (start.velocity == 0.0) {
      start.acceleration = std::max(start.acceleration, 0.0);  // just released: zero but for round-off
      touching = 2;
    }
  }
  const double length = to.time - from.time;
  const auto theta = first_closing(StepPolynomial{start, value(to), length}.bernstein(), touching);
  if (!theta) {
    return std::nullopt;
  }
  return polished(motion, from.time + *theta * length, from.time, to.time, resolution, [&](const SeriesSample& at) {
    const Kinematics now = value(at);
    std::array<double, 2> left{now.position, now.velocity};
    for (int root = 0; root < touching; ++root) {
      left = {left[0] / at.time, (left[1] - left[0] / at.time) / at.time};
    }
    return left;
  });
}

/// @brief The samples of a search, those between coarse ones made where they are needed.
class SeriesGrid {
 public:
  /// @param frequency that none of the motion exceeds [rad/s]
  SeriesGrid(const FreeMotion& motion, double from, double to, double frequency)
      : motion_{&motion}, coarse_{samples_between(motion, from, to, parts_of(motion, to - from, frequency / kCoarse))} {
    fine_.resize(coarse_.size() - 1);
  }

  /// @brief The first event of one value. @param value Kinematics of a sample @param near of those of two neighbours
  /// and the time between: whether to look closely @param closing of two samples: when it happens between them
  template <class Value, class Near, class Closing>
  [[nodiscard]] std::optional<double> first(const Value& value, const Near& near, const Closing& closing) {
    Kinematics start = value(coarse_.front());
    for (std::size_t i = 0; i < fine_.size(); ++i) {
      const Kinematics end = value(coarse_[i + 1]);
      const bool skipped = !near(start, end, coarse_[i + 1].time - coarse_[i].time);
      start = end;
      if (skipped) {
        continue;
      }
      if (fine_[i].empty()) {
        fine_[i] = samples_between(*motion_, coarse_[i].time, coarse_[i + 1].time, kFine);
      }
      for (std::size_t j = 0; j < kFine; ++j) {
        if (const std::optional<double> time = closing(fine_[i][j], fine_[i][j + 1])) {
          return time;
        }
      }
    }
    return std::nullopt;
  }

 private:
  const FreeMotion* motion_;
  std::vector<SeriesSample> coarse_;
  std::vector<std::vector<SeriesSample>> fine_;
};

}  // namespace udar
