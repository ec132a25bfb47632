#pragma once
/// @file
/// Rows that are read once, a part at a time.

#include <cstddef>
#include <functional>
#include <span>
#include <utility>

namespace udar::io {

/// @brief So many rows of this rank from first to last, of which nobody holds more than a part.
template <class Row>
class RowStream {
 public:
  /// The next so many rows, which stay there until it is called again.
  using Next = std::function<std::span<const Row>(std::size_t)>;

  RowStream(std::size_t size, Next next) : size_{size}, next_{std::move(next)} {}
  /// @param rows which must stay there
  explicit RowStream(std::span<const Row> rows)
      : RowStream{rows.size(), [rest = rows](std::size_t count) mutable {
                    const std::span<const Row> part = rest.first(count);
                    rest = rest.subspan(count);
                    return part;
                  }} {}

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  /// @param count no more than there are left
  [[nodiscard]] std::span<const Row> next(std::size_t count) { return next_(count); }

 private:
  std::size_t size_;
  Next next_;
};

}  // namespace udar::io
