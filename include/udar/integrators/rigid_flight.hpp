#pragma once
/// @file
/// Flight without vibration, whatever its length.

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "udar/integrators/free_motion.hpp"
#include "udar/motion/contact_state.hpp"
#include "udar/motion/equations.hpp"

namespace udar {

/// @brief The motion of an undamped structure to whose velocities and accelerations the line does not answer: powers of
/// time, up to the first instant at which something touches. Source: docs/theory.md, "Rigid motion"
class RigidFlight {
 public:
  /// All outlive this object. @param contacts what may be touched; null: it never begins
  RigidFlight(Equations& equations, ContactState& contact, const Contacts* contacts);

  /// @brief Looks for a flight that begins now. @param time [s] @param state Ym [m], then Vm [m/s] of the local nodes;
  /// stays where it is @param shortest, longest of a flight [s] @param negligible way that vibration may go in it [m]
  /// @return whether there is one
  /// @note Collective: a line solve and, where nothing touches before `shortest`, two more, three under changing loads;
  /// two reductions.
  bool begin(double time, std::span<const double> state, double shortest, double longest, double negligible);
  /// Forgets it and gives its memory back.
  void end();

  [[nodiscard]] bool flies() const noexcept { return motion_.has_value(); }
  [[nodiscard]] double length() const noexcept { return length_; }  ///< [s]
  /// Whether it ends because something touches.
  [[nodiscard]] bool touches() const noexcept { return touches_; }

  /// @name At a time since its beginning [s].
  /// @{
  void at(double elapsed, std::span<double> position, std::span<double> velocity) const;
  [[nodiscard]] double acceleration(double elapsed, std::size_t node) const;  ///< [m/s^2]
  /// As `DenseOutput` has them.
  void line_integrals(double elapsed, std::span<const std::size_t> nodes, std::span<double> integrals) const;
  void mass_integrals(double elapsed, std::span<double> integrals) const;
  [[nodiscard]] std::vector<double> amplitude_integrals(double elapsed) const;
  /// @}
  /// Offers contact the smallest distances of the line from its supports.
  void track_line() const;

 private:
  using Powers = std::array<double, 4>;  // of the share of a time

  [[nodiscard]] Powers distance(const ContactSet& set, std::size_t node, double length, bool of_line) const;
  [[nodiscard]] double first_touch(double longest) const;
  [[nodiscard]] double jerk(std::size_t node) const { return jerk_.empty() ? 0.0 : jerk_[node]; }

  Equations* equations_;
  ContactState* contact_;
  const Contacts* contacts_;
  double wf2_;
  std::optional<FreeMotion> motion_;
  double begin_ = 0.0;   // [s]
  double length_ = 0.0;  // [s]
  bool touches_ = false;
  std::span<const double> position_;
  std::span<const double> velocity_;
  LineState line_;                    // at the beginning
  std::vector<double> line_stretch_;  // Yc - Ym there
  LoadRate rate_;                     // of the stretch, by changing loads
  std::vector<double> line_rate_;     // of the line's; empty: loads are steady
  std::vector<double> acceleration_;  // [m/s^2]
  std::vector<double> jerk_;          // [m/s^3]; empty: loads are steady
};

}  // namespace udar
