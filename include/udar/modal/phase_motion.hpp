#pragma once
/// @file
/// The motion of a reduced model from one change of contact to the next.

#include <cstddef>
#include <span>
#include <vector>

#include "udar/modal/phase_basis.hpp"
#include "udar/modal/reduced_model.hpp"

namespace udar {

/// @brief Closed form of the motion while the same points touch, and the first time at which one of them lets go or
/// another one comes.
class PhaseMotion {
 public:
  /// @param basis must outlive this object
  PhaseMotion(const PhaseBasis& basis, const Drive& drive, const ModalState& start);

  [[nodiscard]] double begin() const noexcept { return begin_; }  ///< [s]

  /// @brief Searches for the first zero of a row up to a time [s].
  /// @return when, or `until` @note Each evaluation advances all rows together.
  [[nodiscard]] double last(double until);
  /// Whether the row of a point is zero at the end that `last` found, but for rounding.
  [[nodiscard]] bool is_zero(std::size_t point) const { return value_[point] <= kZeroShare * size_[point]; }
  /// How often all rows were evaluated.
  [[nodiscard]] std::size_t evaluations() const noexcept { return evaluations_; }

  /// @brief The state at a time of the phase [s]; who touches is left as it is at its start.
  void state_at(const ReducedModel& model, double time, ModalState& state) const;
  /// @brief Adds the impulses of the points that touch between two times of the phase [N s].
  void add_impulses(double from, double until, std::span<double> sums) const;

 private:
  // Zeros that differ by less of the row's size are one (measured: mirror images differ by up to 1e-13).
  static constexpr double kZeroShare = 1e-12;

  void bound_curvature(double length);
  void evaluate(double elapsed);
  [[nodiscard]] double safe_step(std::size_t point) const;

  const PhaseBasis* basis_;
  double begin_;
  std::vector<double> place_;  // z at the start, and so on
  std::vector<double> speed_;
  std::vector<double> load_;
  std::vector<double> load_rate_;
  std::vector<double> constant_;  // of the rows
  std::vector<double> slope_of_constant_;
  std::vector<double> size_;       // of the terms that a row is added up from
  std::vector<double> swing_;      // the part of modes with a frequency, over the whole phase
  std::vector<double> curvature_;  // no second derivative of a row is larger
  std::vector<double> now_;        // z where the rows were evaluated
  std::vector<double> speed_now_;
  std::vector<double> reach_;  // of modes without frequency, how far their terms go
  std::vector<double> value_;  // of the rows
  std::vector<double> slope_;
  std::size_t evaluations_ = 0;
};

}  // namespace udar
