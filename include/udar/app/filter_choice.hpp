#pragma once
/// @file
/// The filter frequency by the accuracy asked for, and the modes that are to be exact.

#include <optional>
#include <vector>

#include "udar/app/case.hpp"
#include "udar/filter/modes.hpp"

namespace udar::app {

/// @brief The beam on a mesh that is fine enough for its lowest modes, if that is coarser than its own.
///
/// 2000 elements, or 200 for each mode: lumped masses lower the frequency of mode k by 3 (k / n)^2 of it at most.
/// @return none if the mesh is coarse enough as it is, or the ranks are too many for a coarser one
/// @note Not collective.
[[nodiscard]] std::optional<BeamParameters> coarser(MPI_Comm comm, const BeamParameters& beam, PetscInt modes);

/// @brief The filter at its frequency: the one asked for; with `-filter_frequency auto` wf, rounded up to six digits,
/// so that no mode that matters is lowered by more than `-filter_accuracy`, and prints these modes.
/// @note Collective; printed by rank 0.
/// @throws InputError if the structure has fewer modes than asked for; SolveError if they cannot be computed
[[nodiscard]] FilterParameters choose_filter(MPI_Comm comm, const ModelParameters& model, const FilterInput& filter);

/// @brief Corrects the modes asked for and prints which, with the frequencies before and after.
/// @return their numbers, counted from 1; empty: none
/// @note Collective; printed by rank 0.
/// @throws InputError if there is no such mode, or only one of two with the same frequency is asked for
std::vector<PetscInt> correct_modes(FilteredStructure& line, const ModeChoice& exact, bool rigid = false);

/// @brief Computes the lowest modes, six for `-udar_view`, else three, then corrects those asked for.
/// @note Collective. @throws as `correct_modes`
[[nodiscard]] std::vector<Mode> settle_modes(FilteredStructure& line, const Case& input);

}  // namespace udar::app
