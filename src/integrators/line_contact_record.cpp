#include "udar/integrators/line_contact_record.hpp"

#include <algorithm>
#include <string>

#include "udar/petsc/error.hpp"

namespace udar {

void LineContactRecord::track(const StepMotion& motion) {
  LineContact& contact = *equations_->line_contact();
  const LineState& start = motion.start().line;
  const LineState& end = motion.end().line;
  const double length = motion.length();
  if (length <= 0.0) {
    return;
  }
  std::vector<double> middle(start.stretch.size());
  for (std::size_t i = 0; i < middle.size(); ++i) {
    middle[i] = motion.polynomial(i).position(0.5);
  }
  LineState halfway;
  equations_->evaluate({start.time + 0.5 * length, start.time}, middle, halfway);
  power_ = {contact.power(start.contact_force, start.time), contact.power(halfway.contact_force, halfway.time),
            contact.power(end.contact_force, end.time)};
  for (const std::size_t i : contact.mine()) {
    const LinePoint& point = contact.points()[i];
    const std::array<double, 3> force{start.contact_force[i], halfway.contact_force[i], end.contact_force[i]};
    contact_->journal().record_force(point.support, point.side * length / 6.0 * (force[0] + 4.0 * force[1] + force[2]));
    const std::size_t node = contact.local(i);
    if (std::ranges::max(force) > 0.0) {
      contact_->journal().record_contact_time(node, {start.time, end.time});
    }
    const double line = motion.end().values[node] + end.stretch[node];
    contact_->record_gap(
        point.side * (line - point.height - point.lift(end.time).height) - contact.nearer(i, end.amplitude), node,
        end.time);
  }
  if (start.in_contact || end.in_contact || halfway.in_contact) {
    contact_->journal().record_line_contact(
        {start.in_contact ? start.time : halfway.time, end.in_contact ? end.time : halfway.time});
  }
}

/// Of the parabola through three instants: Simpson's rule at the end.
double LineContactRecord::work(double length, double share) const {
  const auto& [start, middle, end] = power_;
  return length * share *
         (start +
          share * (0.5 * (4.0 * middle - 3.0 * start - end) + share * 2.0 / 3.0 * (start + end - 2.0 * middle)));
}

/// Forces that all ranks know are saved as a table; others at nodes, in as many fields as supports share a node.
void LineContactRecord::save(const LineState& line, std::size_t count, MotionState& state) const {
  const LineContact& contact = *equations_->line_contact();
  if (contact.dense()) {
    return;  // with the line
  }
  state.tables.erase("contact_force");
  state.scalars["line_in_contact"] = line.in_contact ? 1.0 : 0.0;
  const std::vector<int> layer = layers(count);
  int most = layer.empty() ? 0 : std::ranges::max(layer) + 1;
  MPI_Allreduce(MPI_IN_PLACE, &most, 1, MPI_INT, MPI_MAX, equations_->points().comm());
  for (int k = 0; k < most; ++k) {
    std::vector<double>& field = state.fields["contact_force_" + std::to_string(k)];
    field.assign(count, 0.0);
    for (const std::size_t i : contact.mine()) {
      if (layer[i] == k) {
        field[contact.local(i)] = line.contact_force[i];
      }
    }
  }
}

void LineContactRecord::restore(const MotionState& state, std::size_t count, LineState& line) const {
  const LineContact& contact = *equations_->line_contact();
  if (contact.dense()) {
    if (line.contact_force.size() != contact.points().size()) {
      throw InputError{"restart file: the table 'contact_force' is missing"};
    }
    line.in_contact = std::ranges::any_of(line.contact_force, [](double force) { return force > 0.0; });
    return;
  }
  line.in_contact = state.scalar("line_in_contact") != 0.0;
  const std::vector<int> layer = layers(count);
  line.contact_force.resize(layer.size());
  for (const std::size_t i : contact.mine()) {
    line.contact_force[i] = state.field("contact_force_" + std::to_string(layer[i]), count)[contact.local(i)];
  }
}

/// How many points before this one have the same node.
std::vector<int> LineContactRecord::layers(std::size_t count) const {
  const LineContact& contact = *equations_->line_contact();
  std::vector<int> seen(count, 0);
  std::vector<int> layer(contact.points().size());
  for (const std::size_t i : contact.mine()) {
    layer[i] = seen[contact.local(i)]++;
  }
  return layer;
}

}  // namespace udar
