#pragma once
/// @file
/// One mass on its filter spring over one step, the line's motion given: exact through any number of impacts.

#include <array>
#include <cstddef>
#include <limits>

#include "udar/contact/contact_law.hpp"
#include "udar/contact/impact_law.hpp"
#include "udar/numerics/legendre.hpp"

namespace udar::local {

/// Powers that reach round-off for a step of `angle` = wf h.
[[nodiscard]] std::size_t powers_for(double angle);

/// @brief What a mass meets. Displacements [m] count from its position at the start of the step, velocities [m per
/// step].
struct Stop {
  double at = 0.0;                                               ///< displacement at which it touches at the start [m]
  double restitution = 1.0;                                      ///< e
  double yield_speed = std::numeric_limits<double>::infinity();  ///< where e begins to fall [m per step]
  bool present = false;
  bool moves = false;            ///< by `path`
  std::array<double, 3> path{};  ///< its way since the start, in tau, tau^2 and tau^3 [m]
  double stiffness = 0.0;        ///< k/m [1/step^2]; 0: rigid, > 0: no restitution
  double damping = 0.0;          ///< c/m of one that is not rigid [1/step]
  /// @name In place of spring and damper.
  /// @{
  const ContactLaw* contact_law = nullptr;  ///< null: none
  double carried = 0.0;                     ///< mass that shares the law's force [kg]
  double step = 0.0;                        ///< length of the step [s]
  double largest = 0.0;                     ///< compression up to the start [m]
  /// @}

  /// It gives way, by spring and damper or by a law.
  [[nodiscard]] bool elastic() const noexcept { return stiffness > 0.0 || contact_law != nullptr; }
  [[nodiscard]] ImpactLaw law() const noexcept { return {.restitution = restitution, .yield_speed = yield_speed}; }
  [[nodiscard]] double place(double tau) const noexcept {
    return moves ? at + tau * (path[0] + tau * (path[1] + tau * path[2])) : at;
  }
  [[nodiscard]] double speed(double tau) const noexcept {
    return moves ? path[0] + tau * (2.0 * path[1] + 3.0 * tau * path[2]) : 0.0;
  }
};

/// @brief The problem: z'' = angle^2 (P(tau) - z) - drag z', z(0) = 0, z'(0) = velocity, tau from 0 to 1; lower and
/// upper stop. A stop that is not rigid adds -(k/m) g - (c/m) g' while its gap g is negative and that is not an
/// attraction, or the force of its law over the mass that shares it.
struct Problem {
  double angle = 0.0;                     ///< wf h [rad]
  std::size_t terms = 0;                  ///< of P
  std::size_t powers = 0;                 ///< `powers_for(angle + drag)`
  std::array<double, kMostTerms> line{};  ///< P in powers of tau [m]
  double velocity = 0.0;                  ///< [m per step]
  std::array<Stop, 2> stops{};            ///< below, above
  int resting = -1;                       ///< index of the stop it rests on at the start; -1: moves
  double hop_tolerance = 0.0;             ///< [m]
  double together = 0.0;                  ///< nearer than this it is on the stop [m]
  double pull_resolution = 0.0;           ///< P - z that is not larger does not pull it off a stop [m]
  double until = 1.0;                     ///< tau at which to end
  bool moments = true;                    ///< whether the outcome is to have them: they are most of the work
  double drag = 0.0;                      ///< [1/step]
  std::array<double, kMostTerms> turn{};  ///< in powers of tau, a part of angle^2 P: dampers take z' (drag z' - turn)
};

/// @brief The end of it.
struct Outcome {
  std::array<double, kMostTerms> moments{};  ///< Legendre coefficients of z over [0, 1], if `until` is 1 [m]
  double displacement = 0.0;                 ///< [m]
  double velocity = 0.0;                     ///< [m per step]
  int resting = -1;                          ///< stop it rests on
  int impacts = 0;
  double first_impact = 2.0;        ///< tau; above 1: none
  double kick = 0.0;                ///< sum of |velocity jumps| [m per step]
  std::array<double, 2> largest{};  ///< compressions of stops with a law so far [m]
};

/// More impacts of one mass in one step than this end in rest, with the energy booked as lost.
inline constexpr int kMostImpacts = 20000;

/// @brief Listens to what happens to the mass, in order of time.
class Journal {
 public:
  virtual ~Journal() = default;
  /// @param before, after velocities of the mass [m per step]
  virtual void impact(int /*stop*/, double /*tau*/, double /*before*/, double /*after*/) {}
  /// @param speed away from the stop that is taken from the mass [m per step]
  virtual void rest(int /*stop*/, double /*tau*/, double /*speed*/) {}
  virtual void release(int /*stop*/, double /*tau*/) {}
  /// What a stop gave without an impact, per mass.
  /// @param push integral of the acceleration it gives, up [m per step] @param work that of this and its own speed
  virtual void pressed(int /*stop*/, double /*push*/, double /*work*/) {}
  /// What dampers took, per mass: those of stops, and drags [m^2 per step^2].
  virtual void damped(double /*loss*/) {}
  /// It was in contact with a stop that is not rigid.
  virtual void touched(double /*from*/, double /*until*/) {}
};

/// @brief Moves the mass from 0 to `until`, arc by arc. @param journal null: nobody listens
/// Source: docs/theory.md, "The impact integrator"
[[nodiscard]] Outcome advance(const Problem& problem, Journal* journal = nullptr);

}  // namespace udar::local
