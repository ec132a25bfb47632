#pragma once
/// @file
/// Modes to which the structure answers as if it had no filter.

#include <mpi.h>

#include <cstddef>
#include <span>
#include <vector>

#include "udar/filter/filter_column.hpp"

namespace udar {

/// @brief A mode of the structure to which it answers as if it had no filter springs.
struct CorrectedMode {
  double frequency = 0.0;     ///< w of the lumped structure [rad/s]
  std::vector<double> shape;  ///< phi at the local points [kg^(-1/2)], phi' M phi = 1 over all ranks
};

/// @brief Adds to the stretch of a solve what the filter keeps from some modes. Source: docs/theory.md, "Corrected
/// modes".
class CorrectedModes {
 public:
  CorrectedModes() = default;
  /// @param modes M-orthonormal, frequencies and number equal on every rank @param filter_frequency wf [rad/s]
  CorrectedModes(std::vector<CorrectedMode> modes, double filter_frequency);

  [[nodiscard]] bool empty() const noexcept { return modes_.empty(); }
  [[nodiscard]] std::span<const CorrectedMode> modes() const noexcept { return modes_; }
  /// Largest frequency of them [rad/s]; 0 if there are none.
  [[nodiscard]] double highest_frequency() const noexcept { return highest_; }

  /// @brief The filtered structure stretches by (f - w^2 q) / (wf^2 + w^2) in a mode; that becomes (f - w^2 q) / wf^2.
  /// @param mass [kg], local points @note Collective: one reduction of as many numbers a column as there are modes.
  void apply(MPI_Comm comm, std::span<const double> mass, std::span<const FilterColumn> columns);
  /// phi' M d [m kg^(1/2)] of every mode, of a column of the last `apply`; equal on every rank.
  [[nodiscard]] std::span<const double> amplitudes(std::size_t column) const {
    return std::span{amplitudes_}.subspan(column * modes_.size(), modes_.size());
  }
  /// @brief Takes the modes at given amplitudes out of a stretch. @param[in,out] stretch [m], local points
  void subtract(std::span<const double> amplitudes, std::span<double> stretch) const;

 private:
  std::vector<CorrectedMode> modes_;
  double wf2_ = 0.0;
  double highest_ = 0.0;
  std::vector<double> amplitudes_;  // [column][mode]
};

}  // namespace udar
