#include "udar/structure/striker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

#include "structure/beam_nodes.hpp"
#include "structure/place_algebra.hpp"
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

/// Two that can touch, on the rank that has them.
struct Struck {
  std::size_t strike;                ///< which of all
  std::size_t node;                  ///< local point
  std::optional<std::size_t> other;  ///< local point of the second node; none: a striker
  double side;
  double mass;  ///< of the other [kg]
};

void require_gap(const char* quantity, double gap) {
  require(gap >= 0.0 && std::isfinite(gap), quantity, gap, "a number >= 0 [m]");
}

/// The node at a place, a point along y. @note Collective.
PetscInt struck_node(const MassPoints& points, const char* quantity, const Place& place, const char* expected) {
  require_on(quantity, place.x, points.extent());
  const PetscInt node = points.nearest(place);
  require(points.height_of(node).size() == 1, quantity, place, expected);
  return node;
}

/// @note Collective.
std::vector<Struck> own_struck(const MassPoints& points, const std::vector<Striker>& strikers) {
  std::vector<Struck> own;
  std::vector<PetscInt> nodes;
  for (const Striker& striker : strikers) {
    require(striker.mass > 0.0 && std::isfinite(striker.mass), "striker mass", striker.mass, "a number > 0 [kg]");
    require_gap("striker gap", striker.gap);
    const Place& place = striker.place;
    const char* placed = in_space(place) ? "striker place" : "striker position";
    const PetscInt node = struck_node(points, placed, place, "a node that faces no oblique support [m]");
    require(std::ranges::find(nodes, node) == nodes.end(), placed, place, "a node of its own for each striker [m]");
    std::string fault;
    if (points.owns(node)) {
      const auto local = static_cast<std::size_t>(node - points.begin());
      if (points.fixed(local)) {
        fault = refusal(placed, place, "a node that moves: this one is held [m]");
      }
      own.push_back({.strike = nodes.size(),
                     .node = local,
                     .other = std::nullopt,
                     .side = striker.below ? -1.0 : 1.0,
                     .mass = striker.mass});
    }
    throw_together<InputError>(points.comm(), fault);
    nodes.push_back(node);
  }
  return own;
}

/// Of a node the point that moves along a direction, either way; none if there is none.
std::optional<std::size_t> point_along(const MassPoints& points, std::size_t node, const Place& normal) {
  constexpr double kParallel = 1e-9;
  std::vector<std::size_t> all{node};
  if (const auto others = points.beside(node)) {
    all.insert(all.end(), others->begin(), others->end());
  }
  const auto found = std::ranges::find_if(
      all, [&](std::size_t point) { return std::abs(std::abs(dot(points.axis(point), normal)) - 1.0) <= kParallel; });
  return found != all.end() ? std::optional{*found} : std::nullopt;
}

/// What is wrong with a pair on the rank that has it; empty: nothing. @param[out] own that of the pair is added
std::string add_pair(const MassPoints& points, const NodePair& pair, std::array<PetscInt, 2> nodes,
                     std::vector<Struck>& own, std::size_t strike) {
  std::array<std::size_t, 2> local{};
  for (std::size_t end = 0; end < 2; ++end) {
    const char* const placed = end == 0 ? "pair from place" : "pair to place";
    const Place& place = end == 0 ? pair.from : pair.to;
    const auto point = point_along(points, static_cast<std::size_t>(nodes.at(end) - points.begin()), pair.normal);
    if (!point) {
      return refusal("pair normal", pair.normal,
                     "1,0,0, 0,1,0 or 0,0,1, or one of these turned round, along which "
                     "both nodes move [-]");
    }
    if (points.fixed(*point)) {
      return refusal(placed, place, "a node that moves: this one is held, a support is what it can be hit by [m]");
    }
    if (std::ranges::any_of(own, [&](const Struck& other) { return other.node == *point || other.other == point; })) {
      return refusal(placed, place, "a node of its own for each striker and each pair in its direction [m]");
    }
    local.at(end) = *point;
  }
  own.push_back({.strike = strike,
                 .node = local[0],
                 .other = local[1],
                 .side = dot(points.axis(local[0]), pair.normal) > 0.0 ? 1.0 : -1.0,
                 .mass = points.mass()[local[1]]});
  return {};
}

/// Behind those of strikers. @note Collective.
void add_pairs(const MassPoints& points, const std::vector<NodePair>& pairs, std::size_t strikers,
               std::vector<Struck>& own) {
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const NodePair& pair = pairs[i];
    require_gap("pair gap", pair.gap);
    constexpr const char* kUpright = "a node that faces no oblique support [m]";
    const std::array nodes{struck_node(points, "pair from place", pair.from, kUpright),
                           struck_node(points, "pair to place", pair.to, kUpright)};
    require(nodes[0] != nodes[1], "pair to place", pair.to,
            "a place nearest to another node than `pair from place` [m]");
    std::string fault;
    if (points.owns(nodes[0]) != points.owns(nodes[1])) {
      fault =
          refusal("pair to place", pair.to, "a node on the rank of the other one of the pair: take fewer ranks [m]");
    } else if (points.owns(nodes[0])) {
      fault = add_pair(points, pair, nodes, own, strikers + i);
    }
    throw_together<InputError>(points.comm(), fault);
  }
}

/// @note Collective.
std::vector<Struck> own_struck(const MassPoints& points, const std::vector<Striker>& strikers,
                               const std::vector<NodePair>& pairs) {
  if (points.components() != 1) {
    throw InputError{(!strikers.empty() ? std::string{"striker position"}
                      : !pairs.empty()  ? std::string{"pair from place"}
                                        : std::string{"load axles"}) +
                     ": not allowed where points have several components"};
  }
  std::vector<Struck> own = own_struck(points, strikers);
  add_pairs(points, pairs, strikers.size(), own);
  return own;
}

/// The masses among axles, without the points that they will be. @note Collective.
std::vector<Rider> masses_of_axles(const MassPoints& points, std::span<const TravellingLoad> travelling) {
  std::vector<Rider> riders;
  for (const TravellingLoad& load : travelling) {
    const auto x = std::make_shared<const std::vector<double>>(beam_nodes(points, "load axles"));
    require_sound(load, x->size());
    for (std::size_t axle = 0; axle < load.offset.size(); ++axle) {
      const double stiffness = load.stiffness_of(axle);
      if (load.mass_of(axle) > 0.0) {
        riders.push_back({.point = 0,
                          .mass = load.mass_of(axle),
                          .stiffness = stiffness > 0.0 ? stiffness : std::numeric_limits<double>::infinity(),
                          .passage = {load, axle, x}});
      }
    }
  }
  return riders;
}

bool on_first_rank(MPI_Comm comm) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  return rank == 0;
}

/// Of centres of mass in place of their nodes and of gaps, those of strikers behind all nodes, then of what travels.
std::vector<double> masses(const MassPoints& points, const std::vector<Struck>& own, std::span<const Rider> riders) {
  std::vector<double> mass{points.mass().begin(), points.mass().end()};
  for (const Struck& struck : own) {
    const double of_node = mass[struck.node];
    const double both = of_node + struck.mass;
    mass[struck.node] = both;
    const double reduced = of_node * struck.mass / both;
    if (struck.other) {
      mass[*struck.other] = reduced;
    } else {
      mass.push_back(reduced);
    }
  }
  for (std::size_t i = 0; i < riders.size() && on_first_rank(points.comm()); ++i) {
    mass.push_back(riders[i].mass);
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
  StruckPoints(const MassPoints& points, const std::vector<Striker>& strikers, const std::vector<NodePair>& pairs,
               std::span<const TravellingLoad> travelling)
      : StruckPoints{points, strikers, pairs, own_struck(points, strikers, pairs),
                     masses_of_axles(points, travelling)} {}

  [[nodiscard]] const MassPoints& nodes() const override { return *points_; }
  [[nodiscard]] std::size_t own_point(std::size_t point) const override {
    return is_rider(point) ? 0 : is_striker(point) ? gaps_[point - points_->points()].node : point;
  }
  [[nodiscard]] std::span<const Strike> strikes() const override { return strikes_; }
  [[nodiscard]] std::span<const Rider> riders() const override { return riders_; }
  [[nodiscard]] std::span<const NodeFrame> frames() const override { return points_->frames(); }

  [[nodiscard]] Direction direction(std::size_t point) const override {
    return is_behind(point) ? Direction::y : points_->direction(point);
  }
  [[nodiscard]] Place place(std::size_t point) const override { return points_->place(own_point(point)); }
  /// A gap is a difference of heights, which neither gravity nor a height of the whole changes.
  [[nodiscard]] Place axis(std::size_t point) const override {
    return is_gap(point) ? Place{} : is_rider(point) ? kUp : points_->axis(point);
  }
  [[nodiscard]] Place turning(std::size_t point) const override {
    return is_behind(point) ? Place{} : points_->turning(point);
  }
  [[nodiscard]] std::optional<std::array<std::size_t, 2>> beside(std::size_t point) const override {
    return is_behind(point) ? std::nullopt : points_->beside(point);
  }
  [[nodiscard]] std::int64_t number(std::size_t point) const override {
    if (is_rider(point)) {
      return first_rider_number_ + static_cast<std::int64_t>(point - points_->points() - gaps_.size());
    }
    return is_striker(point) ? first_number_ + static_cast<std::int64_t>(gaps_[point - points_->points()].strike)
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
      if (strike.gap == point && !strike.of_nodes()) {  // of its striker
        return {{.point = strike.centre, .share = 1.0}, {.point = strike.gap, .share = strike.gap_in_other()}};
      }
    }
    if (std::ranges::find(riders_, point, &Rider::point) != riders_.end()) {
      return {{.point = point, .share = 1.0}};
    }
    const auto after = std::ranges::upper_bound(begins_, point) - begins_.begin() - 1;
    return of_structure(points_->height_of(point - begins_[static_cast<std::size_t>(after)] +
                                           structure_begins_[static_cast<std::size_t>(after)]));
  }
  [[nodiscard]] std::vector<PointShare> lever(const Place& place) const override {
    return of_structure(points_->lever(place));
  }
  [[nodiscard]] std::vector<PointShare> of_unknowns(std::vector<PointShare> of_nodes) const override {
    const std::size_t count = of_nodes.size();
    for (std::size_t i = 0; i < count; ++i) {
      for (const Strike& strike : strikes_) {
        if (strike.centre == of_nodes[i].point) {
          of_nodes.push_back({.point = strike.gap, .share = of_nodes[i].share * strike.gap_in_node()});
        } else if (strike.gap == of_nodes[i].point) {
          of_nodes.push_back({.point = strike.gap, .share = of_nodes[i].share * strike.gap_in_other()});
          of_nodes[i].point = strike.centre;
          break;
        }
      }
    }
    return of_nodes;
  }

 private:
  StruckPoints(const MassPoints& points, const std::vector<Striker>& strikers, const std::vector<NodePair>& pairs,
               const std::vector<Struck>& own, std::vector<Rider> riders)
      : MassPoints{points.comm(), 1, masses(points, own, riders), fixed_points(points)},
        points_{&points},
        strikes_(strikers.size() + pairs.size()),
        riders_{std::move(riders)},
        total_mass_{points.total_mass()} {
    for (const Struck& struck : own) {
      struck_.push_back(struck.node);
      if (struck.other) {
        struck_.push_back(*struck.other);
        between_nodes_.push_back(*struck.other);
      } else {
        gaps_.push_back(struck);
      }
    }
    std::ranges::sort(between_nodes_);
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
    tell_strikes(own);
    for (std::size_t k = 0; k < strikers.size(); ++k) {
      strikes_[k].striker = k;
      strikes_[k].start = strikers[k].gap;
      strikes_[k].velocity = strikers[k].velocity;
      total_mass_ += strikers[k].mass;
    }
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      Strike& strike = strikes_[strikers.size() + k];
      strike.start = pairs[k].gap;
      strike.touching -= pairs[k].gap;
    }
    first_rider_number_ = first_number_ + static_cast<std::int64_t>(strikers.size());
    auto point = static_cast<PetscInt>(points_->points() + gaps_.size());
    MPI_Bcast(&point, 1, MPIU_INT, 0, comm());
    for (Rider& rider : riders_) {
      rider.point = point++;
      total_mass_ += rider.mass;
    }
  }

  /// From the rank that has them to all. @note Collective.
  void tell_strikes(const std::vector<Struck>& own) {
    constexpr std::size_t kNumbers = 5;  // centre, gap, share, side, how far apart the nodes stand
    std::vector<double> told(kNumbers * strikes_.size(), 0.0);
    std::size_t behind = points_->points();
    for (const auto& [strike, node, other, side, mass] : own) {
      const std::array<double, kNumbers> numbers{
          static_cast<double>(global(node)), static_cast<double>(global(other ? *other : behind++)),
          mass / this->mass()[node], side,
          other ? side * (points_->reference(*other) - points_->reference(node)) : 0.0};
      std::ranges::copy(numbers, told.begin() + static_cast<std::ptrdiff_t>(kNumbers * strike));
    }
    MPI_Allreduce(MPI_IN_PLACE, told.data(), static_cast<int>(told.size()), MPI_DOUBLE, MPI_SUM, comm());
    for (std::size_t k = 0; k < strikes_.size(); ++k) {
      const std::span<const double> numbers{&told[kNumbers * k], kNumbers};
      strikes_[k].centre = static_cast<PetscInt>(numbers[0]);
      strikes_[k].gap = static_cast<PetscInt>(numbers[1]);
      strikes_[k].share = numbers[2];
      strikes_[k].side = numbers[3];
      strikes_[k].touching = numbers[4];
    }
  }

  [[nodiscard]] bool is_behind(std::size_t point) const { return point >= points_->points(); }
  [[nodiscard]] bool is_striker(std::size_t point) const { return is_behind(point) && !is_rider(point); }
  [[nodiscard]] bool is_rider(std::size_t point) const { return point >= points_->points() + gaps_.size(); }
  [[nodiscard]] bool is_gap(std::size_t point) const {
    return is_striker(point) || std::ranges::binary_search(between_nodes_, point);
  }
  /// Global number here of a global point of the structure.
  [[nodiscard]] PetscInt moved(PetscInt of_structure) const {
    const auto after = std::ranges::upper_bound(structure_begins_, of_structure) - structure_begins_.begin() - 1;
    return of_structure - structure_begins_[static_cast<std::size_t>(after)] + begins_[static_cast<std::size_t>(after)];
  }
  /// Of points of the structure: what of which points here adds up to them.
  [[nodiscard]] std::vector<PointShare> of_structure(std::vector<PointShare> shares) const {
    for (PointShare& share : shares) {
      share.point = moved(share.point);
    }
    return of_unknowns(std::move(shares));
  }
  /// @note Collective. @throws InputError if something else touches a node that is struck
  [[nodiscard]] PointRows without_struck(PointRows rows) const {
    std::string fault;
    for (const std::size_t node : struck_) {
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
        message << "striker position, pair from place, pair to place: no support may touch the node of a striker or of "
                   "a pair, at x = "
                << place.x << " m, from any side; floor, ground and boxes count";
        fault = message.str();
      }
    }
    throw_together<InputError>(comm(), fault);
    return rows;
  }

  const MassPoints* points_;
  std::vector<Struck> gaps_;                // of strikers, in the order of their points
  std::vector<std::size_t> between_nodes_;  // points of nodes that are gaps, ascending
  std::vector<std::size_t> struck_;         // points of nodes
  std::vector<Strike> strikes_;
  std::vector<Rider> riders_;
  std::vector<PetscInt> begins_;            // of the ranks' points
  std::vector<PetscInt> structure_begins_;  // the same of the structure's
  std::int64_t first_number_ = 0;           // of gaps
  std::int64_t first_rider_number_ = 0;
  double total_mass_;
};

}  // namespace

StruckStructure::StruckStructure(std::unique_ptr<const Structure> structure, const std::vector<Striker>& strikers,
                                 const std::vector<NodePair>& pairs, std::span<const TravellingLoad> travelling)
    : structure_{std::move(structure)},
      points_{std::make_unique<StruckPoints>(structure_->points(), strikers, pairs, travelling)} {}

void centres_to_nodes(const MassPoints& points, std::span<double> values) {
  each_own(points, [&](const Strike& strike, std::size_t centre, std::size_t gap) {
    const double of_centre = values[centre];
    values[centre] = strike.node_of(of_centre, values[gap]);
    if (strike.of_nodes()) {
      values[gap] = strike.other_of(of_centre, values[gap]);
    }
  });
}

void nodes_to_centres(const MassPoints& points, std::span<double> values) {
  each_own(points, [&](const Strike& strike, std::size_t centre, std::size_t gap) {
    if (strike.of_nodes()) {
      values[gap] = strike.gap_of(values[centre], values[gap]);
    }
    values[centre] -= strike.gap_in_node() * values[gap];
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
  each_own(points, [&](const Strike& strike, std::size_t centre, std::size_t gap) {
    if (strike.of_nodes()) {
      mass[gap] = strike.share * all[centre];
    }
    mass[centre] *= 1.0 - strike.share;
  });
  return mass;
}

}  // namespace udar
