#include "udar/app/memory_size.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "udar/petsc/error.hpp"
#include "udar/petsc/memory.hpp"
#include "udar/petsc/session.hpp"

namespace udar::app {
namespace {

// Peaks of resident memory, rounded down (`peak_memory_bytes` in summary.json). A node of a beam: 463 bytes between
// `-beam_elements 200000` and 400000 on a floor. An inner node of a network: 1535 and 1691 bytes in a lattice 12,12,12
// between `-network_elements` 2, 20 and 60. A junction with what hangs on it: 16 kB in a grillage 30,30 of 2 elements,
// 38 to 50 kB in lattices of 5,5,5 to 20,20,20, where the factor fills.
constexpr double kBeamNode = 460.0;
constexpr double kNetworkNode = 1500.0;
constexpr double kJunction = 10000.0;
// Of what every rank has of the whole network: `Junction` and `Member` with their names.
constexpr double kJunctionCopy = sizeof(Junction) + 32.0;
constexpr double kMemberCopy = sizeof(Member) + 32.0;
// A row of impulses, with its place in a list.
constexpr double kRowBytes = 64.0;
// PETSc's arrays and vectors of a row of an imported matrix.
constexpr double kUnknown = 100.0;

ModelSize model_size_of(const NetworkParameters& network) {
  ModelSize size{.junctions = static_cast<double>(network.junctions.size()),
                 .members = static_cast<double>(network.members.size())};
  for (const Member& member : network.members) {
    size.inner_nodes += static_cast<double>(member.elements) - 1.0;
  }
  return size;
}

}  // namespace

double memory_of(const ModelSize& size, int ranks) {
  return kBeamNode * size.beam_nodes + kNetworkNode * size.inner_nodes + kJunction * size.junctions +
         static_cast<double>(ranks - 1) * (kJunctionCopy * size.junctions + kMemberCopy * size.members) +
         static_cast<double>(ranks) * size.row_bytes;
}

void refuse_large_memory(MPI_Comm comm, const std::string& what, const ModelSize& size, double most) {
  if (petsc::Session::help_requested()) {
    return;
  }
  int ranks = 1;
  MPI_Comm_size(comm, &ranks);
  const double needed = memory_of(size, ranks);
  const double allowed = most > 0.0 ? most : petsc::available_memory(comm);
  if (needed <= allowed) {
    return;
  }
  std::array<char, 320> text{};
  std::snprintf(text.data(), text.size(),
                " is not allowed, it asks for at least %.3g GB of memory where %s %.3g GB; expected less, or "
                "-structure_memory, the bytes that the run may take",
                needed / 1e9, most > 0.0 ? "-structure_memory allows" : "the machines have", allowed / 1e9);
  throw InputError{what + text.data()};
}

void refuse_large_network(MPI_Comm comm, const std::string& what, const NetworkParameters& network, double most) {
  const ModelSize size = model_size_of(network);
  constexpr auto kCountable = static_cast<double>(std::numeric_limits<PetscInt>::max());
  if (3.0 * (size.junctions + size.inner_nodes) >= kCountable) {
    throw InputError{what + ": the network has more nodes than integers of " + std::to_string(8 * sizeof(PetscInt)) +
                     " bits count"};
  }
  refuse_large_memory(comm, what, size, most);
}

PetscInt most_unknowns(MPI_Comm comm, double most) {
  constexpr auto kCountable = static_cast<double>(std::numeric_limits<PetscInt>::max());
  const double allowed = most > 0.0 ? most : petsc::available_memory(comm);
  return static_cast<PetscInt>(std::min(kCountable, allowed / kUnknown));
}

void refuse_large_memory(MPI_Comm comm, const CaseInput& input) {
  const double most = input.structure.memory;
  if (input.structure.beam()) {
    ModelSize size;
    for (const BeamSegment& segment : input.beam.beam.segments) {
      size.beam_nodes += static_cast<double>(segment.elements);
    }
    std::array<char, 64> what{};
    std::snprintf(what.data(), what.size(), "option -beam_elements: %.10g", size.beam_nodes);
    refuse_large_memory(comm, what.data(), size, most);
  }
  const OutputParameters& output = input.output.output;
  const double rows = std::ceil(std::min(output.force_window, input.time.end) / output.interval);
  std::array<char, 64> what{};
  std::snprintf(what.data(), what.size(), "option -output_force_window: %g", output.force_window);
  refuse_large_memory(comm, what.data(),
                      {.row_bytes = rows * (kRowBytes + 8.0 * static_cast<double>(input.contact.supports.size()))},
                      most);
}

}  // namespace udar::app
