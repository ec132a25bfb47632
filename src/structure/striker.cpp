#include "udar/structure/striker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

std::ostream& operator<<(std::ostream& stream, const Place& place) {
  stream << place.x;
  return in_space(place) ? stream << ',' << place.y << ',' << place.z : stream;
}

template <class Value>
std::string refusal(const char* quantity, const Value& value, const char* expected) {
  std::ostringstream message;
  message << quantity << ": " << value << " is not allowed, expected " << expected;
  return message.str();
}

template <class Value>
void require(bool condition, const char* quantity, const Value& value, const char* expected) {
  if (!condition) {
    throw InputError{refusal(quantity, value, expected)};
  }
}

/// A striker and the local node that it strikes, on the rank that has it.
struct Struck {
  std::size_t striker;
  std::size_t node;
};

/// @note Collective.
std::vector<Struck> own_struck(const MassPoints& points, const std::vector<Striker>& strikers) {
  if (points.components() != 1) {
    throw InputError{"striker position: not allowed where points have several components"};
  }
  std::vector<Struck> own;
  std::vector<PetscInt> nodes;
  for (const Striker& striker : strikers) {
    require(striker.mass > 0.0 && std::isfinite(striker.mass), "striker mass", striker.mass, "a number > 0 [kg]");
    require(striker.gap >= 0.0 && std::isfinite(striker.gap), "striker gap", striker.gap, "a number >= 0 [m]");
    const Place& place = striker.place;
    const char* placed = in_space(place) ? "striker place" : "striker position";
    require_on(placed, place.x, points.extent());
    const PetscInt node = points.nearest(place);
    require(std::ranges::find(nodes, node) == nodes.end(), placed, place, "a node of its own for each striker [m]");
    require(points.height_of(node).size() == 1, placed, place, "a node that faces no oblique support [m]");
    std::string fault;
    if (points.owns(node)) {
      const auto local = static_cast<std::size_t>(node - points.begin());
      if (points.fixed(local)) {
        fault = refusal(placed, place, "a node that moves: this one is held [m]");
      }
      own.push_back({.striker = nodes.size(), .node = local});
    }
    throw_together<InputError>(points.comm(), fault);
    nodes.push_back(node);
  }
  return own;
}

/// Of centres of mass in place of their nodes, then of gaps.
std::vector<double> masses(const MassPoints& points, const std::vector<Striker>& strikers,
                           const std::vector<Struck>& own) {
  std::vector<double> mass{points.mass().begin(), points.mass().end()};
  for (const auto& [striker, node] : own) {
    const double of_node = mass[node];
    const double both = of_node + strikers[striker].mass;
    mass[node] = both;
    mass.push_back(of_node * strikers[striker].mass / both);
  }
  return mass;
}

std::vector<std::size_t> fixed_points(const MassPoints& points) {
  std::vector<std::size_t> fixed;
  for (std::size_t point = 0; point < points.points(); ++point) {
    if (points.fixed(point)) {
      fixed.push_back(point);
    }
  }
  return fixed;
}

class StruckPoints final : public MassPoints {
 public:
  StruckPoints(const MassPoints& points, const std::vector<Striker>& strikers)
      : StruckPoints{points, strikers, own_struck(points, strikers)} {}

  [[nodiscard]] std::size_t own_points() const override { return points_->points(); }
  [[nodiscard]] std::size_t own_point(std::size_t point) const override {
    return is_gap(point) ? own_[point - points_->points()].node : point;
  }
  [[nodiscard]] std::span<const Strike> strikes() const override { return strikes_; }
  [[nodiscard]] std::span<const NodeFrame> frames() const override { return points_->frames(); }

  [[nodiscard]] Direction direction(std::size_t point) const override {
    return is_gap(point) ? Direction::y : points_->direction(point);
  }
  [[nodiscard]] Place place(std::size_t point) const override { return points_->place(own_point(point)); }
  /// A gap is a difference of heights, which neither gravity nor a height of the whole changes.
  [[nodiscard]] Place axis(std::size_t point) const override { return is_gap(point) ? Place{} : points_->axis(point); }
  [[nodiscard]] Place turning(std::size_t point) const override {
    return is_gap(point) ? Place{} : points_->turning(point);
  }
  [[nodiscard]] std::optional<std::array<std::size_t, 2>> beside(std::size_t point) const override {
    return is_gap(point) ? std::nullopt : points_->beside(point);
  }
  [[nodiscard]] std::int64_t number(std::size_t point) const override {
    return is_gap(point) ? first_number_ + static_cast<std::int64_t>(own_[point - points_->points()].striker)
                         : points_->number(point);
  }

  [[nodiscard]] Extent extent() const override { return points_->extent(); }
  [[nodiscard]] double largest_extent() const override { return points_->largest_extent(); }
  [[nodiscard]] double total_mass() const override { return total_mass_; }

  [[nodiscard]] PetscInt nearest(const Place& place) const override { return moved(points_->nearest(place)); }
  [[nodiscard]] PointRows within(const Region& region, const Facing& facing) const override {
    return without_struck(points_->within(region, facing));
  }
  [[nodiscard]] PointRows section(double x, const Region& region, const Facing& facing) const override {
    return without_struck(points_->section(x, region, facing));
  }
  [[nodiscard]] std::vector<PointShare> height_of(PetscInt point) const override {
    for (const Strike& strike : strikes_) {
      if (strike.gap == point) {  // of its striker
        return {{.point = strike.centre, .share = 1.0}, {.point = strike.gap, .share = strike.gap_in_striker()}};
      }
    }
    const auto after = std::ranges::upper_bound(begins_, point) - begins_.begin() - 1;
    std::vector<PointShare> shares = points_->height_of(point - begins_[static_cast<std::size_t>(after)] +
                                                        structure_begins_[static_cast<std::size_t>(after)]);
    return with_gaps(std::move(shares));
  }
  [[nodiscard]] std::vector<PointShare> lever(const Place& place) const override {
    return with_gaps(points_->lever(place));
  }

 private:
  StruckPoints(const MassPoints& points, const std::vector<Striker>& strikers, std::vector<Struck> own)
      : MassPoints{points.comm(), 1, masses(points, strikers, own), fixed_points(points)},
        points_{&points},
        own_{std::move(own)},
        strikes_(strikers.size()),
        total_mass_{points.total_mass()} {
    int ranks = 1;
    MPI_Comm_size(comm(), &ranks);
    begins_.resize(static_cast<std::size_t>(ranks));
    structure_begins_.resize(begins_.size());
    const std::array<PetscInt, 2> begin{this->begin(), points.begin()};
    MPI_Allgather(begin.data(), 1, MPIU_INT, begins_.data(), 1, MPIU_INT, comm());
    MPI_Allgather(&begin[1], 1, MPIU_INT, structure_begins_.data(), 1, MPIU_INT, comm());
    for (std::size_t point = 0; point < points.points(); ++point) {
      first_number_ = std::max(first_number_, points.number(point) + 1);
    }
    MPI_Allreduce(MPI_IN_PLACE, &first_number_, 1, MPI_INT64_T, MPI_MAX, comm());
    std::vector<double> told(3 * strikers.size(), 0.0);  // centre, gap, share
    for (std::size_t i = 0; i < own_.size(); ++i) {
      const std::size_t gap = points.points() + i;
      told[3 * own_[i].striker] = static_cast<double>(global(own_[i].node));
      told[3 * own_[i].striker + 1] = static_cast<double>(global(gap));
      told[3 * own_[i].striker + 2] = strikers[own_[i].striker].mass / mass()[own_[i].node];
    }
    MPI_Allreduce(MPI_IN_PLACE, told.data(), static_cast<int>(told.size()), MPI_DOUBLE, MPI_SUM, comm());
    for (std::size_t k = 0; k < strikers.size(); ++k) {
      strikes_[k] = {.centre = static_cast<PetscInt>(told[3 * k]),
                     .gap = static_cast<PetscInt>(told[3 * k + 1]),
                     .striker = k,
                     .side = strikers[k].below ? -1.0 : 1.0,
                     .share = told[3 * k + 2],
                     .start = strikers[k].gap,
                     .velocity = strikers[k].velocity};
      total_mass_ += strikers[k].mass;
    }
  }

  [[nodiscard]] bool is_gap(std::size_t point) const { return point >= points_->points(); }
  /// Global number here of a global point of the structure.
  [[nodiscard]] PetscInt moved(PetscInt of_structure) const {
    const auto after = std::ranges::upper_bound(structure_begins_, of_structure) - structure_begins_.begin() - 1;
    return of_structure - structure_begins_[static_cast<std::size_t>(after)] + begins_[static_cast<std::size_t>(after)];
  }
  /// Of points of the structure: what of which points here adds up to them.
  [[nodiscard]] std::vector<PointShare> with_gaps(std::vector<PointShare> shares) const {
    const std::size_t count = shares.size();
    for (std::size_t i = 0; i < count; ++i) {
      shares[i].point = moved(shares[i].point);
      for (const Strike& strike : strikes_) {
        if (strike.centre == shares[i].point) {
          shares.push_back({.point = strike.gap, .share = shares[i].share * strike.gap_in_node()});
        }
      }
    }
    return shares;
  }
  /// @note Collective. @throws InputError if something else touches a node that is struck
  [[nodiscard]] PointRows without_struck(PointRows rows) const {
    std::string fault;
    for (const auto& [striker, node] : own_) {
      std::vector<std::size_t> struck{node};
      if (const auto others = points_->beside(node)) {
        struck.insert(struck.end(), others->begin(), others->end());
      }
      const auto touches = [&](const PointRows::Row& row) {
        return std::ranges::any_of(struck, [&](std::size_t point) { return row.first <= point && point < row.last; });
      };
      if (std::ranges::any_of(rows.rows, touches)) {
        const Place place = points_->place(node);
        std::ostringstream message;
        message << "striker position: no support may touch the node of a striker, at x = " << place.x
                << " m, from any side; floor, ground and boxes count";
        fault = message.str();
      }
    }
    throw_together<InputError>(comm(), fault);
    return rows;
  }

  const MassPoints* points_;
  std::vector<Struck> own_;  // in the order of the gaps
  std::vector<Strike> strikes_;
  std::vector<PetscInt> begins_;            // of the ranks' points
  std::vector<PetscInt> structure_begins_;  // the same of the structure's
  std::int64_t first_number_ = 0;           // of gaps
  double total_mass_;
};

}  // namespace

StruckStructure::StruckStructure(std::unique_ptr<const Structure> structure, const std::vector<Striker>& strikers)
    : structure_{std::move(structure)}, points_{std::make_unique<StruckPoints>(structure_->points(), strikers)} {}

void centres_to_nodes(const MassPoints& points, std::span<double> values) {
  each_own(points, [&](const Strike& strike, std::size_t centre, std::size_t gap) {
    values[centre] = strike.node_of(values[centre], values[gap]);
  });
}

std::vector<double> node_values(const MassPoints& points, std::span<const double> values) {
  std::vector<double> of_nodes{values.begin(), values.end()};
  centres_to_nodes(points, of_nodes);
  of_nodes.resize(points.own_points());
  return of_nodes;
}

std::vector<double> node_masses(const MassPoints& points) {
  const std::span<const double> all = points.mass();
  std::vector<double> mass{all.begin(), all.begin() + static_cast<std::ptrdiff_t>(points.own_points())};
  each_own(points,
           [&](const Strike& strike, std::size_t centre, std::size_t /*gap*/) { mass[centre] *= 1.0 - strike.share; });
  return mass;
}

}  // namespace udar
