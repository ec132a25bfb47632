#include "udar/io/summary.hpp"

#include <nlohmann/json.hpp>

#include "io/text_file.hpp"

namespace udar::io {
namespace {

nlohmann::ordered_json number_or_null(const std::optional<double>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json numbers_or_null(const std::vector<std::optional<double>>& values) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const auto& value : values) {
    all.push_back(number_or_null(value));
  }
  return all;
}

/// NAME, NAME_x or in space NAME_place, and NAME_time; null where there is none.
void add_peak(nlohmann::ordered_json& json, const std::string& name, const std::optional<Peak>& peak) {
  json[name] = peak ? nlohmann::ordered_json(peak->value) : nullptr;
  if (peak && peak->member >= 0) {
    json[name + "_member"] = peak->member;
  } else if (peak && (peak->y != 0.0 || peak->z != 0.0)) {
    json[name + "_place"] = {peak->x, peak->y, peak->z};
  } else {
    json[name + "_x"] = peak ? nlohmann::ordered_json(peak->x) : nullptr;
  }
  json[name + "_time"] = peak ? nlohmann::ordered_json(peak->time) : nullptr;
}

nlohmann::ordered_json energies(const EnergyLedger& ledger) {
  return {{"initial", ledger.initial},
          {"kinetic", ledger.kinetic},
          {"line_strain", ledger.line_strain},
          {"fictitious_springs", ledger.fictitious_springs},
          {"load_potential", ledger.load_potential},
          {"support_springs", ledger.support_springs},
          {"load_work", ledger.load_work},
          {"support_work", ledger.support_work},
          {"base_work", ledger.base_work},
          {"lost_in_impacts", ledger.lost_in_impacts},
          {"lost_in_dampers", ledger.lost_in_dampers},
          {"radiated", ledger.radiated},
          {"lost_in_hinges", ledger.lost_in_hinges}};
}

}  // namespace

std::string as_json(const Summary& summary) {
  nlohmann::ordered_json json;
  json["completed"] = summary.completed;
  json["end_time"] = summary.end_time;
  json["elements"] = summary.elements;
  json["ranks"] = summary.ranks;
  json["integrator"] = summary.integrator;
  json["integrator_counts"] = summary.integrator_counts;
  json["steps"] = summary.counts.steps;
  json["rejected_steps"] = summary.counts.rejected_steps;
  json["repeated_steps"] = summary.counts.repeated_steps;
  json["rhs_evaluations"] = summary.counts.rhs_evaluations;
  json["line_solves"] = summary.counts.line_solves;
  json["stepping_line_solves"] = summary.counts.stepping_line_solves;
  json["row_line_solves"] = summary.counts.row_line_solves;
  json["streamed_bytes"] =
      number_or_null(summary.costs.streamed_bytes > 0.0 ? std::optional{summary.costs.streamed_bytes} : std::nullopt);
  json["event_steps"] = summary.counts.event_steps;
  json["impacts"] = summary.counts.impacts;
  json["rests"] = summary.counts.rests;
  json["releases"] = summary.counts.releases;
  json["first_contact_time"] = number_or_null(summary.contact.first_contact_time);
  json["last_contact_time"] = number_or_null(summary.contact.last_contact_time);
  json["min_line_gap"] = number_or_null(summary.contact.min_line_gap);
  json["min_line_gap_x"] = number_or_null(summary.contact.min_line_gap_x);
  json["min_line_gap_time"] = number_or_null(summary.contact.min_line_gap_time);
  json["support_impulse"] = summary.contact.support_impulse;
  json["force_window"] = number_or_null(summary.contact.force_window);
  json["peak_force_window"] = number_or_null(summary.contact.peak_force_window);
  json["peak_support_force"] = summary.contact.peak_support_force;
  json["support_first_contact"] = numbers_or_null(summary.contact.support_first_contact);
  json["support_last_contact"] = numbers_or_null(summary.contact.support_last_contact);
  json["impact_velocity"] = number_or_null(summary.contact.impact_velocity);
  json["rebound_velocity"] = number_or_null(summary.contact.rebound_velocity);
  for (const auto& [name, peak] : summary.peaks) {
    add_peak(json, name, peak);
  }
  json["mode_frequency"] = summary.mode_frequency;
  json["mode_filtered"] = summary.mode_filtered;
  json["energy"] = energies(summary.energy);
  json["energy_drift"] = summary.energy.drift();
  json["warnings"] = summary.warnings;
  json["gauge_position"] = summary.gauge_position;
  json["gauge_node_position"] = summary.gauge_node_position;
  if (const auto& estimate = summary.modal_estimate) {
    json["modal_estimate"] = {{"modes", estimate->modes},
                              {"last_contact_time", number_or_null(estimate->last_contact_time)},
                              {"min_line_gap", number_or_null(estimate->min_line_gap)},
                              {"support_impulse", estimate->support_impulse},
                              {"peak_support_force", estimate->peak_support_force},
                              {"max_bending_stress", number_or_null(estimate->max_bending_stress)}};
  }
  json["wall_seconds"] = summary.costs.wall_seconds;
  json["wall_seconds_mean"] = summary.costs.wall_seconds_mean;
  json["own_seconds"] = summary.costs.own_seconds;
  json["communication"] = nlohmann::ordered_json::object();
  for (const auto& [stage, counts] : summary.costs.communication) {
    json["communication"][stage] = {
        {"messages", counts.messages}, {"message_bytes", counts.message_bytes}, {"reductions", counts.reductions}};
  }
  json["peak_memory_bytes"] = summary.costs.peak_memory_bytes;
  json["memory_per_rank"] = {{"largest", summary.costs.largest_memory_bytes},
                             {"smallest", summary.costs.smallest_memory_bytes}};
  json["versions"] = summary.versions;
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

void write_summary(MPI_Comm comm, const std::string& path, const Summary& summary) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  replace_text(comm, path, rank == 0 ? as_json(summary) : "", true);
}

}  // namespace udar::io
