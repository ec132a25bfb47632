#pragma once
/// @file
/// What the filter does to the natural frequencies of a structure.

#include <optional>
#include <span>
#include <vector>

#include "udar/filter/filtered_structure.hpp"

namespace udar {

/// @brief One vibration mode of the lumped beam and its filtered frequency.
struct Mode {
  double frequency = 0.0;     ///< w of the unfiltered lumped beam [rad/s]
  double filtered = 0.0;      ///< lambda = wf w / sqrt(wf^2 + w^2) [rad/s]
  bool corrected = false;     ///< the line answers to it without the filter
  std::vector<double> shape;  ///< at the local nodes [kg^(-1/2)], M-orthonormal; empty unless asked for

  /// Relative error lambda / w - 1 [-].
  [[nodiscard]] double distortion() const { return filtered / frequency - 1.0; }
};

/// @brief lambda = wf w / sqrt(wf^2 + w^2) [rad/s]: what the filter makes of a frequency w [rad/s].
[[nodiscard]] double filtered_frequency(double frequency, double filter_frequency);

/// @brief The smallest filter frequency [rad/s] that lowers a mode of frequency w [rad/s] by no more than a share
/// `accuracy` of w, in (0, 1): w (1 - a) / sqrt(2 a - a^2).
[[nodiscard]] double filter_frequency_for(double frequency, double accuracy);

/// @brief The lowest vibration modes, rigid-body motions left out; fewer if the beam has fewer.
/// @param line without corrected modes
/// @note Collective; some tens of line solves. Computed by SLEPc on the operator of the filter, options
/// `-filter_eps_*`. Source: docs/theory.md, "What the filter does to a mode"
[[nodiscard]] std::vector<Mode> lowest_modes(FilteredStructure& line, PetscInt count);

/// @brief The same to all the digits that the line solve has, with shapes, by a line on filter springs that separate
/// these modes best, whatever the filter frequency in `filter`, which only gives `Mode::filtered` (0: not known).
/// @note Collective; a factorisation and some tens of line solves, two or three times. The start vector is fixed: the
/// same bits on the same number of ranks.
/// @throws SolveError if SLEPc does not converge
[[nodiscard]] std::vector<Mode> exact_modes(const Structure& structure, const FilterParameters& filter, PetscInt count);

/// @brief How modes are looked for beside others.
struct ModeSearch {
  PetscInt count = 1;
  double tolerance = 1e-10;  ///< of the residual, as a share of w^2 / (wf^2 + w^2)
  int start = 0;             ///< which `start_value`: one start alone finds one mode of those that share a frequency
};

/// @brief The lowest modes beside some that are known, with shapes; the frequency of what strains nothing is 0.
/// @param known M-orthonormal shapes, local points
/// @param line whose filter frequency separates the modes wanted from the others: a third of the last one's
/// @note Collective; about twice as many line solves as there are modes. @throws SolveError if SLEPc does not converge
[[nodiscard]] std::vector<Mode> modes_beside(FilteredStructure& line, std::span<const std::vector<double>> known,
                                             const ModeSearch& search);

/// @brief Something of every mode, at a local point; the same whichever rank has it. @param which of many independent
[[nodiscard]] double start_value(const MassPoints& points, std::size_t point, int which);

/// @brief A line on filter springs that tell the lowest modes from the rest best, and what finding them took.
struct Separation {
  FilterParameters filter;
  PetscInt solves = 0;  ///< line solves
};
/// @brief Filter springs at 0.3 of the frequency of mode number `count`: of a beam by what it nearly is, else by trial
/// (measured on beams: so a Lanczos basis of 2 k holds k modes, and columns of the rest gain more than a digit a
/// solve).
/// @param guess filter frequency to try first [rad/s]; 0: none @note Collective; line solves of two or three searches.
[[nodiscard]] Separation separate_modes(const Structure& structure, const FilterParameters& filter, PetscInt count,
                                        double guess = 0.0);

/// @brief w^2 / (wf^2 + w^2) of a mode that is a motion without strain, seen through round-off: at most this.
/// @note Collective.
[[nodiscard]] double zero_share(const FilteredStructure& line);

/// @brief Largest frequency of the masses on the line, corrected modes included [rad/s], to 1e-5 of it, never above.
/// @return nothing where SLEPc does not converge, as many modes near the largest do not let it
/// @note Collective; some tens of line solves.
[[nodiscard]] std::optional<double> largest_frequency(FilteredStructure& line);

/// @brief ell = (4 EI / (rhoA wf^2))^(1/4) [m]: over this length the line forgets a force on one mass.
/// @return the largest of all segments
[[nodiscard]] double decay_length(const BeamChain& beam, double filter_frequency);

}  // namespace udar
