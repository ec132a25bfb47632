#include "structure/member_frame.hpp"

#include <algorithm>
#include <numeric>

#include "structure/place_algebra.hpp"
#include "udar/structure/junction_rotations.hpp"

namespace udar {
namespace {

using Row = std::array<double, 12>;

/// Puts a vector where an end's displacements (0) or rotations (3) are.
void put(Row& row, std::size_t end, std::size_t first, double factor, const Place& vector) {
  const std::array<double, 3> values = values_of(vector);
  for (std::size_t c = 0; c < 3; ++c) {
    row[6 * end + first + c] += factor * values[c];
  }
}

/// How far the second end moves along a direction more than the first, times a factor.
Row difference(const FrameElement& element, const Place& along, double factor) {
  Row row{};
  for (std::size_t end = 0; end < 2; ++end) {
    const double sign = end == 0 ? -factor : factor;
    put(row, end, 0, sign, along);
    put(row, end, 3, sign, cross(element.arm[end], along));
  }
  return row;
}

/// Stiffness of both ends' rotations beside the chord: of [first, second], their coupling.
struct Bending {
  double first = 0.0;
  double second = 0.0;
  double coupling = 0.0;
};

/// The inverse of the compliance of the bar, of its shear and of its joints; a hinge carries no moment.
Bending bending_of(const MemberSection& section, std::size_t plane, double length, double first_joint,
                   double second_joint) {
  const double bar = length / (6.0 * section.bending(plane));
  const double shear = section.shear_compliance(plane) / length;
  const double first = 2.0 * bar + shear + 1.0 / first_joint;
  const double second = 2.0 * bar + shear + 1.0 / second_joint;
  if (first_joint == 0.0 || second_joint == 0.0) {
    return {.first = first_joint == 0.0 ? 0.0 : 1.0 / first, .second = second_joint == 0.0 ? 0.0 : 1.0 / second};
  }
  const double coupling = shear - bar;
  const double determinant = first * second - coupling * coupling;
  return {.first = second / determinant, .second = first / determinant, .coupling = -coupling / determinant};
}

void add_square(FrameElement::Matrix& matrix, double stiffness, const Row& row) {
  for (std::size_t i = 0; i < row.size(); ++i) {
    for (std::size_t j = 0; j < row.size(); ++j) {
      matrix[i][j] += stiffness * (row[i] * row[j]);
    }
  }
}

void add_bending(FrameElement::Matrix& matrix, const Bending& bending, const Row& first, const Row& second) {
  add_square(matrix, bending.first, first);
  add_square(matrix, bending.second, second);
  for (std::size_t i = 0; i < first.size(); ++i) {
    for (std::size_t j = 0; j < first.size(); ++j) {
      matrix[i][j] += bending.coupling * (first[i] * second[j] + second[i] * first[j]);
    }
  }
}

/// The direction in whose plane with the member's axis its y axis is.
Place orientation_of(const Member& member, const Place& along) {
  if (norm(member.orientation) > 0.0) {
    return (1.0 / norm(member.orientation)) * member.orientation;
  }
  const Place up{.y = 1.0};
  return norm(cross(along, up)) > kParallel ? up : Place{.x = 1.0};
}

}  // namespace

Place end_place(const NetworkParameters& network, const Member& member, std::size_t end) {
  return network.junctions[member.ends[end].junction].place + member.ends[end].offset;
}

Place span_of(const NetworkParameters& network, const Member& member) {
  return end_place(network, member, 1) - end_place(network, member, 0);
}

std::vector<double> node_shares(const Member& member) {
  std::vector<double> shares;
  shares.reserve(member.elements);
  const double whole = std::accumulate(member.spacing.begin(), member.spacing.end(), 0.0);
  double before = 0.0;
  for (std::size_t i = 1; i < member.elements; ++i) {
    before += member.spacing.empty() ? 0.0 : member.spacing[i - 1];
    shares.push_back(member.spacing.empty() ? static_cast<double>(i) / static_cast<double>(member.elements)
                                            : before / whole);
  }
  return shares;
}

Axes axes_of(const NetworkParameters& network, const Member& member) {
  const Place span = span_of(network, member);
  const Place x = (1.0 / norm(span)) * span;
  const Place orientation = orientation_of(member, x);
  const Place across = orientation - dot(orientation, x) * x;
  const Place y = (1.0 / norm(across)) * across;
  return {values_of(x), values_of(y), values_of(cross(x, y))};
}

bool orientation_is_parallel(const NetworkParameters& network, const Member& member) {
  const Place span = span_of(network, member);
  const Place x = (1.0 / norm(span)) * span;
  return !(norm(cross(x, orientation_of(member, x))) > kParallel);
}

double torsion_of(const MemberSection& section, double length, double first_joint, double second_joint) {
  return first_joint == 0.0 || second_joint == 0.0
             ? 0.0
             : 1.0 / (length / section.torsion() + 1.0 / first_joint + 1.0 / second_joint);
}

double scale_of(const MemberSection& section, double length, bool rotation) {
  return (rotation ? section.bending(0) + section.bending(1) + section.torsion() : section.axial()) / length;
}

FrameElement::Matrix turned_rotations(const FrameElement::Matrix& matrix, const Axes& first, const Axes& second) {
  FrameElement::Matrix half = matrix;
  const auto of_node = [&](std::size_t i) -> const Axes& { return i < 6 ? first : second; };
  for (std::size_t row = 0; row < 12; ++row) {
    for (const std::size_t begin : {3U, 9U}) {
      const std::array<double, 3> global{matrix[row][begin], matrix[row][begin + 1], matrix[row][begin + 2]};
      std::ranges::copy(along(of_node(begin), global), half[row].begin() + static_cast<std::ptrdiff_t>(begin));
    }
  }
  FrameElement::Matrix all = half;
  for (std::size_t column = 0; column < 12; ++column) {
    for (const std::size_t begin : {3U, 9U}) {
      const std::array<double, 3> own =
          along(of_node(begin), {half[begin][column], half[begin + 1][column], half[begin + 2][column]});
      for (std::size_t k = 0; k < 3; ++k) {
        all[begin + k][column] = own[k];
      }
    }
  }
  for (std::size_t i = 0; i < 12; ++i) {  // to the bit, again
    for (std::size_t j = 0; j < i; ++j) {
      all[i][j] = all[j][i];
    }
  }
  return all;
}

FrameElement element_of(const Member& member, double element_length, std::size_t element) {
  FrameElement made{.length = element_length};
  if (element == 0) {
    made.arm[0] = member.ends[0].offset;
    made.joint[0] = member.ends[0].joint;
  }
  if (element + 1 == member.elements) {
    made.arm[1] = member.ends[1].offset;
    made.joint[1] = member.ends[1].joint;
  }
  return made;
}

FrameElement::Matrix FrameElement::stiffness(const MemberSection& section, const Axes& axes) const {
  const Place x = place_of(axes[0]);
  const Place y = place_of(axes[1]);
  const Place z = place_of(axes[2]);
  Matrix matrix{};
  add_square(matrix, section.axial() / length, difference(*this, x, 1.0));
  if (twists) {
    Row twist{};
    put(twist, 0, 3, -1.0, x);
    put(twist, 1, 3, 1.0, x);
    add_square(matrix, torsion_of(section, length, joint[0][0], joint[1][0]), twist);
  }
  // A deflection along y turns about z, one along z about -y.
  for (std::size_t plane = 0; plane < 2; ++plane) {
    const std::size_t about = plane == 0 ? 2 : 1;
    std::array<Row, 2> turned{};
    for (std::size_t end = 0; end < 2; ++end) {
      turned[end] = difference(*this, plane == 0 ? y : z, -1.0 / length);
      put(turned[end], end, 3, plane == 0 ? 1.0 : -1.0, plane == 0 ? z : y);
    }
    add_bending(matrix, bending_of(section, plane, length, joint[0][about], joint[1][about]), turned[0], turned[1]);
  }
  return matrix;
}

}  // namespace udar
