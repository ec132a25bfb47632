#include "support/dense.hpp"

#include <slepceps.h>

#include <cmath>
#include <utility>

#include "udar/petsc/error.hpp"
#include "udar/petsc/handle.hpp"

namespace udar::test {

std::vector<double> solve(const Dense& matrix, const std::vector<double>& right_hand_side) {
  const std::size_t n = matrix.size;
  std::vector<long double> a(matrix.values.begin(), matrix.values.end());
  std::vector<long double> b(right_hand_side.begin(), right_hand_side.end());
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < n; ++i) {
      pivot = std::abs(a[i * n + k]) > std::abs(a[pivot * n + k]) ? i : pivot;
    }
    for (std::size_t j = 0; j < n; ++j) {
      std::swap(a[k * n + j], a[pivot * n + j]);
    }
    std::swap(b[k], b[pivot]);
    for (std::size_t i = k + 1; i < n; ++i) {
      const long double factor = a[i * n + k] / a[k * n + k];
      for (std::size_t j = k; j < n; ++j) {
        a[i * n + j] -= factor * a[k * n + j];
      }
      b[i] -= factor * b[k];
    }
  }
  std::vector<double> x(n);
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t j = k + 1; j < n; ++j) {
      b[k] -= a[k * n + j] * b[j];
    }
    b[k] /= a[k * n + k];
    x[k] = static_cast<double>(b[k]);
  }
  return x;
}

Eigen eigen(const Dense& symmetric) {
  const auto n = static_cast<PetscInt>(symmetric.size);
  petsc::Matrix matrix;
  UDAR_CALL(MatCreateSeqDense(PETSC_COMM_SELF, n, n, nullptr, matrix.put()));
  for (PetscInt i = 0; i < n; ++i) {
    for (PetscInt j = 0; j < n; ++j) {
      UDAR_CALL(MatSetValue(matrix, i, j, symmetric(static_cast<std::size_t>(i), static_cast<std::size_t>(j)),
                            INSERT_VALUES));
    }
  }
  UDAR_CALL(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  UDAR_CALL(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  petsc::Handle<EPS, EPSDestroy> solver;
  UDAR_CALL(EPSCreate(PETSC_COMM_SELF, solver.put()));
  UDAR_CALL(EPSSetOperators(solver, matrix, nullptr));
  UDAR_CALL(EPSSetProblemType(solver, EPS_HEP));
  UDAR_CALL(EPSSetType(solver, EPSLAPACK));
  UDAR_CALL(EPSSetWhichEigenpairs(solver, EPS_SMALLEST_REAL));
  UDAR_CALL(EPSSolve(solver));
  Eigen result{.values = std::vector<double>(symmetric.size), .vectors = Dense{symmetric.size}};
  petsc::Vector vector;
  UDAR_CALL(MatCreateVecs(matrix, vector.put(), nullptr));
  for (PetscInt j = 0; j < n; ++j) {
    UDAR_CALL(EPSGetEigenpair(solver, j, &result.values[static_cast<std::size_t>(j)], nullptr, vector, nullptr));
    const double* column = nullptr;
    UDAR_CALL(VecGetArrayRead(vector, &column));
    for (std::size_t i = 0; i < symmetric.size; ++i) {
      result.vectors(i, static_cast<std::size_t>(j)) = column[i];
    }
    UDAR_CALL(VecRestoreArrayRead(vector, &column));
  }
  return result;
}

Dense line_stiffness(const BeamChain& beam) {
  const auto n = static_cast<std::size_t>(beam.nodes());
  const auto last = n - 1;
  Dense t{n};
  Dense s{n};
  for (std::size_t e = 0; e < last; ++e) {
    const BeamElement element = beam.element(static_cast<PetscInt>(e));
    if (std::isinf(element.flexural_compliance)) {
      continue;  // a gap
    }
    const double h = element.length;
    const double bend = h * element.flexural_compliance / 6.0;
    const double shear = element.shear_compliance / h;
    const std::size_t a = e;
    const std::size_t b = e + 1;
    t(a, a) -= 1.0 / h;
    t(a, b) += 1.0 / h;
    t(b, a) += 1.0 / h;
    t(b, b) -= 1.0 / h;
    s(a, a) += 2.0 * bend + shear;
    s(b, b) += 2.0 * bend + shear;
    s(a, b) += bend - shear;
    s(b, a) += bend - shear;
  }
  for (std::size_t node = 0; node < n; ++node) {
    const BeamEnd* end = beam.end_at(static_cast<PetscInt>(node));
    if (end == nullptr) {
      continue;
    }
    if (end->moment_free()) {
      for (std::size_t j = 0; j < n; ++j) {
        t(node, j) = 0.0;
        s(node, j) = 0.0;
        s(j, node) = 0.0;
      }
      s(node, node) = 1.0;
    } else {
      s(node, node) += 1.0 / end->rotational_stiffness;
    }
  }
  Dense c{n};
  for (std::size_t j = 0; j < n; ++j) {
    std::vector<double> column(n);
    for (std::size_t i = 0; i < n; ++i) {
      column[i] = t(i, j);
    }
    const std::vector<double> moment = solve(s, column);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 0; k < n; ++k) {
        c(i, j) += t(k, i) * moment[k];
      }
    }
  }
  const double pull = beam.parameters().tension;
  for (std::size_t i = 0; i < n; ++i) {
    c(i, i) += beam.ground_stiffness(static_cast<PetscInt>(i));
    if (i < last && pull > 0.0 && std::isfinite(beam.element(static_cast<PetscInt>(i)).flexural_compliance)) {
      const double k = pull / beam.element(static_cast<PetscInt>(i)).length;
      c(i, i) += k;
      c(i + 1, i + 1) += k;
      c(i, i + 1) -= k;
      c(i + 1, i) -= k;
    }
  }
  return c;
}

std::vector<std::size_t> free_nodes(const BeamChain& beam) {
  std::vector<std::size_t> nodes;
  for (PetscInt node = 0; node < beam.nodes(); ++node) {
    if (!beam.fixed(node)) {
      nodes.push_back(static_cast<std::size_t>(node));
    }
  }
  return nodes;
}

Eigen lumped_modes(const BeamChain& beam) {
  const Dense c = line_stiffness(beam);
  const std::vector<std::size_t> nodes = free_nodes(beam);
  const auto root_mass = [&](std::size_t node) { return std::sqrt(beam.mass(static_cast<PetscInt>(node))); };
  Dense scaled{nodes.size()};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (std::size_t j = 0; j < nodes.size(); ++j) {
      scaled(i, j) =
          0.5 * (c(nodes[i], nodes[j]) + c(nodes[j], nodes[i])) / (root_mass(nodes[i]) * root_mass(nodes[j]));
    }
  }
  const Eigen reduced = eigen(scaled);
  Eigen modes{.values = reduced.values, .vectors = Dense{static_cast<std::size_t>(beam.nodes())}};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (std::size_t j = 0; j < nodes.size(); ++j) {
      modes.vectors(nodes[i], j) = reduced.vectors(i, j) / root_mass(nodes[i]);
    }
  }
  return modes;
}

}  // namespace udar::test
