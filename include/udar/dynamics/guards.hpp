#pragma once
/// @file
/// What a run is watched for while it runs.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "udar/contact/support.hpp"
#include "udar/motion/contact_state.hpp"
#include "udar/motion/energy_balance.hpp"
#include "udar/motion/equations.hpp"
#include "udar/motion/motion_scale.hpp"

namespace udar {

/// @brief What becomes of a run that is worth a warning; what cannot be believed at all always ends it.
enum class GuardMode : std::uint8_t {
  silent,  ///< nothing
  warn,    ///< says so once, and goes on
  stop,    ///< ends it, as an error does
};

/// @brief What is watched, the gravest first: what comes before `depth` ends every run.
enum class Guard : std::uint8_t {
  finite,         ///< the state of the masses
  finite_energy,  ///< all energies
  fall,           ///< masses, or a line that contact is on, far below a rigid support
  unstable,       ///< balance of energy, off by much of it
  damper_gain,    ///< energy that dampers gave between two rows
  depth,          ///< masses, or the line, below a rigid support by more than the integration's tolerance
  impact_gain,    ///< energy that an impact gave
  loss_gain,      ///< that impacts, rests and friction gave between two rows
  drift,          ///< balance of energy, off by more than is worth a warning
};
inline constexpr std::size_t kGuards = 9;

/// @brief A step whose end is at hand.
struct JudgedStep {
  double begin;                    ///< [s]
  double time;                     ///< [s]
  std::span<const double> before;  ///< Ym [m], then Vm [m/s] at its start
  std::span<const double> after;   ///< the same at its end
  double tolerance;                ///< of the integration, share of the motion's scale
  bool late;                       ///< whether it finds a support as late as at its end
};

/// @brief A row whose energies are at hand, equal on every rank.
struct JudgedRow {
  double time;                 ///< [s]
  const EnergyLedger& before;  ///< of the row before
  const EnergyLedger& now;
  const MassState& masses;
  double tolerance;  ///< as above
};

/// @brief Judges steps and rows by what is at hand, and ends the run or warns of it.
///
/// A step is judged by each rank alone: what is to be said is carried by a reduction that there is anyway, and costs
/// messages only where there is something. Source: docs/theory.md, "Guards"
class Guards {
 public:
  /// @param sets nodes under supports, whoever touches
  /// The referenced objects must outlive this one.
  Guards(const Equations& equations, const ContactState& contact, std::span<const ContactSet> sets,
         const MotionScale& scale)
      : equations_{&equations}, contact_{&contact}, sets_{sets}, scale_{scale} {}

  void set_mode(GuardMode mode) noexcept { mode_ = mode; }

  /// Judges this rank's part of a step; impacts are those in the journal. @note Not collective.
  void see(const JudgedStep& step);
  /// Judges a row. @note Not collective: equal on every rank.
  void see(const JudgedRow& row);

  /// 1 where this rank has something to say, else 0.
  [[nodiscard]] double waiting() const noexcept;
  /// @brief Says what was seen: a warning for each guard, once a run, or the end of it.
  /// @param ranks the sum of `waiting` over the ranks @note Collective if that is not 0.
  /// @throws SolveError naming quantity, limit, node, place, rank and time
  void tell(double ranks);

 private:
  struct Finding {
    double time = 0.0;
    double value = 0.0;
    double limit = 0.0;
    double node = -1.0;  // by its number; negative: that of no node
    double x = 0.0;
  };

  [[nodiscard]] bool watches(Guard guard) const noexcept;
  void find(Guard guard, const Finding& finding);
  void find_at(Guard guard, Finding finding, std::size_t point);
  void see_masses(const JudgedStep& step);
  void see_line(const JudgedStep& step);
  void see_impacts();
  void see_depth(const JudgedStep& step, double depth, std::size_t point);
  [[nodiscard]] static std::string text_of(Guard guard, const Finding& finding, int rank);

  const Equations* equations_;
  const ContactState* contact_;
  std::span<const ContactSet> sets_;
  MotionScale scale_;
  GuardMode mode_ = GuardMode::silent;
  double energy_ = 0.0;                                     // what is turned over, at the last row [J]
  double fastest_ = 0.0;                                    // that a mass of this rank has sunk into a support [m/s]
  std::array<std::optional<Finding>, kGuards> findings_{};  // by guard, the first of this rank that is not told
  std::array<bool, kGuards> told_{};                        // equal on every rank
};

}  // namespace udar
