#include "udar/integrators/yielding_steps.hpp"

#include <algorithm>
#include <array>
#include <limits>

namespace udar {

YieldingSteps::YieldingSteps(Equations& equations)
    : equations_{&equations},
      hinges_{equations.hinges()},
      rotation_before_(hinges_->hinges().size()),
      turned_before_(rotation_before_.size()),
      middle_(rotation_before_.size()),
      nodes_(equations.line().mass().size()),
      lower_(hinges_->contacts(), 0.0),
      upper_(hinges_->contacts(), std::numeric_limits<double>::infinity()) {
  for (const PlasticHinge& hinge : hinges_->hinges()) {
    lower_.push_back(-hinge.moment);
    upper_.push_back(hinge.moment);
  }
  static_cast<void>(hinges_->rows());
}

/// A line that has never yielded is solved for as one that cannot, to the bit.
void YieldingSteps::predict(std::span<const double> displacement, std::span<const double> force,
                            std::span<double> stretch) {
  FilteredStructure& line = equations_->line();
  const double* kink = hinges_->kink(hinges_->rotations());
  if (kink == nullptr) {
    std::vector<double> same(stretch.size());
    line.solve(displacement, force, same, nodes_);
    line.solve(displacement, force, stretch, {});
  } else {
    const FilterColumn column{.displacement = displacement.data(),
                              .force = force.empty() ? nullptr : force.data(),
                              .kink = kink,
                              .stretch = stretch.data(),
                              .internal = nodes_.data()};
    line.solve({&column, 1});
  }
  hinges_->gather(nodes_.data(), middle_);
}

/// The rows are H theta - mu in the middle of the step, of half of what the hinges turn.
bool YieldingSteps::resolve(std::span<const double> gaps, std::span<double> force, std::span<double> stretch) {
  const std::span<const PlasticHinge> hinges = hinges_->hinges();
  std::vector<double> value{gaps.begin(), gaps.end()};
  for (std::size_t i = 0; i < hinges.size(); ++i) {
    value.push_back(hinges[i].hardening * hinges_->rotations()[i] - middle_[i]);
  }
  std::vector<double> x(value.size(), 0.0);
  std::vector<double> added(hinges.size(), 0.0);
  if (stays_elastic(value, force, stretch, added)) {
    end_step(std::span{x}.subspan(gaps.size()), added);
  } else {
    if (hinges_->rows().solve({.value = value, .lower = lower_, .upper = upper_}, x)) {
      hinges_->add(x, stretch, nodes_);
      hinges_->gather(nodes_.data(), added);
    }
    std::copy_n(x.begin(), gaps.size(), force.begin());
    end_step(std::span{x}.subspan(gaps.size()), added);
  }
  return std::ranges::any_of(force, [](double pressed) { return pressed > 0.0; });
}

/// A step in which no hinge turns is that of a line that cannot yield, to the bit. @param value of all rows @param[out]
/// added moments at the hinges by contact; as `stretch` changed only if it does
bool YieldingSteps::stays_elastic(std::span<const double> value, std::span<double> force, std::span<double> stretch,
                                  std::span<double> added) {
  const std::size_t touching = force.size();
  LineContact* contact = equations_->line_contact();
  const bool pressed = contact != nullptr && contact->solve(value.first(touching), force);
  const BoundedRows& rows = hinges_->rows();
  for (std::size_t i = 0; i < added.size(); ++i) {
    const std::size_t row = touching + i;
    for (std::size_t k = 0; pressed && k < touching; ++k) {
      added[i] -= rows.at(row, k) * force[k];
    }
    const double now = value[row] - added[i];
    if (!(lower_[row] <= now && now <= upper_[row])) {
      std::ranges::fill(added, 0.0);
      return false;
    }
  }
  if (pressed) {
    const std::array<double*, 1> line{stretch.data()};
    contact->add(force, line, {});
  }
  return true;
}

/// @param turns half of them @param added moments in the middle of the step, by what the hinges turn and by contact
void YieldingSteps::end_step(std::span<const double> turns, std::span<const double> added) {
  const std::span<const PlasticHinge> hinges = hinges_->hinges();
  std::ranges::copy(hinges_->rotations(), rotation_before_.begin());
  std::ranges::copy(hinges_->turned(), turned_before_.begin());
  lost_ = 0.0;
  std::vector<double> rotation(rotation_before_);
  for (std::size_t i = 0; i < hinges.size(); ++i) {
    const double back = hinges[i].hardening * (rotation_before_[i] + turns[i]);
    rotation[i] += 2.0 * turns[i];
    lost_ += equations_->points().begin() == 0 ? 2.0 * turns[i] * (middle_[i] + added[i] - back) : 0.0;
  }
  hinges_->turn(rotation);
}

void YieldingSteps::take_back() {
  hinges_->restore(rotation_before_, turned_before_);
  lost_ = 0.0;
}

std::vector<double> YieldingSteps::rotations(bool at_start) const {
  const std::span<const double> now = hinges_->rotations();
  return at_start ? rotation_before_ : std::vector<double>{now.begin(), now.end()};
}

}  // namespace udar
