#include "structure/free_rotations.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <span>

#include "structure/disjoint_sets.hpp"
#include "structure/member_frame.hpp"
#include "structure/network_checks.hpp"
#include "structure/pivots.hpp"
#include "structure/place_algebra.hpp"
#include "udar/numerics/symmetric_eigen.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

/// Stiffness of less than this share of the members' is none: what kParallel leaves of bending.
constexpr double kNone = kParallel * kParallel;
constexpr double kAlong = 1e-9;  // 1 minus the cosine between two axes that are one

/// Orthonormal axes, and what resists a rotation about them.
struct Rotations {
  std::vector<double> resistance;
  std::vector<Place> axes;
};

/// The principal axes of a resistance given in some axes. @param matrix by rows
Rotations principal(std::vector<double> matrix, std::span<const Place> given) {
  Rotations rotations{.resistance = std::vector<double>(given.size()), .axes = {}};
  symmetric_eigen(matrix, rotations.resistance);
  for (std::size_t row = 0; row < given.size(); ++row) {
    Place axis{};
    for (std::size_t i = 0; i < given.size(); ++i) {
      axis = axis + matrix[row * given.size() + i] * given[i];
    }
    rotations.axes.push_back(axis);
  }
  return rotations;
}

/// A member as a spring between the rotations of its junctions.
struct Twist {
  std::size_t member = 0;
  std::array<std::size_t, 2> junction{};
  Place axis{};
  double stiffness = 0.0;  // > 0 [N m/rad]
};

class Search {
 public:
  explicit Search(const Network& network)
      : network_{&network},
        given_{&network.parameters()},
        scale_(given_->junctions.size(), 0.0),
        free_(given_->junctions.size()) {}

  FreeRotations run() {
    find_unbent();
    list_twists();
    hold_untied();
    hold_lines();
    require_tied();
    return std::move(found_);
  }

 private:
  void find_unbent();
  void list_twists();
  void hold_untied();
  void hold_lines();
  void require_tied() const;

  [[nodiscard]] const MemberKind& kind_of(std::size_t member) const {
    return network_->kinds()[network_->kind(member)];
  }
  /// Shares of a free rotation's axes in a twist.
  [[nodiscard]] std::vector<double> shares(const Twist& twist, std::size_t end) const {
    std::vector<double> shares;
    for (const Place& axis : free_[twist.junction[end]]) {
      shares.push_back(dot(axis, twist.axis));
    }
    return shares;
  }
  [[nodiscard]] bool couples(const Twist& twist, std::size_t end) const {
    return std::ranges::any_of(shares(twist, end), [](double share) { return std::abs(share) > kParallel; });
  }
  void note(std::size_t count, const char* one, const char* many, std::size_t junction);

  const Network* network_;
  const NetworkParameters* given_;
  std::vector<double> scale_;             // of each junction: what its rotations are compared with [N m/rad]
  std::vector<std::vector<Place>> free_;  // of each junction: axes about which torsion alone resists
  std::vector<Twist> twists_;
  FreeRotations found_;
};

/// Axes about which neither bending nor springs, holds and inertia resist.
void Search::find_unbent() {
  std::vector<std::array<double, 9>> resistance(scale_.size(), std::array<double, 9>{});
  for (std::size_t number = 0; number < given_->members.size(); ++number) {
    const Member& member = given_->members[number];
    const MemberSection& section = given_->sections[member.section];
    for (std::size_t end = 0; end < 2; ++end) {
      const std::size_t junction = member.ends[end].junction;
      FrameElement element = element_of(member, kind_of(number).end_length(end), end == 0 ? 0 : member.elements - 1);
      element.twists = false;
      const FrameElement::Matrix matrix = element.stiffness(section, network_->axes(number));
      for (std::size_t i = 0; i < 9; ++i) {
        resistance[junction].at(i) += matrix.at(6 * end + 3 + i / 3).at(6 * end + 3 + i % 3);
      }
      scale_[junction] += scale_of(section, element.length, true);
    }
  }
  constexpr std::array kGlobal{Place{.x = 1.0}, Place{.y = 1.0}, Place{.z = 1.0}};
  for (std::size_t number = 0; number < scale_.size(); ++number) {
    const Junction& junction = given_->junctions[number];
    for (std::size_t c = 0; c < 3; ++c) {
      resistance[number].at(4 * c) += junction.stiffness.at(3 + c) + (junction.held.at(3 + c) ? scale_[number] : 0.0);
    }
    for (std::size_t k = 0; network_->rotary() && k < network_->rotations(number).count; ++k) {
      const std::array<double, 3>& axis = network_->rotations(number).axes.at(k);  // inertia resists
      for (std::size_t i = 0; i < 9; ++i) {
        resistance[number].at(i) += scale_[number] * axis.at(i / 3) * axis.at(i % 3);
      }
    }
    const Rotations all = principal({resistance[number].begin(), resistance[number].end()}, kGlobal);
    for (std::size_t i = 0; i < all.axes.size(); ++i) {
      if (!(all.resistance[i] > kNone * scale_[number])) {
        free_[number].push_back(all.axes[i]);
      }
    }
  }
}

void Search::list_twists() {
  for (std::size_t number = 0; number < given_->members.size(); ++number) {
    const Member& member = given_->members[number];
    const double length = static_cast<double>(member.elements) * kind_of(number).element_length;
    const double stiffness =
        torsion_of(given_->sections[member.section], length, member.ends[0].joint[0], member.ends[1].joint[0]);
    if (stiffness > 0.0) {
      twists_.push_back({.member = number,
                         .junction = {member.ends[0].junction, member.ends[1].junction},
                         .axis = place_of(network_->axes(number)[0]),
                         .stiffness = stiffness});
    }
  }
}

/// Rotations of a junction that no torsion ties to anything.
void Search::hold_untied() {
  std::vector<std::vector<double>> tied(free_.size());
  for (std::size_t junction = 0; junction < free_.size(); ++junction) {
    tied[junction].resize(free_[junction].size() * free_[junction].size(), 0.0);
  }
  for (const Twist& twist : twists_) {
    for (std::size_t end = 0; end < 2; ++end) {
      const std::vector<double> own = shares(twist, end);
      for (std::size_t i = 0; i < own.size() * own.size(); ++i) {
        tied[twist.junction[end]][i] += twist.stiffness * own[i / own.size()] * own[i % own.size()];
      }
    }
  }
  std::size_t count = 0;
  std::optional<std::size_t> first;
  for (std::size_t junction = 0; junction < free_.size(); ++junction) {
    if (free_[junction].empty()) {
      continue;
    }
    const Rotations all = principal(tied[junction], free_[junction]);
    free_[junction].clear();
    bool untied = false;
    for (std::size_t i = 0; i < all.axes.size(); ++i) {
      if (all.resistance[i] > kNone * scale_[junction]) {
        free_[junction].push_back(all.axes[i]);
      } else {
        found_.springs.push_back({.junction = junction, .axis = all.axes[i], .stiffness = scale_[junction]});
        untied = true;
      }
    }
    first = untied && !first ? junction : first;
    count += untied ? 1 : 0;
  }
  note(count, "1 junction has a rotation", " junctions have rotations", first.value_or(0));
}

/// Straight lines of members that nothing but their torsion ties together.
void Search::hold_lines() {
  DisjointSets sets{free_.size()};
  for (const Twist& twist : twists_) {
    if (couples(twist, 0) && couples(twist, 1)) {
      sets.join(twist.junction[0], twist.junction[1]);
    }
  }
  std::map<std::size_t, const Twist*> lines;  // by set: the first at the set's first junction
  std::vector<bool> other(free_.size(), false);
  for (std::size_t junction = 0; junction < free_.size(); ++junction) {
    other[sets.find(junction)] = other[sets.find(junction)] || free_[junction].size() > 1;
  }
  for (const Twist& twist : twists_) {
    for (std::size_t end = 0; end < 2; ++end) {
      const std::size_t junction = twist.junction[end];
      if (!couples(twist, end)) {
        continue;
      }
      const bool along = std::ranges::all_of(shares(twist, end), [](double s) { return std::abs(s) > 1.0 - kAlong; });
      const std::size_t set = sets.find(junction);
      other[set] = other[set] || !along || !couples(twist, 1 - end);
      if (junction == set) {
        lines.emplace(set, &twist);
      }
    }
  }
  std::erase_if(lines, [&](const auto& line) { return other[line.first]; });
  for (const auto& [junction, twist] : lines) {
    found_.springs.push_back({.junction = junction, .axis = free_[junction].front(), .stiffness = twist->stiffness});
  }
  note(lines.size(), "1 straight line of members has a rotation about its own axis",
       " straight lines of members have rotations about their own axes", lines.empty() ? 0 : lines.begin()->first);
}

/// Whatever is free is tied to what is not.
void Search::require_tied() const {
  std::vector<PetscInt> first(free_.size(), 0);
  std::vector<std::size_t> owner;
  for (std::size_t junction = 0; junction < free_.size(); ++junction) {
    first[junction] = static_cast<PetscInt>(owner.size());
    owner.insert(owner.end(), free_[junction].size(), junction);
  }
  if (owner.empty()) {
    return;
  }
  std::vector<MatrixEntry> entries;
  const auto add_square = [&entries](double stiffness, const std::vector<std::pair<PetscInt, double>>& row) {
    for (const auto& [i, one] : row) {
      for (const auto& [j, other] : row) {
        entries.push_back({.row = i, .column = j, .value = stiffness * one * other});
      }
    }
  };
  const auto put = [&](std::vector<std::pair<PetscInt, double>>& row, std::size_t junction, const Place& axis,
                       double sign) {
    for (std::size_t i = 0; i < free_[junction].size(); ++i) {
      row.emplace_back(first[junction] + static_cast<PetscInt>(i), sign * dot(free_[junction][i], axis));
    }
  };
  for (const Twist& twist : twists_) {
    std::vector<std::pair<PetscInt, double>> row;
    put(row, twist.junction[0], twist.axis, -1.0);
    put(row, twist.junction[1], twist.axis, 1.0);
    add_square(twist.stiffness, row);
  }
  for (const RotationSpring& spring : found_.springs) {
    std::vector<std::pair<PetscInt, double>> row;
    put(row, spring.junction, spring.axis, 1.0);
    add_square(spring.stiffness, row);
  }
  if (const Pivots pivots = pivots_of(entries, std::vector<double>(owner.size(), 0.0)); pivots.failed) {
    const Junction& loose = given_->junctions[owner[static_cast<std::size_t>(*pivots.failed)]];
    throw InputError{"network " + name_of(*given_, loose) +
                     ": it can turn, with others, and nothing resists, expected fewer hinges, a stiffness or a hold "
                     "against its rotation"};
  }
}

void Search::note(std::size_t count, const char* one, const char* many, std::size_t junction) {
  if (count > 0) {
    found_.notes.push_back("network: " + (count == 1 ? std::string{one} : std::to_string(count) + many) +
                           " that nothing resists and no force drives, held by a spring (" +
                           (count == 1 ? "" : "the first ") + "at " + name_of(*given_, given_->junctions[junction]) +
                           ")");
  }
}

}  // namespace

FreeRotations hold_free_rotations(const Network& network) { return Search{network}.run(); }

}  // namespace udar
