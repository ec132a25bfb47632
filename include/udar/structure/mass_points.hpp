#pragma once
/// @file
/// The masses of a structure: where they stand, which rank has them, who finds them.

#include <petscsys.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "udar/numerics/height_grid.hpp"
#include "udar/structure/passage.hpp"

namespace udar {

/// @brief A place in global axes [m]: x along a beam, y up.
struct Place {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
};

/// @brief Which way a point of one component moves: along an axis, or no displacement at all, such as a rotation.
enum class Direction : std::uint8_t { other, x, y, z };

inline constexpr Place kUp{.y = 1.0};

/// Whether a place is given by more than its x.
[[nodiscard]] constexpr bool in_space(const Place& place) noexcept { return place.y != 0.0 || place.z != 0.0; }

/// @brief A box along the axes, edges included [m].
struct Region {
  static constexpr double kEnd = std::numeric_limits<double>::infinity();
  Place from{.x = -kEnd, .y = -kEnd, .z = -kEnd};
  Place to{.x = kEnd, .y = kEnd, .z = kEnd};

  /// Between two planes across x.
  [[nodiscard]] static Region across(double from, double to) {
    return {.from = {.x = from, .y = -kEnd, .z = -kEnd}, .to = {.x = to, .y = kEnd, .z = kEnd}};
  }
  /// Edges to the rounding of decimal fractions.
  [[nodiscard]] bool holds(const Place& place) const;
};

/// @brief Where a face looks: everywhere the same way, or up from a field of heights over x and z.
struct Facing {
  Place normal = kUp;                                 ///< unit vector [-]
  std::shared_ptr<const HeightGrid> field = nullptr;  ///< null: none

  /// Unit vector at a place, along the field's normal above or below it; zero where the field has no height.
  [[nodiscard]] Place at(const Place& place) const;
};

/// @brief The points of a node that moves along axes of its own: point k along axis k, unit vectors at right angles.
struct NodeFrame {
  std::array<std::size_t, 3> points{};  ///< local, of the unknowns along x, y, z
  std::array<Place, 3> axes{};
};

/// @brief Two that can touch, a node and the mass that strikes it or two nodes: their unknowns are the centre of mass
/// of both and the gap between them. Source: docs/theory.md, "Strikers", "Pairs of nodes"
struct Strike {
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  PetscInt centre = 0;          ///< global point, the node's own
  PetscInt gap = 0;             ///< global point, on the same rank; of two nodes the second one's own
  std::size_t striker = kNone;  ///< which; `kNone`: two nodes
  double side = 1.0;            ///< +1: the other stands above, further along the axis of the node's point; -1: below
  double share = 0.0;           ///< of the mass of both that is the other's [-]
  double touching = 0.0;        ///< value of the gap's unknown where the two touch [m]
  double start = 0.0;           ///< gap at the start [m]
  double velocity = 0.0;        ///< of the striker at the start [m/s], y up

  [[nodiscard]] bool of_nodes() const noexcept { return striker == kNone; }

  /// @name The change of unknowns, of heights, velocities and stretches alike; the other is the striker or second node
  /// @{
  [[nodiscard]] double gap_in_node() const noexcept { return -share * side; }          ///< beside a whole centre
  [[nodiscard]] double gap_in_other() const noexcept { return (1.0 - share) * side; }  ///< the same
  [[nodiscard]] double node_of(double of_centre, double of_gap) const noexcept {
    return of_centre + gap_in_node() * of_gap;
  }
  [[nodiscard]] double other_of(double of_centre, double of_gap) const noexcept {
    return of_centre + gap_in_other() * of_gap;
  }
  [[nodiscard]] double gap_of(double node, double other) const noexcept { return side * (other - node); }
  [[nodiscard]] double centre_of(double node, double other) const noexcept {
    return (1.0 - share) * node + share * other;
  }
  /// @}
  /// @name Forces, by the transposed
  /// @{
  [[nodiscard]] double force_on_node(double on_centre, double on_gap) const noexcept {
    return (1.0 - share) * on_centre - side * on_gap;
  }
  [[nodiscard]] double force_on_other(double on_centre, double on_gap) const noexcept {
    return share * on_centre + side * on_gap;
  }
  /// @}
};

/// @brief A mass that travels along a beam, which carries it. Its unknown is its height. Source: docs/theory.md,
/// "Travelling masses"
struct Rider {
  PetscInt point = 0;      ///< global, of the first rank
  double mass = 0.0;       ///< [kg], > 0
  double stiffness = 0.0;  ///< of the spring that it stands on [N/m]; infinite: none
  Passage passage;
};

/// @brief From the leftmost point to the rightmost, along x [m].
struct Extent {
  double from = 0.0;
  double to = 0.0;

  [[nodiscard]] double length() const noexcept { return to - from; }
  [[nodiscard]] double middle() const noexcept { return 0.5 * (from + to); }
};

/// @brief Whether a place lies on a structure, its ends included to the rounding of decimal fractions and of their
/// sums.
/// @param quantity that stands there, such as "load position"
/// @throws InputError naming it, and the range [m]
void require_on(const char* quantity, double x, const Extent& extent);

/// @brief Points that something touches, whichever ranks have them.
struct PointRows {
  /// Local points [first, last).
  struct Row {
    std::size_t first;
    std::size_t last;
  };
  std::vector<Row> rows;  ///< of this rank, ascending, apart from each other; points one by one are rows of one
  PetscInt count = 0;     ///< over all ranks
  double mass = 0.0;      ///< over all ranks [kg]
};

/// @brief A point and the share of something at a place beside it that it takes.
struct PointShare {
  PetscInt point;  ///< global
  double share;
};

/// @brief The layout that everything above a structure works on: points with one mass each, dealt to the ranks in
/// contiguous pieces. Immutable.
///
/// A point has one, two or three coordinates, y, or x and y, or all of them, each an oscillator of its own. Values per
/// coordinate stand component by component: index = component * points() + point; with one component it is the point.
class MassPoints {
 public:
  MassPoints(const MassPoints&) = delete;
  MassPoints& operator=(const MassPoints&) = delete;
  virtual ~MassPoints() = default;

  [[nodiscard]] MPI_Comm comm() const noexcept { return comm_; }
  [[nodiscard]] int components() const noexcept { return components_; }
  /// This rank's points are [begin, end) of `total`, in the order of the ranks.
  [[nodiscard]] PetscInt begin() const noexcept { return begin_; }
  [[nodiscard]] PetscInt end() const noexcept { return begin_ + static_cast<PetscInt>(points()); }
  [[nodiscard]] PetscInt total() const noexcept { return total_; }
  [[nodiscard]] std::size_t points() const noexcept { return mass_.size() / static_cast<std::size_t>(components_); }
  [[nodiscard]] std::size_t coordinates() const noexcept { return mass_.size(); }
  /// Global number of a local point.
  [[nodiscard]] PetscInt global(std::size_t point) const noexcept { return begin_ + static_cast<PetscInt>(point); }
  [[nodiscard]] bool owns(PetscInt global) const noexcept { return global >= begin() && global < end(); }

  /// Of each coordinate [kg], > 0 unless nothing can move it.
  [[nodiscard]] std::span<const double> mass() const noexcept { return mass_; }
  /// Whether a coordinate never moves.
  [[nodiscard]] bool fixed(std::size_t coordinate) const { return std::ranges::binary_search(fixed_, coordinate); }
  /// Which way the unknown of a local point moves in a structure with one component. Loads and what reads heights find
  /// points along y alone.
  [[nodiscard]] virtual Direction direction(std::size_t /*point*/) const { return Direction::y; }
  /// Where a local point stands as long as nothing strains the structure, without its initial state.
  [[nodiscard]] virtual Place place(std::size_t point) const = 0;
  /// Along which a local point moves, a unit vector; zero: nowhere. Of structures with one component. Not that of its
  /// unknown where its node has a frame.
  [[nodiscard]] virtual Place axis(std::size_t point) const;
  /// About which a local point turns that moves nowhere, a unit vector: its place is an angle [rad], its mass an
  /// inertia [kg m^2]; zero: about none.
  [[nodiscard]] virtual Place turning(std::size_t /*point*/) const { return {}; }
  /// The other two points of a node of three, none of others.
  [[nodiscard]] virtual std::optional<std::array<std::size_t, 2>> beside(std::size_t /*point*/) const { return {}; }
  /// Nodes whose axes are their own.
  [[nodiscard]] virtual std::span<const NodeFrame> frames() const { return {}; }
  /// Who can touch whom: by striker, then pairs of nodes; of all ranks.
  [[nodiscard]] virtual std::span<const Strike> strikes() const { return {}; }
  /// Masses that travel along the structure; of all ranks.
  [[nodiscard]] virtual std::span<const Rider> riders() const { return {}; }
  /// The points of nodes alone, each an unknown of its node: all but gaps of strikers and travelling masses, which
  /// follow them.
  [[nodiscard]] virtual const MassPoints& nodes() const { return *this; }
  /// Whether there are no others, and no pairs of nodes.
  [[nodiscard]] bool of_nodes_alone() const { return &nodes() == this; }
  /// How many those are on this rank, the first of these.
  [[nodiscard]] std::size_t own_points() const { return nodes().points(); }
  /// The own point of the node that a local point belongs to: itself, of a gap the centre, of a travelling mass the
  /// first.
  [[nodiscard]] virtual std::size_t own_point(std::size_t point) const { return point; }
  /// The same of one coordinate [m]: its share of the height; 0 of a point that moves across, whose coordinate is how
  /// far it went.
  [[nodiscard]] double reference(std::size_t coordinate) const;
  /// Number of a local point in the model of the user.
  [[nodiscard]] virtual std::int64_t number(std::size_t point) const { return global(point); }

  /// Equal on every rank.
  [[nodiscard]] virtual Extent extent() const = 0;
  /// The largest distance between two points along any axis [m].
  [[nodiscard]] virtual double largest_extent() const { return extent().length(); }
  [[nodiscard]] virtual double total_mass() const = 0;  ///< of what moves along y [kg]

  /// @name Searches among points that move along y. Collective: each may take a reduction.
  /// @{
  /// The nearest point, the first of those equally near.
  [[nodiscard]] virtual PetscInt nearest(const Place& place) const = 0;
  /// All points in a region, edges included to their rounding, that move along the normal of a face.
  [[nodiscard]] virtual PointRows within(const Region& region, const Facing& facing) const = 0;
  /// Of them all with the x that is nearest, the smaller of two equally near; the region's own x does not count.
  [[nodiscard]] virtual PointRows section(double x, const Region& region, const Facing& facing) const = 0;
  /// The height of the node at a point that moves along y: what of which points adds up to it; equal on every rank.
  [[nodiscard]] virtual std::vector<PointShare> height_of(PetscInt point) const { return {{point, 1.0}}; }
  /// What a force at a place is dealt to, so that force and moment stay where that can be; equal on every rank.
  [[nodiscard]] virtual std::vector<PointShare> lever(const Place& place) const { return height_of(nearest(place)); }
  /// @}
  /// What of which unknowns adds up to shares of points of nodes.
  [[nodiscard]] virtual std::vector<PointShare> of_unknowns(std::vector<PointShare> of_nodes) const { return of_nodes; }
  /// One by its global number. @note Collective: one reduction.
  [[nodiscard]] PointRows single(PetscInt global) const;

 protected:
  /// @param mass of this rank's coordinates [kg], component by component @param fixed coordinates, ascending
  /// @note Collective.
  MassPoints(MPI_Comm comm, int components, std::vector<double> mass, std::vector<std::size_t> fixed);

 private:
  MPI_Comm comm_;
  int components_;
  std::vector<double> mass_;
  std::vector<std::size_t> fixed_;
  PetscInt begin_ = 0;
  PetscInt total_ = 0;
};

/// @brief Visits this rank's strikes. @param visit (strike, local point of the centre, of the gap)
template <class Visit>
void each_own(const MassPoints& points, const Visit& visit) {
  for (const Strike& strike : points.strikes()) {
    if (points.owns(strike.centre)) {
      visit(strike, static_cast<std::size_t>(strike.centre - points.begin()),
            static_cast<std::size_t>(strike.gap - points.begin()));
    }
  }
}

/// @brief What places points that know no more than where they stand: one entry a local point, but for `fixed`.
struct PointTable {
  std::vector<double> mass;            ///< [kg], of each coordinate, component by component
  std::vector<Place> place;            ///< [m]
  std::vector<std::size_t> fixed;      ///< coordinates that never move, ascending
  std::vector<std::int64_t> number;    ///< in the model of the user; empty: as they stand
  std::vector<Direction> direction{};  ///< of one component; empty: all along y
  std::size_t nodes = 0;               ///< points are so many nodes' along y, then along x, then along z; 0: no nodes
  std::vector<NodeFrame> frames{};     ///< of nodes whose points move along axes of their own
  std::vector<Place> turning{};        ///< axes of the last points, which turn
};

/// @brief Points anywhere, in any order.
class PlacedPoints final : public MassPoints {
 public:
  /// @note Collective. @throws InputError on all ranks if sizes do not fit, a mass is negative, a number is none, or
  /// nothing moves along y
  PlacedPoints(MPI_Comm comm, int components, PointTable table);

  [[nodiscard]] Place place(std::size_t point) const override { return place_[point]; }
  [[nodiscard]] std::int64_t number(std::size_t point) const override {
    return number_.empty() ? MassPoints::number(point) : number_[point];
  }
  [[nodiscard]] Direction direction(std::size_t point) const override {
    return direction_.empty() ? Direction::y : direction_[point];
  }
  [[nodiscard]] Extent extent() const override { return extent_; }
  [[nodiscard]] double largest_extent() const override { return largest_extent_; }
  [[nodiscard]] double total_mass() const override { return total_mass_; }
  [[nodiscard]] PetscInt nearest(const Place& place) const override;
  [[nodiscard]] PointRows within(const Region& region, const Facing& facing) const override;
  [[nodiscard]] PointRows section(double x, const Region& region, const Facing& facing) const override;
  [[nodiscard]] std::vector<PointShare> height_of(PetscInt point) const override;
  [[nodiscard]] Place axis(std::size_t point) const override;
  [[nodiscard]] Place turning(std::size_t point) const override {
    const std::size_t first = points() - turning_.size();
    return point < first ? Place{} : turning_[point - first];
  }
  [[nodiscard]] std::optional<std::array<std::size_t, 2>> beside(std::size_t point) const override;
  [[nodiscard]] std::span<const NodeFrame> frames() const override { return frames_; }

 private:
  PlacedPoints(PointTable&& table, MPI_Comm comm, int components);
  [[nodiscard]] bool moves_along(std::size_t point, const Facing& facing) const;
  /// Which axis of which frame a point moves along.
  struct Framed {
    const NodeFrame* frame;
    std::size_t axis;
  };
  [[nodiscard]] std::optional<Framed> framed(std::size_t point) const;

  std::vector<Place> place_;
  std::vector<std::int64_t> number_;
  std::vector<Direction> direction_;
  std::size_t nodes_ = 0;
  std::vector<NodeFrame> frames_;
  std::vector<Place> turning_;       // of the last points
  std::vector<std::size_t> framed_;  // of a point: 1 + 3 frame + axis, or 0; empty without frames
  std::vector<std::size_t> by_x_;    // local points that move anywhere, ascending by x, then by number
  Extent extent_;
  double largest_extent_ = 0.0;
  double total_mass_ = 0.0;
};

}  // namespace udar
