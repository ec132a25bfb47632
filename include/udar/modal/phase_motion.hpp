#pragma once
/// @file
/// The motion of a reduced model from one change of contact to the next.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "udar/modal/phase_basis.hpp"
#include "udar/modal/reduced_model.hpp"

namespace udar {

/// @brief Closed form of the motion while the same points touch, and the first time at which one of them lets go or
/// another one comes. In flight modes may be damped, faces may move, and what lags goes back to rest.
class PhaseMotion {
 public:
  /// @param model conservative, and nothing moves, unless nobody touches @param basis, model must outlive this object
  PhaseMotion(const PhaseBasis& basis, const ReducedModel& model, const Drive& drive, const ModalState& start);

  [[nodiscard]] double begin() const noexcept { return begin_; }  ///< [s]

  /// @brief Searches for the first zero of a row up to a time [s].
  /// @return when, or `until` @note Each evaluation advances all rows together.
  [[nodiscard]] double last(double until);
  /// Whether the row of a point is zero at the end that `last` found, but for rounding.
  [[nodiscard]] bool is_zero(std::size_t point) const { return value_[point] <= kZeroShare * size_[point]; }
  /// How often all rows were evaluated.
  [[nodiscard]] std::size_t evaluations() const noexcept { return evaluations_; }

  /// @brief The state at a time of the phase [s]; who touches is left as it is at its start.
  /// @pre nothing lags
  void state_at(double time, ModalState& state) const;
  /// @brief Integrals between two times of the phase: of q [m kg^(1/2) s], and the impulses of the points that touch
  /// [N s]. @pre nothing is damped
  void integrate(double from, double until, std::span<double> amplitude, std::span<double> impulse) const;
  [[nodiscard]] const std::vector<std::uint8_t>& touches() const noexcept { return basis_->touches(); }

  /// Of a coordinate.
  struct Value {
    double place;
    double speed;
  };

 private:
  // Zeros that differ by less of the row's size are one (measured: mirror images differ by up to 1e-13).
  static constexpr double kZeroShare = 1e-12;

  void set_fading(const ModalState& start);
  void bound_curvature(double length);
  void evaluate(double elapsed);
  void add_fading(double elapsed);
  [[nodiscard]] double ratio_of(std::size_t mode) const;
  [[nodiscard]] Value value_of(std::size_t mode, double elapsed) const;
  [[nodiscard]] double safe_step(std::size_t point) const;

  /// Of the gaps of all points, what goes back to rest; empty: nothing does.
  struct Fading {
    std::vector<double> rest;  // with the lag of the rest
    std::vector<double> give;  // with the lag of each support
    std::vector<double> bend;  // no second derivative is larger from where the rows were evaluated on
  };

  const PhaseBasis* basis_;
  const ReducedModel* model_;
  double begin_;
  std::vector<double> place_;  // z at the start, and so on
  std::vector<double> speed_;
  std::vector<double> load_;
  std::vector<double> load_rate_;
  std::vector<double> constant_;  // of the rows
  std::vector<double> slope_of_constant_;
  std::vector<std::array<double, 4>> retreat_;  // of faces, from the start of the phase
  Fading fading_;
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
