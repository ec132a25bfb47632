#pragma once
/// @file
/// How the whole structure moves, and how far it bends away from that.

#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "udar/app/case.hpp"
#include "udar/app/rebound.hpp"
#include "udar/dynamics/impact_dynamics.hpp"
#include "udar/io/peaks.hpp"
#include "udar/motion/observer.hpp"
#include "udar/structure/structure.hpp"

namespace udar::app {

/// @brief Follows at every row the centre of mass, and the deflection of the line: what nothing holds bends away from
/// the solid that moves with its masses, by least squares, what is held from where nothing strains it.
/// One reduction a row of a structure that nothing holds, none of others.
class BodyMotion final : public Observer {
 public:
  /// @param structure, dynamics must outlive this object @note Collective.
  BodyMotion(const Case& input, const Structure& structure, const ImpactDynamics& dynamics);

  [[nodiscard]] double interval() const override { return interval_; }
  void snapshot(const Snapshot& state) override;
  void step(const Progress& /*progress*/) override { flush(); }
  void flush() override;
  void save(MotionState& state) const override;
  void restore(const MotionState& state) override;

  /// The largest deflection so far [m], of a node; empty where parts lie apart. @note Collective.
  [[nodiscard]] std::optional<io::Peak> deflection() const;
  /// Of what falls freely on supports that stand below or above it; empty of others.
  [[nodiscard]] Rebound rebound() const { return search_ ? search_->found() : Rebound{}; }

 private:
  [[nodiscard]] std::vector<double> shares(const Snapshot& state, const std::vector<double>& displacement) const;
  void widen(double time, const std::vector<double>& displacement);
  [[nodiscard]] std::optional<double> first_contact() const;

  const Structure* structure_;
  const MassPoints* points_;  // without what strikes them
  const ImpactDynamics* dynamics_;
  double interval_;
  std::vector<double> unstrained_;          // of each local point, whence displacements count [m]
  std::vector<std::size_t> node_;           // of each local point, whose displacements add up to a vector's length
  std::vector<std::vector<double>> solid_;  // motions as a solid; empty: held
  bool apart_;                              // several parts, which move as several solids
  io::Peak peak_{};                         // of this rank's nodes
  std::optional<ReboundSearch> search_;
  std::deque<ReboundSearch::Row> rows_;  // of which nobody knows yet whether there was contact before
};

}  // namespace udar::app
