#include "udar/contact/line_contact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

#include "udar/numerics/symmetric_eigen.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/log.hpp"

namespace udar {
namespace {

constexpr std::size_t kColumns = 4;  // line solves side by side

// More nodes than these under all supports are many however they are spread: the matrix takes 32 MB on every rank.
constexpr std::size_t kDenseInAll = 2000;

/// Whether a matrix of all pairs of contact nodes is too much, or a support too wide for pivoting.
bool are_many(const Contacts& contacts, std::size_t under_one) {
  std::size_t all = 0;
  std::size_t widest = 0;
  for (const PetscInt touched : contacts.touched) {
    const auto count = static_cast<std::size_t>(touched);
    all += count;
    widest = std::max(widest, count);
  }
  return all > kDenseInAll || widest > under_one;
}

/// Neighbours on the line are neighbours in the matrix.
void sort_by_node(std::vector<LinePoint>& points) { std::ranges::stable_sort(points, {}, &LinePoint::node); }

/// This rank's.
std::vector<LinePoint> own_points(const MassPoints& points, const Contacts& contacts) {
  std::vector<LinePoint> all;
  for (const ContactSet& set : contacts.sets) {
    const Support& support = contacts.supports[static_cast<std::size_t>(set.support)];
    for (std::size_t node = set.first; node < set.last; ++node) {
      const double mass = points.mass()[node];
      all.push_back({.node = points.global(node),
                     .support = set.support,
                     .side = set.side,
                     .height = set.height(node),
                     .motion = set.motion,
                     .compliance = set.carried / (support.stiffness * mass),
                     .damping = set.damping * mass});
    }
  }
  sort_by_node(all);
  return all;
}

/// What supports can do to masses alone.
void refuse_what_masses_need(const Support& support, bool filtered) {
  const std::string where{" `contact surface` line or `filter frequency` none"};
  if (std::isfinite(support.yield_speed)) {
    throw InputError{"support yield speed: masses meet supports that yield; not allowed with" + where};
  }
  if (filtered && support.elastic() && support.damping > 0.0) {
    throw InputError{
        "support damping: a damper that holds the massless line moves by a rate of its own, which "
        "no mass has; expected 0 with `contact surface` line [N s/m]"};
  }
}

void refuse_many_tied(const FilteredStructure& line, std::size_t dense_points) {
  if (!line.corrected_modes().empty()) {
    throw InputError{
        "filter correct modes: not allowed with more than " + std::to_string(dense_points) +
        " contact points of the line under a support or " + std::to_string(kDenseInAll) +
        " in all, expected 0: forces of so many points are found by springs in the filter's place, which know no "
        "corrected modes; choose narrower supports, fewer elements, or `contact surface` mass"};
  }
}

}  // namespace

std::vector<LinePoint> line_points(const MassPoints& points, const Contacts& contacts) {
  const MPI_Comm comm = points.comm();
  enum Column : std::size_t { node, support, height, compliance, damping, columns };
  std::vector<double> mine;
  for (const LinePoint& point : own_points(points, contacts)) {
    mine.insert(mine.end(), {static_cast<double>(point.node), static_cast<double>(point.support), point.height,
                             point.compliance, point.damping});
  }
  int size = 1;
  MPI_Comm_size(comm, &size);
  const auto count = static_cast<int>(mine.size());
  std::vector<int> counts(static_cast<std::size_t>(size));
  MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm);
  std::vector<int> starts(counts.size(), 0);
  std::partial_sum(counts.begin(), counts.end() - 1, starts.begin() + 1);
  std::vector<double> values(static_cast<std::size_t>(starts.back() + counts.back()));
  MPI_Allgatherv(mine.data(), count, MPI_DOUBLE, values.data(), counts.data(), starts.data(), MPI_DOUBLE, comm);
  std::vector<LinePoint> all;
  for (std::size_t i = 0; i < values.size(); i += columns) {
    const Support& of = contacts.supports[static_cast<std::size_t>(values[i + support])];
    all.push_back({.node = static_cast<PetscInt>(values[i + node]),
                   .support = static_cast<PetscInt>(values[i + support]),
                   .side = static_cast<double>(of.side),
                   .height = values[i + height],
                   .motion = of.motion,
                   .compliance = values[i + compliance],
                   .damping = values[i + damping]});
  }
  sort_by_node(all);
  return all;
}

LineContact::LineContact(FilteredStructure& line, const Contacts& contacts, std::size_t dense_points)
    : line_{&line},
      dense_{!are_many(contacts,
                       line.structure().chain() != nullptr ? dense_points : std::numeric_limits<std::size_t>::max())} {
  if (!dense_ && line.structure().chain() == nullptr) {
    throw InputError{
        "contact surface: line is not allowed with more than " + std::to_string(kDenseInAll) +
        " contact points of a network or of imported matrices, expected mass, or supports that touch less"};
  }
  const MassPoints& points = line.points();
  for (const Support& support : contacts.supports) {
    refuse_what_masses_need(support, line.parameters().filtered());
  }
  points_ = dense_ ? line_points(points, contacts) : own_points(points, contacts);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (points.owns(points_[i].node)) {
      mine_.push_back(i);
    }
  }
  zero_.assign(line.mass().size(), 0.0);
  gap_.resize(points_.size());
  force_.resize(points_.size());
  bound_ = line.frequency_bound();
  if (!dense_) {
    refuse_many_tied(line, dense_points);
  }
  if (line.parameters().filtered()) {
    make_ready();
  }
}

void LineContact::make_ready() {
  if (dense_ && !problem_) {
    tie_modes();
    compute_compliance();
  } else if (!dense_ && many_ == nullptr) {
    many_ = std::make_unique<ObstacleForces>(*line_, points_);
  }
}

void LineContact::tie_modes() {
  const auto modes = line_->corrected_modes();
  gather(
      modes.size(),
      [&](std::size_t point, std::size_t mode) { return points_[point].side * modes[mode].shape[local(point)]; }, tie_);
}

double LineContact::nearer(std::size_t point, std::span<const double> amplitude) const {
  double sum = 0.0;
  for (std::size_t mode = 0; mode < amplitude.size(); ++mode) {
    sum += tie_[point * amplitude.size() + mode] * amplitude[mode];
  }
  return sum;
}

/// In these modes wf^2 times the stretch is the force itself.
void LineContact::add_amplitudes(std::span<const double> force, std::size_t column, std::size_t columns,
                                 std::span<double> amplitude) const {
  const double wf2 = line_->filter_frequency() * line_->filter_frequency();
  for (std::size_t point = 0; point < points_.size() && !amplitude.empty(); ++point) {
    const double pull = force[point * columns + column] / wf2;
    for (std::size_t mode = 0; mode < amplitude.size(); ++mode) {
      amplitude[mode] += pull * tie_[point * amplitude.size() + mode];
    }
  }
}

/// The tied modes are no part of what the line gives way by: contact makes their frequencies higher, those of the
/// filter's masses at the most what wf is, and couples both.
void LineContact::bound_frequency(const std::vector<double>& closed) {
  const auto modes = line_->corrected_modes();
  const std::size_t count = points_.size();
  if (modes.empty() || count == 0) {
    return;
  }
  std::vector<double> tied(count * count, 0.0);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < count; ++j) {
      for (std::size_t mode = 0; mode < modes.size(); ++mode) {
        tied[i * count + j] += tie_[i * modes.size() + mode] * tie_[j * modes.size() + mode];
      }
    }
  }
  const std::optional<double> found = largest_of_pencil(std::move(tied), closed, count);
  const double added = found ? std::max(*found, 0.0) : std::numeric_limits<double>::infinity();
  const double wf2 = line_->filter_frequency() * line_->filter_frequency();
  double last = 0.0;
  for (const CorrectedMode& mode : modes) {
    last = std::max(last, mode.frequency);
  }
  const double held = last * last + added;
  const double open = bound_;
  bound_ = std::sqrt(0.5 * (held + wf2) + std::sqrt(0.25 * (held - wf2) * (held - wf2) + added * wf2));
  constexpr double kMostAboveOpen = 4.0;  // as for -ts_type modal
  if (!(bound_ <= kMostAboveOpen * open)) {
    std::ostringstream message;
    message << "filter correct modes: " << std::ranges::count_if(modes, [](auto& mode) { return mode.frequency > 0.0; })
            << " are not allowed with these supports and `contact surface` line, contact could swing at " << bound_
            << " rad/s where " << open
            << " is the highest frequency without: contact points are too close for the line to give way beside the "
               "corrected modes; give `support stiffness`, fewer points under a support, or fewer corrected modes";
    throw InputError{message.str()};
  }
}

void LineContact::compute_compliance() {
  const std::size_t count = points_.size();
  std::vector<double> compliance(count * count, 0.0);
  std::vector<std::vector<double>> load(kColumns, zero_);
  std::vector<std::vector<double>> response(kColumns, zero_);
  const auto is_mine = [&](std::size_t point) { return std::ranges::binary_search(mine_, point); };
  for (std::size_t from = 0; from < count; from += kColumns) {
    const std::size_t columns = std::min(kColumns, count - from);
    std::array<FilterColumn, kColumns> asked;
    for (std::size_t k = 0; k < columns; ++k) {
      if (is_mine(from + k)) {
        load[k][local(from + k)] = points_[from + k].side;
      }
      asked[k] = {.displacement = zero_.data(), .force = load[k].data(), .stretch = response[k].data()};
    }
    line_->solve({asked.data(), columns});
    for (std::size_t k = 0; k < columns; ++k) {
      for (const std::size_t i : mine_) {
        compliance[i * count + from + k] = points_[i].side * response[k][local(i)] - nearer(i, line_->amplitudes(k));
      }
      if (is_mine(from + k)) {
        load[k][local(from + k)] = 0.0;
      }
    }
  }
  sum(compliance);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double mean = 0.5 * (compliance[i * count + j] + compliance[j * count + i]);
      compliance[i * count + j] = mean;
      compliance[j * count + i] = mean;
    }
    compliance[i * count + i] += points_[i].yield(line_->parameters());
  }
  bound_frequency(compliance);
  problem_.emplace(std::move(compliance), count);
}

/// Over the ranks, if they all hold all points.
void LineContact::sum(std::vector<double>& values) const {
  if (!dense()) {
    return;
  }
  const petsc::LogScope reduction{petsc::log_events().reduction};
  MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_SUM,
                line_->points().comm());
}

void LineContact::keep_responses() {
  std::vector<std::vector<double>> responses(points_.size(), zero_);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    std::vector<double> unit(points_.size(), 0.0);
    unit[i] = 1.0;
    const std::array<double*, 1> stretch{responses[i].data()};
    add(unit, stretch, {});
  }
  responses_ = std::move(responses);
}

void LineContact::add_responses(std::span<const double> force, std::span<double* const> stretch) const {
  const std::size_t columns = stretch.size();
  for (std::size_t point = 0; point < points_.size(); ++point) {
    for (std::size_t k = 0; k < columns; ++k) {
      const double pressed = force[point * columns + k];
      for (std::size_t i = 0; pressed != 0.0 && i < zero_.size(); ++i) {
        stretch[k][i] += pressed * responses_[point][i];
      }
    }
  }
}

void LineContact::add(std::span<const double> force, std::span<double* const> stretch,
                      std::span<double* const> moment) {
  int any = std::ranges::any_of(force, [](double value) { return value != 0.0; }) ? 1 : 0;
  if (!dense()) {
    MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_LOR, line_->points().comm());
  }
  if (any == 0) {
    return;
  }
  if (!responses_.empty() && moment.empty()) {
    add_responses(force, stretch);
    return;
  }
  const std::size_t columns = stretch.size();
  const std::size_t internal_numbers = line_->filter_operator().internal_numbers();
  while (load_.size() < columns) {
    load_.push_back(zero_);
    correction_.push_back(zero_);
    correction_.emplace_back(internal_numbers * zero_.size());
  }
  std::vector<FilterColumn> asked(columns);
  for (std::size_t k = 0; k < columns; ++k) {
    for (const std::size_t i : mine_) {
      load_[k][local(i)] += points_[i].side * force[i * columns + k];
    }
    asked[k] = {.displacement = zero_.data(), .force = load_[k].data(), .stretch = correction_[2 * k].data()};
    if (!moment.empty()) {
      asked[k].internal = correction_[2 * k + 1].data();
    }
  }
  line_->solve(asked);
  for (std::size_t k = 0; k < columns; ++k) {
    for (const std::size_t i : mine_) {
      load_[k][local(i)] = 0.0;
    }
    for (std::size_t i = 0; i < zero_.size(); ++i) {
      stretch[k][i] += correction_[2 * k][i];
    }
    for (std::size_t i = 0; !moment.empty() && i < internal_numbers * zero_.size(); ++i) {
      moment[k][i] += correction_[2 * k + 1][i];
    }
  }
}

bool LineContact::apply(double time, std::span<const double> mass_position, std::span<double> stretch,
                        std::span<double> amplitude, std::span<double> moment) {
  gather(
      1, [&](std::size_t point, std::size_t /*field*/) { return mass_position[local(point)] + stretch[local(point)]; },
      gap_);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    gap_[i] = points_[i].side * (gap_[i] - points_[i].height - points_[i].lift(time).height) - nearer(i, amplitude);
  }
  const bool in_contact = solve(gap_, force_);
  const std::array<double*, 1> line{stretch.data()};
  const std::array<double*, 1> bending{moment.data()};
  add(force_, line, moment.empty() ? std::span<double* const>{} : std::span<double* const>{bending});
  add_amplitudes(force_, 0, 1, amplitude);
  return in_contact;
}

double LineContact::spring_energy(std::span<const double> force) const {
  double sum = 0.0;
  for (const std::size_t i : mine_) {
    sum += 0.5 * points_[i].compliance * force[i] * force[i];
  }
  return sum;
}

double LineContact::power(std::span<const double> force, double time) const {
  double sum = 0.0;
  for (const std::size_t i : mine_) {
    sum += points_[i].side * force[i] * points_[i].lift(time).velocity;
  }
  return sum;
}

bool LineContact::solve(std::span<const double> gap, std::span<double> force) {
  if (many_ != nullptr) {
    many_->assume({});
    return many_->solve(gap, force);
  }
  problem_->assume({});
  problem_->solve(gap, force);
  return std::ranges::any_of(force, [](double value) { return value > 0.0; });
}

}  // namespace udar
