#include "udar/filter/own_share.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace udar {
namespace {

double share_of_chain(const BeamChain& beam, double frequency, std::size_t node) {
  const PetscInt global = beam.begin() + static_cast<PetscInt>(node);
  double compliance = std::numeric_limits<double>::infinity();
  double length = 0.0;
  bool end = false;
  for (const BeamElement& element : {beam.element(global - 1), beam.element(global)}) {
    const bool present = std::isfinite(element.flexural_compliance);
    compliance = std::min(compliance, element.flexural_compliance);
    length += present ? 0.5 * element.length : 0.0;
    end = end || !present;
  }
  const double bed = beam.mass(global) * frequency * frequency / length;
  const double decay = std::sqrt(std::sqrt(4.0 / (compliance * bed)));
  return std::min(1.0, (end ? 2.0 : 0.5) * length / decay);
}

/// Solves for the `which`-th of all ranks' points, several at once. @param own the first of this rank's among them
std::vector<double> probed(FilteredStructure& structure, std::span<const std::size_t> points, PetscInt own,
                           std::span<const PetscInt> which) {
  constexpr std::size_t kTogether = 8;
  const std::size_t count = structure.mass().size();
  std::vector<double> displacement(kTogether * count);
  std::vector<double> stretch(kTogether * count);
  std::vector<double> shares(which.size(), 0.0);
  for (std::size_t first = 0; first < which.size(); first += kTogether) {
    const std::size_t columns = std::min(kTogether, which.size() - first);
    std::vector<FilterColumn> batch;
    std::ranges::fill(displacement, 0.0);
    const auto local = [&](std::size_t c) { return which[first + c] - own; };
    const auto mine = [&](std::size_t c) { return local(c) >= 0 && local(c) < static_cast<PetscInt>(points.size()); };
    for (std::size_t c = 0; c < columns; ++c) {
      batch.push_back({.displacement = displacement.data() + c * count, .stretch = stretch.data() + c * count});
      if (mine(c)) {
        displacement[c * count + points[static_cast<std::size_t>(local(c))]] = 1.0;
      }
    }
    structure.solve(batch);
    for (std::size_t c = 0; c < columns; ++c) {
      if (mine(c)) {
        shares[first + c] = 1.0 + stretch[c * count + points[static_cast<std::size_t>(local(c))]];
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, shares.data(), static_cast<int>(shares.size()), MPI_DOUBLE, MPI_MAX,
                structure.points().comm());
  return shares;
}

}  // namespace

std::vector<float> own_shares(FilteredStructure& structure, std::span<const std::size_t> points) {
  std::vector<float> shares;
  if (const BeamChain* chain = structure.structure().chain(); chain != nullptr) {
    for (const std::size_t point : points) {
      shares.push_back(static_cast<float>(share_of_chain(*chain, structure.filter_frequency(), point)));
    }
    return shares;
  }
  constexpr PetscInt kMostProbes = 256;
  constexpr double kEnd = 4.0;  // what an end of a beam takes on beside its middle
  const auto count = static_cast<PetscInt>(points.size());
  PetscInt all = 0;
  PetscInt own = 0;
  MPI_Scan(&count, &own, 1, MPIU_INT, MPI_SUM, structure.points().comm());
  own -= count;
  MPI_Allreduce(&count, &all, 1, MPIU_INT, MPI_SUM, structure.points().comm());
  std::vector<PetscInt> which;
  which.reserve(static_cast<std::size_t>(kMostProbes));
  for (PetscInt probe = 0; probe < std::min(all, kMostProbes); ++probe) {
    which.push_back(all <= kMostProbes ? probe : probe * (all - 1) / (kMostProbes - 1));
  }
  const std::vector<double> found = probed(structure, points, own, which);
  if (all <= kMostProbes) {
    shares.assign(found.begin() + own, found.begin() + own + count);
  } else {
    shares.assign(points.size(), static_cast<float>(std::min(1.0, kEnd * std::ranges::max(found))));
  }
  return shares;
}

}  // namespace udar
