#pragma once
/// @file
/// Tables whose rows wait and go to the disk together.

#include <algorithm>
#include <cstddef>

#include "udar/motion/observer.hpp"

namespace udar::io {

/// @brief An observer with a table: a row at each snapshot, written after 1, 2, 4, ... rows at first, so that a run
/// shows early that it lives, then every 256, so that the ranks seldom have to meet. The same on every rank.
class BlockWriter : public Observer {
 public:
  /// @param interval between rows [s]
  explicit BlockWriter(double interval) : interval_{interval} {}

  [[nodiscard]] double interval() const final { return interval_; }
  void snapshot(const Snapshot& state) final {
    add(state);
    if (++waiting_ >= block_) {
      write();
      waiting_ = 0;
      block_ = std::min(2 * block_, kBlockRows);
    }
  }
  void flush() final {
    write();
    sync();
  }

 protected:
  /// Keeps the row of this time.
  virtual void add(const Snapshot& state) = 0;
  /// Writes all that waits and forgets it. @note Collective.
  virtual void write() = 0;
  /// Brings what was written to the disk. @note Collective.
  virtual void sync() = 0;

 private:
  static constexpr std::size_t kBlockRows = 256;

  double interval_;
  std::size_t waiting_ = 0;
  std::size_t block_ = 1;
};

}  // namespace udar::io
