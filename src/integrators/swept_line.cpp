#include "udar/integrators/swept_line.hpp"

#include <string>

#include "udar/local/dense_map.hpp"
#include "udar/petsc/log.hpp"

namespace udar {

SweptLine::SweptLine(Equations& equations, Sweep& sweep)
    : equations_{&equations}, sweep_{&sweep}, steady_amplitude_(sweep.series.corrected.size()) {}

void SweptLine::start(const LineState& line, const ContactState& contact, const double* velocity, double step) {
  polynomial_step_ = step;
  for (std::size_t i = 0; i < sweep_->count; ++i) {
    const double half = contact.resting(i) ? 0.0 : -0.5 * polynomial_step_ * velocity[i];
    sweep_->series.rows[0][i] = line.stretch[i] + half;  // seen as the step that ends here
    sweep_->series.rows[1][i] = -half;
    for (std::size_t j = 2; j < sweep_->terms; ++j) {
      sweep_->series.rows[j][i] = 0.0;
    }
    for (std::size_t j = 0; j < sweep_->terms && damps_by_rate(); ++j) {
      sweep_->series.rates[j][i] = j == 0 && !contact.resting(i) ? velocity[i] : 0.0;
    }
  }
  from_end_ = true;
}

void SweptLine::begin_step(double length) {
  polynomial_step_ = length;
  from_end_ = true;
  for (std::size_t i = 0; i < sweep_->count; ++i) {
    sweep_->series.rows[0][i] -= sweep_->end[i] - sweep_->start[i];
  }
}

void SweptLine::load(double begin, double step) {
  const Loads& loads = equations_->loads();
  if (steady_known_ && !loads.time_dependent()) {
    return;
  }
  steady_known_ = true;
  const std::vector<double> none(sweep_->count, 0.0);
  FilteredStructure& line = equations_->line();
  line.solve(none, loads.force(begin, work_), sweep_->series.steady[0], {});
  for (std::size_t mode = 0; mode < steady_amplitude_.size(); ++mode) {
    steady_amplitude_[mode][0] = line.amplitudes()[mode];
  }
  if (loads.time_dependent()) {
    const LoadRate& rate = equations_->load_rate(begin);
    for (std::size_t mode = 0; mode < steady_amplitude_.size(); ++mode) {
      steady_amplitude_[mode][1] = 0.5 * step * rate.amplitude[mode];
      steady_amplitude_[mode][0] += steady_amplitude_[mode][1];
    }
    for (std::size_t i = 0; i < sweep_->count; ++i) {
      sweep_->series.steady[1][i] = 0.5 * step * rate.stretch[i];
      sweep_->series.steady[0][i] += sweep_->series.steady[1][i];
    }
  }
}

void SweptLine::solve_start() {
  std::vector<double> displacement(sweep_->count);
  for (std::size_t i = 0; i < sweep_->count; ++i) {
    displacement[i] = sweep_->start[i] - sweep_->axis[i];
  }
  equations_->line().solve(displacement, {}, sweep_->series.start_stretch, {});
  start_amplitude_.assign(equations_->line().amplitudes().begin(), equations_->line().amplitudes().end());
}

void SweptLine::extrapolate(double step) {
  const LegendreMatrix change = legendre_change(sweep_->terms, from_end_ ? 1.0 : 0.0, step / polynomial_step_);
  const auto go_on = [&](auto& rows) {
    std::array<double*, kMostTerms> lines{};
    for (std::size_t j = 0; j < sweep_->terms; ++j) {
      lines[j] = rows[j].data();
    }
    change_basis(sweep_->terms, lines, sweep_->count, change);
  };
  go_on(sweep_->series.rows);
  if (damps_by_rate()) {
    go_on(sweep_->series.rates);
    sweep_->find_drive(false);
  }
  polynomial_step_ = step;
  from_end_ = false;
}

void SweptLine::solve(LineForces* forces) {
  std::array<FilterColumn, kMostUnknowns> columns;
  for (std::size_t j = 0; j < sweep_->unknowns(); ++j) {
    columns[j] = {.displacement = sweep_->moment_rows[j].data(),
                  .stretch = j < sweep_->terms ? sweep_->series.rows[j].data() : sweep_->series.end_stretch.data()};
  }
  equations_->line().solve({columns.data(), sweep_->unknowns()});
  for (std::size_t mode = 0; mode < steady_amplitude_.size(); ++mode) {
    sweep_->series.amplitude[mode] = steady_amplitude_[mode];
    for (std::size_t j = 0; j < sweep_->terms; ++j) {
      sweep_->series.amplitude[mode][j] += equations_->line().amplitudes(j)[mode];
    }
    sweep_->series.amplitude[mode][0] += damps_by_rate() ? start_amplitude_[mode] : 0.0;
  }
  if (damps_by_rate()) {
    sweep_->find_rates();
  }
  if (forces != nullptr) {
    const petsc::LogScope contact{petsc::log_events().contact};
    forces->apply();
  }
  if (damps_by_rate()) {
    sweep_->find_drive(true);
  }
}

double SweptLine::mean_stretch(std::size_t node, double tau) const {
  const auto powers = sweep_->powers([&](std::size_t j) { return sweep_->series.rows[j][node]; });
  double sum = 0.0;
  for (std::size_t k = sweep_->terms; k-- > 0;) {
    sum = sum * tau + powers[k] / static_cast<double>(k + 1);
  }
  return sum;
}

std::vector<double> SweptLine::amplitude_integrals(double tau, double length) const {
  std::vector<double> integrals(sweep_->series.corrected.size());
  for (std::size_t mode = 0; mode < integrals.size(); ++mode) {
    const auto powers = sweep_->powers([&](std::size_t j) { return sweep_->series.amplitude[mode][j]; });
    for (std::size_t k = sweep_->terms; k-- > 0;) {
      integrals[mode] = integrals[mode] * tau + powers[k] / static_cast<double>(k + 1);
    }
    integrals[mode] *= length * tau;
  }
  return integrals;
}

void SweptLine::save(MotionState& state) const {
  for (std::size_t j = 0; j < sweep_->terms; ++j) {
    state.fields["line_" + std::to_string(j)] = sweep_->series.rows[j];
    if (damps_by_rate()) {
      state.fields["line_rate_" + std::to_string(j)] = sweep_->series.rates[j];
    }
  }
  state.scalars["line_step"] = polynomial_step_;
}

/// Of a run with fewer moments the last are zero: no more than a guess depends on them.
void SweptLine::restore(const MotionState& state) {
  for (std::size_t j = 0; j < sweep_->terms; ++j) {
    const auto term = [&](const char* series) {
      const std::string name = series + std::to_string(j);
      return state.fields.contains(name) ? state.field(name, sweep_->count) : std::vector<double>(sweep_->count);
    };
    sweep_->series.rows[j] = term("line_");
    if (damps_by_rate()) {
      sweep_->series.rates[j] = term("line_rate_");
    }
  }
  polynomial_step_ = state.scalar("line_step");
  from_end_ = true;
}

}  // namespace udar
