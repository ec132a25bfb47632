#include "udar/structure/junction_rotations.hpp"

#include "udar/numerics/symmetric_eigen.hpp"

namespace udar {
namespace {

/// Of a principal inertia beside the largest: what is left of it where members are parallel.
constexpr double kNoInertia = 1e-12;

/// @param tensor in global axes, by rows
JunctionRotations principal(const std::array<double, 9>& tensor, const Junction& junction) {
  std::vector<std::size_t> free;
  JunctionRotations rotations;
  std::size_t last = 3;
  for (std::size_t c = 3; c-- > 0;) {
    if (junction.held.at(3 + c)) {
      --last;
      rotations.axes.at(last).at(c) = 1.0;
      rotations.held.at(last) = true;
    } else {
      free.insert(free.begin(), c);
    }
  }
  const std::size_t size = free.size();
  if (size == 0) {
    return rotations;
  }
  std::vector<double> matrix;
  matrix.reserve(size * size);
  for (std::size_t i = 0; i < size * size; ++i) {
    matrix.push_back(tensor.at(3 * free[i / size] + free[i % size]));
  }
  std::vector<double> values(size);
  symmetric_eigen(matrix, values);
  for (std::size_t k = 0; k < size; ++k) {  // the largest first
    const std::size_t row = size - 1 - k;
    for (std::size_t i = 0; i < size; ++i) {
      rotations.axes.at(k).at(free[i]) = matrix[row * size + i];
    }
    if (values[row] > kNoInertia * values.back()) {
      rotations.inertia.at(k) = values[row];
      ++rotations.count;
    }
  }
  return rotations;
}

}  // namespace

std::vector<JunctionRotations> rotations_of_junctions(const NetworkParameters& network, const std::vector<Axes>& axes,
                                                      const std::vector<MemberKind>& kinds,
                                                      const std::vector<std::size_t>& kind) {
  std::vector<std::array<double, 9>> tensors(network.junctions.size(), std::array<double, 9>{});
  for (std::size_t number = 0; number < network.members.size(); ++number) {
    const Member& member = network.members[number];
    const std::array<double, 3>& along = axes[number][0];
    for (std::size_t end = 0; end < 2; ++end) {
      const double inertia = 0.5 * kinds[kind[number]].end_length(end) * network.sections[member.section].polar();
      for (std::size_t i = 0; i < 9; ++i) {
        tensors[member.ends.at(end).junction].at(i) += inertia * along.at(i / 3) * along.at(i % 3);
      }
    }
  }
  std::vector<JunctionRotations> all;
  all.reserve(tensors.size());
  for (std::size_t number = 0; number < tensors.size(); ++number) {
    all.push_back(principal(tensors[number], network.junctions[number]));
  }
  return all;
}

Axes inertia_of(const JunctionRotations& rotations) {
  Axes tensor{};
  for (std::size_t k = 0; k < rotations.count; ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        tensor[i][j] += rotations.inertia[k] * rotations.axes[k][i] * rotations.axes[k][j];
      }
    }
  }
  return tensor;
}

std::array<double, 3> along(const Axes& axes, const std::array<double, 3>& global) {
  std::array<double, 3> own{};
  for (std::size_t k = 0; k < 3; ++k) {
    own[k] = axes[k][0] * global[0] + axes[k][1] * global[1] + axes[k][2] * global[2];
  }
  return own;
}

std::array<double, 3> from_along(const Axes& axes, const std::array<double, 3>& own) {
  std::array<double, 3> global{};
  for (std::size_t k = 0; k < 3; ++k) {
    global[k] = axes[0][k] * own[0] + axes[1][k] * own[1] + axes[2][k] * own[2];
  }
  return global;
}

}  // namespace udar
