#include "udar/modal/phase_basis.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "udar/numerics/symmetric_eigen.hpp"

namespace udar {

PhaseBasis::PhaseBasis(const ReducedModel& model, Complementarity& closed, const std::vector<std::uint8_t>& touches)
    : touches_{touches}, frequency_{model.frequency}, rows_{model.row} {
  const std::size_t modes = model.modes();
  const std::size_t points = model.points();
  std::vector<std::size_t> active;
  for (std::size_t i = 0; i < points; ++i) {
    if (touches[i] != 0) {
      active.push_back(i);
    }
  }
  of_offset_.assign(points * points, 0.0);
  for (std::size_t i = 0; i < points; ++i) {
    of_offset_[i * points + i] = touches[i] != 0 ? 0.0 : 1.0;
  }
  if (active.empty()) {
    return;
  }
  closed.assume(active);
  std::vector<double> unit(points);
  std::vector<double> force(points);
  std::vector<double> rows(points);
  // A column of gaps, to what stands in the rows: forces of those that touch, gaps of the others.
  const auto respond = [&] {
    closed.respond(unit, force);
    closed.gaps(unit, force, rows);
    for (const std::size_t i : active) {
      rows[i] = force[i];
    }
  };
  std::vector<double> stiff(modes * modes);
  std::vector<double> by_modes(points * modes);
  for (std::size_t m = 0; m < modes; ++m) {
    for (std::size_t i = 0; i < points; ++i) {
      unit[i] = model.row[i * modes + m];
    }
    respond();
    for (std::size_t i = 0; i < points; ++i) {
      by_modes[i * modes + m] = rows[i];
    }
    for (const std::size_t i : active) {
      for (std::size_t n = 0; n < modes; ++n) {
        stiff[n * modes + m] -= model.row[i * modes + n] * force[i];
      }
    }
  }
  pull_.assign(points * modes, 0.0);
  for (const std::size_t j : active) {
    std::ranges::fill(unit, 0.0);
    unit[j] = 1.0;
    respond();
    for (std::size_t i = 0; i < points; ++i) {
      of_offset_[i * points + j] = rows[i];
      for (std::size_t m = 0; touches[i] != 0 && m < modes; ++m) {
        pull_[j * modes + m] += model.row[i * modes + m] * force[i];
      }
    }
  }
  diagonalise(model, stiff);
  std::vector<double> modal(modes);
  for (std::size_t i = 0; i < points; ++i) {
    std::copy_n(by_modes.begin() + static_cast<std::ptrdiff_t>(i * modes), modes, modal.begin());
    reduce(modal, std::span{rows_}.subspan(i * modes, modes));
    std::copy_n(pull_.begin() + static_cast<std::ptrdiff_t>(i * modes), modes, modal.begin());
    reduce(modal, std::span{pull_}.subspan(i * modes, modes));
  }
}

void PhaseBasis::diagonalise(const ReducedModel& model, const std::vector<double>& stiff) {
  const std::size_t modes = model.modes();
  vectors_.resize(modes * modes);
  for (std::size_t i = 0; i < modes; ++i) {
    for (std::size_t j = 0; j < modes; ++j) {
      vectors_[i * modes + j] = 0.5 * (stiff[i * modes + j] + stiff[j * modes + i]);
    }
    vectors_[i * modes + i] += model.frequency[i] * model.frequency[i];
  }
  symmetric_eigen(vectors_, frequency_);
  // An eigenvalue this small beside the largest is rounding: a motion that nothing holds.
  const double rounding = static_cast<double>(modes) * std::numeric_limits<double>::epsilon() * frequency_.back();
  for (double& value : frequency_) {
    value = value > rounding ? std::sqrt(value) : 0.0;
  }
}

void PhaseBasis::reduce(std::span<const double> modal, std::span<double> coordinates) const {
  if (vectors_.empty()) {
    std::ranges::copy(modal, coordinates.begin());
    return;
  }
  const std::size_t modes = modal.size();
  for (std::size_t j = 0; j < modes; ++j) {
    coordinates[j] =
        std::inner_product(modal.begin(), modal.end(), vectors_.begin() + static_cast<std::ptrdiff_t>(j * modes), 0.0);
  }
}

void PhaseBasis::expand(std::span<const double> coordinates, std::span<double> modal) const {
  if (vectors_.empty()) {
    std::ranges::copy(coordinates, modal.begin());
    return;
  }
  const std::size_t modes = modal.size();
  std::ranges::fill(modal, 0.0);
  for (std::size_t j = 0; j < modes; ++j) {
    for (std::size_t m = 0; m < modes; ++m) {
      modal[m] += vectors_[j * modes + m] * coordinates[j];
    }
  }
}

void PhaseBasis::offsets(std::span<const double> offset, std::span<double> rows) const {
  const std::size_t points = offset.size();
  for (std::size_t i = 0; i < points; ++i) {
    rows[i] = std::inner_product(offset.begin(), offset.end(),
                                 of_offset_.begin() + static_cast<std::ptrdiff_t>(i * points), 0.0);
  }
}

void PhaseBasis::load(std::span<const double> modal_load, std::span<const double> offset,
                      std::span<double> coordinates) const {
  reduce(modal_load, coordinates);
  const std::size_t modes = modal_load.size();
  for (std::size_t j = 0; !pull_.empty() && j < offset.size(); ++j) {
    for (std::size_t m = 0; m < modes; ++m) {
      coordinates[m] += pull_[j * modes + m] * offset[j];
    }
  }
}

}  // namespace udar
