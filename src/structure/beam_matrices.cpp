#include "udar/structure/beam_matrices.hpp"

#include <array>
#include <cmath>
#include <fstream>
#include <iomanip>
#include <utility>
#include <vector>

#include "udar/petsc/error.hpp"
#include "udar/structure/matrix_file.hpp"

namespace udar {
namespace {

/// Which of displacement and rotation a node has.
std::array<bool, 2> moves(const BeamChain& beam, PetscInt node) {
  const BeamEnd* end = beam.end_at(node);
  return {!beam.fixed(node), end == nullptr || end->rotational_stiffness != BeamEnd::kRigid};
}

/// Numbers of all nodes' unknowns, -1 of one that is not there; equal on every rank.
struct Numbering {
  std::vector<std::array<PetscInt, 2>> of_node;
  PetscInt unknowns = 0;

  explicit Numbering(const BeamChain& beam) {
    for (PetscInt node = 0; node < beam.nodes(); ++node) {
      std::array<PetscInt, 2> numbers{-1, -1};
      for (std::size_t a = 0; a < 2; ++a) {
        if (moves(beam, node)[a]) {
          numbers[a] = unknowns++;
        }
      }
      of_node.push_back(numbers);
    }
  }
};

/// What this rank's nodes and the elements on their right give.
std::vector<MatrixEntry> stiffness_of(const BeamChain& beam, const Numbering& numbering) {
  std::vector<MatrixEntry> entries;
  const auto add = [&](PetscInt row, PetscInt column, double value) {
    if (row >= 0 && column >= 0) {
      entries.push_back({.row = row, .column = column, .value = value});
    }
  };
  for (PetscInt node = beam.begin(); node < beam.end(); ++node) {
    const auto& own = numbering.of_node[static_cast<std::size_t>(node)];
    add(own[0], own[0], beam.ground_stiffness(node));
    if (const BeamEnd* end = beam.end_at(node); end != nullptr && own[1] >= 0) {
      add(own[1], own[1], end->rotational_stiffness);
    }
    if (node + 1 == beam.nodes() || !std::isfinite(beam.element(node).flexural_compliance)) {
      continue;
    }
    const auto& next = numbering.of_node[static_cast<std::size_t>(node) + 1];
    const std::array<PetscInt, 4> unknowns{own[0], own[1], next[0], next[1]};
    const HermiteElement e = hermite_element(beam.element(node), beam.parameters().tension);
    const std::array<std::array<double, 4>, 4> matrix{{{e.side, e.cross, -e.side, e.cross},
                                                       {e.cross, e.diagonal, -e.cross, e.coupling},
                                                       {-e.side, -e.cross, e.side, -e.cross},
                                                       {e.cross, e.coupling, -e.cross, e.diagonal}}};
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = 0; b < 4; ++b) {
        add(unknowns[a], unknowns[b], matrix[a][b]);
      }
    }
  }
  return entries;
}

std::vector<MatrixEntry> mass_of(const BeamChain& beam, const Numbering& numbering) {
  std::vector<MatrixEntry> entries;
  for (PetscInt node = beam.begin(); node < beam.end(); ++node) {
    if (const PetscInt unknown = numbering.of_node[static_cast<std::size_t>(node)][0]; unknown >= 0) {
      entries.push_back({.row = unknown, .column = unknown, .value = beam.mass(node)});
    }
  }
  return entries;
}

void write_places(const BeamChain& beam, const Numbering& numbering, const std::string& path) {
  int rank = 0;
  MPI_Comm_rank(beam.comm(), &rank);
  std::string fault;
  if (rank == 0) {
    std::ofstream file{path};
    file << "x,y,z,direction\n" << std::setprecision(17);
    for (PetscInt node = 0; node < beam.nodes(); ++node) {
      const auto& [displacement, rotation] = numbering.of_node[static_cast<std::size_t>(node)];
      for (const auto& [unknown, direction] : {std::pair{displacement, Direction::y}, {rotation, Direction::other}}) {
        if (unknown >= 0) {
          file << beam.position(node) << ",0,0," << static_cast<int>(direction) << '\n';
        }
      }
    }
    file.close();
    fault = file ? std::string{} : "'" + path + "' cannot be written";
  }
  throw_together<FileError>(beam.comm(), fault);
}

}  // namespace

double shear_ratio(const BeamElement& element) {
  return 12.0 * element.shear_compliance / (element.flexural_compliance * element.length * element.length);
}

HermiteElement hermite_element(const BeamElement& element, double tension) {
  if (!std::isfinite(element.flexural_compliance)) {
    return {};
  }
  const double h = element.length;
  const double ratio = shear_ratio(element);
  const double base = 1.0 / (element.flexural_compliance * h * h * h * (1.0 + ratio));
  return {.side = 12.0 * base + tension / h,
          .cross = 6.0 * h * base,
          .diagonal = (4.0 + ratio) * h * h * base,
          .coupling = (2.0 - ratio) * h * h * base};
}

void write_beam_matrices(const BeamChain& beam, const std::string& prefix) {
  const Numbering numbering{beam};
  const PetscInt size = numbering.unknowns;
  const petsc::Matrix stiffness = matrix_of(beam.comm(), size, size, stiffness_of(beam, numbering));
  const petsc::Matrix mass = matrix_of(beam.comm(), size, size, mass_of(beam, numbering));
  write_matrix(stiffness, prefix + "-stiffness.mtx");
  write_matrix(mass, prefix + "-mass.mtx");
  write_places(beam, numbering, prefix + "-points.csv");
}

}  // namespace udar
