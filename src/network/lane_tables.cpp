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

TurningView<double> turning_of(const MemberTables& tables) {
  const AxialTable& turning = tables.turning();
  return {.weights = turning.weights.data(),
          .releases = turning.releases.data(),
          .keeps = turning.keeps.data(),
          .elements = tables.spacing().elements.data(),
          .nodes = tables.spacing().nodes.data()};
}

TurningView<Lanes> LaneTables::turning() const {
  return {.weights = turning_.weights.data(),
          .releases = turning_.releases.data(),
          .keeps = turning_.keeps.data(),
          .elements = spacing_.elements.data(),
          .nodes = spacing_.nodes.data()};
}

TableView<Lanes> LaneTables::view() const {
  return {.gains = {gains_[0].data(), gains_[1].data()},
          .weights = {weights_[0].data(), weights_[1].data()},
          .axial_weights = axial_.weights.data(),
          .releases = axial_.releases.data(),
          .keeps = axial_.keeps.data(),
          .elements = spacing_.elements.data(),
          .nodes = spacing_.nodes.data()};
}

void LaneTables::put(const AxialTable& own, std::size_t lane, Rods& all) {
  all.releases.resize(own.releases.size());
  all.keeps.resize(own.keeps.size());
  all.weights.resize(own.weights.size());
  for (std::size_t i = 0; i < own.releases.size(); ++i) {
    all.releases[i][lane] = own.releases[i];
    all.keeps[i][lane] = own.keeps[i];
  }
  for (std::size_t i = 0; i < own.weights.size(); ++i) {
    all.weights[i][0][lane] = own.weights[i][0];
    all.weights[i][1][lane] = own.weights[i][1];
  }
}

LaneTables::LaneTables(std::span<const MemberTables* const, kLanes> tables) {
  const std::size_t inner = tables[0]->inner();
  for (std::size_t plane = 0; plane < 2; ++plane) {
    gains_[plane].resize(inner);
    weights_[plane].resize(inner);
  }
  spacing_.nodes.resize(inner);
  spacing_.elements.resize(inner + 1);
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const MemberTables& own = *tables[lane];
    put(own.axial(), lane, axial_);
    put(own.turning(), lane, turning_);
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
      const Spacing<double>::Node& node = own.spacing().nodes[i];
      spacing_.nodes[i].mass[lane] = node.mass;
      spacing_.nodes[i].inverse[lane] = node.inverse;
      spacing_.nodes[i].place[lane] = node.place;
    }
    for (std::size_t i = 0; i <= inner; ++i) {
      spacing_.elements[i].length[lane] = own.spacing().elements[i].length;
      spacing_.elements[i].inverse[lane] = own.spacing().elements[i].inverse;
    }
  }
}

std::size_t LaneTables::bytes() const noexcept {
  std::size_t bytes =
      spacing_.nodes.size() * sizeof(Spacing<Lanes>::Node) + spacing_.elements.size() * sizeof(Spacing<Lanes>::Element);
  for (const Rods* rods : {&axial_, &turning_}) {
    bytes += (rods->releases.size() + rods->keeps.size() + 2 * rods->weights.size()) * sizeof(Lanes);
  }
  for (std::size_t plane = 0; plane < 2; ++plane) {
    bytes += gains_[plane].size() * sizeof(Gain<Lanes>) + weights_[plane].size() * 4 * sizeof(Lanes);
  }
  return bytes;
}

}  // namespace udar::network
