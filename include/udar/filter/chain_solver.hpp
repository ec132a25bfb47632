#pragma once
/// @file
/// The line solve by the chain recursion, distributed over the ranks.

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "udar/filter/chain_span.hpp"
#include "udar/filter/line_data.hpp"

namespace udar {

/// @brief Solves the massless line on its springs exactly, at the speed of memory.
///
/// The line is cut at joints: where its properties change, at its ends, and at regular distances in between. Equal
/// stretches between joints share one small factor and are solved side by side; the joints are coupled by the recursion
/// that transports compliance, the ranks by four numbers each. Source: docs/theory.md, "The chain recursion".
class ChainSolver {
 public:
  /// How the ranks learn what happens at their ends.
  enum class Coupling : std::uint8_t {
    none,        ///< one rank
    neighbours,  ///< what is further away than the neighbour has decayed below round-off
    all,         ///< one `MPI_Allgather` of four numbers a rank
  };
  /// What the factor is made of, this rank's share unless said otherwise.
  struct Report {
    std::size_t joints = 0;
    std::size_t spans = 0;        ///< different stretches, each factored once
    std::size_t inner_nodes = 0;  ///< nodes inside stretches
    std::size_t factor_bytes = 0;
    std::size_t work_bytes = 0;
    double shortest_decay = 0.0;  ///< decay length (4 EI h / k)^(1/4) [m], all ranks
    double longest_decay = 0.0;
    double carried = 0.0;  ///< largest share of a disturbance that passes a whole rank's piece [-], all ranks
    Coupling coupling = Coupling::none;
    int lanes = 0;
  };

  /// Factors in long double. @param lanes 8, 4 or 1 side by side; 0: what the processor has
  /// @note Collective. Cost O(local nodes + ranks).
  /// @throws InputError if a rank has fewer than two nodes, or `lanes` is not for this processor
  explicit ChainSolver(const LineData& line, int lanes = 0);

  /// @brief Solves for every column: all of one kind, with the same arrays given.
  /// @note Collective: per batch of four, two or one columns one message to the left neighbour and what
  /// `Report::coupling` says.
  void solve(std::span<const chain::Column> columns);

  /// Whether this processor can run 8, 4 or 1 lanes.
  [[nodiscard]] static bool lanes_supported(int lanes);
  [[nodiscard]] const Report& report() const noexcept { return report_; }
  /// Bytes that one solve of one column must move to and from memory on this rank, vectors read twice counted twice.
  [[nodiscard]] double bytes_per_solve(const chain::Column& kind) const;

 private:
  static constexpr std::size_t kBatch = 4;  // most columns that share one pass over the joints

  /// A node where stretches meet, and the stretch on its right.
  struct Joint {
    std::size_t node = 0;       // local; local_nodes(): the next rank's first
    std::ptrdiff_t block = -1;  // of the stretch on the right, -1: no inner nodes
    bool starts = false;        // first node of a beam
    bool ends = false;          // last node of a beam
    double release = 0.0;       // 1 / S
    double rotation_release = 0.0;
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
  /// Equal stretches one after the other.
  struct Run {
    std::size_t span = 0;
    std::size_t first = 0;  // local node of the first left joint
    std::size_t block = 0;
    std::size_t blocks = 0;
  };
  /// A rank's piece as its neighbours see it: from the state after its first node to that after the next rank's first.
  struct Piece {
    chain::Square transfer{};
    long double det_transfer = 0.0;
    chain::Symmetric compliance{};
    long double det_compliance = 0.0;
    chain::Symmetric stiffness{};
    long double decay = 0.0;  // longest [m]
    long double force = 0.0;  // EI / decay^3 there [N/m]
    long double shortest = 0.0;
  };
  template <std::size_t Width>
  struct JointState;
  /// State (w, theta) after a rank's first node, force and moment after the next rank's first node; SI.
  using Boundary = std::array<double, 4>;

  /// Where each kind of stretch is in `spans_`.
  using Known = std::map<chain::SpanKey, std::size_t>;
  void cut(const LineData& line);
  void add_stretch(const LineData& line, std::size_t from, std::size_t to, Known& known);
  Piece factor(const LineData& line);
  void couple(const Piece& own);
  [[nodiscard]] static std::vector<std::array<long double, 4>> boundary_rows(const std::vector<Piece>& pieces,
                                                                             std::size_t boundary);
  template <std::size_t Width>
  [[nodiscard]] JointState<Width>* states() {
    return reinterpret_cast<JointState<Width>*>(joint_states_.data());
  }
  /// What a column has at the first nodes of the next rank.
  template <std::size_t Width>
  using Beyond = std::array<std::array<double, 3>, Width>;
  template <std::size_t Width>
  void solve_batch(const chain::Column* columns);
  template <class Treat, class Visit>
  void walk(std::size_t joints, const Treat& treat, const Visit& visit) const;
  template <std::size_t Width>
  void visit(std::size_t j, const chain::Column* columns, const Beyond<Width>& beyond);
  template <std::size_t Width, bool Final>
  std::array<Boundary, Width> sweep(const std::array<Boundary, Width>& known);
  template <std::size_t Width>
  std::array<Boundary, Width> exchange(const std::array<Boundary, Width>& own) const;
  template <std::size_t Width>
  void write(std::size_t j, const chain::Column* columns);

  static constexpr chain::Ends kNothing{};

  MPI_Comm comm_;
  int rank_ = 0;
  int ranks_ = 1;
  std::size_t nodes_;
  std::size_t blocks_ = 0;
  std::vector<chain::Span> spans_;
  std::vector<Run> runs_;
  std::vector<Joint> joints_;
  std::vector<std::array<double, 4>> rows_;  // of what each rank shows (4 a rank), to the four of `Boundary`
  std::vector<chain::Ends> shown_;           // kBatch times blocks_
  std::vector<chain::Ends> told_;
  std::vector<double> joint_states_;
  std::vector<double> scratch_;
  Report report_;
};

}  // namespace udar
