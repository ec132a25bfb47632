#pragma once
/// @file
/// Contact of the line with its supports, in the sweeps of the impact integrator.

#include <array>
#include <cstddef>
#include <vector>

#include "udar/contact/line_contact.hpp"
#include "udar/integrators/sweep.hpp"
#include "udar/integrators/sweep_tally.hpp"
#include "udar/motion/contact_state.hpp"
#include "udar/numerics/gauss.hpp"
#include "udar/numerics/legendre.hpp"

namespace udar {

/// @brief Contact forces over a step as Legendre series in time.
///
/// The complementarity problem is solved at Gauss points of the step and the forces are projected. Where points begin
/// or end to touch, the line's motion has a kink, which no polynomial shows: it is located, and its error is told, so
/// that the step may be cut there. Of many points kinks are estimated from the gaps at the Gauss points. Source:
/// docs/theory.md, "Contact on the line"
class LineForces {
 public:
  /// All outlive this object.
  LineForces(Sweep& sweep, LineContact& contact, ContactState& state);

  /// Another step, or another length of it: the sweep has both.
  void begin();
  /// @brief Adds to the free line, just solved for, what contact forces do to it.
  /// @note Collective: one reduction and, in contact, one batch of line solves; with many points a solve of
  /// `ObstacleForces` at each Gauss point and one reduction, near contact two.
  void apply();
  /// Enters the kinks of the last `apply`.
  void tell(Tally& tally) const;
  /// What supports that move brought in up to a share of the step, this rank's share; exact of the polynomials.
  [[nodiscard]] EnergyFlow flow(double until) const;
  /// Impulses, work, smallest distances and the time of contact of the accepted step.
  void write_journal();

 private:
  struct Kink {
    double tau;
    double jump;  // of the line's slope, largest of all points [m per step]
  };
  using Active = std::vector<std::size_t>;

  void add_projection(std::size_t q, double value, double* coefficients) const;
  void free_gap_at(double tau);
  void locate_kinks();
  void estimate_kinks();
  void find_borders_of_contact();
  void find_border_kink(const Active& inside, double at, double border);
  [[nodiscard]] double missed_of(double tau) const;
  void motion(const Active& active, std::vector<double>& gap, std::vector<double>& force) const;
  [[nodiscard]] double first_change(const Active& active, double from, double to) const;
  void add_kink(const Active& before, const Active& after, double tau);

  Sweep* sweep_;
  LineContact* contact_;
  ContactState* state_;
  double kink_integral_;
  std::array<std::array<double, kMostTerms>, kGauss.size()> legendre_{};  // at the Gauss points
  std::vector<double> face_;      // Legendre coefficients by point: its height [m]
  std::vector<double> free_gap_;  // the same of the gap of the free line [m]
  std::vector<double> force_;     // the same of the forces [N]
  std::array<std::vector<double>, kGauss.size()> force_at_;
  std::array<bool, kGauss.size()> in_contact_{};           // any force, on any rank
  std::array<Active, kGauss.size()> active_;               // points that touch
  std::array<std::vector<double>, kGauss.size()> gap_at_;  // many points, with contact, from faces that give way [m]
  std::vector<Kink> kinks_;                                // that every rank knows
  std::vector<Kink> own_kinks_;                            // of many points: where this rank's change sides
  std::vector<double> gap_;                                // work
  bool first_sweep_ = true;
};

}  // namespace udar
