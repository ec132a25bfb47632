#pragma once
/// @file
/// The line solve in 113-bit arithmetic, by block elimination of the mixed form: what solvers are measured against.

#include <vector>

#include "udar/structure/beam_chain.hpp"

namespace udar::tools {

/// All nodes' spring stretch d = Yc - Ym [m] and moment EI w'' [N m], rounded.
struct QuadLine {
  std::vector<double> stretch;
  std::vector<double> moment;
};

/// @brief Solves docs/theory.md, "The discrete line", for the line's displacement, unscaled.
/// @param displacement, force  Ym [m] and F [N] of all nodes; force may be empty
/// @note Not collective; needs about 100 bytes per node of the whole beam.
QuadLine quad_line(const BeamChain& beam, double wf, const std::vector<double>& displacement,
                   const std::vector<double>& force);

/// Largest difference of local values from their exact ones, relative to the largest exact one; keeps a NaN.
/// @note Collective.
double relative_error(const BeamChain& beam, const std::vector<double>& found, const std::vector<double>& exact);

}  // namespace udar::tools
