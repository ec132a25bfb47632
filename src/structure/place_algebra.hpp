#pragma once
/// @file
/// Places as vectors.

#include <array>
#include <cmath>

#include "udar/structure/mass_points.hpp"

namespace udar {

inline Place operator+(const Place& a, const Place& b) { return {.x = a.x + b.x, .y = a.y + b.y, .z = a.z + b.z}; }
inline Place operator-(const Place& a, const Place& b) { return {.x = a.x - b.x, .y = a.y - b.y, .z = a.z - b.z}; }
inline Place operator*(double factor, const Place& a) {
  return {.x = factor * a.x, .y = factor * a.y, .z = factor * a.z};
}
inline double dot(const Place& a, const Place& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Place cross(const Place& a, const Place& b) {
  return {.x = a.y * b.z - a.z * b.y, .y = a.z * b.x - a.x * b.z, .z = a.x * b.y - a.y * b.x};
}
inline double norm(const Place& a) { return std::hypot(a.x, a.y, a.z); }
inline Place place_of(const std::array<double, 3>& values) { return {.x = values[0], .y = values[1], .z = values[2]}; }
inline std::array<double, 3> values_of(const Place& a) { return {a.x, a.y, a.z}; }

}  // namespace udar
