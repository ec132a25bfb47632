#pragma once
/// @file
/// Numbers that are joined to sets.

#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

namespace udar {

/// @brief Sets of the numbers from 0 on, at first one each; a set is named by its least number.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  [[nodiscard]] std::size_t find(std::size_t number) {
    while (parent_[number] != number) {
      number = parent_[number] = parent_[parent_[number]];
    }
    return number;
  }
  void join(std::size_t a, std::size_t b) {
    a = find(a);
    b = find(b);
    if (a > b) {
      std::swap(a, b);
    }
    parent_[b] = a;
  }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace udar
