// ranks: 1 2; size: medium
/// @file
/// The registered TS types as PETSc uses them: step, interpolation through impacts, rollback, view, missing problem.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "support/steel_beam.hpp"
#include "udar/integrators/problem_integrator.hpp"
#include "udar/integrators/ts_chebyshev.hpp"
#include "udar/integrators/ts_impact.hpp"
#include "udar/petsc/array.hpp"

namespace udar {
namespace {

/// A beam that touches the floor at its left end soon, its TS made by hand.
struct Stepped {
  BeamChain beam{PETSC_COMM_WORLD, test::steel_beam(20)};
  FilteredStructure line{beam, {.filter_frequency = 100.0}};
  Loads loads{beam.points(), 9.81, {}};
  InitialState initial{.height = 0.52, .slope = 0.1, .velocity = -3.0};
  Equations equations{line, loads, initial};
  Contacts contacts = find_contacts(beam.points(), {Support::floor(0.0, 0.5)});
  ContactState contact{beam.points(), contacts, {.hop_tolerance = 1e-10}};
  ImpactProblem problem{.equations = &equations, .contact = &contact, .scale = {.length = 1.0, .velocity = 4.0}};
  petsc::Vector state;
  petsc::TimeStepper ts;

  explicit Stepped(const char* type) {
    UDAR_CALL(register_ts_chebyshev());
    UDAR_CALL(register_ts_impact());
    const MassState masses = initial_masses(beam.points(), initial);
    const std::size_t count = masses.position.size();
    UDAR_CALL(VecCreateMPI(beam.comm(), static_cast<PetscInt>(2 * count), PETSC_DETERMINE, state.put()));
    {
      const petsc::WriteArray values{state};
      std::ranges::copy(masses.position, values.values());
      std::ranges::copy(masses.velocity, values.values() + count);
    }
    UDAR_CALL(TSCreate(beam.comm(), ts.put()));
    UDAR_CALL(TSSetType(ts, type));
    UDAR_CALL(TSSetTolerances(ts, PETSC_DEFAULT, nullptr, std::string{type} == kTsImpact ? 1e-9 : 1e-14, nullptr));
    compose_problem(ts, problem);
    UDAR_CALL(TSSetSolution(ts, state));
    UDAR_CALL(TSSetMaxTime(ts, 1.0));
    UDAR_CALL(TSSetTimeStep(ts, 0.004));
    UDAR_CALL(TSSetUp(ts));
    LineState at_start;
    {
      const petsc::ReadArray values{state};
      equations.evaluate(0.0, {values.values(), count}, at_start);
    }
    integrator_inside(ts)->start(at_start);
  }

  double step() {
    double time = 0.0;
    contact.begin_step();
    integrator_inside(ts)->begin_step();
    UDAR_CALL(TSStep(ts));
    UDAR_CALL(TSGetTime(ts, &time));
    return time;
  }
  [[nodiscard]] std::vector<double> values(Vec vector) const {
    const petsc::ReadArray read{vector};
    return {read.values(), read.values() + 2 * static_cast<std::size_t>(beam.local_nodes())};
  }
  [[nodiscard]] bool hit() const {
    int hits = static_cast<int>(contact.journal().impacts().size());
    MPI_Allreduce(MPI_IN_PLACE, &hits, 1, MPI_INT, MPI_SUM, beam.comm());
    return hits > 0;
  }
};

TEST(TsTypes, InterpolateThroughAnImpact) {
  Stepped impact{kTsImpact};
  double begin = 0.0;
  double end = impact.step();
  while (!impact.hit()) {
    impact.contact.commit(end, {});
    begin = end;
    end = impact.step();
    ASSERT_LT(end, 0.1);
  }
  for (const double share : {0.1, 0.5, 0.9, 1.0}) {
    const double time = (1.0 - share) * begin + share * end;
    petsc::Vector here;
    UDAR_CALL(VecDuplicate(impact.state, here.put()));
    UDAR_CALL(TSInterpolate(impact.ts, time, here));
    // The same time by exact propagation, from impact to impact.
    Stepped exact{kTsChebyshev};
    double reached = 0.0;
    while (reached < time - 1e-15) {
      UDAR_CALL(TSSetTimeStep(exact.ts, time - reached));
      reached = exact.step();
      exact.contact.commit(reached, {});
    }
    const auto found = impact.values(here);
    const auto expected = exact.values(exact.state);
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_NEAR(found[i], expected[i], i < found.size() / 2 ? 1e-9 : 1e-7) << "value " << i << " at " << share;
    }
  }
}

TEST(TsTypes, RollBackAndStepAgain) {
  for (const char* type : {kTsChebyshev, kTsImpact}) {
    Stepped run{type};
    double end = run.step();
    auto before = run.values(run.state);
    double start = 0.0;
    while (!run.hit()) {
      run.contact.commit(end, {});
      start = end;
      before = run.values(run.state);
      UDAR_CALL(TSSetTimeStep(run.ts, 0.004));
      end = run.step();
      ASSERT_LT(end, 0.1);
    }
    const auto after = run.values(run.state);
    double time = 0.0;
    UDAR_CALL(TSRollBack(run.ts));
    UDAR_CALL(TSGetTime(run.ts, &time));
    EXPECT_EQ(time, start) << type;
    EXPECT_EQ(run.values(run.state), before) << type;
    EXPECT_FALSE(run.hit()) << type;
    UDAR_CALL(TSStep(run.ts));
    const auto again = run.values(run.state);
    // The impact integrator starts its sweeps from the polynomial it has found: not from the same guess.
    for (std::size_t i = 0; i < again.size(); ++i) {
      EXPECT_NEAR(again[i], after[i], std::string{type} == kTsImpact ? 1e-8 : 0.0) << type;
    }
  }
}

TEST(TsTypes, RefuseToRunWithoutAProblem) {
  for (const char* type : {kTsChebyshev, kTsImpact}) {
    const Stepped registered{type};
    petsc::TimeStepper alone;
    UDAR_CALL(TSCreate(PETSC_COMM_WORLD, alone.put()));
    UDAR_CALL(TSSetType(alone, type));
    UDAR_CALL(TSSetSolution(alone, registered.state));
    try {
      UDAR_CALL(TSSetUp(alone));
      FAIL() << type << " ran without a problem";
    } catch (const InputError& error) {
      EXPECT_NE(std::string{error.what()}.find("no problem is composed"), std::string::npos) << error.what();
    }
  }
}

TEST(TsTypes, ShowThemselves) {
  for (const char* type : {kTsChebyshev, kTsImpact}) {
    Stepped run{type};
    run.step();
    int size = 0;
    MPI_Comm_size(PETSC_COMM_WORLD, &size);
    const std::string path = testing::TempDir() + "udar_" + type + "_view_" + std::to_string(size) + ".txt";
    PetscViewer viewer = nullptr;
    UDAR_CALL(PetscViewerASCIIOpen(PETSC_COMM_WORLD, path.c_str(), &viewer));
    UDAR_CALL(TSView(run.ts, viewer));
    UDAR_CALL(PetscViewerDestroy(&viewer));
    if (run.beam.begin() > 0) {
      continue;  // the first rank has written it
    }
    std::ifstream file{path};
    const std::string text{std::istreambuf_iterator<char>{file}, {}};
    std::filesystem::remove(path);
    EXPECT_NE(text.find("type: " + std::string{type}), std::string::npos) << text;
    EXPECT_NE(text.find("steps 1,"), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace udar
