#pragma once
/// @file
/// The motion of a reduced model in steps within which contact forces are linear.

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "udar/modal/modal_motion.hpp"
#include "udar/modal/oscillator.hpp"
#include "udar/modal/phase_basis.hpp"
#include "udar/modal/reduced_model.hpp"
#include "udar/numerics/complementarity.hpp"

namespace udar {

/// @brief rho + tau rho' = r over a time in which r goes evenly from r0 to r1: rho1 = left rho0 + first r0 + last r1.
struct Lag {
  double left = 0.0;
  double first = 0.0;
  double last = 1.0;

  /// @param lag tau [s], >= 0
  [[nodiscard]] static Lag after(double time, double lag);
};

/// @brief What a time does to every mode and every lag of a reduced model.
struct ModalKernels {
  double time = 0.0;  ///< [s]
  std::vector<Oscillator> modes;
  Lag rest;
  std::vector<Lag> supports;  ///< empty: no dampers

  ModalKernels(const ReducedModel& model, double duration);
};

/// @brief Steps of any number of contact points, exact but for what contact forces do within a step.
///
/// Modes, lags, loads and supports follow in closed form; forces at the end of a step are those with which nothing
/// overlaps there, a complementarity problem with one constant matrix for each length of step. A step is as long as
/// forces do no work on gaps, which they would not if contact began and ended at its ends: `tolerance` of the largest
/// energy, of an even share of it in every tenth of the first period. A flight is one step, whatever its length.
/// Source: docs/theory.md, "The modal integrator"
class KernelSteps final : public ModalMotion {
 public:
  /// @param model must outlive this object @param tolerance of the energy, > 0
  KernelSteps(const ReducedModel& model, double tolerance);

  void start(const ModalState& state, const Drive& drive) override;
  void turn(const Drive& drive, bool jump) override;
  double advance(double until) override;
  void take_back() override;
  [[nodiscard]] const ModalState& now() const override { return state_; }
  [[nodiscard]] ModalState at(double time) const override;
  [[nodiscard]] std::vector<ModalContact> contacts() const override;
  [[nodiscard]] ModalFlow flow(double until) const override;
  [[nodiscard]] ModalMemory memory() const override;
  void resume(const ModalMemory& memory, const Drive& drive, double time) override;
  [[nodiscard]] std::size_t count() const override { return count_; }
  /// Steps tried and found too long.
  [[nodiscard]] std::size_t rejected() const noexcept { return rejected_; }

 private:
  /// A step taken: the state after any part of it follows.
  struct Taken {
    ModalState start;
    std::vector<double> end_force;
    double length;
    ModalFlow before;  // since the start of the last `advance`
  };
  /// A length of step.
  struct Stride {
    ModalKernels kernels;
    Complementarity problem;
  };

  /// Contact forces as modes feel them, b' r, at the start of a step and at its end.
  struct Push {
    std::vector<double> before;
    std::vector<double> after;
  };

  [[nodiscard]] Stride stride(double length) const;
  [[nodiscard]] Stride& stride_of(int level);
  [[nodiscard]] bool flies() const;
  void find_forces(bool in_balance);
  void land();
  void fly(double until);
  void step(double until);
  [[nodiscard]] ModalState attempt(Stride& stride, Push& push) const;
  void accept(ModalState end, const ModalFlow& flow, double length);
  [[nodiscard]] const Taken& step_at(double time) const;
  [[nodiscard]] std::vector<double> pushed(std::span<const double> force) const;
  [[nodiscard]] ModalState moved(const ModalState& from, const ModalKernels& kernels, std::span<const double> end_force,
                                 const Push& push) const;
  [[nodiscard]] ModalFlow flow_of(const ModalState& from, const ModalKernels& kernels, const ModalState& end,
                                  const Push& push) const;
  void add_modes(const ModalState& from, const ModalKernels& kernels, const ModalState& end, const Push& push,
                 ModalFlow& flow) const;
  void add_supports(const ModalState& from, const ModalKernels& kernels, const ModalState& end, ModalFlow& flow) const;
  [[nodiscard]] double radiated(const ModalState& from, const ModalKernels& kernels, const ModalState& end) const;
  [[nodiscard]] double gap(const ModalState& state, std::size_t point) const;
  [[nodiscard]] double gap_work(const ModalState& end, const ModalFlow& flow, double time, const Push& push) const;

  const ReducedModel* model_;
  double tolerance_;
  double longest_;  // step [s]
  double share_;    // of the energy's tolerance in a second [1/s]
  Complementarity closed_;
  PhaseBasis free_;
  std::map<int, Stride> strides_;
  Drive drive_;
  ModalState state_;
  int level_ = 0;
  double largest_energy_ = 0.0;
  std::vector<Taken> taken_;
  ModalFlow passed_;    // in these
  ModalMemory before_;  // the last `advance`
  std::size_t count_ = 0;
  std::size_t rejected_ = 0;
};

}  // namespace udar
