#include "udar/network/dense_rows.hpp"

#include <algorithm>
#include <array>

#include "numerics/wide.hpp"

namespace udar::network {
namespace {

constexpr std::size_t kPack = 8;

/// Sums of eight numbers that lie eight apart, whatever the processor's width: all have the same bits.
template <std::size_t W, std::size_t Count>
UDAR_INLINE void row_products(const double* row, std::size_t pitch, const double* vectors, double* products) {
  constexpr std::size_t kParts = kPack / W;
  std::array<std::array<wide::Pack<W>, kParts>, Count> sums{};
  for (std::size_t i = 0; i < pitch; i += kPack) {
    for (std::size_t p = 0; p < kParts; ++p) {
      wide::Pack<W> own;  // NOLINT(cppcoreguidelines-pro-type-member-init)
      wide::load<W>(own, row + i + p * W);
      for (std::size_t c = 0; c < Count; ++c) {
        wide::Pack<W> value;  // NOLINT(cppcoreguidelines-pro-type-member-init)
        wide::load<W>(value, vectors + c * pitch + i + p * W);
        sums[c][p] += own * value;
      }
    }
  }
  for (std::size_t c = 0; c < Count; ++c) {
    const auto s = [&](std::size_t k) __attribute__((always_inline)) { return sums[c][k / W][k % W]; };
    products[c] = ((s(0) + s(1)) + (s(2) + s(3))) + ((s(4) + s(5)) + (s(6) + s(7)));
  }
}

template <std::size_t W, std::size_t Count>
UDAR_INLINE void all_products(const double* values, std::size_t rows, std::size_t pitch, const double* vectors,
                              double* products) {
  for (std::size_t r = 0; r < rows; ++r) {
    row_products<W, Count>(values + r * pitch, pitch, vectors, products + r * Count);
  }
}

template <std::size_t W>
UDAR_INLINE void products_of(const double* values, std::size_t rows, std::size_t pitch, const double* vectors,
                             std::size_t count, double* products) {
  switch (count) {
    case 1:
      return all_products<W, 1>(values, rows, pitch, vectors, products);
    case 2:
      return all_products<W, 2>(values, rows, pitch, vectors, products);
    case 3:
      return all_products<W, 3>(values, rows, pitch, vectors, products);
    default:
      return all_products<W, 4>(values, rows, pitch, vectors, products);
  }
}

}  // namespace

DenseRows::DenseRows(std::size_t rows, std::size_t width, std::span<const double> values)
    : rows_{rows}, pitch_{(width + kPack - 1) / kPack * kPack}, values_(rows * pitch_, 0.0) {
  for (std::size_t r = 0; r < rows; ++r) {
    std::ranges::copy(values.subspan(r * width, width), values_.begin() + static_cast<std::ptrdiff_t>(r * pitch_));
  }
}

void DenseRows::multiply(std::span<const double> vectors, std::size_t count, std::span<double> products) const {
  wide::run([&]<std::size_t W>() __attribute__((always_inline)) {
    products_of<W>(values_.data(), rows_, pitch_, vectors.data(), count, products.data());
  });
}

}  // namespace udar::network
