// ranks: 1 2 3; size: short
// The layout of masses: of a beam, whose searches need no messages, and of points anywhere.

#include "udar/structure/mass_points.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <string>

#include "support/steel_beam.hpp"
#include "support/world.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

/// The points of a beam of `elements`, dealt as its own and with the same masses, x in another order.
class Scattered {
 public:
  explicit Scattered(const BeamChain& beam, PetscInt stride)
      : points_{beam.comm(), 1, table(beam, stride)}, nodes_{beam.nodes()}, stride_{stride} {}

  [[nodiscard]] const MassPoints& points() const { return points_; }
  /// The node of the beam that is a point.
  [[nodiscard]] PetscInt node(PetscInt point) const { return point * stride_ % nodes_; }

 private:
  static PointTable table(const BeamChain& beam, PetscInt stride) {
    PointTable table;
    for (PetscInt point = beam.begin(); point < beam.end(); ++point) {
      const PetscInt node = point * stride % beam.nodes();
      table.mass.push_back(beam.mass(node));
      table.place.push_back({.x = beam.position(node)});
      table.number.push_back(100 + node);
      if (beam.fixed(node)) {
        table.fixed.push_back(table.mass.size() - 1);
      }
    }
    return table;
  }

  PlacedPoints points_;
  PetscInt nodes_;
  PetscInt stride_;
};

/// Global numbers of all points of a selection, on every rank.
std::vector<PetscInt> numbers_of(const MassPoints& points, const PointRows& rows) {
  std::vector<PetscInt> hit(static_cast<std::size_t>(points.total()), 0);
  for (const auto& [first, last] : rows.rows) {
    for (std::size_t point = first; point < last; ++point) {
      ++hit[static_cast<std::size_t>(points.global(point))];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, hit.data(), static_cast<int>(hit.size()), MPIU_INT, MPI_SUM, points.comm());
  std::vector<PetscInt> numbers;
  for (std::size_t i = 0; i < hit.size(); ++i) {
    EXPECT_LE(hit[i], 1) << "point " << i;
    if (hit[i] > 0) {
      numbers.push_back(static_cast<PetscInt>(i));
    }
  }
  EXPECT_EQ(rows.count, static_cast<PetscInt>(numbers.size()));
  return numbers;
}

BeamParameters pinned_beam() {
  BeamParameters parameters = test::steel_beam(20);
  parameters.left = test::kPinned;
  return parameters;
}

TEST(MassPoints, OfABeamAreItsNodes) {
  const BeamChain beam{PETSC_COMM_WORLD, pinned_beam()};
  const MassPoints& points = beam.points();
  EXPECT_EQ(points.components(), 1);
  EXPECT_EQ(points.begin(), beam.begin());
  EXPECT_EQ(points.end(), beam.end());
  EXPECT_EQ(points.total(), 21);
  EXPECT_EQ(points.coordinates(), points.points());
  for (std::size_t point = 0; point < points.points(); ++point) {
    const PetscInt node = points.global(point);
    EXPECT_EQ(points.mass()[point], beam.mass(node));
    EXPECT_EQ(points.place(point).x, beam.position(node));
    EXPECT_EQ(points.reference(point), 0.0);
    EXPECT_EQ(points.fixed(point), node == 0);
    EXPECT_EQ(points.number(point), node);
  }
  EXPECT_EQ(points.extent().to, 10.0);
  EXPECT_EQ(beam.rigid_modes(), 2);
  EXPECT_EQ(beam.chain(), &beam);
}

TEST(MassPoints, AnywhereAreFoundAsThoseOfTheBeamTheyComeFrom) {
  const BeamChain beam{PETSC_COMM_WORLD, pinned_beam()};
  for (const PetscInt stride : {PetscInt{1}, PetscInt{8}}) {
    const Scattered scattered{beam, stride};
    const MassPoints& points = scattered.points();
    EXPECT_NEAR(points.total_mass(), beam.total_mass(), 1e-12 * beam.total_mass());  // rounding of 21 terms
    EXPECT_EQ(points.extent().from, 0.0);
    EXPECT_EQ(points.extent().to, 10.0);
    // Also beside the beam and, but for the order of equally near ones, in the middle between two nodes.
    for (const double x : {-3.0, 0.0, 0.2, 4.7, 5.0, 9.9, 30.0}) {
      EXPECT_EQ(scattered.node(points.nearest({.x = x})), beam.nearest_node(x)) << "x " << x;
    }
    for (const auto& [from, to] : {std::pair{2.0, 4.0}, {2.1, 2.4}, {-5.0, 0.0}, {0.0, 10.0}, {9.9, 50.0}}) {
      const PointRows rows = points.within(Region::across(from, to), {.normal = kUp});
      const BeamChain::NodeRange nodes = beam.nodes_within(from, to);
      std::vector<PetscInt> found;
      for (const PetscInt point : numbers_of(points, rows)) {
        found.push_back(scattered.node(point));
      }
      std::ranges::sort(found);
      std::vector<PetscInt> asked(static_cast<std::size_t>(std::max<PetscInt>(nodes.last - nodes.first + 1, 0)));
      std::iota(asked.begin(), asked.end(), nodes.first);
      EXPECT_EQ(found, asked) << from << " to " << to;
      const PointRows own = beam.points().within(Region::across(from, to), {.normal = kUp});
      EXPECT_EQ(own.count, rows.count);
      EXPECT_NEAR(own.mass, rows.mass, 1e-12 * beam.total_mass());  // rounding, as above
      EXPECT_EQ(numbers_of(beam.points(), own), asked);
    }
    EXPECT_EQ(numbers_of(points, points.within({}, {.normal = kUp})).size(), 21U);
    EXPECT_EQ(numbers_of(points, points.single(7)), std::vector<PetscInt>{7});
    EXPECT_EQ(points.single(7).mass, beam.mass(scattered.node(7)));
    for (std::size_t point = 0; point < points.points(); ++point) {
      EXPECT_EQ(points.number(point), 100 + scattered.node(points.global(point)));
      EXPECT_EQ(points.fixed(point), scattered.node(points.global(point)) == 0);
    }
  }
}

TEST(MassPoints, EquallyNearAreTakenByTheirNumber) {
  int rank = 0;
  int size = 1;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  // Each rank has one point of a circle; the last has its centre, too.
  PointTable table{.mass = {1.0}, .place = {{.x = rank % 2 == 0 ? 3.0 : -3.0, .y = 4.0}}, .fixed = {}, .number = {}};
  if (rank == size - 1) {
    table.mass.push_back(1.0);
    table.place.push_back({.z = 2.0});
  }
  const PlacedPoints points{PETSC_COMM_WORLD, 1, table};
  EXPECT_EQ(points.nearest({.z = 1.0}), size);
  EXPECT_EQ(points.nearest({.y = 10.0}), 0);
}

TEST(MassPoints, OfSeveralComponentsStandComponentByComponent) {
  PointTable table{.mass = {1.0, 2.0, 1.0, 2.0, 1.0, 2.0},
                   .place = {{.x = 1.0, .y = 2.0, .z = 3.0}, {.x = 4.0, .y = 5.0, .z = 6.0}},
                   .fixed = {3},
                   .number = {}};
  const PlacedPoints points{PETSC_COMM_WORLD, 3, table};
  EXPECT_EQ(points.points(), 2U);
  EXPECT_EQ(points.coordinates(), 6U);
  std::vector<double> reference;
  for (std::size_t i = 0; i < points.coordinates(); ++i) {
    reference.push_back(points.reference(i));
    EXPECT_EQ(points.fixed(i), i == 3);
  }
  EXPECT_EQ(reference, (std::vector<double>{1.0, 4.0, 2.0, 5.0, 3.0, 6.0}));
}

/// Each rank has a node at x = 2 r with unknowns along x, y and z, of which 1, 2 and 3 kg; one along y stands above.
TEST(MassPoints, ThoseThatMoveAlongYAreFoundAlone) {
  const int rank = test::world_rank();
  const Place node{.x = 2.0 * rank, .y = 0.5};
  PointTable table{.mass = {1.0, 2.0, 3.0, 4.0},
                   .place = {node, node, node, {.x = node.x, .y = 5.0}},
                   .fixed = {},
                   .number = {},
                   .direction = {Direction::x, Direction::y, Direction::z, Direction::y}};
  const PlacedPoints points{PETSC_COMM_WORLD, 1, table};
  const int size = static_cast<int>(points.total() / 4);
  EXPECT_EQ(points.total_mass(), 6.0 * size);
  EXPECT_EQ(points.within({}, {.normal = kUp}).count, 2 * size);
  EXPECT_EQ(points.largest_extent(), std::max(4.5, 2.0 * (size - 1))) << "from 0.5 to 5 m high";
  EXPECT_EQ(points.reference(0), 0.0);
  EXPECT_EQ(points.reference(1), 0.5);
  EXPECT_EQ(points.nearest({}), 1);
  const PointRows section = points.section(2.0 * (size - 1) + 0.3, {}, {.normal = kUp});  // of the last rank
  EXPECT_EQ(section.count, 2);
  EXPECT_EQ(section.mass, 6.0);
  EXPECT_EQ(section.rows.size(), rank + 1 == size ? 2U : 0U);
  EXPECT_EQ(points.section(-7.0, {}, {.normal = kUp}).rows.size(), rank == 0 ? 2U : 0U);
}

TEST(MassPoints, RefuseWhatIsNone) {
  const auto failure = [](const PointTable& table) {
    return test::failure_of<InputError>([&] { static_cast<void>(PlacedPoints{PETSC_COMM_WORLD, 1, table}); });
  };
  EXPECT_NE(failure({.mass = {-1.0}, .place = {{}}, .fixed = {}, .number = {}}).find("[kg]"), std::string::npos);
  EXPECT_NE(failure({.mass = {1.0}, .place = {}, .fixed = {}, .number = {}}).find("0 places"), std::string::npos);
  EXPECT_NE(failure({.mass = {1.0}, .place = {{.y = std::nan("")}}, .fixed = {}, .number = {}}).find("place"),
            std::string::npos);
}

}  // namespace
}  // namespace udar
