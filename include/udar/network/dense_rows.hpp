#pragma once
/// @file
/// Rows of a dense matrix times a few vectors.

#include <cstddef>
#include <span>
#include <vector>

namespace udar::network {

/// @brief Some rows of a matrix, each filled up to whole packs of eight.
class DenseRows {
 public:
  DenseRows() = default;
  /// @param values row by row
  DenseRows(std::size_t rows, std::size_t width, std::span<const double> values);

  /// Numbers from one vector to the next in what `multiply` takes; those behind the width must be finite.
  [[nodiscard]] std::size_t pitch() const noexcept { return pitch_; }
  [[nodiscard]] std::size_t bytes() const noexcept { return values_.size() * sizeof(double); }
  /// @param[out] products by row, then vector
  void multiply(std::span<const double> vectors, std::size_t count, std::span<double> products) const;

 private:
  std::size_t rows_ = 0;
  std::size_t pitch_ = 0;
  std::vector<double> values_;
};

}  // namespace udar::network
