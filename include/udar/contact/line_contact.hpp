#pragma once
/// @file
/// Contact of the massless line with its supports.

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "udar/contact/obstacle_forces.hpp"
#include "udar/contact/support.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/numerics/complementarity.hpp"

namespace udar {

/// @brief The nodes of the line that supports may hold, ascending, those of all ranks on each.
/// @note Collective.
[[nodiscard]] std::vector<LinePoint> line_points(const MassPoints& points, const Contacts& contacts);

/// @brief The line held off its supports: Yc = argmin 1/2 Yc'(wf^2 M + C)Yc - (wf^2 M Ym + F)'Yc with Yc >= support at
/// every node that a support touches; the multipliers are the contact forces. Supports may move, and give way by the
/// force over their stiffness. Without filter the force is that of the middle of a step, and a damper beside the spring
/// counts, too: it moves by a rate that the masses have.
///
/// With few contact points (`dense`) the compliance of the line between them is computed once, by a line solve for
/// each; what then remains is a complementarity problem of their number, solved alike on every rank. With many every
/// rank knows its own points alone, and the problem goes to `ObstacleForces`. Source: docs/theory.md, "Contact on the
/// line"
class LineContact {
 public:
  /// Contact points side by side under one support up to which pivoting serves (docs/theory.md, measured).
  static constexpr std::size_t kDensePoints = 100;

  /// @param dense_points more contact points than these under one support are many; not of networks and imported
  /// matrices, which have no way for many
  /// @note Collective: with a filter as `make_ready`.
  /// @throws InputError as `ObstacleForces` for many, and for supports that yield or are damped; where modes are
  /// corrected for many, and for points too close to each other
  LineContact(FilteredStructure& line, const Contacts& contacts, std::size_t dense_points = kDensePoints);
  /// @brief Makes what `solve` and `problem` or `many` need, unless it is there; without filter nobody may need it.
  /// @note Collective: few points, a line solve for each and one reduction.
  void make_ready();

  [[nodiscard]] MPI_Comm comm() const noexcept { return line_->points().comm(); }
  [[nodiscard]] bool on_first_rank() const noexcept { return line_->points().begin() == 0; }
  [[nodiscard]] bool dense() const noexcept { return dense_; }
  /// Dense: those of all ranks, in this order on each; else this rank's. Ascending by node.
  [[nodiscard]] std::span<const LinePoint> points() const noexcept { return points_; }

  /// @brief Values at the contact points, by point, then field.
  /// @param value of a field at a point of this rank: value(point, field)
  /// @note Collective: one reduction if dense.
  template <class Value>
  void gather(std::size_t fields, const Value& value, std::vector<double>& values) const {
    values.assign(points_.size() * fields, 0.0);
    for (const std::size_t i : mine_) {
      for (std::size_t k = 0; k < fields; ++k) {
        values[i * fields + k] = value(i, k);
      }
    }
    sum(values);
  }
  /// Points on this rank's nodes, ascending.
  [[nodiscard]] std::span<const std::size_t> mine() const noexcept { return mine_; }
  /// Local node of such a point.
  [[nodiscard]] std::size_t local(std::size_t point) const {
    return static_cast<std::size_t>(points_[point].node - line_->points().begin());
  }

  /// @name Where modes are corrected the line is tied to the masses in these: nearer to them than the stretch says.
  /// @{
  /// By how much less that makes a point's distance from its support [m]. @param amplitude of the stretch
  [[nodiscard]] double nearer(std::size_t point, std::span<const double> amplitude) const;
  /// Adds the amplitudes that contact forces give the stretch. @param force as `add` has it @param column of these
  void add_amplitudes(std::span<const double> force, std::size_t column, std::size_t columns,
                      std::span<double> amplitude) const;
  /// @}
  /// No frequency of the masses is higher, whoever touches [rad/s]. Source: docs/theory.md, "Corrected modes"
  [[nodiscard]] double frequency_bound() const noexcept { return bound_; }

  /// @brief Keeps what a unit force at each point does to the line, if dense: from then on `add` solves for moments
  /// alone. @note Collective: a line solve for each point; 8 bytes per point and local node.
  void keep_responses();
  /// Stretch under a unit force at a point, away from its support [m/N]; local nodes, if kept.
  [[nodiscard]] std::span<const double> response(std::size_t point) const { return responses_[point]; }

  /// @brief Adds what contact forces do to the line.
  /// @param force for every point: away from its support [N], `columns` of them one after the other for each point
  /// @param stretch, moment of each column, local nodes; moments empty: not wanted
  /// @note Collective: a line solve per column, none if all forces are zero; one reduction unless dense.
  void add(std::span<const double> force, std::span<double* const> stretch, std::span<double* const> moment);

  /// @brief The line with contact for the line without, at one time [s].
  /// @param[in] mass_position Ym [m] @param[in,out] stretch d = Yc - Ym [m] @param[in,out] amplitude of it in corrected
  /// modes @param[in,out] moment [N m]; may be empty
  /// @return whether any force holds it, equal on every rank
  /// @note Collective: one reduction and, in contact, one line solve; unless dense, as `ObstacleForces::solve` besides.
  bool apply(double time, std::span<const double> mass_position, std::span<double> stretch, std::span<double> amplitude,
             std::span<double> moment);
  /// Contact forces of the last `apply` at the points, away from the supports [N].
  [[nodiscard]] std::span<const double> forces() const noexcept { return force_; }
  /// What contact forces [N] store in the springs of the supports [J], and with what power supports that move bring
  /// energy in by them just after a time [W]; this rank's share. @param force at the points
  [[nodiscard]] double spring_energy(std::span<const double> force) const;
  [[nodiscard]] double power(std::span<const double> force, double time) const;

  /// @brief Forces for gaps of the free line, from no guess: equal gaps give equal forces. @param[in] gap at the points
  /// [m]; infinite: a point that never touches @param[out] force [N]
  /// @return whether there is a force, equal on every rank
  /// @note Collective unless dense.
  bool solve(std::span<const double> gap, std::span<double> force);
  /// If dense, the small problem: gaps of the free line [m] to forces [N]. Its gaps with contact, as those of many
  /// points, are distances from faces that give way.
  [[nodiscard]] Complementarity& problem() noexcept { return *problem_; }
  /// If not dense, the problem of many points.
  [[nodiscard]] ObstacleForces& many() noexcept { return *many_; }

 private:
  void compute_compliance();
  void tie_modes();
  void bound_frequency(const std::vector<double>& closed);
  void sum(std::vector<double>& values) const;
  void add_responses(std::span<const double> force, std::span<double* const> stretch) const;

  FilteredStructure* line_;
  bool dense_;
  std::vector<LinePoint> points_;
  std::vector<std::size_t> mine_;  // points on this rank's nodes
  std::vector<double> tie_;        // by point, then corrected mode: its shape there, away from the support [kg^(-1/2)]
  double bound_ = 0.0;             // [rad/s]
  std::optional<Complementarity> problem_;
  std::unique_ptr<ObstacleForces> many_;
  std::vector<double> zero_;
  std::vector<std::vector<double>> responses_;   // by point, if kept
  std::vector<std::vector<double>> load_;        // work, by column
  std::vector<std::vector<double>> correction_;  // work: stretch, then moment of each column
  std::vector<double> gap_;
  std::vector<double> force_;
};

}  // namespace udar
