#include "udar/integrators/elastic_touches.hpp"

namespace udar {
namespace {

// How a restart file keeps a touch: its state, whether what would end it is zero now, and by which side.
constexpr int kStartsAtZero = 4;
constexpr int kAbove = 8;

}  // namespace

ElasticTouches::ElasticTouches(const ContactState& contact) : contact_{&contact} {
  for (const ContactSet& set : contact.sets()) {
    touches_.emplace_back(set.elastic() ? set.last - set.first : 0);
  }
}

void ElasticTouches::pass() {
  for (auto& of_run : touches_) {
    for (ElasticTouch& touch : of_run) {
      touch.pass();
    }
  }
}

void ElasticTouches::save(std::size_t count, MotionState& state) const {
  std::vector<double>& field = state.fields["touch"];
  field.assign(count, 0.0);
  for (const ContactSet& set : contact_->sets()) {
    for (std::size_t node = set.first; node < set.last && set.elastic(); ++node) {
      const ElasticTouch touch = of(set, node);
      const int code = static_cast<int>(touch.state()) + (touch.starts_at_zero() ? kStartsAtZero : 0);
      field[node] += code * (set.side > 0.0 ? 1 : kAbove);  // one on each side at most
    }
  }
}

void ElasticTouches::restore(std::size_t count, const MotionState& state) {
  const std::vector<double>& field = state.field("touch", count);
  for (const ContactSet& set : contact_->sets()) {
    for (std::size_t node = set.first; node < set.last && set.elastic(); ++node) {
      const int code = static_cast<int>(field[node]) / (set.side > 0.0 ? 1 : kAbove) % kAbove;
      at(set, node) = ElasticTouch{static_cast<ElasticTouch::State>(code % kStartsAtZero), code >= kStartsAtZero};
    }
  }
}

}  // namespace udar
