// ranks: 1 2 3 4; size: medium
// Four are the fewest on which a rank in the middle has another between itself and an end.
/// @file
/// The chain solver against the same line solved in 113-bit arithmetic, and its manners as a PETSc type.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "support/steel_beam.hpp"
#include "support/world.hpp"
#include "tools/quad_line.hpp"
#include "udar/filter/pc_chain.hpp"

namespace udar {
namespace {

/// A line to solve, by the number of elements.
struct Line {
  const char* name;
  std::function<BeamParameters(PetscInt)> build;
  PetscInt fewest;  // elements that it needs
};

BeamParameters with_ends(PetscInt elements, const BeamEnd& left, const BeamEnd& right) {
  BeamParameters beam = test::steel_beam(elements);
  beam.left = left;
  beam.right = right;
  return beam;
}

/// Three segments of different mesh, section, shear and foundation; point masses; springs under the line.
BeamParameters uneven(PetscInt elements) {
  BeamParameters beam = test::steel_beam(elements - 4);
  const BeamSegment first = beam.segments[0];
  beam.segments[0].elements = elements / 2;
  beam.segments.push_back(first);
  beam.segments[1].elements = elements - elements / 2 - 2;
  beam.segments[1].length = 3.0;
  beam.segments[1].shear_stiffness = 4e7;
  beam.segments[1].foundation_stiffness = 5e4;
  beam.segments.push_back(first);
  beam.segments[2].elements = 2;
  beam.segments[2].mass_per_length *= 40.0;
  beam.segments[2].bending_stiffness *= 0.1;
  beam.point_masses = {{.position = 4.0, .mass = 300.0}, {.position = 11.0, .mass = 20.0}};
  beam.line_supports = {{.position = 2.0, .stiffness = 1e5}, {.position = 7.0}, {.position = 14.0}};
  return beam;
}

/// Two beams that do not touch.
BeamParameters apart(PetscInt elements) {
  BeamParameters beam = test::steel_beam(elements / 3);
  beam.segments.push_back({.length = 0.5, .elements = 1});
  beam.segments.push_back(test::steel_beam(elements - elements / 3 - 1).segments[0]);
  beam.right = test::kClamped;
  return beam;
}

/// Masses spread over six decades, every node its own.
BeamParameters spread(PetscInt elements) {
  BeamParameters beam = test::steel_beam(elements);
  std::mt19937 generator{7};
  std::uniform_real_distribution<double> decades{-3.0, 3.0};
  const double share = beam.segments[0].mass_per_length * 10.0 / static_cast<double>(elements);
  for (PetscInt node = 0; node <= elements; ++node) {
    beam.point_masses.push_back({.position = 10.0 * static_cast<double>(node) / static_cast<double>(elements),
                                 .mass = share * std::pow(10.0, decades(generator))});
  }
  return beam;
}

const BeamEnd kSpring{.translational_stiffness = 1e6, .rotational_stiffness = 1e6};

const std::vector<Line>& lines() {
  static const std::vector<Line> all{
      {"free", test::steel_beam, 5},
      {"clamped", [](PetscInt n) { return with_ends(n, test::kClamped, test::kClamped); }, 5},
      {"pinned", [](PetscInt n) { return with_ends(n, test::kPinned, test::kPinned); }, 5},
      {"cantilever", [](PetscInt n) { return with_ends(n, {}, test::kClamped); }, 5},
      {"springs", [](PetscInt n) { return with_ends(n, kSpring, {.translational_stiffness = 5e5}); }, 5},
      {"uneven", uneven, 20},
      {"apart", apart, 12},
      {"spread", spread, 5}};
  return all;
}

/// A motion with some of everything: offset and tilt, gentle and short waves; smooth, and at rest where an end is held.
struct Motion {
  std::vector<double> displacement;  // of all nodes
  std::vector<double> force;

  Motion(const BeamChain& beam, double offset, double tilt) {
    for (PetscInt node = 0; node < beam.nodes(); ++node) {
      const double s = beam.position(node) / beam.length();
      const double window = (beam.fixed(0) ? s : 1.0) * (beam.fixed(beam.elements()) ? 1.0 - s : 1.0);
      displacement.push_back(beam.fixed(node) ? 0.0
                                              : offset + tilt * s +
                                                    window * (5e-4 * (std::cos(3.0 * s) + std::sin(7.0 * s) + s * s) +
                                                              1e-6 * std::sin(300.0 * s)));
      force.push_back(beam.mass(node) * (1.0 + std::cos(20.0 * s)));
    }
  }
  [[nodiscard]] std::vector<double> local(const BeamChain& beam, const std::vector<double>& all) const {
    return {all.begin() + beam.begin(), all.begin() + beam.end()};
  }
};

class ChainOfLanes : public testing::TestWithParam<int> {};

TEST_P(ChainOfLanes, SolvesEveryLineToRoundOff) {
  if (GetParam() > chain::native_lanes()) {
    GTEST_SKIP() << "this processor has no vectors of " << GetParam() << " numbers";
  }
  const test::Option lanes{"-filter_pc_chain_lanes", std::to_string(GetParam()).c_str()};
  for (const Line& kind : lines()) {
    // With nothing inside stretches, with stretches one at a time, with one group of lanes, with many and a rest.
    for (const PetscInt elements :
         {PetscInt{7}, PetscInt{12}, PetscInt{20}, PetscInt{67}, PetscInt{300}, PetscInt{7001}}) {
      if (elements < kind.fewest) {
        continue;
      }
      SCOPED_TRACE(std::string{kind.name} + ", " + std::to_string(elements) + " elements");
      const BeamChain beam{PETSC_COMM_WORLD, kind.build(elements)};
      FilteredStructure line{beam, {.filter_frequency = 50.0, .check_interval = 1}};
      ASSERT_NE(line.chain(), nullptr);
      const auto count = static_cast<std::size_t>(beam.local_nodes());
      for (const bool loaded : {false, true}) {
        const Motion motion{beam, 0.0, 0.0};
        const auto exact =
            tools::quad_line(beam, 50.0, motion.displacement, loaded ? motion.force : std::vector<double>{});
        const auto displacement = motion.local(beam, motion.displacement);
        const auto force = loaded ? motion.local(beam, motion.force) : std::vector<double>{};
        std::vector<double> stretch(count);
        std::vector<double> again(count);
        std::vector<double> moment(count);
        line.solve(displacement, force, stretch, moment);
        line.solve(displacement, force, again, {});
        // 1e-12: the accuracy that docs/theory.md promises for accelerations.
        EXPECT_LT(tools::relative_error(beam, stretch, exact.stretch), 1e-12);
        EXPECT_LT(tools::relative_error(beam, again, exact.stretch), 1e-12);
        // Moments follow the second differences of what is left of the displacement.
        EXPECT_LT(tools::relative_error(beam, moment, exact.moment), 1e-10);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Lanes, ChainOfLanes, testing::Values(1, 4, 8));

/// A line of up to five segments and everything else at random; properties over four decades.
BeamParameters random_line(std::mt19937& generator) {
  const auto number = [&](double from, double to) { return std::uniform_real_distribution{from, to}(generator); };
  const auto pick = [&](PetscInt from, PetscInt to) { return std::uniform_int_distribution{from, to}(generator); };
  const auto power = [&](double from, double to) { return std::pow(10.0, number(from, to)); };
  const auto end = [&]() -> BeamEnd {
    switch (pick(0, 4)) {
      case 0:
        return {};
      case 1:
        return test::kPinned;
      case 2:
        return test::kClamped;
      case 3:
        return {.translational_stiffness = power(3.0, 8.0), .rotational_stiffness = power(3.0, 8.0)};
      default:
        return {.translational_stiffness = 0.0, .rotational_stiffness = BeamEnd::kRigid};
    }
  };
  BeamParameters beam;
  double length = 0.0;
  for (PetscInt count = pick(1, 5); count > 0; --count) {
    if (length > 0.0 && pick(0, 3) == 0) {
      beam.segments.push_back({.length = number(0.1, 1.0), .elements = 1});
      length += beam.segments.back().length;
    }
    const std::array<PetscInt, 3> most{4, 100, 3000};
    beam.segments.push_back({.length = number(0.5, 20.0),
                             .elements = pick(1, most[static_cast<std::size_t>(pick(0, 2))]),
                             .bending_stiffness = 1.6e7 * power(-2.0, 2.0),
                             .mass_per_length = 246.0 * power(-2.0, 2.0)});
    if (pick(0, 2) == 0) {
      beam.segments.back().shear_stiffness = power(6.0, 10.0);
    }
    beam.segments.back().foundation_stiffness = pick(0, 3) == 0 ? power(2.0, 6.0) : 0.0;
    length += beam.segments.back().length;
  }
  beam.left = end();
  beam.right = end();
  for (PetscInt count = pick(0, 4); count > 0; --count) {
    beam.point_masses.push_back({.position = number(0.0, length), .mass = power(-1.0, 4.0)});
  }
  for (PetscInt count = pick(0, 3); count > 0; --count) {
    beam.line_supports.push_back({.position = number(0.0, length)});
    if (pick(0, 1) == 0) {
      beam.line_supports.back().stiffness = power(3.0, 8.0);
    }
  }
  return beam;
}

TEST(Chain, SolvesRandomLines) {
  std::mt19937 generator{2};
  int solved = 0;
  for (int number = 0; number < 150; ++number) {
    const BeamParameters parameters = random_line(generator);
    const double wf = std::pow(10.0, std::uniform_real_distribution{0.5, 3.5}(generator));
    PetscInt elements = 0;
    for (const BeamSegment& segment : parameters.segments) {
      elements += segment.elements;
    }
    if (elements + 1 < 2 * test::world_size()) {
      continue;
    }
    SCOPED_TRACE("line " + std::to_string(number) + " of " + std::to_string(elements) + " elements");
    const BeamChain beam{PETSC_COMM_WORLD, parameters};
    FilteredStructure line{beam, {.filter_frequency = wf, .check_interval = 1}};
    const Motion motion{beam, 0.0, 0.0};
    const std::vector<double> force = number % 2 == 0 ? motion.force : std::vector<double>{};
    const auto exact = tools::quad_line(beam, wf, motion.displacement, force);
    std::vector<double> stretch(static_cast<std::size_t>(beam.local_nodes()));
    std::vector<double> moment(stretch.size());
    line.solve(motion.local(beam, motion.displacement),
               force.empty() ? std::vector<double>{} : motion.local(beam, force), stretch, moment);
    // Neighbouring segments differ by up to four decades, and the line jumps where it is held: round-off of the larger
    // states is seen in the smaller results.
    EXPECT_LT(tools::relative_error(beam, stretch, exact.stretch), 1e-10);
    EXPECT_LT(tools::relative_error(beam, moment, exact.moment), 1e-6);
    ++solved;
  }
  EXPECT_GT(solved, 100);
}

TEST(Chain, KeepsItsDigitsUnderOffsetAndTilt) {
  for (const Line& kind : {lines()[0], lines()[7]}) {
    SCOPED_TRACE(kind.name);
    const BeamChain beam{PETSC_COMM_WORLD, kind.build(100000)};
    FilteredStructure line{beam, {.filter_frequency = 50.0}};
    const Motion motion{beam, 1.0, 0.3};
    const auto exact = tools::quad_line(beam, 50.0, motion.displacement, {});
    std::vector<double> stretch(static_cast<std::size_t>(beam.local_nodes()));
    line.solve(motion.local(beam, motion.displacement), {}, stretch, {});
    EXPECT_LT(tools::relative_error(beam, stretch, exact.stretch), 1e-11);
  }
}

TEST(Chain, IsNotStretchedByRigidMotion) {
  const BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(4096)};  // x are exact, and so is a tilt of 1/4
  FilteredStructure line{beam, {.filter_frequency = 50.0}};
  std::vector<double> displacement;
  for (PetscInt node = beam.begin(); node < beam.end(); ++node) {
    displacement.push_back(1.0 + 0.25 * static_cast<double>(node) / 4096.0);
  }
  std::vector<double> stretch(displacement.size(), 1.0);
  line.solve(displacement, {}, stretch, {});
  for (const double value : stretch) {
    ASSERT_EQ(value, 0.0);
  }
}

TEST(Chain, SolvesColumnsTogetherAsOneByOne) {
  const BeamChain beam{PETSC_COMM_WORLD, uneven(4000)};
  FilteredStructure line{beam, {.filter_frequency = 50.0}};
  const auto count = static_cast<std::size_t>(beam.local_nodes());
  constexpr std::size_t kColumns = 7;
  std::vector<std::vector<double>> given;
  std::vector<std::vector<double>> together(kColumns, std::vector<double>(count));
  for (std::size_t c = 0; c < kColumns; ++c) {
    const Motion motion{beam, 0.01 * static_cast<double>(c), 0.1};
    given.push_back(motion.local(beam, motion.displacement));
  }
  std::vector<FilterColumn> columns;
  columns.reserve(kColumns);
  for (std::size_t c = 0; c < kColumns; ++c) {
    columns.push_back({.displacement = given[c].data(), .stretch = together[c].data()});
  }
  line.solve(columns);
  EXPECT_EQ(line.solves(), static_cast<PetscInt>(kColumns));
  for (std::size_t c = 0; c < kColumns; ++c) {
    std::vector<double> alone(count);
    line.solve(given[c], {}, alone, {});
    for (std::size_t i = 0; i < count; ++i) {
      // The joints of four columns are swept by other instructions than those of one: round-off of 0.2 m.
      ASSERT_NEAR(together[c][i], alone[i], 1e-15);
    }
  }
}

/// The preconditioner as PETSc sees it: the operator of a line, a solver on it, and vectors.
struct ByPetsc {
  BeamChain beam;
  FilteredStructure line;
  petsc::Vector right;
  petsc::Vector found;
  petsc::Vector product;

  explicit ByPetsc(BeamParameters parameters)
      : beam{PETSC_COMM_WORLD, std::move(parameters)}, line{beam, {.filter_frequency = 50.0}} {
    UDAR_CALL(MatCreateVecs(line.op(), found.put(), right.put()));
    UDAR_CALL(VecDuplicate(right, product.put()));
    for (PetscInt row = 2 * beam.begin(); row < 2 * beam.end(); ++row) {
      UDAR_CALL(VecSetValue(right, row, std::sin(0.01 * static_cast<double>(row)), INSERT_VALUES));
    }
    UDAR_CALL(VecAssemblyBegin(right));
    UDAR_CALL(VecAssemblyEnd(right));
  }
  /// Normwise backward error of `found`.
  [[nodiscard]] double backward_error() const {
    double largest = 0.0;
    double scale = 0.0;
    double norm = 0.0;
    UDAR_CALL(MatNorm(line.filter_operator().matrix(), NORM_INFINITY, &norm));
    UDAR_CALL(MatMult(line.op(), found, product));
    UDAR_CALL(VecAXPY(product, -1.0, right));
    UDAR_CALL(VecNorm(product, NORM_INFINITY, &largest));
    UDAR_CALL(VecNorm(found, NORM_INFINITY, &scale));
    return largest / (norm * scale);
  }
};

// Round-off of the recursion's states, which are larger than its results where masses differ by decades.
constexpr double kBackwardError = 1e-14;

TEST(PcChain, InvertsTheOperatorForAnyRightHandSide) {
  for (const Line& kind : lines()) {
    SCOPED_TRACE(kind.name);
    ByPetsc with{kind.build(500)};
    PC pc = nullptr;
    UDAR_CALL(KSPGetPC(with.line.solver(), &pc));
    UDAR_CALL(PCApply(pc, with.right, with.found));
    EXPECT_LT(with.backward_error(), kBackwardError);
    petsc::Vector transposed;
    UDAR_CALL(VecDuplicate(with.found, transposed.put()));
    UDAR_CALL(PCApplyTranspose(pc, with.right, transposed));
    PetscBool same = PETSC_FALSE;
    UDAR_CALL(VecEqual(transposed, with.found, &same));
    EXPECT_EQ(same, PETSC_TRUE);
  }
}

TEST(PcChain, PreconditionsAnIterativeSolver) {
  const test::Option method{"-filter_ksp_type", "gmres"};
  ByPetsc with{uneven(3000)};
  EXPECT_EQ(with.line.chain(), nullptr);
  UDAR_CALL(KSPSolve(with.line.solver(), with.right, with.found));
  PetscInt iterations = 0;
  UDAR_CALL(KSPGetIterationNumber(with.line.solver(), &iterations));
  EXPECT_LE(iterations, 2);
  EXPECT_LT(with.backward_error(), kBackwardError);
}

TEST(PcChain, SolvesTheColumnsOfADenseMatrix) {
  constexpr PetscInt kColumns = 6;
  ByPetsc with{apart(900)};
  petsc::Matrix right;
  petsc::Matrix found;
  const PetscInt rows = 2 * with.beam.local_nodes();
  for (petsc::Matrix* matrix : {&right, &found}) {
    UDAR_CALL(MatCreateDense(PETSC_COMM_WORLD, rows, PETSC_DECIDE, PETSC_DETERMINE, kColumns, nullptr, matrix->put()));
  }
  for (PetscInt c = 0; c < kColumns; ++c) {
    Vec column = nullptr;
    UDAR_CALL(MatDenseGetColumnVecWrite(right, c, &column));
    UDAR_CALL(VecCopy(with.right, column));
    UDAR_CALL(VecScale(column, 1.0 + static_cast<double>(c)));
    UDAR_CALL(MatDenseRestoreColumnVecWrite(right, c, &column));
  }
  UDAR_CALL(KSPMatSolve(with.line.solver(), right, found));
  UDAR_CALL(KSPSolve(with.line.solver(), with.right, with.found));
  for (PetscInt c = 0; c < kColumns; ++c) {
    Vec column = nullptr;
    double difference = 0.0;
    double scale = 0.0;
    UDAR_CALL(MatDenseGetColumnVecRead(found, c, &column));
    UDAR_CALL(VecWAXPY(with.product, -1.0 - static_cast<double>(c), with.found, column));
    UDAR_CALL(VecNorm(with.product, NORM_INFINITY, &difference));
    UDAR_CALL(VecNorm(column, NORM_INFINITY, &scale));
    UDAR_CALL(MatDenseRestoreColumnVecRead(found, c, &column));
    EXPECT_LT(difference / scale, 1e-14);
  }
}

TEST(PcChain, ServesAnAssembledMatrixThatCarriesItsLine) {
  ByPetsc with{uneven(400)};
  petsc::LinearSolver solver;
  UDAR_CALL(KSPCreate(PETSC_COMM_WORLD, solver.put()));
  UDAR_CALL(KSPSetOperators(solver, with.line.filter_operator().matrix(), with.line.filter_operator().matrix()));
  PC pc = nullptr;
  UDAR_CALL(KSPGetPC(solver, &pc));
  UDAR_CALL(PCSetType(pc, kPcChain));
  UDAR_CALL(KSPSetType(solver, KSPPREONLY));
  UDAR_CALL(KSPSolve(solver, with.right, with.found));
  EXPECT_LT(with.backward_error(), kBackwardError);
}

TEST(PcChain, RefusesAnyOtherMatrixByName) {
  petsc::Matrix matrix;
  UDAR_CALL(
      MatCreateAIJ(PETSC_COMM_WORLD, 4, 4, PETSC_DETERMINE, PETSC_DETERMINE, 1, nullptr, 0, nullptr, matrix.put()));
  UDAR_CALL(PetscObjectSetName(reinterpret_cast<PetscObject>(static_cast<Mat>(matrix)), "heat"));
  UDAR_CALL(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  UDAR_CALL(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  UDAR_CALL(register_pc_chain());
  petsc::Handle<PC, PCDestroy> pc;
  UDAR_CALL(PCCreate(PETSC_COMM_WORLD, pc.put()));
  UDAR_CALL(PCSetOperators(pc, matrix, matrix));
  UDAR_CALL(PCSetType(pc, kPcChain));
  const std::string message = test::failure_of<InputError>([&] { UDAR_CALL(PCSetUp(pc)); });
  EXPECT_NE(message.find("'heat' of type"), std::string::npos) << message;
}

TEST(FilteredStructure, TakesTheBlockFormForTensionAndSaysSo) {
  BeamParameters pulled = test::steel_beam(50);
  pulled.tension = 1e5;
  const BeamChain beam{PETSC_COMM_WORLD, pulled};
  FilteredStructure line{beam, {.filter_frequency = 50.0}};
  EXPECT_EQ(line.chain(), nullptr);
  EXPECT_EQ(line.filter_operator().block_form_reason(), "tension");
  const test::Option chain{"-filter_pc_type", "chain"};
  const std::string message =
      test::failure_of<InputError>([&] { const FilteredStructure refused{beam, {.filter_frequency = 50.0}}; });
  EXPECT_NE(message.find("tension"), std::string::npos) << message;
}

TEST(ChainCoupling, IsChosenByTheDecayAcrossARank) {
  int size = 1;
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  // Decay length 3.2 m: a short beam couples all ranks, one of 2 km only neighbours.
  for (const double length : {10.0, 2000.0}) {
    BeamParameters parameters = test::steel_beam(900);
    parameters.segments[0].length = length;
    const BeamChain beam{PETSC_COMM_WORLD, parameters};
    FilteredStructure line{beam, {.filter_frequency = 50.0, .check_interval = 1}};
    ASSERT_NE(line.chain(), nullptr);
    using chain::Coupling;
    // Two ranks are each other's only neighbours.
    const Coupling expected =
        size == 1 ? Coupling::none : (size == 2 || length > 1000.0 ? Coupling::neighbours : Coupling::all);
    EXPECT_EQ(line.chain()->report().coupling, expected) << length << " m";
    const Motion motion{beam, 0.1, 0.1};
    const auto exact = tools::quad_line(beam, 50.0, motion.displacement, motion.force);
    std::vector<double> stretch(static_cast<std::size_t>(beam.local_nodes()));
    line.solve(motion.local(beam, motion.displacement), motion.local(beam, motion.force), stretch, {});
    EXPECT_LT(tools::relative_error(beam, stretch, exact.stretch), 1e-12) << length << " m";
  }
}

}  // namespace
}  // namespace udar
