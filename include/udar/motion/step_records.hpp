#pragma once
/// @file
/// What happened in a step, one record behind the other, however many there are.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "udar/motion/scratch_file.hpp"

namespace udar {

/// @brief Records of one step in the order in which they came. One block of them is in memory, and one more while they
/// are read; those before wait in a scratch file, or in memory where the disk takes no more. Not collective.
///
/// Reading from first to last, or back, reads each block of the file once.
template <class Record>
class StepRecords {
  static_assert(std::is_trivially_copyable_v<Record>);

 public:
  /// Records in a block: 1 MiB of impacts.
  static constexpr std::size_t kBlock = std::size_t{1} << 14;

  class Iterator {
   public:
    using value_type = Record;
    using difference_type = std::ptrdiff_t;

    Iterator() = default;
    Iterator(const StepRecords& all, std::size_t at) : all_{&all}, at_{at} {}
    const Record& operator*() const { return (*all_)[at_]; }
    const Record* operator->() const { return &(*all_)[at_]; }
    Iterator& operator++() {
      ++at_;
      return *this;
    }
    Iterator operator++(int) { return std::exchange(*this, {*all_, at_ + 1}); }
    bool operator==(const Iterator& other) const { return at_ == other.at_; }

   private:
    const StepRecords* all_ = nullptr;
    std::size_t at_ = 0;
  };

  /// Where its scratch file is to stand.
  void set_folder(std::string folder) { scratch_.set_folder(std::move(folder)); }
  void push_back(const Record& record) {
    if (blocks_.back().size() == kBlock) {
      put_away();
    }
    blocks_.back().push_back(record);
  }
  void clear() {
    blocks_.resize(1);
    blocks_.back().clear();
    scratch_.clear();
    in_file_ = 0;
    shown_block_ = kNone;
  }

  [[nodiscard]] std::size_t size() const noexcept {
    return (in_file_ + blocks_.size() - 1) * kBlock + blocks_.back().size();
  }
  [[nodiscard]] bool empty() const noexcept { return size() == 0; }
  /// The reference holds until another block is read. @throws FileError on this rank
  [[nodiscard]] const Record& operator[](std::size_t i) const {
    const std::size_t block = i / kBlock;
    if (block >= in_file_) {
      return blocks_[block - in_file_][i % kBlock];
    }
    if (block != shown_block_) {
      show(block);
    }
    return shown_[i % kBlock];
  }
  [[nodiscard]] Iterator begin() const { return {*this, 0}; }
  [[nodiscard]] Iterator end() const { return {*this, size()}; }
  /// How many are in memory.
  [[nodiscard]] std::size_t held() const noexcept {
    return (blocks_.size() - 1) * kBlock + blocks_.back().size() + shown_.size();
  }

 private:
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  void put_away() {
    if (blocks_.size() == 1 && scratch_.append(std::as_bytes(std::span{blocks_.front()}))) {
      ++in_file_;
      blocks_.front().clear();
    } else {
      blocks_.emplace_back();
    }
  }
  void show(std::size_t block) const {
    shown_.resize(kBlock);
    shown_block_ = kNone;
    scratch_.read(static_cast<std::uint64_t>(block) * kBlock * sizeof(Record),
                  std::as_writable_bytes(std::span{shown_}));
    shown_block_ = block;
  }

  ScratchFile scratch_;
  std::size_t in_file_ = 0;                     // blocks
  std::vector<std::vector<Record>> blocks_{1};  // behind those; the last one grows
  mutable std::vector<Record> shown_;           // a block of the file
  mutable std::size_t shown_block_ = kNone;
};

}  // namespace udar
