#include "udar/network/dense_rows.hpp"

#include <algorithm>
#include <array>

#include "numerics/clones.hpp"

namespace udar::network {
namespace {

constexpr std::size_t kPack = 8;
using DensePack = double __attribute__((vector_size(8 * kPack)));
using DenseLoose [[gnu::vector_size(8 * kPack), gnu::aligned(8), gnu::may_alias]] = double;

[[gnu::always_inline]] inline const DenseLoose& pack_at(const double* from) {
  return *reinterpret_cast<const DenseLoose*>(from);
}

template <std::size_t Count>
[[gnu::always_inline]] inline void row_products(const double* row, std::size_t pitch, const double* vectors,
                                                double* products) {
  std::array<DensePack, Count> sums{};
  for (std::size_t i = 0; i < pitch; i += kPack) {
    const DensePack own = pack_at(row + i);
    for (std::size_t c = 0; c < Count; ++c) {
      sums[c] += own * pack_at(vectors + c * pitch + i);
    }
  }
  for (std::size_t c = 0; c < Count; ++c) {
    const DensePack& s = sums[c];
    products[c] = ((s[0] + s[1]) + (s[2] + s[3])) + ((s[4] + s[5]) + (s[6] + s[7]));
  }
}

template <std::size_t Count>
[[gnu::always_inline]] inline void all_products(const double* values, std::size_t rows, std::size_t pitch,
                                                const double* vectors, double* products) {
  for (std::size_t r = 0; r < rows; ++r) {
    row_products<Count>(values + r * pitch, pitch, vectors, products + r * Count);
  }
}

UDAR_CLONES void products_of(const double* values, std::size_t rows, std::size_t pitch, const double* vectors,
                             std::size_t count, double* products) {
  switch (count) {
    case 1:
      return all_products<1>(values, rows, pitch, vectors, products);
    case 2:
      return all_products<2>(values, rows, pitch, vectors, products);
    case 3:
      return all_products<3>(values, rows, pitch, vectors, products);
    default:
      return all_products<4>(values, rows, pitch, vectors, products);
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
  products_of(values_.data(), rows_, pitch_, vectors.data(), count, products.data());
}

}  // namespace udar::network
