#pragma once
/// @file
/// What the filter does to the natural frequencies of the beam.

#include <vector>

#include "udar/filter/filtered_line.hpp"

namespace udar {

/// @brief One vibration mode of the lumped beam and its filtered frequency.
struct Mode {
  double frequency = 0.0;  ///< w of the unfiltered lumped beam [rad/s]
  double filtered = 0.0;   ///< lambda = wf w / sqrt(wf^2 + w^2) [rad/s]

  /// Relative error lambda / w - 1 [-].
  [[nodiscard]] double distortion() const { return filtered / frequency - 1.0; }
};

/// @brief The lowest vibration modes, rigid-body motions left out; fewer if the beam has fewer.
/// @note Collective; some tens of line solves. Computed by SLEPc on the operator of the filter, options
/// `-filter_eps_*`. Source: docs/theory.md, "What the filter does to a mode"
[[nodiscard]] std::vector<Mode> lowest_modes(FilteredLine& line, PetscInt count);

/// @brief ell = (4 EI / (rhoA wf^2))^(1/4) [m]: over this length the line forgets a force on one mass.
/// @return the largest of all segments
[[nodiscard]] double decay_length(const BeamChain& beam, double filter_frequency);

}  // namespace udar
