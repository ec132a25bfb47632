#include "udar/filter/pc_chain.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "udar/petsc/composed.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/preconditioner.hpp"

namespace udar {
namespace {

constexpr const char* kComposed = "udar_line";

std::string name_of(Mat matrix) {
  const char* type = nullptr;
  const char* name = nullptr;
  UDAR_CALL(MatGetType(matrix, &type));
  UDAR_CALL(PetscObjectGetName(reinterpret_cast<PetscObject>(matrix), &name));
  return std::string{"'"} + name + "' of type " + type;
}

class ChainPreconditioner final : public petsc::Preconditioner {
 public:
  void set_from_options(PC pc) override {
    const char* prefix = nullptr;
    UDAR_CALL(PCGetOptionsPrefix(pc, &prefix));
    UDAR_CALL(PetscOptionsGetInt(nullptr, prefix, "-pc_chain_lanes", &lanes_, nullptr));
    if (lanes_ != 0 && !ChainSolver::lanes_supported(static_cast<int>(lanes_))) {
      std::string quantity = std::string{prefix != nullptr ? prefix : ""} + "pc chain lanes";
      std::ranges::replace(quantity, '_', ' ');
      throw InputError{quantity + ": " + std::to_string(lanes_) +
                       " is not allowed, expected 0 (automatic), 1, 4 or 8, on this processor at most " +
                       std::to_string(chain::native_lanes()) + " [spans side by side]"};
    }
  }

  void set_up(Mat amat, Mat pmat) override {
    const LineData* line = composed_line(pmat);
    if (line == nullptr) {
      line = composed_line(amat);
    }
    if (line == nullptr) {
      throw InputError{"preconditioner chain solves the lines of udar only, and no line is composed with the matrix " +
                       name_of(pmat) + "; choose another -pc_type"};
    }
    solver_ = std::make_unique<ChainSolver>(*line, static_cast<int>(lanes_));
  }

  void apply(std::span<const Column> columns) override {
    std::vector<FilterColumn> all(columns.size());
    for (std::size_t c = 0; c < columns.size(); ++c) {
      all[c].right_hand_side = columns[c].right;
      all[c].unknowns = columns[c].solution;
    }
    solver_->solve(all);
  }

  void view(PetscViewer viewer) const override {
    if (solver_ == nullptr) {
      UDAR_CALL(PetscViewerASCIIPrintf(viewer, "  not yet set up\n"));
      return;
    }
    constexpr std::array kCouplings{"none (one rank)", "messages between neighbours",
                                    "one MPI_Allgather of 4 numbers a rank"};
    const ChainSolver::Report& report = solver_->report();
    UDAR_CALL(PetscViewerASCIIPrintf(viewer,
                                     "  first rank: %zu joints, %zu nodes inside spans, %zu different "
                                     "spans, %d side by side\n",
                                     report.joints, report.inner_nodes, report.spans, report.lanes));
    UDAR_CALL(PetscViewerASCIIPrintf(viewer, "  first rank: factor %zu bytes, work %zu bytes\n", report.factor_bytes,
                                     report.work_bytes));
    UDAR_CALL(
        PetscViewerASCIIPrintf(viewer, "  decay length %g to %g m\n", report.shortest_decay, report.longest_decay));
    UDAR_CALL(PetscViewerASCIIPrintf(viewer, "  coupling of ranks: %s; at most %.2g of a disturbance passes a rank\n",
                                     kCouplings[static_cast<std::size_t>(report.coupling)], report.carried));
  }

  [[nodiscard]] ChainSolver* solver() const { return solver_.get(); }

 private:
  PetscInt lanes_ = 0;
  std::unique_ptr<ChainSolver> solver_;
};

}  // namespace

void compose_line(Mat matrix, const LineData& line) {
  petsc::compose(reinterpret_cast<PetscObject>(matrix), kComposed, line);
}

const LineData* composed_line(Mat matrix) {
  return petsc::composed<LineData>(reinterpret_cast<PetscObject>(matrix), kComposed);
}

PetscErrorCode register_pc_chain() { return petsc::register_preconditioner<ChainPreconditioner>(kPcChain); }

ChainSolver* chain_solver(PC pc) {
  PetscBool chain = PETSC_FALSE;
  UDAR_CALL(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), kPcChain, &chain));
  return chain == PETSC_TRUE ? static_cast<ChainPreconditioner*>(petsc::attached(pc))->solver() : nullptr;
}

}  // namespace udar
