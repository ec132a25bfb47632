#include "udar/filter/network_solver.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <string>

#include "udar/petsc/error.hpp"

extern "C" {
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dpotri_(const char* uplo, const int* n, double* a, const int* lda, int* info);
}

namespace udar {
namespace {

using network::Block;
using network::JunctionSystem;
using network::kLanes;
using Real = long double;
using Matrix3 = std::array<std::array<Real, 3>, 3>;

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

std::array<double, 3> triple(const Place& place) { return {place.x, place.y, place.z}; }

/// From values of a junction, displacement and rotation in global axes, to those of a member's end in its own.
std::array<std::array<Real, 6>, 6> to_end(const Axes& axes, const Place& offset) {
  // u_end = u + theta x o
  const Real x = offset.x;
  const Real y = offset.y;
  const Real z = offset.z;
  const Matrix3 arm{{{0, z, -y}, {-z, 0, x}, {y, -x, 0}}};
  std::array<std::array<Real, 6>, 6> all{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      all[i][k] = all[3 + i][3 + k] = axes[i][k];
      for (std::size_t m = 0; m < 3; ++m) {
        all[i][3 + k] += static_cast<Real>(axes[i][m]) * arm[m][k];
      }
    }
  }
  return all;
}

/// The local points of a column as three directions.
template <class Number>
network::Triple<Number> triple_of(Number* values, std::size_t nodes) {
  return values == nullptr ? network::Triple<Number>{}
                           : network::Triple<Number>{.x = values + nodes, .y = values, .z = values + 2 * nodes};
}

}  // namespace

NetworkSolver::NetworkSolver(const Network& network, double filter_frequency)
    : network_{&network}, wf2_{filter_frequency * filter_frequency} {
  MPI_Comm_rank(network.comm(), &rank_);
  MPI_Comm_size(network.comm(), &ranks_);
  for (const MemberKind& kind : network.kinds()) {
    tables_.emplace_back(network.parameters().sections[kind.section], kind, filter_frequency);
    report_.table_bytes += tables_.back().inner() * 23 * sizeof(double);
  }
  number_junctions();
  factor();
  build_packs();
  report_.packs = packs_.size();
  report_.kinds = tables_.size();
  report_.junctions = junctions_.size();
  report_.interface = interface_.size();
  report_.own_interface = junctions_.size() - inner_;
  report_.factor_blocks = system_->factor_blocks();
  report_.factor_bytes = system_->factor_bytes();
}

/// Who meets where.
void NetworkSolver::number_junctions() {
  const NetworkParameters& parameters = network_->parameters();
  const std::size_t count = parameters.junctions.size();
  const auto ranks = static_cast<std::size_t>(ranks_);
  std::vector<std::vector<int>> at(count);  // ranks with members there
  for (std::size_t member = 0; member < parameters.members.size(); ++member) {
    for (const MemberEnd& end : parameters.members[member].ends) {
      at[end.junction].push_back(network_->member_ranks()[member]);
    }
  }
  owned_ = touched_ = {.counts = std::vector<int>(ranks), .starts = {}, .interface = {}};
  std::vector<std::vector<std::size_t>> owned(ranks);
  std::vector<std::vector<std::size_t>> touched(ranks);
  std::vector<std::size_t> shared;  // local
  for (std::size_t junction = 0; junction < count; ++junction) {
    std::vector<int>& who = at[junction];
    const int owner = network_->junction_ranks()[junction];
    who.push_back(owner);
    std::ranges::sort(who);
    who.erase(std::ranges::unique(who).begin(), who.end());
    const bool mine = std::ranges::binary_search(who, rank_);
    if (who.size() > 1) {
      owned[static_cast<std::size_t>(owner)].push_back(interface_.size());
      for (const int rank : who) {
        touched[static_cast<std::size_t>(rank)].push_back(interface_.size());
      }
      interface_.push_back(junction);
      if (mine) {
        shared.push_back(junction);
      }
    } else if (mine) {
      junctions_.push_back(junction);
    }
  }
  inner_ = junctions_.size();
  junctions_.insert(junctions_.end(), shared.begin(), shared.end());
  local_.assign(count, kNone);
  for (std::size_t i = 0; i < junctions_.size(); ++i) {
    local_[junctions_[i]] = i;
  }
  for (auto& [exchange, lists] : {std::pair{&owned_, &owned}, std::pair{&touched_, &touched}}) {
    for (std::size_t rank = 0; rank < ranks; ++rank) {
      exchange->counts[rank] = static_cast<int>((*lists)[rank].size());
      exchange->starts.push_back(static_cast<int>(exchange->interface.size()));
      exchange->interface.insert(exchange->interface.end(), (*lists)[rank].begin(), (*lists)[rank].end());
    }
  }
}

void NetworkSolver::build_packs() {
  const NetworkParameters& parameters = network_->parameters();
  for (const MemberPack& given : network_->packs()) {
    network::Placement pack;
    pack.first = given.first;
    pack.lanes = given.lanes;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::size_t number = given.member[std::min(lane, given.lanes - 1)];
      const Member& member = parameters.members[number];
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
          pack.axes[i][k][lane] = network_->axes(number)[i][k];
        }
      }
      for (std::size_t end = 0; end < 2; ++end) {
        pack.slot[end][lane] = system_->place(local_[member.ends[end].junction]);
        const std::array<double, 3> offset = triple(member.ends[end].offset);
        for (std::size_t i = 0; i < 3; ++i) {
          pack.offset[end][i][lane] = offset[i];
          pack.offsets = pack.offsets || offset[i] != 0.0;
        }
      }
    }
    report_.members += given.lanes;
    packs_.push_back(pack);
  }
}

std::vector<Block> NetworkSolver::member_blocks() const {
  std::vector<Block> blocks;
  std::vector<std::array<std::array<Real, 12>, 12>> stiffness;
  for (const network::MemberTables& tables : tables_) {
    stiffness.push_back(tables.end_stiffness());
  }
  const NetworkParameters& parameters = network_->parameters();
  for (const MemberPack& pack : network_->packs()) {
    const auto& k = stiffness[pack.kind];
    for (std::size_t lane = 0; lane < pack.lanes; ++lane) {
      const Member& member = parameters.members[pack.member[lane]];
      std::array<std::array<std::array<Real, 6>, 6>, 2> t;
      for (std::size_t end = 0; end < 2; ++end) {
        t[end] = to_end(network_->axes(pack.member[lane]), member.ends[end].offset);
      }
      for (const auto& [a, b] : {std::pair{0, 0}, std::pair{1, 1}, std::pair{0, 1}}) {
        const auto row = static_cast<std::size_t>(a);
        const auto column = static_cast<std::size_t>(b);
        Block block{.row = local_[member.ends[row].junction], .column = local_[member.ends[column].junction]};
        std::array<std::array<Real, 6>, 6> half{};  // k t
        for (std::size_t i = 0; i < 6; ++i) {
          for (std::size_t l = 0; l < 6; ++l) {
            for (std::size_t m = 0; m < 6; ++m) {
              half[i][l] += k[6 * row + i][6 * column + m] * t[column][m][l];
            }
          }
        }
        for (std::size_t i = 0; i < 6; ++i) {
          for (std::size_t l = 0; l < 6; ++l) {
            for (std::size_t m = 0; m < 6; ++m) {
              block.value[i][l] += t[row][m][i] * half[m][l];
            }
          }
        }
        blocks.push_back(block);
      }
    }
  }
  return blocks;
}

/// Masses and springs of the junctions that are this rank's.
void NetworkSolver::add_grounds(std::vector<Block>& blocks) const {
  const std::span<const double> mass = network_->points().mass();
  const std::vector<std::size_t>& own = network_->own_junctions();
  for (std::size_t i = 0; i < own.size(); ++i) {
    const Junction& junction = network_->parameters().junctions[own[i]];
    Block block{.row = local_[own[i]], .column = local_[own[i]]};
    for (std::size_t k = 0; k < 3; ++k) {
      block.value[k][k] = static_cast<Real>(wf2_) * mass[i] + junction.stiffness[k];
      block.value[3 + k][3 + k] = junction.stiffness[3 + k];
    }
    blocks.push_back(block);
  }
  for (const RotationSpring& spring : network_->rotation_springs()) {
    if (network_->junction_ranks()[spring.junction] == rank_) {
      Block block{.row = local_[spring.junction], .column = local_[spring.junction]};
      const std::array<double, 3> axis = triple(spring.axis);
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
          block.value[3 + i][3 + k] = static_cast<Real>(spring.stiffness) * axis[i] * axis[k];
        }
      }
      blocks.push_back(block);
    }
  }
}

/// Unknowns that never move become rows of the identity.
void NetworkSolver::hold(std::vector<Block>& blocks) {
  for (const std::size_t junction : junctions_) {
    held_.push_back(network_->parameters().junctions[junction].held);
  }
  for (Block& block : blocks) {
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t k = 0; k < 6; ++k) {
        if (held_[block.row][i] || held_[block.column][k]) {
          block.value[i][k] = 0;
        }
      }
    }
  }
  for (std::size_t j = 0; j < junctions_.size(); ++j) {
    Block block{.row = j, .column = j};
    for (std::size_t i = 0; i < 6; ++i) {
      block.value[i][i] = held_[j][i] ? 1 : 0;
    }
    blocks.push_back(block);
  }
}

void NetworkSolver::factor() {
  static constexpr std::array kUnknowns{"displacement along x", "displacement along y", "displacement along z",
                                        "rotation about x",     "rotation about y",     "rotation about z"};
  std::vector<Block> blocks = member_blocks();
  add_grounds(blocks);
  hold(blocks);
  std::string failure;
  try {
    system_ = std::make_unique<JunctionSystem>(junctions_.size(), blocks, junctions_.size() - inner_);
  } catch (const JunctionSystem::Loose& loose) {
    const Junction& junction = network_->parameters().junctions[junctions_[loose.block]];
    failure = "junction " + (junction.name.empty() ? std::to_string(junctions_[loose.block]) : junction.name) +
              ": nothing holds its " + kUnknowns[loose.unknown] + ": the structure is a mechanism";
  }
  throw_together<InputError>(network_->comm(), failure);
  if (!interface_.empty()) {
    invert_interface();
  }
}

/// The Schur complements of all ranks add up; rank 0 inverts, so that all have the same bits.
void NetworkSolver::invert_interface() {
  const std::size_t rows = 6 * interface_.size();
  const std::size_t own = 6 * (junctions_.size() - inner_);
  std::vector<double> sum(rows * rows, 0.0);
  const auto first = static_cast<std::size_t>(touched_.starts[static_cast<std::size_t>(rank_)]);
  const auto row_of = [&](std::size_t local) { return 6 * touched_.interface[first + local / 6] + local % 6; };
  for (std::size_t i = 0; i < own; ++i) {
    for (std::size_t k = 0; k < own; ++k) {
      sum[row_of(i) * rows + row_of(k)] = system_->schur()[i * own + k];
    }
  }
  const auto size = static_cast<int>(rows * rows);
  MPI_Reduce(rank_ == 0 ? MPI_IN_PLACE : sum.data(), sum.data(), size, MPI_DOUBLE, MPI_SUM, 0, network_->comm());
  int info = 0;
  if (rank_ == 0) {
    const auto n = static_cast<int>(rows);
    dpotrf_("L", &n, sum.data(), &n, &info);
    if (info == 0) {
      dpotri_("L", &n, sum.data(), &n, &info);
    }
    for (std::size_t i = 0; i < rows; ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        sum[i * rows + k] = sum[k * rows + i];
      }
    }
  }
  MPI_Bcast(&info, 1, MPI_INT, 0, network_->comm());
  if (info != 0) {
    throw InputError{"network: nothing holds an unknown where ranks meet: the structure is a mechanism"};
  }
  MPI_Bcast(sum.data(), size, MPI_DOUBLE, 0, network_->comm());
  inverse_.resize(own * rows);
  for (std::size_t i = 0; i < own; ++i) {
    std::copy_n(sum.begin() + static_cast<std::ptrdiff_t>(row_of(i) * rows), rows,
                inverse_.begin() + static_cast<std::ptrdiff_t>(i * rows));
  }
}

void NetworkSolver::solve(std::span<const FilterColumn> columns, std::span<const double> load) {
  while (!columns.empty()) {
    const std::size_t batch = std::min(columns.size(), JunctionSystem::kBatch);
    const std::size_t loads = load.empty() ? 0 : 6 * junctions_.size() * batch;
    solve_batch(columns.first(batch), load.first(loads));
    columns = columns.subspan(batch);
    load = load.subspan(loads);
  }
}

void NetworkSolver::solve_batch(std::span<const FilterColumn> columns, std::span<const double> load) {
  find_places(columns);
  load_own(columns);
  for (std::size_t i = 0; i < load.size(); ++i) {
    const std::size_t c = i / (6 * junctions_.size());
    const std::size_t junction = i / 6 % junctions_.size();
    values_[(system_->place(junction) * columns.size() + c) * JunctionSystem::kPitch + i % 6] += load[i];
  }
  condense_members(columns);
  solve_junctions(columns.size());
  resolve_members(columns);
  const std::size_t points = network_->points().coordinates();
  for (const FilterColumn& column : columns) {
    for (std::size_t i = 0; column.internal != nullptr && i < points; ++i) {
      column.internal[points + i] = column.displacement[i] + column.stretch[i];
    }
  }
}

void NetworkSolver::take_moments(std::span<double> rotation, std::span<double> load) const {
  const auto turned = triple_of(rotation.data(), network_->nodes());
  const std::vector<std::size_t>& own = network_->own_junctions();
  for (std::size_t i = 0; i < own.size(); ++i) {
    std::size_t k = 6 * local_[own[i]] + 3;
    for (double* about : {turned.x, turned.y, turned.z}) {
      load[k++] += about[i];
      about[i] = 0.0;
    }
  }
}

/// Displacements of the masses at the local junctions: own ones, and those of the interface from whoever has them.
void NetworkSolver::find_places(std::span<const FilterColumn> columns) {
  const std::size_t nodes = network_->nodes();
  const std::vector<std::size_t>& own = network_->own_junctions();
  places_.resize(junctions_.size() * columns.size() * JunctionSystem::kPitch);
  const auto put = [&](std::size_t c, std::size_t local, const double* from) {
    std::copy_n(from, 3, places_.data() + (system_->place(local) * columns.size() + c) * JunctionSystem::kPitch);
  };
  const auto value = [&](std::size_t c, std::size_t i) {  // of an own junction
    const auto given = triple_of(columns[c].displacement, nodes);
    return std::array{given.x[i], given.y[i], given.z[i]};
  };
  for (std::size_t c = 0; c < columns.size(); ++c) {
    for (std::size_t i = 0; i < own.size(); ++i) {
      put(c, local_[own[i]], value(c, i).data());
    }
  }
  if (interface_.empty()) {
    return;
  }
  const std::size_t width = 3 * columns.size();
  const auto rank = static_cast<std::size_t>(rank_);
  shown_.clear();
  for (int k = 0; k < owned_.counts[rank]; ++k) {
    const std::size_t junction = interface_[owned_.interface[static_cast<std::size_t>(owned_.starts[rank] + k)]];
    const auto i = static_cast<std::size_t>(std::ranges::lower_bound(own, junction) - own.begin());
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const auto place = value(c, i);
      shown_.insert(shown_.end(), place.begin(), place.end());
    }
  }
  gather(owned_, width);
  for (std::size_t k = 0; k < owned_.interface.size(); ++k) {
    if (const std::size_t local = local_[interface_[owned_.interface[k]]]; local != kNone) {
      for (std::size_t c = 0; c < columns.size(); ++c) {
        put(c, local, gathered_.data() + k * width + 3 * c);
      }
    }
  }
}

/// All ranks' `shown_` into `gathered_`, `width` numbers a junction.
void NetworkSolver::gather(const Exchange& exchange, std::size_t width) {
  std::vector<int> counts = exchange.counts;
  std::vector<int> starts = exchange.starts;
  for (std::size_t rank = 0; rank < counts.size(); ++rank) {
    counts[rank] *= static_cast<int>(width);
    starts[rank] *= static_cast<int>(width);
  }
  gathered_.resize(exchange.interface.size() * width);
  MPI_Allgatherv(shown_.data(), static_cast<int>(shown_.size()), MPI_DOUBLE, gathered_.data(), counts.data(),
                 starts.data(), MPI_DOUBLE, network_->comm());
}

/// Forces on the own junctions, and those of their springs to the ground.
void NetworkSolver::load_own(std::span<const FilterColumn> columns) {
  const std::size_t width = columns.size() * JunctionSystem::kPitch;
  values_.assign(junctions_.size() * width, 0.0);
  const std::vector<std::size_t>& own = network_->own_junctions();
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const auto force = triple_of(columns[c].force, network_->nodes());
    for (std::size_t i = 0; i < own.size(); ++i) {
      const std::size_t at = system_->place(local_[own[i]]) * width + c * JunctionSystem::kPitch;
      double* to = values_.data() + at;
      const double* place = places_.data() + at;
      const std::array<double, 3> given =
          force.x != nullptr ? std::array{force.x[i], force.y[i], force.z[i]} : std::array<double, 3>{};
      for (std::size_t k = 0; k < 3; ++k) {
        to[k] = given[k] - network_->parameters().junctions[own[i]].stiffness[k] * place[k];
      }
    }
  }
}

network::Sweep NetworkSolver::sweep_of(std::span<const FilterColumn> columns, std::size_t column) {
  const std::size_t nodes = network_->nodes();
  return {.displacement = triple_of(columns[column].displacement, nodes),
          .force = triple_of(columns[column].force, nodes),
          .place = places_.data() + column * JunctionSystem::kPitch,
          .value = values_.data() + column * JunctionSystem::kPitch,
          .pitch = columns.size() * JunctionSystem::kPitch,
          .stretch = triple_of(columns[column].stretch, nodes),
          .rotation = triple_of(columns[column].internal, nodes)};
}

void NetworkSolver::condense_members(std::span<const FilterColumn> columns) {
  condensed_.resize(packs_.size() * columns.size());
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const network::Sweep sweep = sweep_of(columns, c);
    for (std::size_t p = 0; p < packs_.size(); ++p) {
      network::condense(tables_[network_->packs()[p].kind], packs_[p], sweep, condensed_[c * packs_.size() + p]);
    }
  }
}

void NetworkSolver::solve_junctions(std::size_t columns) {
  const std::size_t width = columns * JunctionSystem::kPitch;
  for (std::size_t j = 0; j < junctions_.size(); ++j) {
    for (std::size_t k = 0; k < 6; ++k) {
      for (std::size_t c = 0; held_[j][k] && c < columns; ++c) {
        values_[system_->place(j) * width + c * JunctionSystem::kPitch + k] = 0.0;
      }
    }
  }
  system_->forward(values_, columns);
  if (!interface_.empty()) {
    solve_interface(columns);
  }
  system_->backward(values_, columns);
}

/// Every rank adds up what all show in the order of the ranks, and takes its rows of the inverse.
void NetworkSolver::solve_interface(std::size_t columns) {
  const std::size_t width = columns * JunctionSystem::kPitch;
  const std::size_t shown = 6 * columns;
  shown_.clear();
  for (std::size_t j = inner_; j < junctions_.size(); ++j) {
    for (std::size_t c = 0; c < columns; ++c) {
      const double* from = values_.data() + system_->place(j) * width + c * JunctionSystem::kPitch;
      shown_.insert(shown_.end(), from, from + 6);
    }
  }
  gather(touched_, shown);
  const std::size_t rows = 6 * interface_.size();
  sums_.assign(rows * columns, 0.0);
  for (std::size_t k = 0; k < touched_.interface.size(); ++k) {
    for (std::size_t c = 0; c < columns; ++c) {
      for (std::size_t i = 0; i < 6; ++i) {
        sums_[c * rows + 6 * touched_.interface[k] + i] += gathered_[k * shown + 6 * c + i];
      }
    }
  }
  for (std::size_t j = inner_; j < junctions_.size(); ++j) {
    for (std::size_t c = 0; c < columns; ++c) {
      double* to = values_.data() + system_->place(j) * width + c * JunctionSystem::kPitch;
      for (std::size_t i = 0; i < 6; ++i) {
        const double* row = inverse_.data() + (6 * (j - inner_) + i) * rows;
        to[i] = std::inner_product(row, row + rows, sums_.begin() + static_cast<std::ptrdiff_t>(c * rows), 0.0);
      }
    }
  }
}

void NetworkSolver::resolve_members(std::span<const FilterColumn> columns) {
  const std::vector<std::size_t>& own = network_->own_junctions();
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const network::Sweep sweep = sweep_of(columns, c);
    for (std::size_t i = 0; i < own.size(); ++i) {
      const double* from = sweep.value + system_->place(local_[own[i]]) * sweep.pitch;
      sweep.stretch.x[i] = from[0];
      sweep.stretch.y[i] = from[1];
      sweep.stretch.z[i] = from[2];
      if (sweep.rotation.x != nullptr) {
        sweep.rotation.x[i] = from[3];
        sweep.rotation.y[i] = from[4];
        sweep.rotation.z[i] = from[5];
      }
    }
    for (std::size_t p = 0; p < packs_.size(); ++p) {
      network::resolve(tables_[network_->packs()[p].kind], packs_[p], sweep, condensed_[c * packs_.size() + p]);
    }
  }
}

}  // namespace udar
