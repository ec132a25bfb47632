#pragma once
/// @file
/// Junctions where members of several ranks meet.

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "udar/network/dense_rows.hpp"
#include "udar/structure/network.hpp"

namespace udar {

/// @brief The junctions between ranks: what passes there, and the solution once each rank has eliminated its own.
///
/// Every rank keeps its rows of the inverse of the Schur complements' sum, and adds up right-hand sides in the order of
/// the ranks: copies of a junction have the same bits. Source: docs/theory.md, "Networks"
class NetworkInterface {
 public:
  explicit NetworkInterface(const Network& network);

  [[nodiscard]] bool empty() const noexcept { return junctions_.empty(); }
  [[nodiscard]] std::size_t size() const noexcept { return junctions_.size(); }  ///< of all ranks
  /// Junctions of this rank's members, and its own: those of no other rank, and those of the interface; ascending.
  [[nodiscard]] const std::vector<std::size_t>& inner() const noexcept { return inner_; }
  [[nodiscard]] const std::vector<std::size_t>& shared() const noexcept { return shared_; }

  /// @param schur of the shared junctions on this rank, 6 rows each @return whether the sum is positive definite
  /// @note Collective; one rank inverts, so that all have the same bits.
  [[nodiscard]] bool invert(std::span<const double> schur);

  /// @brief Tells all ranks values of the junctions that are owned here.
  /// @param width numbers a junction @param value of an own junction, `width` numbers
  /// @param take given a junction of this rank's interface and its values
  /// @note Collective: one `MPI_Allgatherv`.
  void spread(std::size_t width, const std::function<void(std::size_t junction, double* values)>& value,
              const std::function<void(std::size_t junction, const double* values)>& take);

  /// @brief Right-hand sides of the shared junctions become solutions.
  /// @param values six numbers of each of them and column, by junction, then column @param columns at most four
  /// @note Collective: one `MPI_Allgatherv`.
  void solve(std::span<double> values, std::size_t columns);

 private:
  /// What passes between ranks.
  struct Exchange {
    std::vector<int> counts;  // junctions of each rank
    std::vector<int> starts;
    std::vector<std::size_t> which;  // of the interface each of them is, one rank after the other
  };
  [[nodiscard]] static Exchange exchange_of(const std::vector<std::vector<std::size_t>>& lists);
  void gather(const Exchange& exchange, std::size_t width, std::span<const double> shown);

  const Network* network_;
  std::vector<std::size_t> junctions_;  // ascending
  std::vector<std::size_t> inner_;
  std::vector<std::size_t> shared_;
  Exchange owned_;              // by owner
  Exchange touched_;            // by who has members there
  network::DenseRows inverse_;  // own rows
  std::vector<double> shown_;
  std::vector<double> gathered_;
  std::vector<double> sums_;
  std::vector<double> products_;
};

}  // namespace udar
