#include "udar/contact/held_line.hpp"

#include <algorithm>
#include <array>

namespace udar {

HeldLine::HeldLine(LineContact& contact)
    : contact_{&contact},
      touches_(contact.points().size(), std::uint8_t{0}),
      free_(contact.points().size()),
      force_(contact.points().size()) {
  contact.keep_responses();
}

void HeldLine::assume(std::span<const std::uint8_t> touches) {
  active_.clear();
  for (std::size_t i = 0; i < touches.size(); ++i) {
    touches_[i] = touches[i];
    if (touches[i] != 0) {
      active_.push_back(i);
    }
  }
}

void HeldLine::hold(std::span<const FilterColumn> columns, std::span<double> amplitudes, std::vector<double>& rows) {
  const std::span<const LinePoint> points = contact_->points();
  contact_->gather(
      columns.size(),
      [&](std::size_t i, std::size_t k) {
        const std::size_t node = contact_->local(i);
        return points[i].side * (columns[k].displacement[node] + columns[k].stretch[node]);
      },
      gap_);
  Complementarity& problem = contact_->problem();
  problem.assume(active_);
  rows.resize(columns.size() * points.size());
  const std::size_t modes = amplitudes.size() / columns.size();
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const std::span<double> amplitude = amplitudes.subspan(k * modes, modes);
    for (std::size_t i = 0; i < points.size(); ++i) {
      free_[i] = gap_[i * columns.size() + k] - contact_->nearer(i, amplitude);
    }
    const std::span<double> row{rows.data() + k * points.size(), points.size()};
    problem.respond(free_, force_);
    problem.gaps(free_, force_, row);
    for (const std::size_t i : active_) {
      row[i] = force_[i];
    }
    const std::array<double*, 1> stretch{columns[k].stretch};
    contact_->add(force_, stretch, {});
    contact_->add_amplitudes(force_, 0, 1, amplitude);
  }
}

/// The gap of a point that touches stays zero, that of others is the row.
void HeldLine::free_rates(std::span<const double> rows, std::span<double> gaps) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    force_[i] = touches_[i] != 0 ? -rows[i] : 0.0;
    free_[i] = touches_[i] != 0 ? 0.0 : rows[i];
  }
  contact_->problem().assume(active_);
  contact_->problem().gaps(free_, force_, gaps);
}

}  // namespace udar
