#include "udar/network/lane_tables.hpp"

namespace udar::network {

TableView<double> view_of(const MemberTables& tables) {
  const AxialTable& axial = tables.axial();
  return {.gains = {tables.bending(0).gains.data(), tables.bending(1).gains.data()},
          .weights = {tables.bending(0).weights.data(), tables.bending(1).weights.data()},
          .axial_weights = axial.weights.data(),
          .releases = axial.releases.data(),
          .keeps = axial.keeps.data(),
          .elements = tables.spacing().elements.data(),
          .nodes = tables.spacing().nodes.data()};
}

TableView<Lanes> LaneTables::view() const {
  return {.gains = {gains_[0].data(), gains_[1].data()},
          .weights = {weights_[0].data(), weights_[1].data()},
          .axial_weights = axial_weights_.data(),
          .releases = releases_.data(),
          .keeps = keeps_.data(),
          .elements = spacing_.elements.data(),
          .nodes = spacing_.nodes.data()};
}

LaneTables::LaneTables(std::span<const MemberTables* const, kLanes> tables) {
  const std::size_t inner = tables[0]->inner();
  for (std::size_t plane = 0; plane < 2; ++plane) {
    gains_[plane].resize(inner);
    weights_[plane].resize(inner);
  }
  releases_.resize(inner);
  keeps_.resize(inner);
  spacing_.nodes.resize(inner);
  axial_weights_.resize(inner + 1);
  spacing_.elements.resize(inner + 1);
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const MemberTables& own = *tables[lane];
    const AxialTable& axial = own.axial();
    for (std::size_t i = 0; i < inner; ++i) {
      for (std::size_t plane = 0; plane < 2; ++plane) {
        const BendingTable& table = own.bending(plane);
        Gain<Lanes>& gain = gains_[plane][i];
        gain.keep[lane] = table.gains[i].keep;
        gain.deflect[lane] = table.gains[i].deflect;
        gain.turn[lane] = table.gains[i].turn;
        gain.release[lane] = table.gains[i].release;
        gain.bend[lane] = table.gains[i].bend;
        for (std::size_t k = 0; k < 4; ++k) {
          weights_[plane][i][k][lane] = table.weights[i][k];
        }
      }
      releases_[i][lane] = axial.releases[i];
      keeps_[i][lane] = axial.keeps[i];
      const Spacing<double>::Node& node = own.spacing().nodes[i];
      spacing_.nodes[i].mass[lane] = node.mass;
      spacing_.nodes[i].inverse[lane] = node.inverse;
      spacing_.nodes[i].place[lane] = node.place;
    }
    for (std::size_t i = 0; i <= inner; ++i) {
      for (std::size_t k = 0; k < 2; ++k) {
        axial_weights_[i][k][lane] = axial.weights[i][k];
      }
      spacing_.elements[i].length[lane] = own.spacing().elements[i].length;
      spacing_.elements[i].inverse[lane] = own.spacing().elements[i].inverse;
    }
  }
}

std::size_t LaneTables::bytes() const noexcept {
  std::size_t bytes = (releases_.size() + keeps_.size()) * sizeof(Lanes) + axial_weights_.size() * 2 * sizeof(Lanes) +
                      spacing_.nodes.size() * sizeof(Spacing<Lanes>::Node) +
                      spacing_.elements.size() * sizeof(Spacing<Lanes>::Element);
  for (std::size_t plane = 0; plane < 2; ++plane) {
    bytes += gains_[plane].size() * sizeof(Gain<Lanes>) + weights_[plane].size() * 4 * sizeof(Lanes);
  }
  return bytes;
}

}  // namespace udar::network
