#include "udar/filter/corrected_modes.hpp"

#include <algorithm>
#include <utility>

namespace udar {

CorrectedModes::CorrectedModes(std::vector<CorrectedMode> modes, double filter_frequency)
    : modes_{std::move(modes)}, wf2_{filter_frequency * filter_frequency} {
  for (const CorrectedMode& mode : modes_) {
    highest_ = std::max(highest_, mode.frequency);
  }
}

void CorrectedModes::apply(MPI_Comm comm, std::span<const double> mass, std::span<const FilterColumn> columns) {
  const std::size_t count = mass.size();
  const std::size_t modes = modes_.size();
  amplitudes_.assign(columns.size() * modes, 0.0);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    for (std::size_t k = 0; k < modes; ++k) {
      const double* shape = modes_[k].shape.data();
      double sum = 0.0;
      for (std::size_t i = 0; i < count; ++i) {
        sum += mass[i] * shape[i] * columns[c].stretch[i];
      }
      amplitudes_[c * modes + k] = sum;
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, amplitudes_.data(), static_cast<int>(amplitudes_.size()), MPI_DOUBLE, MPI_SUM, comm);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    for (std::size_t k = 0; k < modes; ++k) {
      const double* shape = modes_[k].shape.data();
      const double gain = modes_[k].frequency * modes_[k].frequency / wf2_;
      double& amplitude = amplitudes_[c * modes + k];
      for (std::size_t i = 0; i < count; ++i) {
        columns[c].stretch[i] += gain * amplitude * shape[i];
      }
      amplitude *= 1.0 + gain;
    }
  }
}

void CorrectedModes::subtract(std::span<const double> amplitudes, std::span<double> stretch) const {
  for (std::size_t k = 0; k < modes_.size(); ++k) {
    const double* shape = modes_[k].shape.data();
    for (std::size_t i = 0; i < stretch.size(); ++i) {
      stretch[i] -= amplitudes[k] * shape[i];
    }
  }
}

}  // namespace udar
