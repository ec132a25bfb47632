#pragma once
/// @file
/// The filter's operator of a network.

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "udar/filter/scaled_operator.hpp"
#include "udar/petsc/handle.hpp"
#include "udar/structure/network.hpp"

namespace udar {

class NetworkSolver;

/// @brief wf^2 M + C of a network: `NetworkSolver` is what solves, the product by elements what solutions are checked
/// with; it takes differences along elements first, so that a translation gives nothing. The assembled frame is made
/// for those that ask for it.
///
/// Internal numbers, two for each point: of the node about the axis along which the point moves the rotation of the
/// line [rad], of a point that turns nothing; after those of all points its displacement Yc from where it is unstressed
/// [m], of a point that turns the line's angle [rad]. Source: docs/theory.md,
/// "Networks"
class NetworkOperator final : public ScaledOperator {
 public:
  /// @param network must live as long @param filter_frequency wf [rad/s], finite @note Collective.
  NetworkOperator(const Network& network, double filter_frequency);
  NetworkOperator(const NetworkOperator&) = delete;
  NetworkOperator& operator=(const NetworkOperator&) = delete;
  ~NetworkOperator() override;

  [[nodiscard]] const Network& network() const noexcept { return *network_; }
  [[nodiscard]] double filter_frequency() const noexcept { return filter_frequency_; }
  /// Local unknowns that never move, and what stands on their diagonal.
  [[nodiscard]] const std::vector<std::pair<std::size_t, double>>& held() const noexcept { return held_; }

  /// Numbers of this rank's nodes along and about global axes, `Network::nodal_row`, and of its unknowns, not scaled.
  using Nodal = std::vector<double>;
  using Rows = std::vector<double>;
  /// From displacements and rotations that are unknowns, and from forces and moments on nodes, to the other.
  [[nodiscard]] Nodal nodal_of(Rows rows) const;
  [[nodiscard]] Rows rows_of(Nodal nodal) const;

  [[nodiscard]] Mat op() const override { return op_; }
  [[nodiscard]] Mat matrix() override;
  /// That of the elements' matrices added by size: at most a few times that of their sum.
  [[nodiscard]] double norm() const override;
  [[nodiscard]] const char* solver_type() const override;
  [[nodiscard]] std::string block_form_reason() const override { return {}; }
  void right_hand_side(const FilterColumn& column, std::span<double> values) const override;
  void extract(std::span<const double> unknowns, const FilterColumn& column) const override;
  void unknowns_of(const FilterColumn& column, std::span<double> unknowns) const override;
  [[nodiscard]] std::size_t internal_numbers() const override { return 2; }
  /// Rotations follow from displacements by the network on filter springs that hold it where its masses are: those of a
  /// filter far above its own frequencies. Factors on first demand.
  void internal_of(const FilterColumn& column) override;
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
  /// An element of this rank's members.
  struct Placed {
    std::size_t member = 0;
    std::array<bool, 2> at_junction{};   ///< whether its nodes are junctions
    std::array<std::size_t, 2> where{};  ///< of junctions the place in `touched_`, else the local node
  };
  /// A stiffness against the motion of a local node along, or its rotation about, an axis.
  struct Spring {
    std::size_t local = 0;
    std::size_t first = 0;  // freedom: 0 displacement, 3 rotation
    std::array<double, 3> axis{};
    double stiffness = 0.0;
  };
  /// Of this rank's unknowns, and six of each junction that its members touch.
  struct Sums {
    std::vector<double> own;
    std::vector<double> junction;
  };

  using ElementMatrix = std::array<std::array<double, 12>, 12>;

  void prepare_gather();
  void list_springs();
  void list_held();
  void find_scale();
  void multiply(std::span<const double> x, std::span<double> y);
  void gather(const double* displacement, const double* rotation, bool all_move) const;
  [[nodiscard]] std::size_t unknown(std::size_t local, std::size_t freedom) const;
  template <class Visit>
  void each_axes(const Visit& visit) const;
  template <class Visit>
  void each_rotation(const Visit& visit) const;
  [[nodiscard]] const Axes& axes_at(const Placed& placed, std::size_t node) const;
  [[nodiscard]] ElementMatrix in_own_axes(const Placed& placed, const ElementMatrix& matrix) const;
  [[nodiscard]] std::array<double, 3> in_own_axes(const Spring& spring) const;
  [[nodiscard]] Rows reordered(Nodal own) const;
  [[nodiscard]] Nodal reordered_back(Rows rows) const;
  [[nodiscard]] std::vector<double> turned(const double* points) const;
  [[nodiscard]] Sums no_sums() const;
  [[nodiscard]] double& sum_at(Sums& sums, const Placed& placed, std::size_t row) const;
  void add_up(Sums& sums) const;
  [[nodiscard]] auto straining() const;
  [[nodiscard]] Nodal forces(const double* displacement, const double* rotation) const;
  template <class Visit>
  void each_element(const Visit& visit) const;
  template <class Visit>
  void visit_elements(const double* displacement, const double* rotation, bool all_move, const Visit& visit) const;

  const Network* network_;
  double filter_frequency_;
  std::vector<std::size_t> touched_;  // junctions of this rank's members, ascending
  petsc::Vector all_;                 // displacements and rotations as the rows of the stiffness
  petsc::Vector of_junctions_;        // six of each of `touched_`
  petsc::Handle<VecScatter, VecScatterDestroy> gather_;
  std::vector<Spring> springs_;
  std::vector<std::pair<std::size_t, double>> held_;  // rows
  std::vector<std::size_t> held_places_;              // of them in nodal order
  petsc::Matrix op_;
  petsc::Matrix matrix_;
  std::unique_ptr<NetworkSolver> held_network_;  // by its masses
};

}  // namespace udar
