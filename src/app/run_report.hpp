#pragma once
/// @file
/// What a run says of itself when it is over.

#include <span>
#include <string>

#include "app/run_costs.hpp"
#include "app/run_output.hpp"
#include "udar/app/case.hpp"
#include "udar/dynamics/impact_dynamics.hpp"
#include "udar/filter/modes.hpp"
#include "udar/io/summary.hpp"

namespace udar::app {

/// @brief Where clocks and counters stood at two points of a run.
struct RunMarks {
  CostMark begin;               ///< of the run
  CostMark stepping;            ///< of its first step
  std::span<const Mode> modes;  ///< the lowest, as the run has printed them
};

/// @brief What there is to say of a run, but for costs; takes the warnings so far. @note Collective.
[[nodiscard]] io::Summary gather_summary(const Case& input, FilteredStructure& line, const ImpactDynamics& dynamics,
                                         const RunOutput& output);

/// @brief Warns of what the numbers say against themselves, and writes summary.json.
/// @note Collective. @throws FileError on all ranks
[[nodiscard]] io::Summary summarise(const Case& input, FilteredStructure& line, const ImpactDynamics& dynamics,
                                    const RunOutput& output, const RunMarks& marks);

/// @brief Writes summary.json of a run. @note Collective. @throws FileError on all ranks
void write(MPI_Comm comm, const Case& input, const io::Summary& summary);

/// How a run that ended early is continued from its last checkpoint.
[[nodiscard]] std::string continue_with(const Case& input);

/// @brief The end of the message of a run that failed: how far it had come, and how it is continued.
/// @param time that it had reached [s] @param kept whether restart.h5 is of that time; else of some time before, if
/// there is one
[[nodiscard]] std::string how_to_go_on(const Case& input, double time, bool kept);

/// @brief The last lines on the terminal, as `input.output.page` has them: what the run came to, how far it came, and
/// how it can be continued. @note Collective.
void print_end(MPI_Comm comm, const Case& input, const Structure& structure, const io::Summary& summary);

}  // namespace udar::app
