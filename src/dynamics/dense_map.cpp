#include "udar/dynamics/dense_map.hpp"

#include <algorithm>
#include <cmath>

#ifdef __clang__
#define UDAR_INDEPENDENT
#else
#define UDAR_INDEPENDENT _Pragma("GCC ivdep")
#endif

namespace udar {
namespace {

// NOLINTBEGIN(cppcoreguidelines-avoid-c-arrays,modernize-avoid-c-arrays,cppcoreguidelines-pro-type-member-init)
template <std::size_t Terms, bool Predict>
[[gnu::always_inline]] inline void map_block(const Rows& rows, std::size_t count, const DenseMap& all, double step,
                                             Largest& largest) {
  double start[Terms];
  double weight[Terms][Terms];
  double gain[Terms][Terms];
  double place_of[Terms];
  double speed_of[Terms];
  double* __restrict moment[Terms];
  double* __restrict line[Terms];
  for (std::size_t j = 0; j < Terms; ++j) {
    start[j] = all.start[j] * step;
    place_of[j] = all.place[j];
    speed_of[j] = all.speed[j] / step;
    moment[j] = rows.moment[j];
    line[j] = rows.line[j];
    for (std::size_t k = 0; k < Terms; ++k) {
      weight[j][k] = all.line[j][k];
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
  double* __restrict places = rows.place;
  double* __restrict speeds = rows.speed;
  double change = 0.0;
  double last = 0.0;
  double before = 0.0;
  UDAR_INDEPENDENT
  for (std::size_t i = 0; i < count; ++i) {
    const double velocity = velocities[i];
    const double base = positions[i] - axis[i];
    double p[Terms];
    double u[Terms];
    double r[Terms];
#pragma GCC unroll 8
    for (std::size_t j = 0; j < Terms; ++j) {
      u[j] = moment[j][i] - (j == 0 ? base : 0.0);
      p[j] = line[j][i];
      if (!Predict) {
        p[j] += u[j] + (j == 0 ? steady0[i] : j == 1 ? steady1[i] : 0.0);
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
      double next = Predict ? r[j] : u[j];
#pragma GCC unroll 8
      for (std::size_t k = 0; k < Terms; ++k) {
        next += Predict ? 0.0 : gain[j][k] * r[k];
      }
      moment[j][i] = next + (j == 0 ? base : 0.0);
      place += place_of[j] * p[j];
      speed += speed_of[j] * p[j];
      change = std::max(change, std::abs(r[j]));
    }
    last = std::max(last, std::abs(p[Terms - 1]));
    before = std::max(before, std::abs(p[Terms - 2]));
    if (!Predict) {
      places[i] = positions[i] + place;
      speeds[i] = speed;
    }
  }
  largest.change = std::max(largest.change, change);
  largest.last = std::max(largest.last, last);
  largest.before = std::max(largest.before, before);
}
// NOLINTEND(cppcoreguidelines-avoid-c-arrays,modernize-avoid-c-arrays,cppcoreguidelines-pro-type-member-init)

}  // namespace

// One copy for each generation of processors; the loader takes the best.
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__)
__attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#endif
void map_masses(std::size_t terms, bool predict, const Rows& rows, std::size_t count, const DenseMap& map, double step,
                Largest& largest) {
  switch (2 * terms + (predict ? 1 : 0)) {
    case 4:
      return map_block<2, false>(rows, count, map, step, largest);
    case 5:
      return map_block<2, true>(rows, count, map, step, largest);
    case 6:
      return map_block<3, false>(rows, count, map, step, largest);
    case 7:
      return map_block<3, true>(rows, count, map, step, largest);
    case 8:
      return map_block<4, false>(rows, count, map, step, largest);
    case 9:
      return map_block<4, true>(rows, count, map, step, largest);
    case 10:
      return map_block<5, false>(rows, count, map, step, largest);
    default:
      return map_block<5, true>(rows, count, map, step, largest);
  }
}

}  // namespace udar
