#include "udar/integrators/law_history.hpp"

#include <algorithm>

namespace udar {
namespace {

/// One support on each side of a node at most has a law.
const char* field_of(const ContactSet& set) {
  return set.side > 0.0 ? "largest_compression_below" : "largest_compression_above";
}

}  // namespace

LawHistory::LawHistory(const ContactState& contact) : contact_{&contact} {
  any_ = std::ranges::any_of(contact.supports(), [](const Support& support) {
    return support.contact_law && support.contact_law->remembers();
  });
  for (const ContactSet& set : contact.sets()) {
    largest_.emplace_back(set.contact_law && set.contact_law->remembers() ? set.last - set.first : 0, 0.0);
  }
}

void LawHistory::note(const ContactSet& set, std::size_t node, double largest) {
  if (largest != this->largest(set, node)) {
    notes_.push_back({.set = contact_->index_of(set), .node = node, .largest = largest});
  }
}

void LawHistory::end_step() {
  for (const Note& note : notes_) {
    largest_[note.set][note.node - contact_->sets()[note.set].first] = note.largest;
  }
  notes_.clear();
}

void LawHistory::save(std::size_t count, MotionState& state) const {
  if (!any_) {
    return;
  }
  LawHistory now = *this;
  now.end_step();
  state.fields["largest_compression_below"].assign(count, 0.0);
  state.fields["largest_compression_above"].assign(count, 0.0);
  for (std::size_t index = 0; index < largest_.size(); ++index) {
    const ContactSet& set = contact_->sets()[index];
    std::ranges::copy(now.largest_[index],
                      state.fields[field_of(set)].begin() + static_cast<std::ptrdiff_t>(set.first));
  }
}

void LawHistory::restore(std::size_t count, const MotionState& state) {
  if (!any_) {
    return;
  }
  forget();
  for (std::size_t index = 0; index < largest_.size(); ++index) {
    const ContactSet& set = contact_->sets()[index];
    const std::vector<double>& field = state.field(field_of(set), count);
    std::copy_n(field.begin() + static_cast<std::ptrdiff_t>(set.first), largest_[index].size(),
                largest_[index].begin());
  }
}

}  // namespace udar
