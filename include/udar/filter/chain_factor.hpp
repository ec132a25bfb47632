#pragma once
/// @file
/// The factor of the chain recursion: joints, the spans between them, and how the ranks hang together.

#include <petscsys.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "udar/filter/chain_span.hpp"
#include "udar/filter/line_data.hpp"

namespace udar::chain {

/// How the ranks learn what happens at their ends.
enum class Coupling : std::uint8_t {
  none,        ///< one rank
  neighbours,  ///< what is further away than the neighbour has decayed below round-off
  all,         ///< one `MPI_Allgather` of four numbers a rank
};

/// A node where spans meet, and the span on its right.
struct Joint {
  std::size_t node = 0;       // local; local nodes: the next rank's first
  std::ptrdiff_t block = -1;  // of the span on the right, -1: no inner nodes
  bool starts = false;        // first node of a beam
  bool ends = false;          // last node of a beam
  double release = 0.0;       // 1 / S
  double rotation_release = 0.0;
  double keep = 1.0;   // of the state's own displacement: 1 - gain
  bool stiff = false;  // its spring against the line: displacements follow from forces, not forces from displacements
  std::array<double, 2> gain{};
  double compliance = 0.0;    // 1 / K
  double ground_ratio = 0.0;  // ground / K
  double kink_ratio = 0.0;    // weight of the rise on the left
  double kink_scale = 0.0;    // 1 / h
  std::array<double, 2> inverse_scale{};
  std::array<double, 4> transfer{};
  std::array<double, 4> reaction{};   // (1 + J P)^-1
  std::array<double, 3> stiffness{};  // J
  std::array<double, 3> combined{};   // (P^-1 + J)^-1
};

/// Equal spans one after the other.
struct SpanRow {
  std::size_t span = 0;   // index of what they are
  std::size_t first = 0;  // local node of the first left joint
  std::size_t block = 0;  // of the first of them
  std::size_t blocks = 0;
};

/// A rank's piece as its neighbours see it: from the state after its first node to that after the next rank's first.
struct Piece {
  Matrix2 transfer{};
  long double det_transfer = 0.0;
  Symmetric compliance{};
  long double det_compliance = 0.0;
  Symmetric stiffness{};
  long double decay = 0.0;  // longest [m]
  long double force = 0.0;  // EI / decay^3 there [N/m]
  long double shortest = 0.0;
};

/// @brief What the solver's two sweeps need, computed once in long double; this rank's share.
///
/// The line is cut at joints: where its properties change, at its ends, and at regular distances in between. Equal
/// spans share one small factor. Source: docs/theory.md, "The chain recursion".
struct Factor {
  /// @note Collective. Cost O(local nodes + ranks). @throws InputError if a rank has fewer than two nodes
  explicit Factor(const LineData& line);

  MPI_Comm comm;
  int rank = 0;
  int ranks = 1;
  std::size_t nodes;       ///< local
  std::size_t blocks = 0;  ///< spans with inner nodes
  std::size_t inner_nodes = 0;
  std::vector<Span> spans;  ///< different ones
  std::vector<SpanRow> rows_of_spans;
  std::vector<Joint> joints;
  Coupling coupling = Coupling::none;
  /// From what each rank shows (4 a rank) to the state after this rank's first node, force and moment after the next's.
  std::vector<std::array<double, 4>> boundary;
  double shortest_decay = 0.0;  ///< decay length (4 EI h / k)^(1/4) [m], all ranks
  double longest_decay = 0.0;
  double carried = 0.0;  ///< largest share of a disturbance that passes a whole rank's piece [-], all ranks

 private:
  using Known = std::map<SpanKey, std::size_t>;  // where each kind of span is in `spans`
  void cut(const LineData& line);
  void add_spans(const LineData& line, std::size_t from, std::size_t to, Known& known);
  void couple(const Piece& own);
};

}  // namespace udar::chain
