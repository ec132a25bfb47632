#include "app/support_contacts.hpp"

#include <mpi.h>

#include <algorithm>
#include <limits>
#include <string>

#include "udar/motion/motion_state.hpp"
#include "udar/petsc/error.hpp"

namespace udar::app {
namespace {

constexpr const char* kContacts = "support_contact_times";
constexpr const char* kImpulses = "support_contact_impulse";
constexpr double kNever = -std::numeric_limits<double>::infinity();

}  // namespace

SupportContacts::SupportContacts(const Case& input, const MassPoints& points)
    : comm_{points.comm()},
      interval_{input.output.interval},
      ends_(2 * input.supports.size(), kNever),
      impulse_(input.supports.size(), 0.0) {}

void SupportContacts::note(std::size_t support, double first, double last) {
  ends_[2 * support] = std::max(ends_[2 * support], -first);
  ends_[2 * support + 1] = std::max(ends_[2 * support + 1], last);
}

/// A support that gave something since the last row touched between: from that row on, to this one.
void SupportContacts::snapshot(const Snapshot& state) {
  for (std::size_t support = 0; support < impulse_.size(); ++support) {
    if (state.support_impulse[support] != impulse_[support]) {
      note(support, state.time, row_);
      impulse_[support] = state.support_impulse[support];
    }
  }
  row_ = state.time;
}

void SupportContacts::events(const StepRecords<ImpactRecord>& impacts, const StepRecords<RestRecord>& rests,
                             const EventCounts& /*all*/) {
  for (const ImpactRecord& impact : impacts) {
    note(static_cast<std::size_t>(impact.support), impact.time, impact.time);
  }
  for (const RestRecord& rest : rests) {
    note(static_cast<std::size_t>(rest.support), rest.time, rest.time);
  }
}

std::vector<double> SupportContacts::of_all_ranks() const {
  std::vector<double> ends = ends_;
  MPI_Allreduce(MPI_IN_PLACE, ends.data(), static_cast<int>(ends.size()), MPI_DOUBLE, MPI_MAX, comm_);
  return ends;
}

std::vector<SupportContacts::Times> SupportContacts::times() const {
  const std::vector<double> ends = of_all_ranks();
  std::vector<Times> all(impulse_.size());
  for (std::size_t support = 0; support < all.size(); ++support) {
    if (ends[2 * support] != kNever) {
      all[support] = {.first = -ends[2 * support], .last = ends[2 * support + 1]};
    }
  }
  return all;
}

void SupportContacts::save(MotionState& state) const {
  state.tables[kContacts] = of_all_ranks();
  state.tables[kImpulses] = impulse_;
  state.tables[kImpulses].push_back(row_);
}

void SupportContacts::restore(const MotionState& state) {
  const std::vector<double>& ends = state.table(kContacts);
  const std::vector<double>& impulse = state.table(kImpulses);
  if (ends.size() != ends_.size() || impulse.size() != impulse_.size() + 1) {
    throw InputError{"restart file: the times of contact are not of " + std::to_string(impulse_.size()) + " supports"};
  }
  ends_ = ends;
  impulse_.assign(impulse.begin(), impulse.end() - 1);
  row_ = impulse.back();
}

}  // namespace udar::app
