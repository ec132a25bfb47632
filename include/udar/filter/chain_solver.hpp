#pragma once
/// @file
/// The line solve by the chain recursion, distributed over the ranks.

#include <array>
#include <span>
#include <vector>

#include "udar/filter/chain_factor.hpp"
#include "udar/filter/filter_column.hpp"
#include "udar/filter/line_data.hpp"
#include "udar/filter/operator.hpp"

namespace udar {

/// @brief Solves the massless line on its springs exactly, at the speed of memory.
///
/// Equal spans between joints share one small factor and are solved side by side; the joints are coupled by the
/// recursion that transports compliance, the ranks by four numbers each. Source: docs/theory.md, "The chain recursion".
class ChainSolver final : public ColumnSolver {
 public:
  /// What the factor is made of, this rank's share unless said otherwise.
  struct Report {
    std::size_t joints = 0;
    std::size_t spans = 0;        ///< different spans, each factored once
    std::size_t inner_nodes = 0;  ///< nodes inside spans
    std::size_t factor_bytes = 0;
    std::size_t work_bytes = 0;
    double shortest_decay = 0.0;  ///< decay length (4 EI h / k)^(1/4) [m], all ranks
    double longest_decay = 0.0;
    double carried = 0.0;  ///< largest share of a disturbance that passes a whole rank's piece [-], all ranks
    chain::Coupling coupling = chain::Coupling::none;
    int lanes = 0;
  };

  /// Factors in long double. @param lanes 8, 4 or 1 side by side; 0: what the processor has
  /// @note Collective. Cost O(local nodes + ranks).
  /// @throws InputError if a rank has fewer than two nodes, or `lanes` is not for this processor
  explicit ChainSolver(const LineData& line, int lanes = 0);

  /// @brief Solves for every column: all of one kind, with the same arrays given.
  /// @note Collective: per batch of four, two or one columns one message to the left neighbour and what
  /// `Report::coupling` says.
  void solve(std::span<const FilterColumn> columns) override;

  /// Whether this processor can run 8, 4 or 1 lanes.
  [[nodiscard]] static bool lanes_supported(int lanes);
  [[nodiscard]] const Report& report() const noexcept { return report_; }
  /// Bytes that one solve of one column must move to and from memory on this rank, vectors read twice counted twice.
  [[nodiscard]] double bytes_per_solve(const FilterColumn& kind) const;

 private:
  static constexpr std::size_t kBatch = 4;  // most columns that share one pass over the joints

  template <std::size_t Width>
  struct JointState;
  /// State (w, theta) after a rank's first node, force and moment after the next rank's first node; SI.
  using Boundary = std::array<double, 4>;
  /// One half of it.
  using State = std::array<double, 2>;

  template <std::size_t Width>
  [[nodiscard]] JointState<Width>* states() {
    return reinterpret_cast<JointState<Width>*>(joint_states_.data());
  }
  /// What a column has at the first nodes of the next rank.
  template <std::size_t Width>
  using Beyond = std::array<std::array<double, 3>, Width>;
  template <std::size_t Width>
  void solve_batch(const FilterColumn* columns);
  template <class Treat, class Visit>
  void walk(std::size_t joints, const Treat& treat, const Visit& visit) const;
  template <std::size_t Width>
  void visit(std::size_t j, const FilterColumn* columns, const Beyond<Width>& beyond);
  template <std::size_t Width>
  std::array<State, Width> sweep_right(const std::array<Boundary, Width>& known);
  template <std::size_t Width, bool Final>
  std::array<State, Width> sweep_left(const std::array<Boundary, Width>& known);
  template <std::size_t Width, bool Final>
  std::array<Boundary, Width> sweep(const std::array<Boundary, Width>& known);
  template <std::size_t Width>
  std::array<Boundary, Width> exchange(const std::array<Boundary, Width>& own) const;
  template <std::size_t Width>
  void write(std::size_t j, const FilterColumn* columns);

  static constexpr chain::Ends kNothing{};

  chain::Factor factor_;
  std::vector<chain::Ends> shown_;  // kBatch times the blocks
  std::vector<chain::Ends> told_;
  std::vector<double> joint_states_;
  std::vector<double> scratch_;
  Report report_;
};

}  // namespace udar
