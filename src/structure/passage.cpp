#include "udar/structure/passage.hpp"

#include <algorithm>
#include <ranges>
#include <utility>

namespace udar {

Passage::Passage(const TravellingLoad& load, std::size_t axle, std::shared_ptr<const std::vector<double>> x)
    : x_{std::move(x)}, offset_{load.offset[axle]}, speed_{load.speed}, start_{load.start} {}

double Passage::arrival(std::size_t passed) const {
  const std::vector<double>& x = *x_;
  const double way = rightward() ? x[passed] - x.front() : x.back() - x[x.size() - 1 - passed];
  return arrival_of(start_, offset_ + way, speed_);
}

Passage::State Passage::at(const Instant& at) const {
  const double now = TimeTable::just_after(at.begin);
  const auto nodes = std::views::iota(std::size_t{0}, x_->size());
  const auto passed = static_cast<std::size_t>(
      std::ranges::upper_bound(nodes, now, {}, [this](std::size_t node) { return arrival(node); }) - nodes.begin());
  if (passed == 0 || passed == x_->size()) {
    return {.where = passed == 0 ? Where::before : Where::behind};
  }
  const double from = arrival(passed - 1);
  const double span = arrival(passed) - from;
  const double gone = (at.time - from) / span;
  if (rightward()) {
    return {.where = Where::on, .node = passed - 1, .ahead = gone, .rate = 1.0 / span};
  }
  return {.where = Where::on, .node = x_->size() - 1 - passed, .ahead = 1.0 - gone, .rate = -1.0 / span};
}

double Passage::x(double time) const { return end(Where::before) + speed_ * (time - enters()); }

double Passage::end(Where where) const { return (where == Where::before) == rightward() ? x_->front() : x_->back(); }

}  // namespace udar
