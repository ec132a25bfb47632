#pragma once
/// @file
/// Symmetric positive definite systems in blocks of six: block Cholesky, complete or up to given blocks.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace udar::network {

/// @brief One block of a symmetric matrix, row by row.
struct Block {
  std::size_t row = 0;
  std::size_t column = 0;
  std::array<std::array<long double, 6>, 6> value{};
};

/// @brief L L' of a sparse matrix of 6 x 6 blocks, ordered by METIS' nested dissection. The last `kept` blocks may stay
/// out of it: what is left of the matrix there, the Schur complement, is for others to add up.
class JunctionSystem {
 public:
  /// Numbers of a block in a vector: six, and two that mean nothing.
  static constexpr std::size_t kPitch = 8;
  /// Most columns that share one pass.
  static constexpr std::size_t kBatch = 4;

  /// @param count blocks of a row @param blocks those with row >= column; several at one place add up
  /// @param kept the last so many rows are not eliminated
  /// @throws Loose if a pivot is not positive, or no more than the rounding of what it came from
  JunctionSystem(std::size_t count, std::span<const Block> blocks, std::size_t kept = 0);

  /// An unknown that nothing holds.
  struct Loose {
    std::size_t block;
    std::size_t unknown;  // 0 to 5
  };

  [[nodiscard]] std::size_t count() const noexcept { return count_; }
  /// Where a block stands in the vectors.
  [[nodiscard]] std::size_t place(std::size_t block) const { return place_[block]; }
  [[nodiscard]] std::size_t kept() const noexcept { return count_ - eliminated_; }
  [[nodiscard]] std::size_t factor_blocks() const noexcept { return rows_.size(); }
  [[nodiscard]] std::size_t factor_bytes() const noexcept { return values_.size() * sizeof(double); }
  /// The Schur complement of the kept blocks, 6 `kept` rows, symmetric, row by row.
  [[nodiscard]] const std::vector<double>& schur() const noexcept { return schur_; }

  /// @brief First half: eliminates, and turns what stands at kept blocks into the Schur complement's right-hand side.
  /// @param values by the place of a block, then column: `columns` times `kPitch` numbers each
  void forward(std::span<double> values, std::size_t columns) const;
  /// Second half, when the kept blocks hold the solution.
  void backward(std::span<double> values, std::size_t columns) const;
  /// Both.
  void solve(std::span<double> values, std::size_t columns) const {
    forward(values, columns);
    backward(values, columns);
  }

 private:
  using Entries = std::array<double, 6 * kPitch>;  // by column

  void order(std::span<const Block> blocks);
  void find_pattern(std::span<const Block> blocks);
  void factor(std::span<const Block> blocks);
  void scatter(std::span<const Block> blocks, std::vector<Entries>& diagonal);
  void add_to_schur(std::size_t row, std::size_t column, const Block& block, bool turned);
  void finish_column(std::size_t j, const Entries& diagonal, const std::array<double, 6>& before,
                     const std::vector<Entries>& below);
  void add_kept_diagonal(const std::vector<Entries>& diagonal);

  std::size_t count_;
  std::size_t eliminated_;
  std::vector<std::size_t> place_;   // of each block in the order of elimination
  std::vector<std::size_t> first_;   // of each column: where its rows begin, below the diagonal
  std::vector<std::size_t> rows_;    // places
  std::vector<double> values_;       // of each of them by column
  std::vector<Entries> inverse_;     // of the diagonal's factor: lower triangle, by column
  std::vector<Entries> transposed_;  // and its transpose
  std::vector<double> schur_;
};

}  // namespace udar::network
