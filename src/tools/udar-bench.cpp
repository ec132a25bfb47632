/// @file
/// Measurements of udar's parts; every table in docs/performance.md names the call that printed it.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "udar/app/case.hpp"
#include "udar/app/run.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/session.hpp"

namespace {

using namespace udar;
__extension__ using Quad = __float128;

enum class Kind { accuracy };
constexpr std::array kKinds{std::pair<const char*, Kind>{"accuracy", Kind::accuracy}};

/// A way to solve the line: its name in the table, its formulation and its solver options.
struct Form {
  const char* name;
  Formulation formulation;
  std::vector<std::pair<const char*, const char*>> options;
  PetscInt most_elements;  // beyond, a solve takes too long to be worth a line in the table
};

std::vector<Form> forms(bool given) {
  constexpr PetscInt kAny = 100'000'000;
  if (given) {
    return {{"mixed, solver as given", Formulation::mixed, {}, kAny}};
  }
  return {{"hermite, BAIJ LU + refinement", Formulation::hermite, {{"-filter_pc_type", "lu"}}, kAny},
          {"mixed, AIJ LU (pointwise)",
           Formulation::mixed,
           {{"-filter_pc_type", "lu"}, {"-filter_mat_type", "aij"}, {"-filter_ksp_max_it", "1"}},
           kAny},
          {"mixed, MUMPS LU",
           Formulation::mixed,
           {{"-filter_pc_type", "lu"}, {"-filter_pc_factor_mat_solver_type", "mumps"}, {"-filter_ksp_max_it", "1"}},
           100'000},
          {"mixed, BAIJ LU", Formulation::mixed, {{"-filter_pc_type", "lu"}, {"-filter_ksp_max_it", "1"}}, kAny},
          {"mixed, default (LU + refinement)", Formulation::mixed, {}, kAny}};
}

/// The smooth motion: half a millimetre of each of three gentle shapes.
double smooth_displacement(double x, double length) {
  const double s = x / length;
  return 5e-4 * (std::cos(3.0 * s) + std::sin(7.0 * s) + s * s);
}

/// Spring stretch of a free uniform beam without loads, solved in 113-bit arithmetic: the mixed form of
/// docs/theory.md, unscaled, by block elimination.
std::vector<double> quad_stretch(const BeamChain& beam, double wf, const std::vector<double>& displacement) {
  struct Block {
    Quad a, b, c, d;
  };
  const auto n = static_cast<std::size_t>(beam.nodes());
  const BeamElement element = beam.element(0);
  const Quad h = static_cast<Quad>(beam.length()) / static_cast<Quad>(beam.elements());
  const Quad bend = h * static_cast<Quad>(element.flexural_compliance) / 6;
  std::vector<Block> factor(n);  // inverse of the pivot block times the coupling to the next node
  std::vector<std::array<Quad, 2>> x(n);
  for (std::size_t i = 0; i < n; ++i) {
    const bool first = i == 0;
    const bool last = i + 1 == n;
    const Quad k = static_cast<Quad>(wf) * wf * beam.mass(static_cast<PetscInt>(i));
    const auto u = [&](std::size_t j) { return static_cast<Quad>(displacement[j]); };
    // Rows (d_i, mu_i); at a free end mu = 0 and its row and column are left out.
    const Quad t = first || last ? Quad{0} : -2 / h;
    Block pivot{k, t, t, first || last ? Quad{-1} : -4 * bend};
    std::array<Quad, 2> right{0, first || last ? Quad{0} : -((u(i + 1) - u(i)) / h - (u(i) - u(i - 1)) / h)};
    // Coupling of node i to i + 1: [0, 1/h; 1/h, -bend] where both moments exist.
    const auto coupling = [&](bool own_end, bool other_end) {
      return Block{0, other_end ? Quad{0} : 1 / h, own_end ? Quad{0} : 1 / h, own_end || other_end ? Quad{0} : -bend};
    };
    if (!first) {
      const Block lower = coupling(last, i == 1);
      const Block& f = factor[i - 1];
      pivot.a -= lower.a * f.a + lower.b * f.c;
      pivot.b -= lower.a * f.b + lower.b * f.d;
      pivot.c -= lower.c * f.a + lower.d * f.c;
      pivot.d -= lower.c * f.b + lower.d * f.d;
      right[0] -= lower.a * x[i - 1][0] + lower.b * x[i - 1][1];
      right[1] -= lower.c * x[i - 1][0] + lower.d * x[i - 1][1];
    }
    const Quad determinant = pivot.a * pivot.d - pivot.b * pivot.c;
    const auto divide = [&](Quad top, Quad bottom) {
      return std::array<Quad, 2>{(pivot.d * top - pivot.b * bottom) / determinant,
                                 (pivot.a * bottom - pivot.c * top) / determinant};
    };
    x[i] = divide(right[0], right[1]);
    const Block upper = coupling(first, i + 2 == n);
    const auto left_column = divide(upper.a, upper.c);
    const auto right_column = divide(upper.b, upper.d);
    factor[i] = {left_column[0], right_column[0], left_column[1], right_column[1]};
  }
  std::vector<double> stretch(n);
  for (std::size_t i = n; i-- > 0;) {
    if (i + 1 < n) {
      const Block& f = factor[i];
      x[i][0] -= f.a * x[i + 1][0] + f.b * x[i + 1][1];
      x[i][1] -= f.c * x[i + 1][0] + f.d * x[i + 1][1];
    }
    stretch[i] = static_cast<double>(x[i][0]);
  }
  return stretch;
}

/// Prints, for each form and N, the largest error of the acceleration relative to its largest value, and the time of a
/// solve per node (best of the repeats).
void accuracy(MPI_Comm comm, BeamParameters parameters, double wf, const std::vector<PetscInt>& sizes, PetscInt repeats,
              bool given) {
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  UDAR_CALL(PetscPrintf(comm, "wf %g rad/s, %d rank(s): error of the acceleration / nanoseconds per node and solve\n",
                        wf, ranks));
  UDAR_CALL(PetscPrintf(comm, "%-34s", "form"));
  for (const PetscInt size : sizes) {
    UDAR_CALL(PetscPrintf(comm, " %18lld", static_cast<long long>(size)));
  }
  UDAR_CALL(PetscPrintf(comm, "\n"));
  for (const Form& form : forms(given)) {
    UDAR_CALL(PetscPrintf(comm, "%-34s", form.name));
    for (const PetscInt size : sizes) {
      if (size > form.most_elements) {
        UDAR_CALL(PetscPrintf(comm, " %18s", "-"));
        continue;
      }
      parameters.segments[0].elements = size;
      const BeamChain beam{comm, parameters};
      for (const auto& [key, value] : form.options) {
        UDAR_CALL(PetscOptionsSetValue(nullptr, key, value));
      }
      FilteredLine line{beam, {.filter_frequency = wf, .formulation = form.formulation, .check_interval = 0}};
      for (const auto& [key, value] : form.options) {
        UDAR_CALL(PetscOptionsClearValue(nullptr, key));
      }
      const auto count = static_cast<std::size_t>(beam.local_nodes());
      std::vector<double> all(static_cast<std::size_t>(beam.nodes()));
      for (PetscInt node = 0; node < beam.nodes(); ++node) {
        all[static_cast<std::size_t>(node)] = smooth_displacement(beam.position(node), beam.length());
      }
      const auto first = static_cast<std::size_t>(beam.begin());
      const std::vector<double> displacement(all.begin() + beam.begin(), all.begin() + beam.end());
      const std::vector<double> force(count, 0.0);
      std::vector<double> stretch(count);
      std::vector<double> moment(count);
      double best = 1e30;
      for (PetscInt repeat = 0; repeat < repeats; ++repeat) {
        MPI_Barrier(comm);
        const double begin = MPI_Wtime();
        line.solve(displacement, force, stretch, moment);
        best = std::min(best, MPI_Wtime() - begin);
      }
      const std::vector<double> exact = quad_stretch(beam, wf, all);
      std::array<double, 3> largest{0.0, 0.0, best};
      for (std::size_t i = 0; i < count; ++i) {
        const double error = std::abs(stretch[i] - exact[first + i]);
        largest[0] = error <= largest[0] ? largest[0] : error;  // keeps a NaN
        largest[1] = std::max(largest[1], std::abs(exact[first + i]));
      }
      MPI_Allreduce(MPI_IN_PLACE, largest.data(), static_cast<int>(largest.size()), MPI_DOUBLE, MPI_MAX, comm);
      UDAR_CALL(PetscPrintf(comm, "    %7.0e /%6.0f", largest[0] / largest[1],
                            largest[2] * 1e9 / static_cast<double>(beam.nodes())));
    }
    UDAR_CALL(PetscPrintf(comm, "\n"));
  }
}

int bench(MPI_Comm comm) {
  petsc::OptionGroup group{comm, "Benchmark (the beam and the filter by -beam_* and -filter_frequency of udar)"};
  Kind kind = Kind::accuracy;
  std::vector<PetscInt> sizes{100, 1000, 10000, 100000, 1000000};
  PetscInt repeats = 20;
  bool given = false;
  double wf = 50.0;
  double length = 10.0;
  double bending = 2.1e11 * 0.25e-4 * std::numbers::pi;
  double mass = 7850.0 * 1e-2 * std::numbers::pi;
  group.choice<Kind>("-bench_kind", kind, kKinds, "accuracy: error and time of a line solve by form and size");
  group.integers("-bench_elements", sizes, petsc::at_least(2), "sizes to measure");
  group.integer("-bench_repeats", repeats, petsc::at_least(1), "samples of each time; the best counts");
  group.boolean("-bench_given", given, "measure only the solver that the options name (-filter_ksp_*, -filter_pc_*)");
  group.real("-filter_frequency", wf, "rad/s", petsc::positive(), "filter frequency wf");
  group.real("-beam_length", length, "m", petsc::positive(), "length");
  group.real("-beam_bending_stiffness", bending, "N m^2", petsc::positive(), "EI");
  group.real("-beam_mass_per_length", mass, "kg/m", petsc::positive(), "rhoA");
  if (petsc::Session::help_requested()) {
    return 0;
  }
  BeamParameters beam;
  beam.segments.push_back({.length = length, .elements = 1, .bending_stiffness = bending, .mass_per_length = mass});
  accuracy(comm, beam, wf, sizes, repeats, given);
  petsc::check_unknown_options(comm);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return udar::app::guarded_main(argc, argv, "udar-bench: measurements of udar's parts\n", bench);
}
