#pragma once
/// @file
/// The massless line with plastic hinges at its nodes.

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "udar/contact/line_contact.hpp"
#include "udar/filter/filtered_structure.hpp"
#include "udar/numerics/bounded_rows.hpp"
#include "udar/structure/beam_chain.hpp"

namespace udar {

/// @brief The hinges of a beam, how far each is turned, and what turning them does to the line.
///
/// A hinge of rotation theta makes its row of compatibility T w - theta = S mu and stays elastic while |mu - H theta|
/// is below its yield moment. What a unit of it does is known from one line solve for each; the operator stays. All
/// that is not of this rank's nodes is equal on every rank. Source: docs/theory.md, "A beam that yields"
class HingedLine {
 public:
  /// More hinges and contact points than these are refused: the matrix takes 32 MB on every rank.
  static constexpr std::size_t kMostRows = 2000;

  /// @param contact whose points turn with the hinges; null: none; must outlive this object
  /// @throws InputError unless this is a beam in the mixed form without corrected modes, or with too many rows
  HingedLine(FilteredStructure& line, const LineContact* contact);

  [[nodiscard]] std::span<const PlasticHinge> hinges() const noexcept { return hinges_; }
  [[nodiscard]] std::size_t contacts() const noexcept { return contact_ != nullptr ? contact_->points().size() : 0; }
  /// Hinges on this rank's nodes, ascending.
  [[nodiscard]] std::span<const std::size_t> mine() const noexcept { return mine_; }
  /// Local node of such a hinge.
  [[nodiscard]] std::size_t local(std::size_t hinge) const {
    return static_cast<std::size_t>(hinges_[hinge].node - beam_->begin());
  }

  /// @name Plastic rotation of each hinge [rad], and how much it has turned forth and back; equal on every rank.
  /// @{
  [[nodiscard]] std::span<const double> rotations() const noexcept { return rotation_; }
  [[nodiscard]] std::span<const double> turned() const noexcept { return turned_; }
  void turn(std::span<const double> rotations);
  /// @}

  /// @brief Rotations as a column has them, one value per local node; null: all are zero. Valid until the next call.
  [[nodiscard]] const double* kink(std::span<const double> rotations);
  /// Puts them on the nodes of this rank [rad].
  void spread(std::span<const double> rotations, std::span<double> nodes) const;
  /// What hardening stores [J], of all hinges.
  [[nodiscard]] double stored(std::span<const double> rotations) const;
  /// @brief Moments at the hinges [N m] from those at the local nodes. @note Collective: one reduction.
  void gather(const double* moment, std::span<double> at_hinges) const;

  /// @brief What forces at contact points [N] and rotations of hinges [rad], in this order, do to gaps [m] and minus mu
  /// + H theta [N m]. @note Collective on first demand: a line solve for each row, two reductions.
  [[nodiscard]] BoundedRows& rows();
  /// Stretch under a unit rotation of a hinge [m/rad], local nodes. @pre `rows` has been called, and nothing touches
  [[nodiscard]] std::span<const double> response(std::size_t hinge) const { return responses_[hinge]; }
  /// @brief Adds what they do to the line. @param x as in `rows` @param[in,out] stretch [m] @param[out] moment that
  /// they give the nodes [N m] @note Collective: a line solve.
  void add(std::span<const double> x, std::span<double> stretch, std::span<double> moment);

  /// Takes up the state of an earlier run. @throws InputError unless there is a number for each hinge
  void restore(std::span<const double> rotations, std::span<const double> turned);

 private:
  FilteredStructure* line_;
  const BeamChain* beam_;
  const LineContact* contact_;
  std::vector<PlasticHinge> hinges_;
  std::vector<std::size_t> mine_;
  std::vector<double> rotation_;
  std::vector<double> turned_;
  std::optional<BoundedRows> rows_;
  std::vector<std::vector<double>> responses_;  // by hinge, where there are no contact points
  std::vector<double> zero_;                    // of the local nodes
  std::vector<double> kink_;                    // work
  std::vector<double> force_;                   // work
  std::vector<double> stretch_;                 // work
};

}  // namespace udar
