#pragma once
/// @file
/// Few plastic hinges in steps of the Chebyshev integrator: who yields, and until when.

#include <petscvec.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "udar/contact/released_line.hpp"
#include "udar/integrators/series_search.hpp"
#include "udar/motion/equations.hpp"
#include "udar/motion/motion_state.hpp"

namespace udar {

/// @brief While the same hinges yield the motion is linear, and their rotations and the moments of the others are known
/// from the terms of its series: the rows of `ReleasedLine`. A step ends where a moment reaches its bound or a hinge
/// stands; who yields then is the complementarity problem of the rates.
///
/// Equal on every rank. Source: docs/theory.md, "A beam that yields"
class YieldingHinges {
 public:
  /// @param equations with few hinges and nothing that holds the line @note Collective: a line solve for each hinge.
  explicit YieldingHinges(Equations& equations);

  [[nodiscard]] ReleasedLine& line() noexcept { return line_; }
  /// Whether any hinge yields in the step.
  [[nodiscard]] bool any() const noexcept { return line_.any(); }

  /// @brief Turns hinges at once where the line is beyond their bounds: forces have jumped. @param state of the
  /// TS @return lost, this rank's share [J] @note Collective: a reduction.
  double settle(double time, Vec state);
  /// @brief Finds who is at a bound, whatever was before. @note Collective: a reduction.
  void start(double time, Vec state);
  /// @brief Begins a step, with who yields in it. @param[in,out] rate of the free line by changing loads, which becomes
  /// that of this one @note Collective: a reduction.
  void begin_step(double time, std::span<const double> position, std::span<const double> velocity, LoadRate& rate);

  /// When a moment could reach its bound if its second derivative stayed [s].
  [[nodiscard]] double guess(const FreeMotion& motion) const;
  /// @brief The first event between two times of the step [s]; infinite: none.
  [[nodiscard]] double search(const FreeMotion& motion, double from, double to);
  /// @brief Ends the step after a time [s]: turns the hinges.
  void end_step(const FreeMotion& motion, double length);
  void take_back();

  /// @name From the start of the step at hand to a time in it [s].
  /// @{
  [[nodiscard]] std::vector<double> rotations(const FreeMotion& motion, double time) const;
  /// Lost [J], this rank's share.
  [[nodiscard]] double lost(const FreeMotion& motion, double time) const;
  /// @}

  void save(MotionState& state) const;
  void restore(const MotionState& state);

 private:
  /// Where hinges are at the end of a step, which the next one starts with.
  struct Status {
    std::vector<std::int8_t> bound;   ///< 1, -1: X is at this yield moment
    std::vector<std::int8_t> stands;  ///< not zero: the hinge has just come to a stand
    std::vector<double> rate;         ///< of X of the line without turning [N m/s]
  };

  [[nodiscard]] Kinematics distance(const FreeMotion& motion, std::size_t hinge, double side,
                                    const SeriesSample& at) const;
  [[nodiscard]] std::array<double, 2> turning(const FreeMotion& motion, std::size_t hinge,
                                              const SeriesSample& at) const;
  [[nodiscard]] double first_stand(const FreeMotion& motion, std::size_t hinge, SeriesGrid& grid, double end) const;
  [[nodiscard]] std::vector<std::int8_t> who_yields(std::span<const double> rates);
  [[nodiscard]] std::vector<double> stresses(const Instant& at, std::span<const double> position,
                                             std::span<const double> velocity, const LoadRate* rate) const;

  [[nodiscard]] std::vector<double> stresses(double time, Vec state) const;
  /// Of what is equal on every rank.
  [[nodiscard]] double own_share(double sum) const { return equations_->points().begin() == 0 ? sum : 0.0; }

  Equations* equations_;
  HingedLine* hinges_;
  ReleasedLine line_;
  Status next_;
  Status now_;
  double begin_ = 0.0;                // [s]
  std::vector<double> constant_;      // of the rows
  std::vector<double> steady_;        // their rates by changing loads
  std::vector<double> load_rate_;     // of X of the line without turning
  std::vector<double> event_at_;      // time in the step [s]; infinite: none found
  std::vector<std::int8_t> towards_;  // which bound it is then
  std::vector<double> rotation_before_;
  std::vector<double> turned_before_;
};

}  // namespace udar
