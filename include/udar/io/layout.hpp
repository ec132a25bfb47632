#pragma once
/// @file
/// What every writer must know about a run: plain values, no time and no files.

#include <petscsys.h>

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace udar::io {

/// @brief The nodes of this rank, `[begin, end)` of `total`; the ranks hold consecutive ranges in their order.
struct NodeRange {
  PetscInt begin = 0;
  PetscInt end = 0;
  PetscInt total = 0;  ///< over all ranks

  [[nodiscard]] PetscInt count() const noexcept { return end - begin; }
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

  MPI_Comm comm = MPI_COMM_NULL;               ///< borrowed; must outlive the writers
  PetscInt elements = 0;                       ///< over all ranks
  NodeRange nodes;                             ///< of this rank
  std::vector<double> x;                       ///< of this rank's nodes, along the beam [m]
  std::vector<double> stress_per_moment;       ///< 1/W at each of them [Pa/(N m)]; not a number: not known
  std::vector<double> utilisation_per_moment;  ///< of the yield stress [1/(N m)]; not a number: not known
  std::span<const double> mass;                ///< of the same [kg]; borrowed while files are opened
  std::vector<PetscInt> gauge_node;            ///< global node of each gauge
  std::vector<double> gauge_position;          ///< what was asked for [m]
  std::vector<Support> supports;               ///< the floor, if any, is the last
  std::vector<double> ground_x;                ///< of the ground's profile [m]; empty: none
  std::vector<double> ground_height;           ///< as many [m]
  double filter_frequency = 0.0;               ///< [rad/s]
  double longest_sample = 0.0;                 ///< extremes are looked for at least this often [s]; 0: at rows alone
  std::string options_text;                    ///< one `-key value` per line
};

}  // namespace udar::io
