/// @file
/// A beam falls on two supports, built and run from C++. All `-ts_*` and `-filter_ksp_*` options apply:
///     mpirun -n 2 ./falling_beam -ts_max_time 1 -ts_rtol 1e-10

#include <cstdio>
#include <exception>

#include "udar/dynamics/impact_dynamics.hpp"
#include "udar/petsc/session.hpp"
#include "udar/structure/section.hpp"

namespace {

/// Prints where the middle of the beam is, on the rank that owns it.
class MiddlePrinter final : public udar::Observer {
 public:
  explicit MiddlePrinter(const udar::MassPoints& points)
      : points_{&points}, node_{points.nearest({.x = points.extent().middle()})} {}
  [[nodiscard]] double interval() const override { return 0.1; }
  void snapshot(const udar::Snapshot& state) override {
    if (points_->owns(node_)) {
      const auto i = static_cast<std::size_t>(node_ - points_->begin());
      std::printf("t %.1f s: mass %+.6f m, line %+.6f m, moment %+.4e N m\n", state.time,
                  state.values("mass_position")[i], state.values("line_position")[i], state.values("moment")[i]);
    }
  }

 private:
  const udar::MassPoints* points_;
  PetscInt node_;
};

}  // namespace

int main(int argc, char** argv) {
  try {
    const udar::petsc::Session session{argc, argv, "A beam falls on two supports\n"};

    const udar::Section section = udar::circle_section(0.1, 0.3);  // radius [m], Poisson's ratio
    udar::ModelParameters parameters;
    parameters.beam.segments = {{.length = 10.0,
                                 .elements = 20,
                                 .bending_stiffness = 2.1e11 * section.inertia,
                                 .mass_per_length = 7850.0 * section.area}};
    parameters.filter.filter_frequency = 100.0;
    parameters.initial.height = 1.0;
    parameters.supports = {{.position = 2.0}, {.position = 8.0}};
    udar::Model model{PETSC_COMM_WORLD, parameters};
    udar::ImpactDynamics dynamics{model};

    MiddlePrinter printer{model.structure->points()};
    dynamics.add_observer(printer);
    dynamics.solve();

    const std::vector<double> impulse = dynamics.support_impulses();
    if (udar::petsc::Session::on_first_rank()) {
      std::printf("%d impacts, impulses %.1f and %.1f N s, energy drift %.1e\n",
                  static_cast<int>(dynamics.counts().impacts), impulse[0], impulse[1], dynamics.energy().drift());
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "falling_beam: %s\n", error.what());
    return 1;
  }
  return 0;
}
