#pragma once
/// @file
/// The solve of a network: members condensed to their junctions, the junctions by block Cholesky, and back.

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "udar/filter/filter_column.hpp"
#include "udar/filter/network_interface.hpp"
#include "udar/filter/network_members.hpp"
#include "udar/filter/operator.hpp"
#include "udar/network/junction_system.hpp"
#include "udar/network/member_sweep.hpp"
#include "udar/structure/network.hpp"

namespace udar {

/// @brief Solves (wf^2 M + C) of a network exactly: each member is condensed to its two junctions by the chain
/// recursion, eight members, or spans of long ones, side by side; the junctions are few.
///
/// Junctions that members of several ranks meet at are the interface; every rank keeps its rows of the inverse of their
/// Schur complement. Source: docs/theory.md, "Networks"
class NetworkSolver final : public ColumnSolver {
 public:
  /// What the factor is made of; of this rank unless said otherwise.
  struct Report {
    NetworkMembers::Report members;
    std::size_t junctions = 0;      ///< that its members meet at
    std::size_t interface = 0;      ///< of all ranks, those between ranks
    std::size_t own_interface = 0;  ///< of them those of its members
    std::size_t factor_blocks = 0;  ///< 6 x 6, below the diagonal
    std::size_t factor_bytes = 0;
  };

  /// Factors: members in long double. @param filter_frequency wf [rad/s], finite
  /// @note Collective. @throws InputError naming a junction that nothing holds
  NetworkSolver(const Network& network, double filter_frequency);

  /// @brief Solves for every column: displacement, force and stretch of the rank's points; `internal` as that of
  /// `NetworkOperator`. Columns go up to four at a time.
  /// @note Collective: on several ranks one `MPI_Allgatherv` a batch, of six numbers of each junction of the interface
  /// and column; before it one message to each neighbour, of three numbers, with rotary inertia six, which travels
  /// while the members that need none of it are condensed
  void solve(std::span<const FilterColumn> columns) override { solve(columns, {}); }
  /// @param load besides, six forces and moments of each local junction [N, N m], one column after the other; empty:
  /// none; those of several ranks on one junction add up
  void solve(std::span<const FilterColumn> columns, std::span<const double> load);
  /// Of each junction of the network: which local one it is.
  [[nodiscard]] std::span<const std::size_t> local_junctions() const noexcept { return local_; }
  /// @brief Moves moments on the own junctions to where `solve` takes them. @param rotation of the nodes about y, x, z
  void take_moments(std::span<double> rotation, std::span<double> load) const;

  [[nodiscard]] const Report& report() const noexcept { return report_; }

 private:
  void number_junctions();
  void find_axes();
  [[nodiscard]] std::array<double, 3> turned(std::size_t i, const double* values) const;
  [[nodiscard]] std::size_t turning_point(std::size_t node, std::size_t k) const;
  void resolve_turning(const FilterColumn& column, std::size_t i, const double* beside) const;
  [[nodiscard]] std::vector<network::Block> member_blocks() const;
  void add_member(const std::array<std::array<long double, 12>, 12>& k, std::size_t number,
                  std::vector<network::Block>& blocks) const;
  void add_grounds(std::vector<network::Block>& blocks) const;
  void hold(std::vector<network::Block>& blocks);
  void factor();
  void solve_batch(std::span<const FilterColumn> columns, std::span<const double> load);
  /// Numbers that tell how the mass of a junction moved.
  [[nodiscard]] std::size_t width() const noexcept { return network_->rotary() ? 6 : 3; }
  [[nodiscard]] std::array<double, 6> moved(const FilterColumn& column, std::size_t i) const;
  [[nodiscard]] double* places_at(std::size_t junction, std::size_t column, std::size_t columns);
  void find_places(std::span<const FilterColumn> columns);
  void send_places(std::size_t columns);
  void receive_places(std::size_t columns);
  void load_own(std::span<const FilterColumn> columns);
  void condense_members(std::span<const FilterColumn> columns, bool shared);
  void solve_junctions(std::size_t columns);
  void solve_interface(std::size_t columns);
  [[nodiscard]] network::Sweep sweep_of(std::span<const FilterColumn> columns, std::size_t column);
  void resolve_members(std::span<const FilterColumn> columns);

  const Network* network_;
  double wf2_;
  NetworkInterface interface_;
  NetworkMembers members_;
  std::vector<std::size_t> junctions_;                     // local: of the network; those of the interface last
  std::vector<std::size_t> local_;                         // of a junction of the network: where it is in `junctions_`
  std::vector<std::array<bool, 6>> held_;                  // of local junctions
  std::vector<std::array<std::size_t, 2>> held_unknowns_;  // place of the junction, and which of its six
  std::vector<std::array<double, 3>> cut_axes_;  // along members at nodes where these are cut; with rotary inertia
  std::unique_ptr<network::JunctionSystem> system_;
  /// Displacements of local junctions, where `values_` has theirs, then of the nodes where members are cut.
  std::vector<double> places_;
  std::vector<double> values_;  // of the junction system
  Report report_;
};

}  // namespace udar
