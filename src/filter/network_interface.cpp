#include "udar/filter/network_interface.hpp"

#include <algorithm>

#include "udar/numerics/positive_inverse.hpp"

namespace udar {

NetworkInterface::NetworkInterface(const Network& network) : network_{&network} {
  const NetworkParameters& parameters = network.parameters();
  int size = 1;
  MPI_Comm_size(network.comm(), &size);
  const auto ranks = static_cast<std::size_t>(size);
  std::vector<std::vector<int>> at(parameters.junctions.size());  // ranks with members there, and the owner
  for (std::size_t member = 0; member < parameters.members.size(); ++member) {
    for (const MemberEnd& end : parameters.members[member].ends) {
      at[end.junction].push_back(network.member_ranks()[member]);
    }
  }
  std::vector<std::vector<std::size_t>> touched(ranks);
  for (std::size_t junction = 0; junction < at.size(); ++junction) {
    std::vector<int>& who = at[junction];
    const int owner = network.junction_ranks()[junction];
    who.push_back(owner);
    std::ranges::sort(who);
    who.erase(std::ranges::unique(who).begin(), who.end());
    const bool mine = std::ranges::binary_search(who, network.rank());
    if (who.size() == 1) {
      if (mine) {
        inner_.push_back(junction);
      }
      continue;
    }
    list_neighbours(junction, owner, who);
    for (const int rank : who) {
      touched[static_cast<std::size_t>(rank)].push_back(junctions_.size());
    }
    junctions_.push_back(junction);
    if (mine) {
      shared_.push_back(junction);
    }
  }
  touched_ = exchange_of(touched);
}

void NetworkInterface::list_neighbours(std::size_t junction, int owner, const std::vector<int>& who) {
  if (owner == network_->rank()) {
    for (const int rank : who) {
      if (rank != owner) {
        neighbour(rank).owned.push_back(junction);
      }
    }
  } else if (std::ranges::binary_search(who, network_->rank())) {
    neighbour(owner).lacked.push_back(junction);
  }
}

NetworkInterface::Neighbour& NetworkInterface::neighbour(int rank) {
  const auto known = std::ranges::find(neighbours_, rank, &Neighbour::rank);
  return known != neighbours_.end() ? *known : neighbours_.emplace_back(Neighbour{.rank = rank});
}

NetworkInterface::Exchange NetworkInterface::exchange_of(const std::vector<std::vector<std::size_t>>& lists) {
  Exchange exchange;
  for (const std::vector<std::size_t>& list : lists) {
    exchange.counts.push_back(static_cast<int>(list.size()));
    exchange.starts.push_back(static_cast<int>(exchange.which.size()));
    exchange.which.insert(exchange.which.end(), list.begin(), list.end());
  }
  return exchange;
}

bool NetworkInterface::invert(std::span<const double> schur) {
  const std::size_t rows = 6 * junctions_.size();
  const std::size_t own = 6 * shared_.size();
  const auto first = static_cast<std::size_t>(touched_.starts[static_cast<std::size_t>(network_->rank())]);
  const auto row_of = [&](std::size_t local) { return 6 * touched_.which[first + local / 6] + local % 6; };
  std::vector<double> sum(rows * rows, 0.0);
  for (std::size_t i = 0; i < own; ++i) {
    for (std::size_t k = 0; k < own; ++k) {
      sum[row_of(i) * rows + row_of(k)] = schur[i * own + k];
    }
  }
  const bool inverts = network_->rank() == 0;
  const auto size = static_cast<int>(rows * rows);
  MPI_Reduce(inverts ? MPI_IN_PLACE : sum.data(), sum.data(), size, MPI_DOUBLE, MPI_SUM, 0, network_->comm());
  int positive = inverts && invert_positive(sum, rows) ? 1 : 0;
  MPI_Bcast(&positive, 1, MPI_INT, 0, network_->comm());
  MPI_Bcast(sum.data(), size, MPI_DOUBLE, 0, network_->comm());
  for (std::size_t i = 0; i < own; ++i) {  // rows ascend
    std::copy_n(sum.begin() + static_cast<std::ptrdiff_t>(row_of(i) * rows), rows,
                sum.begin() + static_cast<std::ptrdiff_t>(i * rows));
  }
  inverse_ = network::DenseRows{own, rows, std::span{sum}.first(own * rows)};
  return positive != 0;
}

/// All ranks' numbers into `gathered_`, `width` a junction.
void NetworkInterface::gather(std::size_t width, std::span<const double> shown) {
  std::vector<int> counts = touched_.counts;
  std::vector<int> starts = touched_.starts;
  for (std::size_t rank = 0; rank < counts.size(); ++rank) {
    counts[rank] *= static_cast<int>(width);
    starts[rank] *= static_cast<int>(width);
  }
  gathered_.resize(touched_.which.size() * width);
  MPI_Allgatherv(shown.data(), static_cast<int>(shown.size()), MPI_DOUBLE, gathered_.data(), counts.data(),
                 starts.data(), MPI_DOUBLE, network_->comm());
}

void NetworkInterface::send(std::size_t width, const std::function<void(std::size_t junction, double* values)>& value) {
  constexpr int kTag = 1;
  for (Neighbour& other : neighbours_) {
    if (!other.lacked.empty()) {
      other.received.resize(other.lacked.size() * width);
      MPI_Irecv(other.received.data(), static_cast<int>(other.received.size()), MPI_DOUBLE, other.rank, kTag,
                network_->comm(), &requests_.emplace_back());
    }
  }
  for (Neighbour& other : neighbours_) {
    if (!other.owned.empty()) {
      other.sent.resize(other.owned.size() * width);
      for (std::size_t k = 0; k < other.owned.size(); ++k) {
        value(other.owned[k], other.sent.data() + k * width);
      }
      MPI_Isend(other.sent.data(), static_cast<int>(other.sent.size()), MPI_DOUBLE, other.rank, kTag, network_->comm(),
                &requests_.emplace_back());
    }
  }
}

void NetworkInterface::receive(std::size_t width,
                               const std::function<void(std::size_t junction, const double* values)>& take) {
  MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
  requests_.clear();
  for (const Neighbour& other : neighbours_) {
    for (std::size_t k = 0; k < other.lacked.size(); ++k) {
      take(other.lacked[k], other.received.data() + k * width);
    }
  }
}

void NetworkInterface::solve(std::span<double> values, std::size_t columns) {
  const std::size_t width = 6 * columns;
  const std::size_t pitch = inverse_.pitch();
  gather(width, values);
  sums_.assign(pitch * columns, 0.0);
  for (std::size_t k = 0; k < touched_.which.size(); ++k) {
    for (std::size_t i = 0; i < width; ++i) {
      sums_[i / 6 * pitch + 6 * touched_.which[k] + i % 6] += gathered_[k * width + i];
    }
  }
  products_.resize(values.size());
  inverse_.multiply(sums_, columns, products_);
  for (std::size_t j = 0; j < shared_.size(); ++j) {
    for (std::size_t i = 0; i < width; ++i) {
      values[j * width + i] = products_[j * width + i % 6 * columns + i / 6];
    }
  }
}

}  // namespace udar
