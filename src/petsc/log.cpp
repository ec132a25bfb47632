#include "udar/petsc/log.hpp"

#include <petsclog.h>
#include <petsctime.h>

#include <map>
#include <utility>

namespace udar::petsc {
namespace {

LogEvents& mutable_log_events() {
  static LogEvents events;
  return events;
}

PetscErrorCode forget_log_events() {
  PetscFunctionBeginUser;
  mutable_log_events() = {};
  PetscFunctionReturn(0);
}

/// The scope that is open on this rank, and what each event came to so far.
LogScope*& open_scope() {
  static LogScope* scope = nullptr;
  return scope;
}

std::map<PetscLogEvent, EventTotals>& totals_so_far() {
  static std::map<PetscLogEvent, EventTotals> totals;
  return totals;
}

}  // namespace

const LogEvents& log_events() { return mutable_log_events(); }

PetscErrorCode register_log_events() {
  PetscFunctionBeginUser;
  LogEvents& events = mutable_log_events();
  if (events.solve >= 0) {
    PetscFunctionReturn(0);
  }
  PetscClassId library = 0;
  PetscCall(PetscClassIdRegister("udar", &library));
  PetscCall(PetscLogEventRegister("FilterAssemble", library, &events.assemble));
  PetscCall(PetscLogEventRegister("FilterSolve", library, &events.solve));
  PetscCall(PetscLogEventRegister("Contact", library, &events.contact));
  PetscCall(PetscLogEventRegister("LocalMotion", library, &events.local_motion));
  PetscCall(PetscLogEventRegister("Reduction", library, &events.reduction));
  PetscCall(PetscLogEventRegister("Output", library, &events.output));
  PetscCall(PetscLogEventRegister("OutputFields", library, &events.fields));
  PetscCall(PetscRegisterFinalize(forget_log_events));
  PetscFunctionReturn(0);
}

LogScope::LogScope(PetscLogEvent event) : event_{event} {
  if (event_ >= 0) {
    around_ = std::exchange(open_scope(), this);
    PetscLogEventBegin(event_, 0, 0, 0, 0);
    before_ = traffic();
    PetscTime(&begin_);
  }
}

LogScope::~LogScope() {
  if (event_ >= 0) {
    PetscLogDouble end = 0.0;
    PetscTime(&end);
    EventTotals& totals = totals_so_far()[event_];
    totals.own += end - begin_ - inside_;
    if (!within_itself()) {
      const Traffic now = traffic();
      totals.seconds += end - begin_;
      ++totals.calls;
      totals.traffic.messages += now.messages - before_.messages;
      totals.traffic.message_bytes += now.message_bytes - before_.message_bytes;
      totals.traffic.reductions += now.reductions - before_.reductions;
    }
    PetscLogEventEnd(event_, 0, 0, 0, 0);
    open_scope() = around_;
    if (around_ != nullptr) {
      around_->inside_ += end - begin_;
    }
  }
}

bool LogScope::within_itself() const noexcept {
  const LogScope* scope = around_;
  while (scope != nullptr && scope->event_ != event_) {
    scope = scope->around_;
  }
  return scope != nullptr;
}

Traffic traffic() {
  return {.messages = 0.5 * (petsc_isend_ct + petsc_send_ct + petsc_irecv_ct + petsc_recv_ct),
          .message_bytes = 0.5 * (petsc_isend_len + petsc_send_len + petsc_irecv_len + petsc_recv_len),
          .reductions = petsc_allreduce_ct + petsc_gather_ct + petsc_scatter_ct};
}

EventTotals event_totals(PetscLogEvent event) {
  const auto found = totals_so_far().find(event);
  return found != totals_so_far().end() ? found->second : EventTotals{};
}

}  // namespace udar::petsc
