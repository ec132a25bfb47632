#include "udar/integrators/ts_moreau.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "udar/contact/line_contact.hpp"
#include "udar/integrators/problem_integrator.hpp"
#include "udar/integrators/yielding_steps.hpp"
#include "udar/motion/finite.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/log.hpp"

namespace udar {
namespace {

// A mass that comes slower than this share of the speed its impulse gives lies on the support: what is left is
// rounding.
constexpr double kLying = 1e-6;

class Moreau final : public ProblemIntegrator {
 public:
  [[nodiscard]] Features can() const override { return kMoreauType.can; }

  void set_from_options(TS /*stepper*/, PetscOptionItems* /*PetscOptionsObject*/) override {}

  void start(const LineState& /*line*/) override { ProblemIntegrator::begin_step(); }

  bool advance() override {
    enter_step(step_);
    for (std::size_t i = 0; i < count_; ++i) {
      guess_[i] = start_[i] + 0.5 * step_ * start_[count_ + i];
      displacement_[i] = guess_[i] - equations_->axis()[i];
    }
    const std::span<const double> force = equations_->loads().mean(begin_, begin_ + step_, work_);
    if (yielding_) {
      yielding_->predict(displacement_, force, stretch_);
    } else {
      equations_->line().solve(displacement_, force, stretch_, {});
    }
    resolve_contact();
    {
      const petsc::WriteArray end{state_};
      for (std::size_t i = 0; i < count_; ++i) {
        end.values()[i] = start_[i] + step_ * start_[count_ + i] + 2.0 * stretch_[i];
        end.values()[count_ + i] = start_[count_ + i] + 4.0 / step_ * stretch_[i];
      }
      require_finite(*equations_, {end.values(), count_}, {end.values() + count_, count_}, begin_);
    }
    // Times are multiples of the step: thousands of sums would leave a sliver of a step at the end.
    leave_step((std::round(begin_ / step_) + 1.0) * step_ - begin_, step_);
    write_journal();
    return true;
  }

  void view(TS /*stepper*/, PetscViewer viewer) const override {
    UDAR_CALL(
        PetscViewerASCIIPrintf(viewer, "  Moreau-Jean scheme: step %g s, theta 1/2, %d contact nodes\n", step_,
                               static_cast<int>(contact_nodes_ != nullptr ? contact_nodes_->points().size() : 0)));
  }

  [[nodiscard]] double next_step() const override { return step_; }
  [[nodiscard]] bool fixed_step() const override { return true; }

  /// The nodes move evenly between the ends of a step.
  void line_integrals(std::span<const std::size_t> nodes, double until, std::span<double> integrals) const override {
    const double elapsed = std::clamp(until - begin_, 0.0, length_);
    std::ranges::transform(nodes, integrals.begin(), [&](std::size_t node) {
      return elapsed * (start_[node] + 0.5 * elapsed * mean_velocity(node));
    });
  }

  void line_places(std::span<const std::size_t> nodes, double at, std::span<double> places) const override {
    const double elapsed = std::clamp(at - begin_, 0.0, length_);
    std::ranges::transform(nodes, places.begin(),
                           [&](std::size_t node) { return start_[node] + elapsed * mean_velocity(node); });
  }

  [[nodiscard]] EnergyFlow flow(double until) const override {
    const bool later = stepped_ && until - begin_ >= 0.5 * length_;
    const petsc::ReadArray now{state_};
    return {.work = later ? work_in_ : 0.0,
            .damped = later ? damped_ : 0.0,
            .yielded = later && yielding_ ? yielding_->lost() : 0.0,
            .stored = later || !stepped_ ? stored(now.values(), begin_ + length_) : stored(start_, begin_)};
  }

  [[nodiscard]] std::vector<double> rotations(double time) const override {
    return yielding_ ? yielding_->rotations(stepped_ && time - begin_ < 0.5 * length_) : std::vector<double>{};
  }

  void save(MotionState& /*state*/) const override {}
  void restore(const MotionState& /*state*/) override { ProblemIntegrator::begin_step(); }

 private:
  void prepare() override {
    if (equations_->line().structure().chain() == nullptr) {
      throw InputError{
          "filter frequency: none is not allowed with a network and `ts type` moreau, which is for beams, expected a "
          "number > 0 [rad/s], or `ts type` modal"};
    }
    step_ = 2.0 / wf_;
    guess_.resize(count_);
    displacement_.resize(count_);
    stretch_.resize(count_);
    contact_nodes_ = equations_->line_contact();
    if (contact_nodes_ != nullptr) {
      contact_nodes_->make_ready();
    }
    force_.resize(contact_nodes_ != nullptr ? contact_nodes_->points().size() : 0);
    if (equations_->hinges() != nullptr) {
      yielding_.emplace(*equations_);
    }
  }
  void take_back() override {
    if (yielding_) {
      yielding_->take_back();
    }
  }
  void within(double elapsed, std::span<double> position, std::span<double> velocity,
              std::span<std::uint8_t> resting) const override {
    // The nearer end of the step: velocities that turn round within it have no mean that keeps energy.
    const petsc::ReadArray end{state_};
    const double* const nearer = elapsed < 0.5 * length_ ? start_ : end.values();
    for (std::size_t i = 0; i < count_; ++i) {
      position[i] = nearer[i];
      velocity[i] = nearer[count_ + i];
      resting[i] = 0;
    }
    if (contact_nodes_ != nullptr) {
      for (const std::size_t point : contact_nodes_->mine()) {
        resting[contact_nodes_->local(point)] |= static_cast<std::uint8_t>(force_[point] > 0.0);
      }
    }
  }

  /// What its motion adds to a support's height at the start of the step [m], and its velocity at both ends [m/s].
  struct Face {
    double height;
    double before;
    double after;
  };
  [[nodiscard]] Face face_of(const LinePoint& point) const {
    const SupportMotion::State start = point.lift(begin_);
    return {.height = start.height, .before = start.velocity, .after = point.lift(begin_ + step_).velocity};
  }

  /// v+ - s+ >= -e (v- - s-) where a support of velocity s is reached in this step. As v+ = v- + (4/h) d with the
  /// stretch d from y + h/2 v-, that is d >= -(h/4)((1 + e) v- - s+ - e s-): the line held off a support, and the
  /// impulse over the step's length is the force.
  void resolve_contact() {
    const petsc::LogScope scope{petsc::log_events().contact};
    const std::vector<double> gaps = contact_gaps();
    if (yielding_) {
      in_contact_ = yielding_->resolve(gaps, force_, stretch_);
    } else if (contact_nodes_ != nullptr) {
      in_contact_ = contact_nodes_->solve(gaps, force_);
      const std::array<double*, 1> line{stretch_.data()};
      contact_nodes_->add(force_, line, {});
    }
  }

  /// Of the free line; infinite: the support is not reached.
  [[nodiscard]] std::vector<double> contact_gaps() const {
    if (contact_nodes_ == nullptr) {
      return {};
    }
    enum Field : std::size_t { guess, velocity, stretch, fields };
    const auto& points = contact_nodes_->points();
    std::vector<double> values;
    contact_nodes_->gather(
        fields,
        [&](std::size_t point, std::size_t field) {
          const std::size_t node = contact_nodes_->local(point);
          return field == guess ? guess_[node] : (field == velocity ? start_[count_ + node] : stretch_[node]);
        },
        values);
    std::vector<double> gaps(points.size(), std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double* of = values.data() + i * fields;
      if (points[i].compliance > 0.0) {
        gaps[i] = elastic_gap(points[i], of[guess], of[velocity], of[stretch]);
        continue;
      }
      const Face face = face_of(points[i]);
      if (points[i].side * (of[guess] - points[i].height - face.height - 0.5 * step_ * face.before) <= 0.0) {
        const ImpactLaw law = contact_->supports()[static_cast<std::size_t>(points[i].support)].law();
        const double e = law.ratio(std::abs(of[velocity] - face.before));
        gaps[i] = points[i].side * (of[stretch] + 0.25 * step_ * (1.0 + e) * of[velocity] -
                                    0.25 * step_ * (face.after + e * face.before));
      }
    }
    return gaps;
  }

  /// Of the force r = k s + c s' that a spring with damper has by its sag s in the middle of the step, where it pushes:
  /// with the free stretch d and the compliance p = 1 / (k + 2 c / h) it is side (d + a s0 + b s0') + p r >= 0 beside
  /// r >= 0, with a = k p, b = c p and what the step begins with.
  [[nodiscard]] double elastic_gap(const LinePoint& point, double guess, double velocity, double stretch) const {
    const SupportMotion::State face = point.lift(begin_ + 0.5 * step_);
    const double above = guess - point.height - face.height;
    if (point.damping > 0.0 && point.side * (above + stretch) > 0.0) {
      return std::numeric_limits<double>::infinity();  // a damper pushes nobody who is not there
    }
    const double b = point.damping * point.yield(equations_->line().parameters());
    const double a = 1.0 - 2.0 * b / step_;
    return point.side * (stretch + a * above + b * (velocity - face.velocity));
  }

  /// What the springs hold when the nodes are at given places [J], this rank's share.
  [[nodiscard]] double stored(const double* position, double time) const {
    double sum = 0.0;
    if (contact_nodes_ == nullptr) {
      return sum;
    }
    for (const std::size_t i : contact_nodes_->mine()) {
      const LinePoint& point = contact_nodes_->points()[i];
      if (point.compliance > 0.0) {
        const double gap = point.side * (position[contact_nodes_->local(i)] - point.height - point.lift(time).height);
        const double sag = std::max(-gap, 0.0);
        sum += 0.5 / point.compliance * sag * sag;
      }
    }
    return sum;
  }

  [[nodiscard]] double mean_velocity(std::size_t node) const {
    return start_[count_ + node] + 2.0 / step_ * stretch_[node];
  }

  void write_journal() {
    work_in_ = 0.0;
    damped_ = 0.0;
    if (yielding_) {
      contact_->journal().record_flow({.yielded = yielding_->lost()});
    }
    if (contact_nodes_ == nullptr) {
      return;
    }
    ContactJournal& journal = contact_->journal();
    const petsc::ReadArray end{state_};
    for (const std::size_t i : contact_nodes_->mine()) {
      const LinePoint& point = contact_nodes_->points()[i];
      const std::size_t node = contact_nodes_->local(i);
      const double lift = point.lift(begin_ + length_).height;
      contact_->record_gap(point.side * (end.values()[node] - point.height - lift), node, begin_ + length_);
      if (force_[i] > 0.0 && point.compliance > 0.0) {
        const double impulse = point.side * force_[i] * step_;
        const double speed = point.lift(begin_ + 0.5 * step_).velocity;
        work_in_ += impulse * speed;
        damped_ += point.damping * std::pow(mean_velocity(node) - speed, 2) * step_;
        journal.record_force(point.support, impulse, {begin_, begin_ + step_});
        journal.record_contact_time(node, {begin_, begin_ + step_});
      } else if (force_[i] > 0.0) {
        const Face face = face_of(point);
        const double middle = begin_ + 0.5 * step_;
        const double impulse = point.side * force_[i] * step_;
        const double speed = 0.5 * (face.before + face.after);
        const double loss = impulse * (speed - mean_velocity(node));
        work_in_ += impulse * speed;
        const double approach = -point.side * (start_[count_ + node] - face.before);
        if (approach > kLying * force_[i] * step_ / equations_->line().mass()[node]) {
          journal.record_impact(node, {.time = middle,
                                       .support = point.support,
                                       .velocity_before = start_[count_ + node],
                                       .velocity_after = end.values()[count_ + node],
                                       .impulse = impulse,
                                       .energy_loss = loss});
        } else {
          journal.record_loss(middle, loss);
          journal.record_impulse(point.support, impulse, middle);
          journal.record_contact_time(node, {middle, middle});
        }
      }
    }
    journal.record_flow({.work = work_in_, .damped = damped_});
    if (in_contact_) {
      journal.record_line_contact({begin_, begin_ + length_});
    }
  }

  double step_ = 0.0;
  LineContact* contact_nodes_ = nullptr;  // null: nothing to touch
  std::vector<double> guess_;             // y + h/2 v
  std::vector<double> displacement_;
  std::vector<double> stretch_;            // ymid - guess
  std::vector<double> force_;              // by contact point [N]
  std::optional<YieldingSteps> yielding_;  // where the line may yield
  bool in_contact_ = false;                // any of them on any rank
  double work_in_ = 0.0;                   // by supports that move, in the middle of the step [J]
  double damped_ = 0.0;                    // by dampers in supports, in the step [J]
  std::vector<double> work_;
};

}  // namespace

PetscErrorCode register_ts_moreau() { return petsc::register_integrator<Moreau>(kTsMoreau); }

}  // namespace udar
