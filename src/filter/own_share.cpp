#include "udar/filter/own_share.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
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

/// Solves for points of all ranks, several at once. @param own how many ranks before this have @param all of all ranks
/// @return the share of each of them
std::vector<double> probed(FilteredStructure& structure, std::span<const std::size_t> points, PetscInt own,
                           PetscInt all) {
  constexpr PetscInt kTogether = 8;
  const std::size_t count = structure.mass().size();
  std::vector<double> displacement(static_cast<std::size_t>(kTogether) * count);
  std::vector<double> stretch(displacement.size());
  std::vector<double> shares(static_cast<std::size_t>(all), 0.0);
  for (PetscInt first = 0; first < all; first += kTogether) {
    const auto columns = static_cast<std::size_t>(std::min(kTogether, all - first));
    std::vector<FilterColumn> batch;
    std::ranges::fill(displacement, 0.0);
    const auto local = [&](std::size_t c) { return first + static_cast<PetscInt>(c) - own; };
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
        shares[static_cast<std::size_t>(first) + c] =
            1.0 + stretch[c * count + points[static_cast<std::size_t>(local(c))]];
      }
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, shares.data(), static_cast<int>(shares.size()), MPI_DOUBLE, MPI_MAX,
                structure.points().comm());
  return shares;
}

/// A number between 0 and 1 that tells nothing of the point but is its own on any number of ranks (splitmix64).
double scattered(const MassPoints& points, std::size_t point) {
  auto bits =
      static_cast<std::uint64_t>(points.number(point)) * 4 + static_cast<std::uint64_t>(points.direction(point));
  bits += 0x9e3779b97f4a7c15U;
  bits = (bits ^ (bits >> 30U)) * 0xbf58476d1ce4e5b9U;
  bits = (bits ^ (bits >> 27U)) * 0x94d049bb133111ebU;
  return std::ldexp(static_cast<double>(bits ^ (bits >> 31U)), -64);
}

}  // namespace

std::vector<float> own_shares(FilteredStructure& structure, std::span<const std::size_t> points) {
  std::vector<float> shares;
  if (const BeamChain* chain = structure.structure().chain(); chain != nullptr && structure.points().of_nodes_alone()) {
    for (const std::size_t point : points) {
      shares.push_back(static_cast<float>(share_of_chain(*chain, structure.filter_frequency(), point)));
    }
    return shares;
  }
  constexpr PetscInt kProbes = 256;
  constexpr double kEnd = 4.0;                  // what an end of a beam takes on beside its middle
  const auto over_ranks = [&](PetscInt mine) {  // of all, of those before this one
    std::array<PetscInt, 2> sum{};
    MPI_Allreduce(&mine, sum.data(), 1, MPIU_INT, MPI_SUM, structure.points().comm());
    MPI_Scan(&mine, &sum[1], 1, MPIU_INT, MPI_SUM, structure.points().comm());
    return std::array{sum[0], sum[1] - mine};
  };
  const auto [all, before] = over_ranks(static_cast<PetscInt>(points.size()));
  if (all <= kProbes) {
    const std::vector<double> found = probed(structure, points, before, all);
    shares.assign(found.begin() + before, found.begin() + before + static_cast<PetscInt>(points.size()));
    return shares;
  }
  std::vector<std::size_t> chosen;
  const double part = static_cast<double>(kProbes) / static_cast<double>(all);
  std::ranges::copy_if(points, std::back_inserter(chosen),
                       [&](std::size_t point) { return scattered(structure.points(), point) < part; });
  const auto [probes, own] = over_ranks(static_cast<PetscInt>(chosen.size()));
  const std::vector<double> found = probed(structure, chosen, own, probes);
  const double most = found.empty() ? 1.0 : std::ranges::max(found);
  shares.assign(points.size(), static_cast<float>(std::min(1.0, kEnd * most)));
  return shares;
}

}  // namespace udar
