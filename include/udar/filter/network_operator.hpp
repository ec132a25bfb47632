#pragma once
/// @file
/// The filter's operator of a network.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "udar/filter/assembled.hpp"
#include "udar/petsc/handle.hpp"
#include "udar/structure/network.hpp"

namespace udar {

/// @brief wf^2 M + C of a network: the assembled frame is what solutions are checked with and other solvers take,
/// `NetworkSolver` is what solves.
///
/// Internal numbers, two for each point: of the node about the axis along which the point moves the rotation of the
/// line [rad]; after those of all points its displacement Yc from where it is unstressed [m]. Source: docs/theory.md,
/// "Networks"
class NetworkOperator final : public AssembledOperator {
 public:
  /// @param network must live as long @param filter_frequency wf [rad/s], finite @note Collective.
  NetworkOperator(const Network& network, double filter_frequency);

  [[nodiscard]] const Network& network() const noexcept { return *network_; }
  [[nodiscard]] double filter_frequency() const noexcept { return filter_frequency_; }

  [[nodiscard]] const char* solver_type() const override;
  [[nodiscard]] std::string block_form_reason() const override { return {}; }
  void extract(std::span<const double> unknowns, const FilterColumn& column) const override;
  void unknowns_of(const FilterColumn& column, std::span<double> unknowns) const override;
  [[nodiscard]] std::size_t internal_numbers() const override { return 2; }
  /// Of each element in member axes: axial force, shear forces along y and z, torque, and of both ends the larger
  /// bending moment about y and about z.
  [[nodiscard]] std::span<const FieldInfo> internal_fields() const override;
  [[nodiscard]] std::size_t internal_places() const override;
  void internal_values(std::span<const double> internal, std::span<double> values) const override;
  [[nodiscard]] double strain_energy(std::span<const double> displacement,
                                     std::span<const double> internal) const override;

 private:
  /// Displacement and rotation of a node, three and three.
  using Motion = std::array<double, 6>;
  void prepare_gather();
  void gather(std::span<const double> internal) const;
  template <class Visit>
  void visit_elements(std::span<const double> internal, const Visit& visit) const;

  const Network* network_;
  double filter_frequency_;
  std::vector<std::size_t> touched_;  // junctions of this rank's members, ascending
  petsc::Vector all_;                 // displacements and rotations as the rows of the stiffness
  petsc::Vector of_junctions_;        // six of each of `touched_`
  petsc::Handle<VecScatter, VecScatterDestroy> gather_;
};

}  // namespace udar
