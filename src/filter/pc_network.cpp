#include "udar/filter/pc_network.hpp"

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "udar/filter/inner_moments.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/composed.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/preconditioner.hpp"

namespace udar {
namespace {

constexpr const char* kComposedNetwork = "udar_network";

const NetworkOperator* network_of(Mat matrix) {
  return petsc::composed<NetworkOperator>(reinterpret_cast<PetscObject>(matrix), kComposedNetwork);
}

class NetworkPreconditioner final : public petsc::Preconditioner {
 public:
  void set_from_options(PC /*pc*/) override {}

  void set_up(Mat amat, Mat pmat) override {
    operator_ = network_of(pmat) != nullptr ? network_of(pmat) : network_of(amat);
    if (operator_ == nullptr) {
      throw InputError{
          "preconditioner network solves the networks of udar only, and none is composed with the matrix; choose "
          "another -pc_type"};
    }
    solver_ = std::make_unique<NetworkSolver>(operator_->network(), operator_->filter_frequency());
    moments_.reset();
  }

  /// Right-hand sides of the scaled frame.
  void apply(std::span<const Column> columns) override {
    if (moments_ == nullptr) {
      moments_ = std::make_unique<InnerMoments>(operator_->network(), solver_->local_junctions());
    }
    const std::size_t points = operator_->mass().size();
    const std::size_t displacements = 3 * operator_->network().nodes();
    const std::span<const double> scale = operator_->scale();
    const std::size_t junctions = 6 * solver_->report().junctions;
    std::vector<double> force(points * columns.size());
    std::vector<double> moment(displacements * columns.size());  // of nodes; then how far they turn when none moves
    std::vector<double> answer(3 * points * columns.size());     // stretch, rotations, displacement
    std::vector<double> loads(junctions * columns.size(), 0.0);
    const std::vector<double> still(points, 0.0);
    std::vector<FilterColumn> all;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      NetworkOperator::Rows rows(scale.size());
      for (std::size_t i = 0; i < rows.size(); ++i) {
        rows[i] = columns[c].right[i] / scale[i];
      }
      const std::span own{force.data() + points * c, points};
      std::copy_n(rows.begin(), points, own.begin());
      std::fill_n(rows.begin(), points, 0.0);
      const NetworkOperator::Nodal nodal = operator_->nodal_of(std::move(rows));
      const std::span turned{moment.data() + displacements * c, displacements};
      std::copy(nodal.begin() + static_cast<std::ptrdiff_t>(displacements), nodal.end(), turned.begin());
      const std::span junction{loads.data() + junctions * c, junctions};
      solver_->take_moments(turned, junction);
      moments_->eliminate({.point = own, .rotation = turned, .junction = junction});
      all.push_back({.displacement = still.data(),
                     .force = own.data(),
                     .stretch = answer.data() + 3 * points * c,
                     .internal = answer.data() + 3 * points * c + points});
    }
    solver_->solve(all, loads);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      NetworkOperator::Nodal nodal(2 * displacements, 0.0);
      for (std::size_t i = 0; i < displacements; ++i) {
        nodal[displacements + i] = all[c].internal[i] + moment[displacements * c + i];
      }
      const NetworkOperator::Rows rows = operator_->rows_of(std::move(nodal));
      for (std::size_t i = 0; i < rows.size(); ++i) {
        columns[c].solution[i] = (i < points ? all[c].stretch[i] : rows[i]) / scale[i];
      }
      for (const auto& [unknown, diagonal] : operator_->held()) {
        columns[c].solution[unknown] = columns[c].right[unknown] / diagonal;
      }
    }
  }

  void view(PetscViewer viewer) const override {
    if (solver_ == nullptr) {
      UDAR_CALL(PetscViewerASCIIPrintf(viewer, "  not yet set up\n"));
      return;
    }
    const NetworkSolver::Report& report = solver_->report();
    const NetworkMembers::Report& members = report.members;
    UDAR_CALL(PetscViewerASCIIPrintf(
        viewer, "  first rank: %zu members of %zu kinds in %zu packs, %zu spans of those that are cut\n",
        members.members, members.kinds, members.packs, members.spans));
    UDAR_CALL(PetscViewerASCIIPrintf(viewer, "  first rank: %zu junctions, %zu blocks of 6 x 6 in the factor\n",
                                     report.junctions, report.factor_blocks));
    UDAR_CALL(PetscViewerASCIIPrintf(viewer, "  first rank: factor %zu bytes, tables %zu bytes\n", report.factor_bytes,
                                     members.table_bytes));
    UDAR_CALL(PetscViewerASCIIPrintf(viewer,
                                     "  between ranks: %zu junctions, of them of the first rank's members %zu\n",
                                     report.interface, report.own_interface));
  }

  [[nodiscard]] NetworkSolver* solver() const { return solver_.get(); }

 private:
  const NetworkOperator* operator_ = nullptr;
  std::unique_ptr<NetworkSolver> solver_;
  std::unique_ptr<InnerMoments> moments_;
};

}  // namespace

void compose_network(Mat matrix, const NetworkOperator& network) {
  petsc::compose(reinterpret_cast<PetscObject>(matrix), kComposedNetwork, network);
}

PetscErrorCode register_pc_network() { return petsc::register_preconditioner<NetworkPreconditioner>(kPcNetwork); }

NetworkSolver* network_solver(PC pc) {
  PetscBool network = PETSC_FALSE;
  UDAR_CALL(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), kPcNetwork, &network));
  return network == PETSC_TRUE ? static_cast<NetworkPreconditioner*>(petsc::attached(pc))->solver() : nullptr;
}

}  // namespace udar
