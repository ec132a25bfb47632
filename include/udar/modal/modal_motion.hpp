#pragma once
/// @file
/// How a reduced model moves: what its two ways have in common.

#include <cstddef>
#include <vector>

#include "udar/modal/reduced_model.hpp"

namespace udar {

/// @brief What flowed and passed from the start of the step at hand to a time in it.
struct ModalFlow {
  double support_work = 0.0;       ///< brought in by supports that move [J]
  double in_supports = 0.0;        ///< lost in their dampers [J]
  double in_modes = 0.0;           ///< lost by the damping of the modes [J]
  double radiated = 0.0;           ///< lost by the lag of the static rest [J]
  std::vector<double> amplitude;   ///< integral of q [m kg^(1/2) s]
  std::vector<double> rest_force;  ///< of rho [N s]
  std::vector<double> impulse;     ///< of r [N s]

  ModalFlow(std::size_t modes, std::size_t points) : amplitude(modes), rest_force(points), impulse(points) {}

  void add(const ModalFlow& more);
};

/// @brief A point that touches, from one time to another [s].
struct ModalContact {
  std::size_t point;
  double from;
  double until;
};

/// @brief What `resume` needs to go on to the same bits.
struct ModalMemory {
  ModalState entered{0, 0};     ///< where the motion at hand began
  double level = 0.0;           ///< of the steps
  double largest_energy = 0.0;  ///< so far [J]
};

/// @brief The motion of a reduced model, from step to step.
/// @note Not collective: equal on every rank.
class ModalMotion {
 public:
  ModalMotion() = default;
  ModalMotion(const ModalMotion&) = delete;
  ModalMotion& operator=(const ModalMotion&) = delete;
  virtual ~ModalMotion() = default;

  /// @brief Takes up the motion; forces follow from where the modes are, so that supports may press on it from the
  /// start.
  virtual void start(const ModalState& state, const Drive& drive) = 0;
  /// @brief Loads or supports change their course. @param jump some of them jumps
  virtual void turn(const Drive& drive, bool jump) = 0;
  /// @brief Goes on, at the latest to a time [s]. @return the time reached
  virtual double advance(double until) = 0;
  /// @brief Takes the last `advance` back. @pre no `turn` since
  virtual void take_back() = 0;

  [[nodiscard]] virtual const ModalState& now() const = 0;
  /// The state at a time of the last step [s].
  [[nodiscard]] virtual ModalState at(double time) const = 0;
  /// Who touched in the last step; ascending by point, then time.
  [[nodiscard]] virtual std::vector<ModalContact> contacts() const = 0;
  /// From the start of the last step to a time in it [s].
  [[nodiscard]] virtual ModalFlow flow(double until) const = 0;

  [[nodiscard]] virtual ModalMemory memory() const = 0;
  /// @brief Goes on from what `memory` gave. @param time now [s]
  virtual void resume(const ModalMemory& memory, const Drive& drive, double time) = 0;
  /// Changes of contact or steps so far.
  [[nodiscard]] virtual std::size_t count() const = 0;
};

}  // namespace udar
