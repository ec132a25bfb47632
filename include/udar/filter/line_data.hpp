#pragma once
/// @file
/// One rank's piece of the massless line on its springs, as plain numbers.

#include <petscmat.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "udar/structure/beam_chain.hpp"

namespace udar {

/// @brief What the chain solver must know of the line: this rank's nodes [begin, end) and one node and element beyond.
///
/// Nodes are numbered along the line over all ranks; each rank has at least two. An element that does not exist (before
/// the first node, after the last one, or in a gap between two beams) has infinite flexural compliance.
struct LineData {
  MPI_Comm comm = MPI_COMM_NULL;
  PetscInt begin = 0;
  PetscInt end = 0;
  PetscInt nodes = 0;                    ///< of all ranks
  std::vector<BeamElement> elements;     ///< [i] left of local node i, [i + 1] right of it; local nodes + 2
  std::vector<double> filter_stiffness;  ///< k = wf^2 m [N/m], > 0; local nodes, then node `end` unless it is the last
  std::vector<double> ground_stiffness;  ///< line to reference axis [N/m], infinite: fixed; as filter_stiffness
  double left_rotation = 0.0;            ///< rotational spring at the first node of all [N m/rad]; infinite: clamped
  double right_rotation = 0.0;           ///< the same at the last node
  /// Factors of the two unknowns (displacement, moment) per node in the operator's rows and columns; 0: the unknown is
  /// not there and has the row of the identity. 2 per node, nodes as filter_stiffness.
  std::vector<double> scale;

  [[nodiscard]] std::size_t local_nodes() const noexcept { return static_cast<std::size_t>(end - begin); }
  [[nodiscard]] static bool present(const BeamElement& element) noexcept {
    return std::isfinite(element.flexural_compliance);
  }
  /// Rotational spring at a local node [N m/rad].
  [[nodiscard]] double rotation(std::size_t i) const noexcept {
    const PetscInt node = begin + static_cast<PetscInt>(i);
    return node == 0 ? left_rotation : (node == nodes - 1 ? right_rotation : 0.0);
  }
};

/// @brief Attaches the line to an operator, so that `-pc_type chain` can solve with it.
///
/// The operator is that of docs/theory.md, "The discrete line": displacement and moment of each node side by side,
/// scaled by `LineData::scale`. The data must live as long as the operator.
/// @note Not collective.
void compose_line(Mat matrix, const LineData& line);

/// @brief The line attached to an operator, null if there is none.
[[nodiscard]] const LineData* composed_line(Mat matrix);

}  // namespace udar
