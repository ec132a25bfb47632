#pragma once
/// @file
/// Elements of a frame in motion.

#include <array>
#include <cstddef>

#include "structure/member_frame.hpp"
#include "structure/place_algebra.hpp"

namespace udar {

/// @brief What two nodes of an element do, less the translation of the first, and the forces that this takes.
struct Strained {
  std::array<double, 12> motion{};
  std::array<double, 12> force{};

  Strained(const FrameElement::Matrix& matrix, const std::array<double, 6>& left, const std::array<double, 6>& right) {
    for (std::size_t k = 0; k < 6; ++k) {
      motion.at(k) = k < 3 ? 0.0 : left.at(k);
      motion.at(6 + k) = right.at(k) - (k < 3 ? left.at(k) : 0.0);
    }
    for (std::size_t k = 3; k < 12; ++k) {
      push(matrix, k);
    }
  }

  /// Less its rotation, too: what spins turns far. @param span from node to node [m]
  Strained(const FrameElement::Matrix& matrix, const std::array<double, 6>& left, const std::array<double, 6>& right,
           const Place& span) {
    for (std::size_t k = 0; k < 6; ++k) {
      motion.at(6 + k) = right.at(k) - left.at(k);
    }
    motion[6] -= left[4] * span.z - left[5] * span.y;
    motion[7] -= left[5] * span.x - left[3] * span.z;
    motion[8] -= left[3] * span.y - left[4] * span.x;
    for (std::size_t k = 6; k < 12; ++k) {
      push(matrix, k);
    }
  }

 private:
  void push(const FrameElement::Matrix& matrix, std::size_t k) {
    for (std::size_t row = 0; row < 12; ++row) {
      force[row] += matrix[k][row] * motion[k];  // it is symmetric; rows side by side
    }
  }
};

/// @brief From one node of an element to the other [m].
inline Place span_of(const FrameElement& element, const Axes& axes) {
  return element.arm[0] + element.length * place_of(axes[0]) - element.arm[1];
}

/// @brief Moments at the end of a rigid arm instead of at the node.
inline void carry_to_end(const Place& arm, double* force) {
  force[3] -= arm.y * force[2] - arm.z * force[1];
  force[4] -= arm.z * force[0] - arm.x * force[2];
  force[5] -= arm.x * force[1] - arm.y * force[0];
}

}  // namespace udar
