#include "udar/structure/member_shape.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>

#include "udar/structure/section.hpp"

namespace udar {
namespace {

/// J = a b^3 / 3 (1 - 192 b / (pi^5 a) sum of tanh(n pi a / (2 b)) / n^5 over odd n), a >= b. The sum is that of 1 /
/// n^5, known, less what converges as exp(-n pi a / b).
double rectangle_torsion(double width, double height) {
  const double a = std::max(width, height);
  const double b = std::min(width, height);
  constexpr double kOddFifthPowers = 1.0045237627951396;  // 31/32 zeta(5)
  constexpr int kLast = 13;                               // the next is exp(-15 pi)
  double rest = 0.0;
  for (int n = kLast; n > 0; n -= 2) {
    rest += 2.0 / (std::exp(n * std::numbers::pi * a / b) + 1.0) / std::pow(n, 5);
  }
  const double factor = 1.0 - 192.0 * b / (std::pow(std::numbers::pi, 5) * a) * (kOddFifthPowers - rest);
  return a * b * b * b / 3.0 * factor;
}

}  // namespace

void give_shape(MemberSection& section, const MemberShape& shape, bool shear) {
  const double poisson = section.youngs_modulus / (2.0 * section.shear_modulus) - 1.0;
  std::array<Section, 2> planes{};  // bending in the planes xy and xz
  switch (shape.kind) {
    case MemberShape::Kind::circle:
      planes.fill(circle_section(shape.radius, poisson));
      section.torsion_constant = 2.0 * planes[0].inertia;
      section.radius = shape.radius;
      break;
    case MemberShape::Kind::tube:
      planes.fill(tube_section(shape.radius, shape.inner_radius, poisson));
      section.torsion_constant = 2.0 * planes[0].inertia;
      section.radius = shape.radius;
      break;
    case MemberShape::Kind::rectangle:
      planes = {rectangle_section(shape.width, shape.height, poisson),
                rectangle_section(shape.height, shape.width, poisson)};
      section.torsion_constant = rectangle_torsion(shape.width, shape.height);
      section.radius = 0.0;
      break;
  }
  section.area = planes[0].area;
  section.inertia = {planes[0].inertia, planes[1].inertia};
  section.shear_factor = {shear ? planes[0].shear_coefficient : 0.0, shear ? planes[1].shear_coefficient : 0.0};
}

std::vector<double> graded_spacing(std::size_t elements, double ratio) {
  std::vector<double> spacing;
  for (std::size_t i = 0; elements > 1 && ratio != 1.0 && i < elements; ++i) {
    spacing.push_back(std::pow(ratio, static_cast<double>(i) / static_cast<double>(elements - 1)));
  }
  return spacing;
}

NetworkParameters regular_network(const RegularNetwork& regular) {
  const auto& counts = regular.junctions;
  const std::array<std::size_t, 3> stride{1, counts[0], counts[0] * counts[1]};
  NetworkParameters network{.sections = {regular.section}, .junctions = {}, .members = {}};
  network.junctions.reserve(stride[2] * counts[2]);
  std::array<std::size_t, 3> at{};
  for (at[2] = 0; at[2] < counts[2]; ++at[2]) {
    for (at[1] = 0; at[1] < counts[1]; ++at[1]) {
      for (at[0] = 0; at[0] < counts[0]; ++at[0]) {
        Junction& junction = network.junctions.emplace_back();
        junction.name = std::to_string(at[0]) + " " + std::to_string(at[1]) + " " + std::to_string(at[2]);
        junction.place = {.x = static_cast<double>(at[0]) * regular.spacing[0],
                          .y = static_cast<double>(at[1]) * regular.spacing[1],
                          .z = static_cast<double>(at[2]) * regular.spacing[2]};
      }
    }
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t from = 0; from < network.junctions.size(); ++from) {
      if (from / stride[axis] % counts[axis] + 1 < counts[axis]) {
        const std::size_t to = from + stride[axis];
        Member& member = network.members.emplace_back();
        member.name = network.junctions[from].name + " to " + network.junctions[to].name;
        member.ends = {MemberEnd{.junction = from}, MemberEnd{.junction = to}};
        member.elements = regular.elements;
        member.spacing = graded_spacing(regular.elements, regular.grading);
      }
    }
  }
  return network;
}

}  // namespace udar
