#pragma once
/// @file
/// The motion between the two ends of a step of PETSc's explicit integrators.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "udar/integrators/elastic_touches.hpp"
#include "udar/motion/contact_state.hpp"
#include "udar/motion/equations.hpp"
#include "udar/numerics/step_polynomial.hpp"

namespace udar {

/// @brief What is known at one end of a step.
struct StepEnd {
  LineState line;                    ///< and its time
  const double* values = nullptr;    ///< Ym [m], then Vm [m/s], of the local nodes
  std::vector<double> rate;          ///< d(Vm) [m/s], kept only while a mass rests or the structure is damped
  std::vector<double> bend;          ///< d'' [m/s^2], kept where the structure is damped
  std::vector<double> acceleration;  ///< of the masses [m/s^2], kept unless the contact is plain
};

/// @brief What a support gives a mass, over its mass, from the start of the step to a share of it.
struct SupportAction {
  double push = 0.0;  ///< [m/s]
  EnergyFlow flow;    ///< [m^2/s^2]
};

/// @brief Dense output of masses, line and supports over one step.
///
/// Masses move by the quintic through position, velocity and acceleration at both ends, the line by the cubic or, with
/// damping, the quintic through the stretch and its rates. theta is the share of the step that has passed.
/// Source: docs/theory.md, "Dense output"
class StepMotion {
 public:
  /// All outlive this object.
  StepMotion(Equations& equations, const ContactState& contact);

  /// All supports are rigid and at rest, and nothing is damped; the same on every rank.
  [[nodiscard]] bool plain() const noexcept { return plain_; }
  [[nodiscard]] StepEnd& start() noexcept { return start_; }
  [[nodiscard]] StepEnd& end() noexcept { return end_; }
  [[nodiscard]] const StepEnd& start() const noexcept { return start_; }
  [[nodiscard]] const StepEnd& end() const noexcept { return end_; }
  [[nodiscard]] double begin() const noexcept { return start_.line.time; }                                ///< [s]
  [[nodiscard]] double length() const noexcept { return end_.line.time - start_.line.time; }              ///< [s]
  [[nodiscard]] double time(double theta) const noexcept { return start_.line.time + theta * length(); }  ///< [s]
  [[nodiscard]] ElasticTouches& touches() noexcept { return touches_; }
  [[nodiscard]] const ElasticTouches& touches() const noexcept { return touches_; }

  /// Acceleration over stretch [1/s^2].
  [[nodiscard]] double wf2() const noexcept { return wf2_; }
  /// The step has no length. @param with_rate whether rates are known
  void end_at_start(bool with_rate);
  /// @brief d'' and the accelerations at one end, from its values, line and rate. @note Collective with damping.
  void find_accelerations(StepEnd& end);
  /// What changing loads add to both rates; as long as the equations keep it.
  void set_load_rate(std::span<const double> rate) noexcept { load_rate_ = rate; }
  /// d' by loads alone over the step at hand [m/s].
  [[nodiscard]] double load_rate(std::size_t node) const { return load_rate_.empty() ? 0.0 : load_rate_[node]; }

  [[nodiscard]] Kinematics kinematics(std::size_t node, const StepEnd& end) const;
  [[nodiscard]] StepPolynomial polynomial(std::size_t node) const;
  /// Gap of a mass and its rates.
  [[nodiscard]] Kinematics gap(const ContactSet& set, const Kinematics& mass, std::size_t node, double time) const;
  [[nodiscard]] Kinematics gap(const ContactSet& set, std::size_t node, const StepEnd& end) const {
    return gap(set, kinematics(node, end), node, end.line.time);
  }
  /// What spring and damper of a support that gives way add to the mass's acceleration [m/s^2].
  [[nodiscard]] double contact_acceleration(const ContactSet& set, std::size_t node, const Kinematics& mass,
                                            double time) const;
  /// What lifts a mass at rest off its support, as stretch [m]: value and rate.
  struct Lift {
    double value;
    double rate;
  };
  [[nodiscard]] Lift lift(const ContactSet& set, std::size_t node, const StepEnd& end) const;
  /// Distance of the line from a support, at a node that may touch it [m].
  [[nodiscard]] double line_gap(const ContactSet& set, std::size_t node, double theta) const;
  /// How much nearer to its mass than the stretch says the line is, in corrected modes [m].
  [[nodiscard]] double amplitude_offset(std::size_t node, double theta) const;
  /// Integral over the step of the stretch that presses a mass at rest on a plain support [m s].
  [[nodiscard]] double pull_integral(std::size_t node) const;
  [[nodiscard]] SupportAction action(const ContactSet& set, std::size_t node, double theta) const;

  /// @name The parts of `DenseOutput`.
  /// @{
  void masses(double time, std::span<double> position, std::span<double> velocity,
              std::span<std::uint8_t> resting) const;
  [[nodiscard]] double line_integral(std::size_t node, double until) const;
  [[nodiscard]] double mass_integral(std::size_t node, double until) const;
  [[nodiscard]] std::vector<double> amplitude_integrals(double until) const;  ///< @note Collective.
  /// By the masses' supports and dampers, up to a share of the step.
  [[nodiscard]] EnergyFlow flow(double theta) const;
  /// @}

 private:
  [[nodiscard]] StepPolynomial stretch_polynomial(std::size_t node) const;
  [[nodiscard]] double damper_rate(std::size_t node, double theta) const;
  [[nodiscard]] double pull_of_line(const StepPolynomial& motion, double theta) const;
  [[nodiscard]] double resting_stretch(std::size_t node, double theta) const;
  [[nodiscard]] double stretch(const ContactSet& set, std::size_t node, double theta) const;

  Equations* equations_;
  const ContactState* contact_;
  std::size_t count_;
  double wf2_;
  Damping damping_;
  bool plain_;
  StepEnd start_;
  StepEnd end_;
  std::span<const double> load_rate_;
  ElasticTouches touches_;
};

}  // namespace udar
