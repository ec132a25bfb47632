#pragma once
/// @file
/// How the masses stand to supports that give way.

#include <cstddef>
#include <vector>

#include "udar/contact/elastic_touch.hpp"
#include "udar/contact/support.hpp"
#include "udar/motion/contact_state.hpp"
#include "udar/motion/motion_state.hpp"

namespace udar {

/// @brief One `ElasticTouch` for every local node of every support that is not rigid.
class ElasticTouches {
 public:
  /// @param contact outlives this object
  explicit ElasticTouches(const ContactState& contact);

  /// Open where the support is rigid.
  [[nodiscard]] ElasticTouch of(const ContactSet& set, std::size_t node) const {
    return set.elastic() ? touches_[contact_->index_of(set)][node - set.first] : ElasticTouch{};
  }
  [[nodiscard]] ElasticTouch& at(const ContactSet& set, std::size_t node) {
    return touches_[contact_->index_of(set)][node - set.first];
  }
  /// A step without events has passed.
  void pass();

  /// Adds the field "touch" of `count` local nodes.
  void save(std::size_t count, MotionState& state) const;
  void restore(std::size_t count, const MotionState& state);

 private:
  const ContactState* contact_;
  std::vector<std::vector<ElasticTouch>> touches_;  // by contact set, then node
};

}  // namespace udar
