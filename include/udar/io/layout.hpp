#pragma once
/// @file
/// What every writer must know about a run: plain values, no time and no files.

#include <petscsys.h>

#include <algorithm>
#include <cstdint>
#include <functional>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "udar/structure/field.hpp"

namespace udar::io {

/// @brief The nodes of this rank, `[begin, end)` of `total`; the ranks hold consecutive ranges in their order.
struct NodeRange {
  PetscInt begin = 0;
  PetscInt end = 0;
  PetscInt total = 0;  ///< over all ranks

  [[nodiscard]] PetscInt count() const noexcept { return end - begin; }
};

/// @brief A multiple of the largest size that a field reaches at each point: the bending stress |M| / W.
struct ScaledPeak {
  std::string name;            ///< "stress": stress_max in the envelope
  std::string unit;            ///< "Pa"
  std::string field;           ///< one with extremes at the points
  std::vector<double> factor;  ///< of this rank's points; not a number: not known
};

/// @brief The plain description of a run that all writers get. Equal on every rank but for `nodes` and `x`.
struct RunLayout {
  /// @brief One support, or the floor.
  struct Support {
    double position = 0.0;     ///< centre along the beam [m]
    double width = 0.0;        ///< along the beam [m]; 0 for a point support
    double height = 0.0;       ///< of the contact face [m], y up
    double restitution = 0.0;  ///< between 0 and 1
    int side = 1;              ///< +1 below the beam, -1 above
    std::function<double(double)> lift =
        nullptr;  ///< what its motion adds to the height [m] at a time [s]; empty: none
  };

  MPI_Comm comm = MPI_COMM_NULL;  ///< borrowed; must outlive the writers
  PetscInt elements = 0;          ///< over all ranks
  NodeRange nodes;                ///< of this rank
  std::vector<double> x;          ///< of this rank's nodes, along the beam [m]
  Topology topology;              ///< of all points
  /// Of points that do not stand on a line in their order, else empty: the rest of their places [m], which way they
  /// move (1, 2, 3: x, y, z; 0: no displacement), and their number in the model of the user.
  std::vector<double> y, z;
  std::vector<std::int64_t> direction, number;
  std::vector<FieldInfo> fields;       ///< of the snapshots, in their order
  std::vector<ScaledPeak> peaks;       ///< made of their extremes
  std::span<const double> mass;        ///< of the same [kg]; borrowed while files are opened
  std::vector<PetscInt> gauge_node;    ///< global node of each gauge
  std::vector<double> gauge_position;  ///< what was asked for [m]
  std::vector<Support> supports;       ///< the floor, if any, is the last
  std::vector<double> ground_x;        ///< of the ground's profile [m]; empty: none
  std::vector<double> ground_height;   ///< as many [m]
  double filter_frequency = 0.0;       ///< [rad/s]
  double longest_sample = 0.0;         ///< extremes are looked for at least this often [s]; 0: at rows alone
  std::string options_text;            ///< one `-key value` per line

  /// Fields with rows at the points: those of the line, then those of the masses.
  [[nodiscard]] std::vector<FieldInfo> fields_in_pictures() const {
    std::vector<FieldInfo> shown;
    for (const Body body : {Body::line, Body::masses}) {
      std::ranges::copy_if(fields, std::back_inserter(shown), [body](const FieldInfo& field) {
        return field.body == body && field.rows && field.where == Where::points;
      });
    }
    return shown;
  }
  /// This rank's cells: between its points, and between its last and the next.
  [[nodiscard]] NodeRange cells() const noexcept {
    if (topology.cells == Topology::Cells::vertices) {
      return {};
    }
    const PetscInt all = std::max<PetscInt>(nodes.total - 1, 0);
    return {.begin = std::min(nodes.begin, all), .end = std::min(nodes.end, all), .total = all};
  }
};

}  // namespace udar::io
