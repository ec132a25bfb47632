#include "udar/contact/released_line.hpp"

#include <algorithm>

#include "udar/petsc/log.hpp"

namespace udar {

std::vector<double> yielding_matrix(HingedLine& hinges) {
  const BoundedRows& rows = hinges.rows();
  std::vector<double> matrix;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t j = 0; j < rows.size(); ++j) {
      matrix.push_back(rows.at(i, j));
    }
  }
  return matrix;
}

ReleasedLine::ReleasedLine(FilteredStructure& line, HingedLine& hinges)
    : line_{&line},
      hinges_{&hinges},
      problem_{yielding_matrix(hinges), hinges.hinges().size()},
      yields_(hinges.hinges().size(), 0),
      value_(yields_.size()),
      turn_(yields_.size()) {}

void ReleasedLine::assume(std::span<const std::int8_t> yields) {
  std::vector<std::size_t> active;
  for (std::size_t i = 0; i < yields.size(); ++i) {
    yields_[i] = yields[i];
    if (yields[i] != 0) {
      active.push_back(i);
    }
  }
  any_ = !active.empty();
  problem_.assume(std::move(active));
}

void ReleasedLine::release(std::span<double> values) {
  std::ranges::transform(values, value_.begin(), [](double x) { return -x; });
  problem_.respond(value_, turn_);
  std::vector<double> left(values.size());
  problem_.gaps(value_, turn_, left);
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = yields(i) ? turn_[i] : -left[i];
  }
}

void ReleasedLine::turn(std::span<const double> rotations, std::span<double> stretch) const {
  for (std::size_t k = 0; k < rotations.size(); ++k) {
    const std::span<const double> response = hinges_->response(k);
    for (std::size_t i = 0; rotations[k] != 0.0 && i < stretch.size(); ++i) {
      stretch[i] += rotations[k] * response[i];
    }
  }
}

void ReleasedLine::moments(std::span<const Field> fields, std::vector<double>& moments) const {
  const double wf2 = line_->filter_frequency() * line_->filter_frequency();
  const std::span<const double> mass = line_->mass();
  moments.assign(fields.size() * points(), 0.0);
  for (std::size_t f = 0; f < fields.size(); ++f) {
    const auto& [displacement, force] = fields[f];
    for (std::size_t k = 0; k < points(); ++k) {
      const std::span<const double> response = hinges_->response(k);
      double& sum = moments[f * points() + k];
      for (std::size_t i = 0; i < displacement.size(); ++i) {
        sum += wf2 * mass[i] * response[i] * displacement[i];
      }
      for (std::size_t i = 0; i < force.size(); ++i) {
        sum += response[i] * force[i];
      }
    }
  }
  const petsc::LogScope reduction{petsc::log_events().reduction};
  MPI_Allreduce(MPI_IN_PLACE, moments.data(), static_cast<int>(moments.size()), MPI_DOUBLE, MPI_SUM,
                line_->points().comm());
}

void ReleasedLine::subtract(std::span<const double> rotations, std::span<double> moments) const {
  for (std::size_t i = 0; i < moments.size(); ++i) {
    for (std::size_t j = 0; j < rotations.size(); ++j) {
      moments[i] -= hinges_->rows().at(i, j) * rotations[j];
    }
  }
}

void ReleasedLine::hold(std::span<const FilterColumn> columns, std::span<double> /*amplitudes*/,
                        std::vector<double>& rows) {
  const std::size_t nodes = line_->mass().size();
  std::vector<Field> fields;
  for (const FilterColumn& column : columns) {
    fields.push_back({.displacement = {column.displacement, nodes}, .force = {}});
  }
  moments(fields, moments_);
  rows = moments_;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const std::span<double> row{rows.data() + c * points(), points()};
    release(row);
    turn(turn_, {columns[c].stretch, nodes});
  }
}

}  // namespace udar
