#include "app/modal_estimate.hpp"

#include <petscsys.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "app/run_layout.hpp"
#include "app/run_output.hpp"
#include "app/run_report.hpp"
#include "udar/dynamics/impact_dynamics.hpp"
#include "udar/dynamics/model.hpp"
#include "udar/io/run_directory.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/scoped_options.hpp"
#include "udar/petsc/warnings.hpp"

namespace udar::app {
namespace {

constexpr double kMoreModes = 1.4;

/// The same run into a folder of its own, without what takes most of the time.
Case aside(const Case& input) {
  Case other = input;
  other.output.directory += "/more_modes";
  other.output.overwrite = true;
  other.output.field_interval = 0.0;
  other.restart = {};
  return other;
}

std::vector<double> differences(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> all(std::min(a.size(), b.size()));
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i] = std::abs(a[i] - b[i]);
  }
  return all;
}

std::optional<double> difference(const std::optional<double>& a, const std::optional<double>& b) {
  return a && b ? std::optional{std::abs(*a - *b)} : std::nullopt;
}

std::optional<double> stress(const io::Summary& summary) {
  const auto found =
      std::ranges::find(summary.peaks, "max_bending_stress", &decltype(summary.peaks)::value_type::first);
  return found != summary.peaks.end() && found->second ? std::optional{found->second->value} : std::nullopt;
}

/// @return empty: it cannot be run, or was told to stop
std::optional<io::Summary> run_aside(MPI_Comm comm, const Case& other, const std::function<bool()>& stop) {
  try {
    const io::FolderLock lock = io::prepare_run_directory(comm, other.output.directory, other.output.overwrite);
    Model model{comm, other};
    ImpactDynamics dynamics{model};
    dynamics.set_stop_request(stop);
    const RunOutput output{other, model, dynamics, make_layout(other, model.line, model.contacts, dynamics.fields()),
                           nullptr};
    dynamics.solve();
    io::Summary summary = gather_summary(other, model.line, dynamics, output);
    return summary.completed ? std::optional{std::move(summary)} : std::nullopt;
  } catch (const InputError&) {
    return std::nullopt;  // there are not so many modes, or they are too many for the contact points
  } catch (const std::runtime_error& error) {
    petsc::warn(comm, "no estimate by more modes: %s", error.what());
    return std::nullopt;
  }
}

}  // namespace

std::optional<io::ModalEstimate> estimate_by_more_modes(MPI_Comm comm, const Case& input, const io::Summary& found,
                                                        const std::function<bool()>& stop) {
  if (!input.modal || !input.modal_estimate || !found.completed ||
      (!input.restart.file.empty() && !input.restart.in_place)) {
    return std::nullopt;
  }
  io::ModalEstimate estimate;
  estimate.modes =
      static_cast<PetscInt>(std::ceil(kMoreModes * static_cast<double>(found.integrator_counts.at("modes"))));
  const petsc::ScopedOptions more{{{"-modal_modes", std::to_string(estimate.modes)}}};
  const Case other = aside(input);
  const std::optional<io::Summary> second = run_aside(comm, other, stop);
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  if (rank == 0) {
    std::error_code ignored;
    std::filesystem::remove_all(other.output.directory, ignored);
  }
  if (!second) {
    return std::nullopt;
  }
  estimate.last_contact_time = difference(found.contact.last_contact_time, second->contact.last_contact_time);
  estimate.min_line_gap = difference(found.contact.min_line_gap, second->contact.min_line_gap);
  estimate.support_impulse = differences(found.contact.support_impulse, second->contact.support_impulse);
  estimate.peak_support_force = differences(found.contact.peak_support_force, second->contact.peak_support_force);
  estimate.max_bending_stress = difference(stress(found), stress(*second));
  return estimate;
}

void print_estimate(MPI_Comm comm, const io::Summary& found) {
  if (!found.modal_estimate) {
    return;
  }
  const auto largest = [](const std::vector<double>& off, const std::vector<double>& of) {
    double size = 0.0;
    double error = 0.0;
    for (std::size_t i = 0; i < off.size(); ++i) {
      size = std::max(size, std::abs(of[i]));
      error = std::max(error, off[i]);
    }
    return size > 0.0 ? 100.0 * error / size : 0.0;
  };
  const io::ModalEstimate& estimate = *found.modal_estimate;
  UDAR_CALL(PetscPrintf(comm,
                        "udar: %d modes in place of %d change impulses by %.2g %% and peak forces by %.2g %% of the "
                        "largest (modal_estimate in summary.json)\n",
                        static_cast<int>(estimate.modes), static_cast<int>(found.integrator_counts.at("modes")),
                        largest(estimate.support_impulse, found.contact.support_impulse),
                        largest(estimate.peak_support_force, found.contact.peak_support_force)));
}

}  // namespace udar::app
