#pragma once
/// @file
/// The way of one axle over the nodes of a beam.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "udar/structure/time_table.hpp"
#include "udar/structure/travelling_load.hpp"

namespace udar {

/// @brief Where an axle that travels at constant speed is, as the shares of the two nodes beside it.
class Passage {
 public:
  /// Before the beam and behind it there is a road.
  enum class Where : std::uint8_t { before, on, behind };
  struct State {
    Where where = Where::before;
    std::size_t node = 0;  ///< on the beam: the left one of the two
    double ahead = 0.0;    ///< the share of the right one, 0 to 1
    double rate = 0.0;     ///< of that share [1/s]
  };

  /// @param axle of the train @param x of all nodes from left to right, strictly ascending [m]
  Passage(const TravellingLoad& load, std::size_t axle, std::shared_ptr<const std::vector<double>> x);

  [[nodiscard]] State at(const Instant& at) const;
  /// Along the beam, and beyond its ends [m].
  [[nodiscard]] double x(double time) const;
  /// Of the road before it enters or after it has left [m].
  [[nodiscard]] double end(Where where) const;
  [[nodiscard]] double enters() const { return arrival(0); }               ///< [s]
  [[nodiscard]] double leaves() const { return arrival(x_->size() - 1); }  ///< [s]

 private:
  /// At a node, counted from where it enters [s].
  [[nodiscard]] double arrival(std::size_t passed) const;
  [[nodiscard]] bool rightward() const noexcept { return speed_ > 0.0; }

  std::shared_ptr<const std::vector<double>> x_;
  double offset_;
  double speed_;
  double start_;
};

}  // namespace udar
