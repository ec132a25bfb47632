#include "udar/filter/inner_moments.hpp"

#include <algorithm>

#include "structure/member_frame.hpp"

namespace udar {
namespace {

using Vector3 = std::array<double, 3>;
using Square3 = std::array<Vector3, 3>;

Square3 part(const FrameElement::Matrix& matrix, std::size_t row, std::size_t column) {
  Square3 result{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      result[i][k] = matrix[row + i][column + k];
    }
  }
  return result;
}

Vector3 times(const Square3& matrix, const Vector3& vector) {
  Vector3 result{};
  for (std::size_t i = 0; i < 3; ++i) {
    result[i] = matrix[i][0] * vector[0] + matrix[i][1] * vector[1] + matrix[i][2] * vector[2];
  }
  return result;
}

Square3 inverse(const Square3& m) {
  Square3 result{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t a = (k + 1) % 3;
      const std::size_t b = (k + 2) % 3;
      const std::size_t c = (i + 1) % 3;
      const std::size_t d = (i + 2) % 3;
      result[i][k] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
    }
  }
  const double determinant = m[0][0] * result[0][0] + m[0][1] * result[1][0] + m[0][2] * result[2][0];
  for (Vector3& row : result) {
    for (double& value : row) {
      value /= determinant;
    }
  }
  return result;
}

/// The different elements of a member: of equal ones first, one between, last.
struct Elements {
  std::vector<FrameElement::Matrix> matrices;
  std::size_t count;
  bool equal;

  Elements(const Network& network, std::size_t number) : count{network.parameters().members[number].elements} {
    const Member& member = network.parameters().members[number];
    const MemberKind& kind = network.kinds()[network.kind(number)];
    equal = kind.equal_elements();
    for (std::size_t i = 0; i < (equal ? 3 : count); ++i) {
      const std::size_t element = !equal || i == 0 ? i : i == 1 ? std::min<std::size_t>(1, count - 1) : count - 1;
      matrices.push_back(element_of(member, kind.length(element), element)
                             .stiffness(network.parameters().sections[member.section], network.axes(number)));
    }
  }
  [[nodiscard]] const FrameElement::Matrix& operator[](std::size_t element) const {
    return matrices[!equal || element == 0 ? element : element + 1 == count ? 2 : 1];
  }
};

/// Between two hinges of torsion.
bool twists_freely(const Member& member) { return member.ends[0].joint[0] == 0.0 && member.ends[1].joint[0] == 0.0; }

}  // namespace

InnerMoments::InnerMoments(const Network& network, std::span<const std::size_t> local)
    : network_{&network}, local_{local} {
  for (std::size_t member = 0; member < network.parameters().members.size(); ++member) {
    if (network.member_ranks()[member] == network.rank() && network.parameters().members[member].elements > 1) {
      members_.push_back(member);
      first_.push_back(inverse_.size());
      factor(member);
    }
  }
}

/// The spring that the frame has there.
void InnerMoments::add_twist(std::size_t member, Matrix3& own) const {
  const MemberKind& kind = network_->kinds()[network_->kind(member)];
  const double stiffness = network_->parameters().sections[kind.section].torsion() / kind.element_length;
  const Vector3& axis = network_->axes(member)[0];
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      own[i][k] += stiffness * axis[i] * axis[k];
    }
  }
}

void InnerMoments::factor(std::size_t member) {
  const Elements elements{*network_, member};
  for (std::size_t i = 1; i < elements.count; ++i) {
    Matrix3 own = part(elements[i - 1], 9, 9);
    const Matrix3 right = part(elements[i], 3, 3);
    const Matrix3 coupling = i > 1 ? part(elements[i - 1], 9, 3) : Matrix3{};
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) {
        own[r][c] += right[r][c];
      }
    }
    if (i == 1 && twists_freely(network_->parameters().members[member])) {
      add_twist(member, own);
    }
    if (i > 1) {
      for (std::size_t c = 0; c < 3; ++c) {
        const Vector3 taken = times(coupling, times(inverse_.back(), coupling[c]));  // a column of c' is a row of c
        for (std::size_t r = 0; r < 3; ++r) {
          own[r][c] -= taken[r];
        }
      }
    }
    inverse_.push_back(inverse(own));
    coupling_.push_back(coupling);
  }
}

void InnerMoments::eliminate(const Loads& loads) const {
  for (std::size_t index = 0; index < members_.size(); ++index) {
    eliminate(index, loads);
  }
}

void InnerMoments::eliminate(std::size_t index, const Loads& loads) const {
  const std::size_t number = members_[index];
  const std::size_t nodes = network_->nodes();
  const Elements elements{*network_, number};
  const std::size_t inner = elements.count - 1;
  std::vector<Vector3> turned(inner + 2, Vector3{});  // by node; those of the ends stay where they are
  const auto at = [&](std::size_t node, std::size_t k) {
    return Network::kBlock.at(k) * nodes + network_->node(number, node).local;
  };
  for (std::size_t i = 1; i <= inner; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      turned[i][k] = loads.rotation[at(i, k)];
    }
    if (i > 1) {
      const Vector3 taken =
          times(coupling_[first_[index] + i - 1], times(inverse_[first_[index] + i - 2], turned[i - 1]));
      for (std::size_t k = 0; k < 3; ++k) {
        turned[i][k] -= taken[k];
      }
    }
  }
  for (std::size_t i = inner; i >= 1; --i) {
    if (i < inner) {
      const Matrix3& coupling = coupling_[first_[index] + i];
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t r = 0; r < 3; ++r) {
          turned[i][k] -= coupling[r][k] * turned[i + 1][r];
        }
      }
    }
    turned[i] = times(inverse_[first_[index] + i - 1], turned[i]);
  }
  const Member& member = network_->parameters().members[number];
  for (std::size_t e = 0; e < elements.count; ++e) {
    for (std::size_t row = 0; row < 12; ++row) {
      const std::size_t node = e + row / 6;
      double taken = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        taken += elements[e][row][3 + k] * turned[e][k] + elements[e][row][9 + k] * turned[e + 1][k];
      }
      if (node == 0 || node == elements.count) {
        loads.junction[6 * local_[member.ends.at(node == 0 ? 0 : 1).junction] + row % 6] -= taken;
      } else if (row % 6 < 3) {
        loads.point[at(node, row % 6)] -= taken;
      }
    }
  }
  for (std::size_t i = 1; i <= inner; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      loads.rotation[at(i, k)] = turned[i][k];
    }
  }
}

}  // namespace udar
