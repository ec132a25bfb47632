#pragma once
/// @file
/// A mass and a support with spring and damper: when it presses, when it lets go.

#include <cstdint>

namespace udar {

/// @brief The contact of one mass with a support that gives way, as a state machine over its gap g:
///
///     open -> pressing      g closes
///     pressing -> slack     k g + c g' rises to zero: spring and damper no longer push, the damper would pull
///     pressing -> open      the same without damper: the gap opens with it
///     slack -> pressing     k g + c g' falls to zero
///     slack -> open         g opens
///
/// Source: docs/theory.md, "Supports that give way"
class ElasticTouch {
 public:
  enum class State : std::uint8_t {
    open,      ///< the gap is open
    pressing,  ///< it is closed, and spring and damper press
    slack,     ///< it is closed, but opens so fast that the damper would pull
  };

  ElasticTouch() = default;
  /// @param starts_at_zero as the function of that name
  explicit ElasticTouch(State state, bool starts_at_zero = false) noexcept
      : state_{state}, starts_at_zero_{starts_at_zero} {}

  /// @brief As gap and rate alone have it. @param force k g + c g'
  [[nodiscard]] static ElasticTouch found(double gap, double force) noexcept {
    return ElasticTouch{gap >= 0.0 ? State::open : force < 0.0 ? State::pressing : State::slack};
  }

  [[nodiscard]] State state() const noexcept { return state_; }
  [[nodiscard]] bool closed() const noexcept { return state_ != State::open; }
  [[nodiscard]] bool pressing() const noexcept { return state_ == State::pressing; }
  [[nodiscard]] bool slack() const noexcept { return state_ == State::slack; }

  /// A closed gap changes where this times k g + c g' turns negative.
  [[nodiscard]] double sign() const noexcept { return slack() ? 1.0 : -1.0; }
  /// What would end the state is zero at the start of the arc, by construction.
  [[nodiscard]] bool starts_at_zero() const noexcept { return starts_at_zero_; }
  /// Whether the gap opens where the force ends.
  [[nodiscard]] bool opens_with_force(double damping) const noexcept { return !slack() && damping == 0.0; }
  /// Whether the mass is on the support's face when the state changes.
  [[nodiscard]] bool changes_on_face(bool opens) const noexcept { return !closed() || opens; }

  /// An arc without events has passed.
  void pass() noexcept { starts_at_zero_ = false; }
  /// @brief The next state.
  /// @param opens whether it is the gap that opens @param rate g' there
  void change(bool opens, double damping, double rate) noexcept {
    starts_at_zero_ = !opens && (closed() || damping == 0.0 || rate == 0.0);
    state_ = opens ? State::open : (pressing() ? State::slack : State::pressing);
  }

 private:
  State state_ = State::open;
  bool starts_at_zero_ = false;
};

}  // namespace udar
