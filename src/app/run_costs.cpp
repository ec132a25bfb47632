#include "app/run_costs.hpp"

#include <petscsys.h>

#include <chrono>
#include <cstdint>
#include <fstream>
#include <utility>
#include <vector>

#include "udar/petsc/error.hpp"

namespace udar::app {
namespace {

/// Largest resident size of this rank so far [bytes].
double peak_memory() {
  // Not getrusage: its peak is also that of whatever program started this one.
  std::ifstream status{"/proc/self/status"};
  for (std::string word; status >> word;) {
    double kilobytes = 0.0;
    if (word == "VmHWM:" && status >> kilobytes) {
      return 1024.0 * kilobytes;
    }
  }
  PetscLogDouble memory = 0.0;
  UDAR_CALL(PetscMemoryGetMaximumUsage(&memory));
  return memory;
}

petsc::Traffic difference(const petsc::Traffic& a, const petsc::Traffic& b) {
  return {.messages = a.messages - b.messages,
          .message_bytes = a.message_bytes - b.message_bytes,
          .reductions = a.reductions - b.reductions};
}

}  // namespace

double wall_time() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

CostMark cost_mark() {
  const petsc::LogEvents& events = petsc::log_events();
  CostMark mark;
  mark.time = wall_time();
  mark.traffic = petsc::traffic();
  mark.stages = {
      {"assemble", petsc::event_totals(events.assemble)},   {"line_solve", petsc::event_totals(events.solve)},
      {"contact", petsc::event_totals(events.contact)},     {"local_motion", petsc::event_totals(events.local_motion)},
      {"reduction", petsc::event_totals(events.reduction)}, {"output", petsc::event_totals(events.output)}};
  return mark;
}

void add_costs(MPI_Comm comm, const CostMark& begin, const CostMark& stepping, const CostMark& end,
               io::Summary& summary) {
  std::map<std::string, double> seconds{
      {"total", end.time - begin.time}, {"set_up", stepping.time - begin.time}, {"stepping", end.time - stepping.time}};
  std::map<std::string, double> own{{"other", end.time - stepping.time}};
  std::map<std::string, petsc::Traffic> traffic{{"stepping", difference(end.traffic, stepping.traffic)}};
  for (const auto& [stage, totals] : end.stages) {
    const petsc::EventTotals& before = stepping.stages.at(stage);
    if (stage == "assemble") {
      seconds[stage] = totals.seconds - begin.stages.at(stage).seconds;
      continue;
    }
    seconds[stage] = totals.seconds - before.seconds;
    own[stage] = totals.own - before.own;
    own["other"] -= own[stage];
    traffic[stage] = difference(totals.traffic, before.traffic);
  }
  const double memory = peak_memory();

  std::vector<double> largest{memory, -memory};
  std::vector<double> sums{memory, summary.costs.streamed_bytes};
  for (const auto& [stage, value] : seconds) {
    largest.push_back(value);
    sums.push_back(value);
  }
  for (const auto& [stage, value] : own) {
    sums.push_back(value);
  }
  for (const auto& [stage, value] : traffic) {
    largest.insert(largest.end(), {value.messages, value.message_bytes, value.reductions});
  }
  MPI_Allreduce(MPI_IN_PLACE, largest.data(), static_cast<int>(largest.size()), MPI_DOUBLE, MPI_MAX, comm);
  MPI_Allreduce(MPI_IN_PLACE, sums.data(), static_cast<int>(sums.size()), MPI_DOUBLE, MPI_SUM, comm);

  summary.costs.largest_memory_bytes = static_cast<std::uint64_t>(largest[0]);
  summary.costs.smallest_memory_bytes = static_cast<std::uint64_t>(-largest[1]);
  summary.costs.peak_memory_bytes = static_cast<std::uint64_t>(sums[0]);
  auto most = largest.begin() + 2;
  summary.costs.streamed_bytes = sums[1];
  auto sum = sums.begin() + 2;
  const double ranks = summary.ranks;
  for (const auto& [stage, value] : seconds) {
    summary.costs.wall_seconds[stage] = *most++;
    summary.costs.wall_seconds_mean[stage] = *sum++ / ranks;
  }
  for (const auto& [stage, value] : own) {
    summary.costs.own_seconds[stage] = *sum++ / ranks;
  }
  for (const auto& [stage, value] : traffic) {
    io::CommunicationCounts& counts = summary.costs.communication[stage];
    counts.messages = *most++;
    counts.message_bytes = *most++;
    counts.reductions = *most++;
  }
}

}  // namespace udar::app
