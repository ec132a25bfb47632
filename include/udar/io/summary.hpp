#pragma once
/// @file
/// summary.json: what a run comes to, for programs.

#include <mpi.h>
#include <petscsys.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "udar/io/peaks.hpp"
#include "udar/motion/observer.hpp"

namespace udar::io {

/// @brief What one rank tells others in one stage of the run.
struct CommunicationCounts {
  double messages = 0.0;       ///< between two ranks: half of those sent and received
  double message_bytes = 0.0;  ///< of these
  double reductions = 0.0;     ///< collective calls
};

/// @brief How often things were done.
struct SummaryCounts {
  PetscInt steps = 0;           ///< accepted
  PetscInt rejected_steps = 0;  ///< by the error control
  PetscInt repeated_steps = 0;  ///< taken again to end at an impact
  PetscInt rhs_evaluations = 0;
  PetscInt line_solves = 0;
  PetscInt stepping_line_solves = 0;  ///< of these, those of the stepping
  PetscInt row_line_solves = 0;       ///< of these, those of output rows
  PetscInt event_steps = 0;           ///< with an impact, rest or release
  PetscInt impacts = 0;
  PetscInt rests = 0;
  PetscInt releases = 0;
};

/// @brief What supports did.
struct SummaryContact {
  std::optional<double> first_contact_time;  ///< [s]; empty without contact
  std::optional<double> last_contact_time;   ///< [s]
  std::optional<double> min_line_gap;        ///< smallest distance of the line from a support [m]; empty without any
  std::optional<double> min_line_gap_x;      ///< where [m]
  std::optional<double> min_line_gap_time;   ///< when [s]
  std::vector<double> support_impulse;       ///< of each support on the masses, y up [N s]
  std::optional<double> force_window;        ///< what forces of supports are averaged over [s]; empty without any
  std::optional<double> peak_force_window;   ///< what the next are averaged over, no longer than that [s]
  std::vector<double> peak_support_force;    ///< the mean force of largest size in the motion, y up [N]
  /// @name Of each support, when it was touched [s]; empty: never
  /// @{
  std::vector<std::optional<double>> support_first_contact;
  std::vector<std::optional<double>> support_last_contact;
  /// @}
  std::optional<double> impact_velocity;   ///< of the centre of mass at the first contact [m/s], y up
  std::optional<double> rebound_velocity;  ///< at the height of that, on its way back [m/s]
};

/// @brief What the run took.
struct SummaryCosts {
  double streamed_bytes = 0.0;  ///< that steps and solves had to move to and from memory, all ranks; 0: not known
  std::map<std::string, double> wall_seconds;                ///< by stage of the run, largest over the ranks
  std::map<std::string, double> wall_seconds_mean;           ///< mean over the ranks
  std::map<std::string, double> own_seconds;                 ///< of the stepping, without stages inside; mean
  std::map<std::string, CommunicationCounts> communication;  ///< by stage, largest over the ranks
  std::uint64_t peak_memory_bytes = 0;                       ///< largest resident size, summed over the ranks
  std::uint64_t largest_memory_bytes = 0;                    ///< of any rank
  std::uint64_t smallest_memory_bytes = 0;                   ///< of any rank
};

/// @brief How far numbers are from those of a run with more modes.
struct ModalEstimate {
  PetscInt modes = 0;                        ///< of the other run
  std::optional<double> last_contact_time;   ///< [s]
  std::optional<double> min_line_gap;        ///< [m]
  std::vector<double> support_impulse;       ///< [N s]
  std::vector<double> peak_support_force;    ///< [N]
  std::optional<double> max_bending_stress;  ///< [Pa]
};

/// @brief The content of summary.json; the keys are the names here, without those of the parts. An empty optional is
/// written as null.
struct Summary {
  bool completed = false;  ///< reached its end time
  double end_time = 0.0;   ///< reached [s]
  PetscInt elements = 0;
  int ranks = 1;
  std::string integrator;                             ///< the type of the TS
  std::map<std::string, PetscInt> integrator_counts;  ///< what it counts of its own, in this run of the program
  SummaryCounts counts{};
  SummaryContact contact{};
  SummaryCosts costs{};
  /// Largest values by their keys, "max_bending_stress"; none where it is not known.
  std::vector<std::pair<std::string, std::optional<Peak>>> peaks;
  std::optional<ModalEstimate> modal_estimate;  ///< empty: there was no other run
  std::vector<double> mode_frequency;           ///< of the lowest vibration modes, without the filter [rad/s]
  std::vector<double> mode_filtered;            ///< what the filter makes of them [rad/s]; empty without filter
  EnergyLedger energy{};                        ///< at the end [J]
  std::vector<std::string> warnings;            ///< what `petsc::warn` told the user, in order
  std::vector<double> gauge_position;           ///< asked for [m]
  std::vector<double> gauge_node_position;      ///< of the node it became [m]
  std::map<std::string, std::string> versions;  ///< as of `library_versions`
};

/// @brief As summary.json has it.
[[nodiscard]] std::string as_json(const Summary& summary);

/// @brief Writes `summary` as JSON. The file appears whole or not at all.
/// @param[in] summary used on rank 0
/// @note Collective. Numbers that are not finite are written as null.
/// @throws FileError on all ranks
void write_summary(MPI_Comm comm, const std::string& path, const Summary& summary);

}  // namespace udar::io
