#include "udar/contact/hinged_line.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "udar/petsc/error.hpp"
#include "udar/petsc/log.hpp"

namespace udar {
namespace {

void refuse_line_without_hinges(const FilteredStructure& line, const LineContact* contact) {
  if (line.parameters().formulation != Formulation::mixed) {
    throw InputError{"beam formulation: hermite is not allowed with `beam yield moment`, expected mixed"};
  }
  if (!line.corrected_modes().empty()) {
    throw InputError{
        "filter correct modes: not allowed with `beam yield moment`, expected 0: modes of a beam that stays elastic "
        "are "
        "none of one that yields"};
  }
  if (contact != nullptr && !contact->dense()) {
    throw InputError{
        "beam yield moment: not allowed with so many contact points of the line, expected fewer, or a larger `contact "
        "line dense max`"};
  }
}

}  // namespace

HingedLine::HingedLine(FilteredStructure& line, const LineContact* contact)
    : line_{&line}, beam_{line.structure().chain()}, contact_{contact}, hinges_{beam_->plastic_hinges()} {
  refuse_line_without_hinges(line, contact);
  if (const std::size_t rows = hinges_.size() + contacts(); rows > kMostRows) {
    throw InputError{"beam hinge position: " + std::to_string(rows) +
                     " hinges and contact points are not allowed, expected at most " + std::to_string(kMostRows) +
                     "; give some places, or fewer elements"};
  }
  for (std::size_t i = 0; i < hinges_.size(); ++i) {
    if (beam_->begin() <= hinges_[i].node && hinges_[i].node < beam_->end()) {
      mine_.push_back(i);
    }
  }
  rotation_.assign(hinges_.size(), 0.0);
  turned_.assign(hinges_.size(), 0.0);
  zero_.assign(line.mass().size(), 0.0);
  kink_ = zero_;
  force_ = zero_;
  stretch_ = zero_;
}

void HingedLine::turn(std::span<const double> rotations) {
  for (std::size_t i = 0; i < hinges_.size(); ++i) {
    turned_[i] += std::abs(rotations[i] - rotation_[i]);
    rotation_[i] = rotations[i];
  }
}

void HingedLine::restore(std::span<const double> rotations, std::span<const double> turned) {
  if (rotations.size() != hinges_.size() || turned.size() != hinges_.size()) {
    throw InputError{"restart file: it was written with another number of plastic hinges"};
  }
  rotation_.assign(rotations.begin(), rotations.end());
  turned_.assign(turned.begin(), turned.end());
}

void HingedLine::spread(std::span<const double> rotations, std::span<double> nodes) const {
  std::ranges::fill(nodes, 0.0);
  for (const std::size_t i : mine_) {
    nodes[local(i)] = rotations[i];
  }
}

const double* HingedLine::kink(std::span<const double> rotations) {
  if (std::ranges::all_of(rotations, [](double rotation) { return rotation == 0.0; })) {
    return nullptr;
  }
  spread(rotations, kink_);
  return kink_.data();
}

double HingedLine::stored(std::span<const double> rotations) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < hinges_.size(); ++i) {
    sum += 0.5 * hinges_[i].hardening * rotations[i] * rotations[i];
  }
  return sum;
}

void HingedLine::gather(const double* moment, std::span<double> at_hinges) const {
  std::ranges::fill(at_hinges, 0.0);
  for (const std::size_t i : mine_) {
    at_hinges[i] = moment[local(i)];
  }
  const petsc::LogScope reduction{petsc::log_events().reduction};
  MPI_Allreduce(MPI_IN_PLACE, at_hinges.data(), static_cast<int>(at_hinges.size()), MPI_DOUBLE, MPI_SUM,
                line_->points().comm());
}

void HingedLine::add(std::span<const double> x, std::span<double> stretch, std::span<double> moment) {
  std::ranges::fill(force_, 0.0);
  for (std::size_t i = 0; i < contacts(); ++i) {
    const LinePoint& point = contact_->points()[i];
    if (line_->points().owns(point.node)) {
      force_[contact_->local(i)] += point.side * x[i];
    }
  }
  const FilterColumn column{.displacement = zero_.data(),
                            .force = force_.data(),
                            .kink = kink(x.subspan(contacts())),
                            .stretch = stretch_.data(),
                            .internal = moment.data()};
  line_->solve({&column, 1});
  for (std::size_t i = 0; i < stretch.size(); ++i) {
    stretch[i] += stretch_[i];
  }
}

/// Forces and rotations couple with opposite signs: what a force adds to the moment a rotation adds to the gap.
BoundedRows& HingedLine::rows() {
  if (rows_) {
    return *rows_;
  }
  const std::size_t touching = contacts();
  const std::size_t count = touching + hinges_.size();
  std::vector<double> matrix(count * count, 0.0);
  std::vector<double> unit(count, 0.0);
  std::vector<double> stretch(zero_.size());
  std::vector<double> moment(zero_.size());
  for (std::size_t column = 0; column < count; ++column) {
    unit[column] = 1.0;
    std::ranges::fill(stretch, 0.0);
    add(unit, stretch, moment);
    unit[column] = 0.0;
    for (std::size_t i = 0; i < touching; ++i) {
      const LinePoint& point = contact_->points()[i];
      matrix[i * count + column] = line_->points().owns(point.node) ? point.side * stretch[contact_->local(i)] : 0.0;
    }
    if (touching == 0) {
      responses_.push_back(stretch);
    }
    for (const std::size_t i : mine_) {
      matrix[(touching + i) * count + column] = -moment[local(i)];
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, matrix.data(), static_cast<int>(matrix.size()), MPI_DOUBLE, MPI_SUM,
                line_->points().comm());
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double sign = i >= touching && j < touching ? -1.0 : 1.0;
      double& below = matrix[i * count + j];
      double& above = matrix[j * count + i];
      below = 0.5 * (below + sign * above);
      above = sign * below;
    }
    matrix[i * count + i] +=
        i < touching ? contact_->points()[i].yield(line_->parameters()) : hinges_[i - touching].hardening;
  }
  rows_.emplace(std::move(matrix), count);
  return *rows_;
}

}  // namespace udar
