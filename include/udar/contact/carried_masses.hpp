#pragma once
/// @file
/// Masses that travel along the massless line and are carried by it.

#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "udar/filter/filtered_structure.hpp"
#include "udar/structure/initial_state.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar {

/// @brief What masses that travel do to the line at one time, of all of them on every rank.
struct Carried {
  std::vector<double> force;  ///< of each on the line, y up [N]
  std::vector<double> climb;  ///< how fast the line's height under it changes as it travels alone [m/s]; 0 on a road
};

/// @brief The line under masses that travel along it.
///
/// A mass hangs on its filter spring, wf^2 M, from a foot that is on the line at a moving place, or above it on a
/// spring of its own. With what the line gives way by between these places the forces follow from a symmetric positive
/// definite system of their number, solved alike on every rank: no stiffness limits a step. Before the beam and behind
/// it there is a rigid road at the height of the reference axis at its end. Source: docs/theory.md, "Travelling masses"
class CarriedMasses {
 public:
  /// @param line of a structure with `MassPoints::riders`, must outlive this object
  /// @param gravity [m/s^2]: heights of masses on springs of their own count from where their weight puts these
  CarriedMasses(FilteredStructure& line, const InitialState& initial, double gravity);

  /// @brief The line with the masses on it for the line without, at one time.
  /// @param[in] position Ym [m] @param[in,out] stretch d = Yc - Ym [m] @param[in,out] moment as
  /// `FilterColumn::internal`; may be empty @note Collective: one reduction; besides, for each node that comes to be
  /// beside a mass, a line solve, and a reduction for all of them.
  void apply(const Instant& at, std::span<const double> position, std::span<double> stretch, std::span<double> moment,
             Carried& carried);

  /// @brief Adds to the rate of the stretch what the masses on the line make of it.
  /// @param velocity Vm [m/s] @param carried as `apply` left it at this time
  /// @param load_rate what changing loads add to the rate of the line without masses [m/s]; empty: nothing
  /// @param[in,out] rate d(Vm) of the line without masses [m/s] @note Collective as `apply`.
  void add_rate(const Instant& at, std::span<const double> velocity, const Carried& carried,
                std::span<const double> load_rate, std::span<double> rate);

  /// Stored in the masses' own springs [J], of all of them.
  [[nodiscard]] double spring_energy(const Carried& carried) const;
  /// With what power whatever keeps the masses at their speeds brings in energy [W], of all of them.
  [[nodiscard]] static double power(const Carried& carried);
  /// @brief Where the line, or the road, is under each mass [m], of this rank's masses, else 0.
  /// @param foot heights of their filter springs' other ends, Ym + d, local points
  [[nodiscard]] std::vector<double> heights_below(std::span<const double> foot, const Carried& carried) const;

 private:
  /// A node beside a mass, and what a force of 1 N on it does.
  struct Node {
    std::size_t number = 0;
    std::vector<std::pair<std::size_t, double>> own;  // unknowns of this rank that add up to its height, if it has it
    std::vector<double> stretch;                      // [m/N]
    std::vector<double> moment;                       // internal forces over N

    [[nodiscard]] double height(std::span<const double> values) const;
  };
  /// Where a mass is: shares of two of the nodes, `nodes_[first]` and the next.
  struct Spot {
    Passage::State state;
    std::size_t first = 0;

    [[nodiscard]] bool on() const noexcept { return state.where == Passage::Where::on; }
    [[nodiscard]] std::array<double, 2> shares() const noexcept { return {1.0 - state.ahead, state.ahead}; }
    [[nodiscard]] std::array<double, 2> rates() const noexcept { return {-state.rate, state.rate}; }
  };

  void find_places(const Instant& at);
  void take_nodes(const std::vector<std::size_t>& wanted);
  [[nodiscard]] Node response(std::size_t number);
  void compute_compliance();
  [[nodiscard]] double compliance(const Spot& a, std::array<double, 2> of_a, const Spot& b,
                                  std::array<double, 2> of_b) const;
  [[nodiscard]] double own_compliance(std::size_t mass) const;
  void invert_system();
  [[nodiscard]] std::vector<double> solve(std::span<const double> right) const;
  void add_forces(std::span<const double> of_nodes, std::span<double> stretch, std::span<double> moment) const;
  [[nodiscard]] bool here(const Rider& rider) const { return points_->owns(rider.point); }
  [[nodiscard]] std::size_t local(const Rider& rider) const {
    return static_cast<std::size_t>(rider.point - points_->begin());
  }

  FilteredStructure* line_;
  const MassPoints* points_;
  std::span<const Rider> riders_;
  std::vector<std::array<double, 2>> road_;  // of each: before the beam, behind it [m]
  double gravity_;
  std::vector<Spot> places_;        // of the masses
  std::vector<Node> nodes_;         // beside masses, ascending
  std::vector<double> compliance_;  // of the line between these, by rows [m/N]
  std::vector<double> inverse_;     // of the system of the forces
};

}  // namespace udar
