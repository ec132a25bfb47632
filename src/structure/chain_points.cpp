#include "chain_points.hpp"

#include <cmath>

namespace udar {
namespace {

std::vector<double> masses_of(const BeamChain& beam) {
  std::vector<double> mass;
  mass.reserve(static_cast<std::size_t>(beam.local_nodes()));
  for (PetscInt node = beam.begin(); node < beam.end(); ++node) {
    mass.push_back(beam.mass(node));
  }
  return mass;
}

std::vector<std::size_t> fixed_of(const BeamChain& beam) {
  std::vector<std::size_t> fixed;
  for (PetscInt node = beam.begin(); node < beam.end(); ++node) {
    if (beam.fixed(node)) {
      fixed.push_back(static_cast<std::size_t>(node - beam.begin()));
    }
  }
  return fixed;
}

class ChainPoints final : public MassPoints {
 public:
  explicit ChainPoints(const BeamChain& beam)
      : MassPoints{beam.comm(), 1, masses_of(beam), fixed_of(beam)}, beam_{&beam} {}

  [[nodiscard]] Place place(std::size_t point) const override { return {.x = beam_->position(global(point))}; }
  [[nodiscard]] Extent extent() const override { return {.from = 0.0, .to = beam_->length()}; }
  [[nodiscard]] double total_mass() const override { return beam_->total_mass(); }
  [[nodiscard]] PetscInt nearest(const Place& place) const override { return beam_->nearest_node(place.x); }

  [[nodiscard]] PointRows within(const Region& region, const Facing& facing) const override {
    PointRows rows;
    if (!meets(region, facing)) {
      return rows;
    }
    const Extent beam = extent();
    const auto [first, last] = beam_->nodes_within(std::isinf(region.from.x) ? beam.from : region.from.x,
                                                   std::isinf(region.to.x) ? beam.to : region.to.x);
    if (first <= last) {
      rows.count = last - first + 1;
      rows.mass = beam_->mass_of({.first = first, .last = last});
      const PetscInt begin = std::max(first, this->begin());
      const PetscInt end = std::min(last + 1, this->end());
      if (begin < end) {
        rows.rows.push_back({.first = static_cast<std::size_t>(begin - this->begin()),
                             .last = static_cast<std::size_t>(end - this->begin())});
      }
    }
    return rows;
  }

  [[nodiscard]] PointRows section(double x, const Region& region, const Facing& facing) const override {
    return meets(region, facing) ? single(beam_->nearest_node(x)) : PointRows{};
  }

  [[nodiscard]] std::vector<PointShare> lever(const Place& place) const override {
    const auto [near, far] = beam_->lever(place.x);
    std::vector<PointShare> shares{{.point = near.node, .share = near.share}};
    if (far.share > 0.0) {
      shares.push_back({.point = far.node, .share = far.share});
    }
    return shares;
  }

 private:
  /// All lie on y = z = 0 and move up.
  [[nodiscard]] static bool meets(Region region, const Facing& facing) {
    region.from.x = region.to.x = 0.0;
    return facing.normal.y == 1.0 && !facing.field && region.holds({});
  }

  const BeamChain* beam_;
};

}  // namespace

std::unique_ptr<const MassPoints> points_of(const BeamChain& beam) { return std::make_unique<ChainPoints>(beam); }

}  // namespace udar
