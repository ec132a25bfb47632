#pragma once
/// @file
/// Junctions where members of several ranks meet.

#include <mpi.h>

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

  /// @brief Sends values of the junctions that are owned here to the ranks whose members meet there, and goes on.
  /// @param width numbers a junction @param value of an own junction, `width` numbers
  /// @note Collective with `receive`: one message to each such rank.
  void send(std::size_t width, const std::function<void(std::size_t junction, double* values)>& value);
  /// @brief Waits for what `send` of the others sent. @param take given a junction that is not owned here and its
  /// values
  void receive(std::size_t width, const std::function<void(std::size_t junction, const double* values)>& take);

  /// @brief Right-hand sides of the shared junctions become solutions.
  /// @param values six numbers of each of them and column, by junction, then column @param columns at most four
  /// @note Collective: one `MPI_Allgatherv`.
  void solve(std::span<double> values, std::size_t columns);

 private:
  /// A rank that shares junctions with this one: of the network, ascending.
  struct Neighbour {
    int rank = 0;
    std::vector<std::size_t> owned{};   // here, and it has members there
    std::vector<std::size_t> lacked{};  // owned there, and this rank has members there
    std::vector<double> sent{};
    std::vector<double> received{};
  };
  /// What each rank shows of the interface.
  struct Exchange {
    std::vector<int> counts;  // junctions of each rank
    std::vector<int> starts;
    std::vector<std::size_t> which;  // of the interface each of them is, one rank after the other
  };
  [[nodiscard]] static Exchange exchange_of(const std::vector<std::vector<std::size_t>>& lists);
  /// @param who ranks with members at a junction, and its owner
  void list_neighbours(std::size_t junction, int owner, const std::vector<int>& who);
  [[nodiscard]] Neighbour& neighbour(int rank);
  void gather(std::size_t width, std::span<const double> shown);

  const Network* network_;
  std::vector<std::size_t> junctions_;  // ascending
  std::vector<std::size_t> inner_;
  std::vector<std::size_t> shared_;
  std::vector<Neighbour> neighbours_;
  std::vector<MPI_Request> requests_;  // of what is under way
  Exchange touched_;                   // by who has members there
  network::DenseRows inverse_;         // own rows
  std::vector<double> gathered_;
  std::vector<double> sums_;
  std::vector<double> products_;
};

}  // namespace udar
