#include "udar/local/dense_map.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "numerics/clones.hpp"

#ifdef __clang__
#define UDAR_INDEPENDENT
#else
#define UDAR_INDEPENDENT _Pragma("GCC ivdep")
#endif

namespace udar {
namespace {

// Of a double: in a file that knows no infinity, its bits tell it.
constexpr std::uint64_t kMagnitude = 0x7fff'ffff'ffff'ffff;
constexpr std::uint64_t kInfinite = 0x7ff0'0000'0000'0000;

// Vector kernels: one loop over the masses each, whose constant inner loops the compiler takes apart.
// NOLINTBEGIN(cppcoreguidelines-avoid-c-arrays,modernize-avoid-c-arrays,cppcoreguidelines-pro-type-member-init)
template <std::size_t Terms, bool Predict, bool Damped>
// NOLINTNEXTLINE(readability-function-cognitive-complexity,readability-function-size): a kernel
[[gnu::always_inline]] inline void map_block(const BlockRows& rows, std::size_t count, const DenseMap& all, double step,
                                             SweepMaxima& largest) {
  double start[Terms];
  double weight[Terms][Terms];
  constexpr std::size_t unknowns = Terms + (Damped ? 1 : 0);
  double gain[unknowns][unknowns];
  double place_of[Terms];
  double speed_of[Terms];
  double* __restrict moment[unknowns];
  double* __restrict line[Terms];
  const double* __restrict drive[Terms];
  for (std::size_t j = 0; j < Terms; ++j) {
    start[j] = all.start[j] * step;
    place_of[j] = all.place[j];
    speed_of[j] = all.speed[j] / step;
    line[j] = rows.line[j];
    drive[j] = rows.drive[j];
    for (std::size_t k = 0; k < Terms; ++k) {
      weight[j][k] = all.line[j][k];
    }
  }
  for (std::size_t j = 0; j < unknowns; ++j) {
    moment[j] = rows.moment[j];
    for (std::size_t k = 0; k < unknowns; ++k) {
      gain[j][k] = all.gain[j][k];
    }
  }
  const double place_of_start = all.place_of_start * step;
  const double speed_of_start = all.speed_of_start;
  const double* __restrict steady0 = rows.steady[0];
  const double* __restrict steady1 = rows.steady[1];
  const double* __restrict velocities = rows.velocity;
  const double* __restrict positions = rows.position;
  const double* __restrict axis = rows.axis;
  const double* __restrict free = rows.free;
  double* __restrict places = rows.place;
  double* __restrict speeds = rows.speed;
  double change = 0.0;
  double rate = 0.0;
  double last = 0.0;
  double before = 0.0;
  std::uint64_t bits = 0;
  UDAR_INDEPENDENT
  for (std::size_t i = 0; i < count; ++i) {
    const double velocity = velocities[i];
    const double base = positions[i] - axis[i];
    double p[Terms];
    double u[unknowns];
    std::array<double, unknowns> r;
#pragma GCC unroll 8
    for (std::size_t j = 0; j < unknowns; ++j) {
      u[j] = moment[j][i] - (j == 0 ? base : 0.0);
    }
#pragma GCC unroll 8
    for (std::size_t j = 0; j < Terms; ++j) {
      if (Predict || Damped) {
        p[j] = drive[j][i];
      } else {
        p[j] = line[j][i] + u[j] + (j == 0 ? steady0[i] : j == 1 ? steady1[i] : 0.0);
        line[j][i] = p[j];
      }
    }
#pragma GCC unroll 8
    for (std::size_t j = 0; j < Terms; ++j) {
      r[j] = start[j] * velocity - (Predict ? 0.0 : u[j]);
#pragma GCC unroll 8
      for (std::size_t k = 0; k < Terms; ++k) {
        r[j] += weight[j][k] * p[k];
      }
    }
    double place = place_of_start * velocity;
    double speed = speed_of_start * velocity;
#pragma GCC unroll 8
    for (std::size_t j = 0; j < Terms; ++j) {
      place += place_of[j] * p[j];
      speed += speed_of[j] * p[j];
    }
    if (Damped) {
      r[unknowns - 1] = place - (Predict ? 0.0 : u[unknowns - 1]);
    }
#pragma GCC unroll 8
    for (std::size_t j = 0; j < unknowns; ++j) {
      double next = Predict ? r[j] : u[j];
#pragma GCC unroll 8
      for (std::size_t k = 0; k < unknowns; ++k) {
        next += Predict ? 0.0 : gain[j][k] * r[k];
      }
      moment[j][i] = next + (j == 0 ? base : 0.0);
      change = std::max(change, free[i] * std::abs(r[j]));
    }
    if (Damped) {
#pragma GCC unroll 8
      for (std::size_t j = 0; j < Terms; ++j) {
        rate = std::max(rate, free[i] * std::abs(rate_term(j, r, r[unknowns - 1])));
      }
    }
    last = std::max(last, std::abs(p[Terms - 1]));
    before = std::max(before, std::abs(p[Terms - 2]));
    if (!Predict) {
      place += positions[i];
      bits = std::max(
          {bits, std::bit_cast<std::uint64_t>(place) & kMagnitude, std::bit_cast<std::uint64_t>(speed) & kMagnitude});
      places[i] = place;
      speeds[i] = speed;
    }
  }
  largest.change = std::max(largest.change, change);
  largest.rate = std::max(largest.rate, rate);
  largest.last = std::max(largest.last, last);
  largest.before = std::max(largest.before, before);
  largest.finite = largest.finite && bits < kInfinite;
}

template <std::size_t Terms, bool Given>
[[gnu::always_inline]] inline void bound_block(const BlockRows& rows, std::size_t count, const ResponseBounds& reach,
                                               double step, const BlockBounds& bounds) {
  const double* __restrict moment[Terms];
  const double* __restrict line[Terms];
  double of_line[Terms][kBounds];
  double rest_of_line[Terms];
  double of_start[kBounds];
  for (std::size_t b = 0; b < kBounds; ++b) {
    of_start[b] = reach.start[b] * step;
  }
  for (std::size_t j = 0; j < Terms; ++j) {
    moment[j] = rows.moment[j];
    line[j] = Given ? rows.drive[j] : rows.line[j];
    rest_of_line[j] = reach.rest_of_line[j];
    for (std::size_t b = 0; b < kBounds; ++b) {
      of_line[j][b] = reach.line[j][b];
    }
  }
  const double rest_of_start = reach.rest_of_start * step;
  const double* __restrict steady0 = rows.steady[0];
  const double* __restrict steady1 = rows.steady[1];
  const double* __restrict velocities = rows.velocity;
  const double* __restrict positions = rows.position;
  const double* __restrict axis = rows.axis;
  double* __restrict lows = bounds.low;
  double* __restrict highs = bounds.high;
  double* __restrict line_lows = bounds.line_low;
  double* __restrict line_highs = bounds.line_high;
  UDAR_INDEPENDENT
  for (std::size_t i = 0; i < count; ++i) {
    const double velocity = velocities[i];
    double p[Terms];
    double rest = rest_of_start * std::abs(velocity);
    double swing = 0.0;
#pragma GCC unroll 8
    for (std::size_t j = 0; j < Terms; ++j) {
      p[j] = line[j][i];
      if (!Given) {
        p[j] += moment[j][i] - (j == 0 ? positions[i] - axis[i] : 0.0) +
                (j == 0   ? steady0[i]
                 : j == 1 ? steady1[i]
                          : 0.0);
      }
      rest += rest_of_line[j] * std::abs(p[j]);
      swing += j > 0 ? std::abs(p[j]) : 0.0;
    }
    double low = 0.0;
    double high = 0.0;
#pragma GCC unroll 16
    for (std::size_t b = 1; b < kBounds; ++b) {
      double value = of_start[b] * velocity;
#pragma GCC unroll 8
      for (std::size_t j = 0; j < Terms; ++j) {
        value += of_line[j][b] * p[j];
      }
      low = std::min(low, value);
      high = std::max(high, value);
    }
    lows[i] = low - rest;
    highs[i] = high + rest;
    line_lows[i] = p[0] - swing;
    line_highs[i] = p[0] + swing;
  }
}

template <std::size_t Terms>
[[gnu::always_inline]] inline void change_block(const std::array<double*, kMostTerms>& lines, std::size_t count,
                                                const LegendreMatrix& all) {
  double change[Terms][Terms];
  double* __restrict line[Terms];
  for (std::size_t j = 0; j < Terms; ++j) {
    line[j] = lines[j];
    for (std::size_t k = 0; k < Terms; ++k) {
      change[j][k] = all[j][k];
    }
  }
  UDAR_INDEPENDENT
  for (std::size_t i = 0; i < count; ++i) {
    double old[Terms];
#pragma GCC unroll 8
    for (std::size_t j = 0; j < Terms; ++j) {
      old[j] = line[j][i];
    }
#pragma GCC unroll 8
    for (std::size_t j = 0; j < Terms; ++j) {
      double sum = 0.0;
#pragma GCC unroll 8
      for (std::size_t k = j; k < Terms; ++k) {
        sum += change[j][k] * old[k];
      }
      line[j][i] = sum;
    }
  }
}

template <std::size_t Terms, bool Level>
[[gnu::always_inline]] inline double lowest_block(const BlockRows& rows, std::size_t count, double side,
                                                  const double* heights, const LegendreMatrix& all) {
  double bernstein[Terms][Terms];
  const double* __restrict line[Terms];
  for (std::size_t j = 0; j < Terms; ++j) {
    line[j] = rows.line[j];
    for (std::size_t k = 0; k < Terms; ++k) {
      bernstein[j][k] = side * all[j][k];
    }
  }
  const double* __restrict positions = rows.position;
  double lowest = std::numeric_limits<double>::max();
  UDAR_INDEPENDENT
  for (std::size_t i = 0; i < count; ++i) {
    const double position = side * (Level ? positions[i] : positions[i] - heights[i]);
#pragma GCC unroll 8
    for (std::size_t b = 0; b < Terms; ++b) {
      double value = position;
#pragma GCC unroll 8
      for (std::size_t j = 0; j < Terms; ++j) {
        value += bernstein[b][j] * line[j][i];
      }
      lowest = std::min(lowest, value);
    }
  }
  return lowest;
}
// NOLINTEND(cppcoreguidelines-avoid-c-arrays,modernize-avoid-c-arrays,cppcoreguidelines-pro-type-member-init)

/// Calls `body` with the number of terms as a constant.
template <class Body>
[[gnu::always_inline]] inline auto with_terms(std::size_t terms, const Body& body) {
  switch (terms) {
    case 2:
      return body.template operator()<2>();
    case 3:
      return body.template operator()<3>();
    case 4:
      return body.template operator()<4>();
    default:
      return body.template operator()<5>();
  }
}

}  // namespace

UDAR_CLONES
void map_masses(std::size_t terms, bool predict, const BlockRows& rows, std::size_t count, const DenseMap& map,
                double step, SweepMaxima& largest) {
  with_terms(terms, [&]<std::size_t Terms>() __attribute__((always_inline)) {
    if (rows.damped) {
      return predict ? map_block<Terms, true, true>(rows, count, map, step, largest)
                     : map_block<Terms, false, true>(rows, count, map, step, largest);
    }
    return predict ? map_block<Terms, true, false>(rows, count, map, step, largest)
                   : map_block<Terms, false, false>(rows, count, map, step, largest);
  });
}

UDAR_CLONES
void bound_masses(std::size_t terms, bool predict, const BlockRows& rows, std::size_t count,
                  const ResponseBounds& reach, double step, const BlockBounds& bounds) {
  with_terms(terms, [&]<std::size_t Terms>() __attribute__((always_inline)) {
    return predict || rows.damped ? bound_block<Terms, true>(rows, count, reach, step, bounds)
                                  : bound_block<Terms, false>(rows, count, reach, step, bounds);
  });
}

UDAR_CLONES
void change_basis(std::size_t terms, const std::array<double*, kMostTerms>& line, std::size_t count,
                  const LegendreMatrix& change) {
  with_terms(terms, [&]<std::size_t Terms>()
                        __attribute__((always_inline)) { return change_block<Terms>(line, count, change); });
}

namespace {

template <bool Level>
[[gnu::always_inline]] inline void mark_block(const NearSupport& of, std::size_t count, const double* position,
                                              const double* bound, const std::int32_t* resting, std::uint8_t* near) {
  const double side = of.side;
  const double height = of.height;
  const double* heights = of.heights;
  const double together = of.together;
  for (std::size_t i = 0; i < count; ++i) {
    constexpr double kPerMetre = 1e-14;  // more than a position's rounding
    const double gap = side * (position[i] + bound[i] - (Level ? height : height + heights[i]));
    const bool reached = gap <= together + kPerMetre * std::abs(position[i]);
    near[i] = static_cast<std::uint8_t>(static_cast<int>(reached) | static_cast<int>(resting[i] != 0));
  }
}

}  // namespace

UDAR_CLONES
void mark_near(const NearSupport& of, std::size_t count, const double* position, const double* bound,
               const std::int32_t* resting, std::uint8_t* near) {
  return of.heights == nullptr ? mark_block<true>(of, count, position, bound, resting, near)
                               : mark_block<false>(of, count, position, bound, resting, near);
}

UDAR_CLONES
double lowest_line(std::size_t terms, const BlockRows& rows, std::size_t count, double side, const double* heights,
                   const LegendreMatrix& bernstein) {
  return with_terms(terms, [&]<std::size_t Terms>() __attribute__((always_inline)) {
    return heights == nullptr ? lowest_block<Terms, true>(rows, count, side, heights, bernstein)
                              : lowest_block<Terms, false>(rows, count, side, heights, bernstein);
  });
}

}  // namespace udar
