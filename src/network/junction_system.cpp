#include "udar/network/junction_system.hpp"

#include <metis.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "numerics/wide.hpp"

namespace udar::network {
namespace {

constexpr std::size_t kPitch = JunctionSystem::kPitch;
constexpr std::size_t kColumn = 6 * kPitch;  // numbers of a block that is written in registers
constexpr std::size_t kPacked = 36;          // and of one that is only read, without the two that are zero
constexpr std::size_t kBehind = 2;           // numbers that are read behind the last such
constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

// NOLINTBEGIN(cppcoreguidelines-pro-type-member-init): packs are written before they are read
/// Six numbers, and up to two that nobody uses, in as many registers as that takes.
template <std::size_t W>
struct Six {
  using Pack = wide::Pack<W>;
  static constexpr std::size_t kParts = (6 + W - 1) / W;
  std::array<Pack, kParts> part;

  UDAR_INLINE void load(const double* from) {
    for (std::size_t p = 0; p < kParts; ++p) {
      wide::load<W>(part[p], from + p * W);
    }
  }
  UDAR_INLINE void store(double* to) const {
    for (std::size_t p = 0; p < kParts; ++p) {
      wide::store<W>(to + p * W, part[p]);
    }
  }
  /// Adds column * factor.
  UDAR_INLINE void add(const double* column, double factor) {
    for (std::size_t p = 0; p < kParts; ++p) {
      Pack own;
      wide::load<W>(own, column + p * W);
      part[p] += own * factor;
    }
  }
  UDAR_INLINE void subtract(const double* column, double factor) {
    for (std::size_t p = 0; p < kParts; ++p) {
      Pack own;
      wide::load<W>(own, column + p * W);
      part[p] -= own * factor;
    }
  }
  /// Adds column * values, one by one.
  UDAR_INLINE void add(const double* column, const Six& values) {
    for (std::size_t p = 0; p < kParts; ++p) {
      Pack own;
      wide::load<W>(own, column + p * W);
      part[p] += own * values.part[p];
    }
  }
  /// Of the six.
  [[nodiscard]] UDAR_INLINE double sum() const {
    const auto s = [&](std::size_t k) __attribute__((always_inline)) { return part[k / W][k % W]; };
    return ((s(0) + s(1)) + (s(2) + s(3))) + (s(4) + s(5));
  }
};

/// c -= a b' for blocks column by column, of which `Pitch` numbers stand between columns of a and b.
template <std::size_t W, std::size_t Pitch>
UDAR_INLINE void subtract_blocks(double* c, const double* a, const double* b) {
  for (std::size_t column = 0; column < 6; ++column) {
    Six<W> sum;
    sum.load(c + column * kPitch);
    for (std::size_t m = 0; m < 6; ++m) {
      sum.subtract(a + m * Pitch, b[m * Pitch + column]);
    }
    sum.store(c + column * kPitch);
  }
}
template <std::size_t Pitch>
void subtract_product(double* c, const double* a, const double* b) {
  wide::run([&]<std::size_t W>() __attribute__((always_inline)) { subtract_blocks<W, Pitch>(c, a, b); });
}

/// One column of the factor, both halves of a solve for `Count` right-hand sides.
template <std::size_t W, std::size_t Count>
UDAR_INLINE void times(const double* matrix, double* vector) {
  for (std::size_t c = 0; c < Count; ++c) {
    double* own = vector + c * kPitch;
    Six<W> sum{};
    for (std::size_t m = 0; m < 6; ++m) {
      sum.add(matrix + m * kPitch, own[m]);
    }
    sum.store(own);
  }
}

template <std::size_t W, std::size_t Count>
UDAR_INLINE void eliminate(const double* factor, const std::size_t* rows, std::size_t count, const double* own,
                           double* values) {
  for (std::size_t r = 0; r < count; ++r, factor += kPacked) {
    double* to = values + rows[r] * Count * kPitch;
    for (std::size_t c = 0; c < Count; ++c) {
      Six<W> sum;
      sum.load(to + c * kPitch);
      for (std::size_t m = 0; m < 6; ++m) {
        sum.subtract(factor + m * 6, own[c * kPitch + m]);
      }
      sum.store(to + c * kPitch);
    }
  }
}

/// Of as many right-hand sides at a time as there are registers for their sums.
template <std::size_t W, std::size_t Count>
UDAR_INLINE void substitute(const double* factor, const std::size_t* rows, std::size_t count, double* own,
                            const double* values) {
  constexpr std::size_t kAtOnce = W == 8 ? Count : 1;
  for (std::size_t first = 0; first < Count; first += kAtOnce) {
    std::array<std::array<Six<W>, 6>, kAtOnce> sums{};
    for (std::size_t r = 0; r < count; ++r) {
      const double* from = values + (rows[r] * Count + first) * kPitch;
      const double* block = factor + r * kPacked;
      for (std::size_t c = 0; c < kAtOnce; ++c) {
        Six<W> value;
        value.load(from + c * kPitch);
        for (std::size_t m = 0; m < 6; ++m) {
          sums[c][m].add(block + m * 6, value);
        }
      }
    }
    for (std::size_t c = 0; c < kAtOnce; ++c) {
      for (std::size_t m = 0; m < 6; ++m) {
        own[(first + c) * kPitch + m] -= sums[c][m].sum();
      }
    }
  }
}
// NOLINTEND(cppcoreguidelines-pro-type-member-init)

/// The factor by columns, as both halves read it.
struct Columns {
  const std::size_t* first;
  const std::size_t* rows;
  const double* values;
  const double* diagonal;  // inverse, or its transpose
  std::size_t count;
};

template <std::size_t W, std::size_t Count>
UDAR_INLINE void forward_all(const Columns& all, double* values) {
  for (std::size_t j = 0; j < all.count; ++j) {
    double* own = values + j * Count * kPitch;
    times<W, Count>(all.diagonal + j * kColumn, own);
    eliminate<W, Count>(all.values + all.first[j] * kPacked, all.rows + all.first[j], all.first[j + 1] - all.first[j],
                        own, values);
  }
}
template <std::size_t W, std::size_t Count>
UDAR_INLINE void backward_all(const Columns& all, double* values) {
  for (std::size_t j = all.count; j-- > 0;) {
    double* own = values + j * Count * kPitch;
    substitute<W, Count>(all.values + all.first[j] * kPacked, all.rows + all.first[j], all.first[j + 1] - all.first[j],
                         own, values);
    times<W, Count>(all.diagonal + j * kColumn, own);
  }
}

/// Calls `half` as wide as the processor, for so many right-hand sides.
template <class Half>
void for_columns(std::size_t columns, const Half& half) {
  wide::run([&]<std::size_t W>() __attribute__((always_inline)) {
    switch (columns) {
      case 1:
        return half.template operator()<W, 1>();
      case 2:
        return half.template operator()<W, 2>();
      case 3:
        return half.template operator()<W, 3>();
      default:
        return half.template operator()<W, 4>();
    }
  });
}

/// A block that is only read, where it can be written.
void spread(const double* packed, double* block) {
  for (std::size_t i = 0; i < kPacked; ++i) {
    block[i / 6 * kPitch + i % 6] = packed[i];
  }
}

/// Inverse of the Cholesky factor of a symmetric block; a pivot that is rounding of its diagonal is none.
/// @return the unknown whose pivot is none, 6 if there is no such
std::size_t invert_factor(const double* matrix, const std::array<double, 6>& diagonal, double* inverse) {
  constexpr double kRounding = 1e-13;
  std::array<std::array<double, 6>, 6> l{};
  for (std::size_t j = 0; j < 6; ++j) {
    for (std::size_t i = j; i < 6; ++i) {
      double sum = matrix[j * kPitch + i];
      for (std::size_t m = 0; m < j; ++m) {
        sum -= l[i][m] * l[j][m];
      }
      if (i == j && !(sum > kRounding * diagonal[j])) {
        return j;
      }
      l[i][j] = i == j ? std::sqrt(sum) : sum / l[j][j];
    }
  }
  for (std::size_t j = 0; j < 6; ++j) {
    for (std::size_t i = j; i < 6; ++i) {
      double sum = i == j ? 1.0 : 0.0;
      for (std::size_t m = j; m < i; ++m) {
        sum -= l[i][m] * inverse[j * kPitch + m];
      }
      inverse[j * kPitch + i] = sum / l[i][i];
    }
  }
  return 6;
}

}  // namespace

JunctionSystem::JunctionSystem(std::size_t count, std::span<const Block> blocks, std::size_t kept)
    : count_{count}, eliminated_{count - kept} {
  order(blocks);
  find_pattern(blocks);
  factor(blocks);
}

void JunctionSystem::order(std::span<const Block> blocks) {
  place_.resize(count_);
  std::iota(place_.begin(), place_.end(), std::size_t{0});
  std::vector<std::vector<idx_t>> near(eliminated_);
  for (const Block& block : blocks) {
    if (block.row != block.column && block.row < eliminated_ && block.column < eliminated_) {
      near[block.row].push_back(static_cast<idx_t>(block.column));
      near[block.column].push_back(static_cast<idx_t>(block.row));
    }
  }
  std::vector<idx_t> begin{0};
  std::vector<idx_t> all;
  for (std::vector<idx_t>& of : near) {
    std::ranges::sort(of);
    of.erase(std::ranges::unique(of).begin(), of.end());
    all.insert(all.end(), of.begin(), of.end());
    begin.push_back(static_cast<idx_t>(all.size()));
  }
  if (all.empty()) {
    return;
  }
  auto vertices = static_cast<idx_t>(eliminated_);
  std::vector<idx_t> permutation(eliminated_);
  std::vector<idx_t> place(eliminated_);
  std::array<idx_t, METIS_NOPTIONS> options{};
  METIS_SetDefaultOptions(options.data());
  options[METIS_OPTION_SEED] = 1;
  METIS_NodeND(&vertices, begin.data(), all.data(), nullptr, options.data(), permutation.data(), place.data());
  std::ranges::copy(place, place_.begin());
}

/// Rows of a column: those of the matrix, and those of the columns whose first row it is.
void JunctionSystem::find_pattern(std::span<const Block> blocks) {
  std::vector<std::vector<std::size_t>> pattern(eliminated_);
  for (const Block& block : blocks) {
    const std::size_t row = std::max(place_[block.row], place_[block.column]);
    const std::size_t column = std::min(place_[block.row], place_[block.column]);
    if (row != column && column < eliminated_) {
      pattern[column].push_back(row);
    }
  }
  first_.assign(1, 0);
  for (std::size_t j = 0; j < eliminated_; ++j) {
    std::vector<std::size_t>& own = pattern[j];
    std::ranges::sort(own);
    own.erase(std::ranges::unique(own).begin(), own.end());
    rows_.insert(rows_.end(), own.begin(), own.end());
    first_.push_back(rows_.size());
    if (!own.empty() && own.front() < eliminated_) {
      std::vector<std::size_t>& parent = pattern[own.front()];
      parent.insert(parent.end(), own.begin() + 1, own.end());
    }
    own = {};
  }
}

void JunctionSystem::factor(std::span<const Block> blocks) {
  values_.assign(rows_.size() * kPacked + kBehind, 0.0);
  inverse_.assign(eliminated_, Entries{});
  transposed_.assign(eliminated_, Entries{});
  schur_.assign(36 * kept() * kept(), 0.0);
  std::vector<Entries> diagonal(count_, Entries{});
  scatter(blocks, diagonal);
  // Left-looking: each column takes what those before it, listed by their next row, do to it.
  std::vector<std::size_t> list(count_, kNone);        // first column whose next row it is
  std::vector<std::size_t> after(eliminated_, kNone);  // the next of such columns
  std::vector<std::size_t> next(first_.begin(), first_.begin() + static_cast<std::ptrdiff_t>(eliminated_));
  std::vector<std::size_t> where(count_, kNone);  // rows of the column at hand
  std::vector<Entries> below;
  const auto enlist = [&](std::size_t column) {
    if (next[column] < first_[column + 1] && rows_[next[column]] < eliminated_) {
      const std::size_t row = rows_[next[column]];
      after[column] = list[row];
      list[row] = column;
    }
  };
  for (std::size_t j = 0; j < eliminated_; ++j) {
    std::array<double, 6> before{};
    for (std::size_t i = 0; i < 6; ++i) {
      before[i] = diagonal[j][i * kPitch + i];
    }
    below.assign(first_[j + 1] - first_[j], Entries{});
    for (std::size_t q = first_[j]; q < first_[j + 1]; ++q) {
      where[rows_[q]] = q - first_[j];
      spread(values_.data() + q * kPacked, below[q - first_[j]].data());
    }
    for (std::size_t k = list[j]; k != kNone;) {
      const std::size_t following = after[k];
      const double* own = values_.data() + next[k] * kPacked;
      subtract_product<6>(diagonal[j].data(), own, own);
      for (std::size_t q = next[k] + 1; q < first_[k + 1]; ++q) {
        subtract_product<6>(below[where[rows_[q]]].data(), values_.data() + q * kPacked, own);
      }
      ++next[k];
      enlist(k);
      k = following;
    }
    finish_column(j, diagonal[j], before, below);
    enlist(j);
  }
  add_kept_diagonal(diagonal);
}

/// The matrix into the places of the factor.
void JunctionSystem::scatter(std::span<const Block> blocks, std::vector<Entries>& diagonal) {
  for (const Block& block : blocks) {
    const std::size_t a = place_[block.row];
    const std::size_t b = place_[block.column];
    const std::size_t column = std::min(a, b);
    const std::size_t row = std::max(a, b);
    if (row != column && column >= eliminated_) {
      add_to_schur(row, column, block, a < b);
      continue;
    }
    const auto add = [&](double* to, std::size_t pitch) {
      for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t k = 0; k < 6; ++k) {
          to[k * pitch + i] += static_cast<double>(a >= b ? block.value[i][k] : block.value[k][i]);
        }
      }
    };
    if (row == column) {
      add(diagonal[row].data(), kPitch);
    } else {
      const auto begin = rows_.begin() + static_cast<std::ptrdiff_t>(first_[column]);
      const auto end = rows_.begin() + static_cast<std::ptrdiff_t>(first_[column + 1]);
      const auto at = static_cast<std::size_t>(std::lower_bound(begin, end, row) - rows_.begin());
      add(values_.data() + at * kPacked, 6);
    }
  }
}

/// A block between two that are kept. @param turned whether it stands the other way round
void JunctionSystem::add_to_schur(std::size_t row, std::size_t column, const Block& block, bool turned) {
  const std::size_t width = 6 * kept();
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t k = 0; k < 6; ++k) {
      const std::size_t r = 6 * (row - eliminated_) + i;
      const std::size_t c = 6 * (column - eliminated_) + k;
      const auto value = static_cast<double>(turned ? block.value[k][i] : block.value[i][k]);
      schur_[r * width + c] += value;
      schur_[c * width + r] += value;
    }
  }
}

/// When all before it are done: its diagonal's factor, its rows, and what it takes from the kept blocks.
/// @param before the diagonal of the matrix @param below its rows
void JunctionSystem::finish_column(std::size_t j, const Entries& diagonal, const std::array<double, 6>& before,
                                   const std::vector<Entries>& below) {
  if (const std::size_t loose = invert_factor(diagonal.data(), before, inverse_[j].data()); loose < 6) {
    const auto block = static_cast<std::size_t>(std::ranges::find(place_, j) - place_.begin());
    throw Loose{.block = block, .unknown = loose};
  }
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t k = 0; k < 6; ++k) {
      transposed_[j][k * kPitch + i] = inverse_[j][i * kPitch + k];
    }
  }
  for (std::size_t q = first_[j]; q < first_[j + 1]; ++q) {
    Entries product{};
    subtract_product<kPitch>(product.data(), below[q - first_[j]].data(), inverse_[j].data());
    for (std::size_t i = 0; i < kPacked; ++i) {
      values_[q * kPacked + i] = -product[i / 6 * kPitch + i % 6];
    }
  }
  const auto end = rows_.begin() + static_cast<std::ptrdiff_t>(first_[j + 1]);
  const auto from = static_cast<std::size_t>(
      std::lower_bound(rows_.begin() + static_cast<std::ptrdiff_t>(first_[j]), end, eliminated_) - rows_.begin());
  const std::size_t width = 6 * kept();
  for (std::size_t q = from; q < first_[j + 1]; ++q) {
    for (std::size_t r = from; r < first_[j + 1]; ++r) {
      Entries product{};
      subtract_product<6>(product.data(), values_.data() + q * kPacked, values_.data() + r * kPacked);
      for (std::size_t i = 0; i < 36; ++i) {
        schur_[(6 * (rows_[q] - eliminated_) + i / 6) * width + 6 * (rows_[r] - eliminated_) + i % 6] +=
            product[i % 6 * kPitch + i / 6];
      }
    }
  }
}

void JunctionSystem::add_kept_diagonal(const std::vector<Entries>& diagonal) {
  const std::size_t width = 6 * kept();
  for (std::size_t g = 0; g < kept(); ++g) {
    for (std::size_t i = 0; i < 36; ++i) {
      schur_[(6 * g + i / 6) * width + 6 * g + i % 6] += diagonal[eliminated_ + g][i % 6 * kPitch + i / 6];
    }
  }
}

void JunctionSystem::forward(std::span<double> values, std::size_t columns) const {
  const Columns all{first_.data(), rows_.data(), values_.data(), inverse_.empty() ? nullptr : inverse_.front().data(),
                    eliminated_};
  for_columns(columns, [&]<std::size_t W, std::size_t Count>()
                           __attribute__((always_inline)) { forward_all<W, Count>(all, values.data()); });
}

void JunctionSystem::backward(std::span<double> values, std::size_t columns) const {
  const Columns all{first_.data(), rows_.data(), values_.data(),
                    transposed_.empty() ? nullptr : transposed_.front().data(), eliminated_};
  for_columns(columns, [&]<std::size_t W, std::size_t Count>()
                           __attribute__((always_inline)) { backward_all<W, Count>(all, values.data()); });
}

}  // namespace udar::network
