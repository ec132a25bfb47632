#include "udar/modal/reduced_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "udar/numerics/symmetric_eigen.hpp"

namespace udar {

std::vector<double> ReducedModel::closed_compliance() const {
  std::vector<double> closed = compliance;
  for (std::size_t i = 0; i < points(); ++i) {
    closed[i * points() + i] += give[i];
  }
  return closed;
}

double ReducedModel::frequency_bound() const {
  const double highest = frequency.empty() ? 0.0 : std::ranges::max(frequency);
  if (points() == 0) {
    return highest;
  }
  // The nonzero eigenvalues of b'A^-1 b are those of the pencil (b b', A).
  std::vector<double> pencil(points() * points());
  for (std::size_t i = 0; i < points(); ++i) {
    for (std::size_t j = 0; j < points(); ++j) {
      for (std::size_t m = 0; m < modes(); ++m) {
        pencil[i * points() + j] += row_of(i)[m] * row_of(j)[m];
      }
    }
  }
  const std::optional<double> added = largest_of_pencil(std::move(pencil), closed_compliance(), points());
  return added ? std::sqrt(highest * highest + std::max(*added, 0.0)) : std::numeric_limits<double>::infinity();
}

ModalEnergy modal_energy(const ReducedModel& model, const Drive& drive, const ModalState& state) {
  ModalEnergy energy;
  for (std::size_t m = 0; m < model.modes(); ++m) {
    const double stretched = model.frequency[m] * state.amplitude[m];
    energy.kinetic += 0.5 * state.velocity[m] * state.velocity[m];
    energy.strain += 0.5 * stretched * stretched;
    energy.load_potential -= drive.load_at(m, state.time) * state.amplitude[m];
  }
  const std::size_t points = model.points();
  for (std::size_t i = 0; i < points; ++i) {
    for (std::size_t j = 0; j < points && state.rest_force[i] != 0.0; ++j) {
      energy.rest_strain += 0.5 * state.rest_force[i] * model.compliance[i * points + j] * state.rest_force[j];
    }
    if (model.give[i] > 0.0) {
      energy.springs += 0.5 * state.give[i] * state.give[i] / model.give[i];
    }
  }
  return energy;
}

}  // namespace udar
