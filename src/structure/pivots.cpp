#include "structure/pivots.hpp"

#include <cmath>

#include "structure/cholmod_session.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

/// A pivot of so little beside its diagonal is rounding: a factorisation keeps some ten digits more than this has zeros
/// with `kShift` in it, and none without.
constexpr double kRounding = 1e-13;
/// Below this a pivot is the shift of a rigid motion, and not stiffness.
constexpr double kSmall = 1e-5;

}  // namespace

Pivots pivots_of(const std::vector<MatrixEntry>& entries, const std::vector<double>& added) {
  const std::size_t size = added.size();
  CholmodSession session;
  // L L', which ends at a pivot that is not positive; L D L' would not.
  session.get()->final_asis = 0;
  session.get()->final_super = 0;
  session.get()->final_ll = 1;
  std::vector<double> diagonal = added;
  cholmod_triplet* triplet =
      cholmod_allocate_triplet(size, size, entries.size() + size, -1, CHOLMOD_REAL, session.get());
  if (triplet == nullptr) {
    throw SolveError{"not memory enough to factor the stiffness"};
  }
  const auto put = [&](PetscInt row, PetscInt column, double value) {
    static_cast<int*>(triplet->i)[triplet->nnz] = static_cast<int>(row);
    static_cast<int*>(triplet->j)[triplet->nnz] = static_cast<int>(column);
    static_cast<double*>(triplet->x)[triplet->nnz] = value;
    ++triplet->nnz;
  };
  for (const MatrixEntry& entry : entries) {
    if (entry.row >= entry.column) {
      put(entry.row, entry.column, entry.value);
    }
    if (entry.row == entry.column) {
      diagonal[static_cast<std::size_t>(entry.row)] += entry.value;
    }
  }
  for (std::size_t i = 0; i < size; ++i) {
    put(static_cast<PetscInt>(i), static_cast<PetscInt>(i), added[i]);
  }
  cholmod_sparse* matrix = cholmod_triplet_to_sparse(triplet, triplet->nnz, session.get());
  cholmod_free_triplet(&triplet, session.get());
  cholmod_factor* factor = matrix != nullptr ? cholmod_analyze(matrix, session.get()) : nullptr;
  Pivots pivots;
  bool done = factor != nullptr;
  if (done) {
    cholmod_factorize(matrix, factor, session.get());
    done = session.status() == CHOLMOD_OK || session.status() == CHOLMOD_NOT_POSDEF;
  }
  if (done && factor->minor < size) {
    pivots.failed = static_cast<const int*>(factor->Perm)[factor->minor];
  } else if (done && cholmod_change_factor(CHOLMOD_REAL, 1, 0, 1, 1, factor, session.get()) != 0) {
    const auto* first = static_cast<const int*>(factor->p);  // of each column, the diagonal's place
    const auto* values = static_cast<const double*>(factor->x);
    for (std::size_t column = 0; column < size; ++column) {
      const PetscInt unknown = static_cast<const int*>(factor->Perm)[column];
      const double share = std::pow(values[first[column]], 2) / diagonal[static_cast<std::size_t>(unknown)];
      pivots.small += share < kSmall ? 1 : 0;
      if (share < kRounding && !pivots.failed) {
        pivots.failed = unknown;
      }
    }
  } else {
    done = false;
  }
  cholmod_free_factor(&factor, session.get());
  cholmod_free_sparse(&matrix, session.get());
  if (!done) {
    throw SolveError{"not memory enough to factor the stiffness"};
  }
  return pivots;
}

}  // namespace udar
