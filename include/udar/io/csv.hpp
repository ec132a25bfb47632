#pragma once
/// @file
/// Tables for people: the text of gauges.csv, energy.csv, impacts.csv, rests.csv, contact.csv and envelope.csv. Numbers
/// have the fewest digits that read back to the same double; every row ends with a newline.
/// @see docs/output.md

#include <cstddef>
#include <span>
#include <string>

#include "udar/motion/observer.hpp"

namespace udar::io {

/// First line of gauges.csv for so many gauges.
[[nodiscard]] std::string gauge_header(std::size_t gauges);
/// @brief Rows of gauges.csv.
/// @param[in] times  of the rows [s]
/// @param[in] values row after row: mass position [m], velocity [m/s] and line position [m] of each gauge
[[nodiscard]] std::string gauge_rows(std::span<const double> times, std::span<const double> values);

[[nodiscard]] std::string energy_header();
[[nodiscard]] std::string energy_rows(std::span<const double> times, std::span<const EnergyLedger> rows);

[[nodiscard]] std::string impact_header();
[[nodiscard]] std::string impact_rows(std::span<const ImpactRecord> rows);

[[nodiscard]] std::string rest_header();
[[nodiscard]] std::string rest_rows(std::span<const RestRecord> rows);

/// @brief One row of contact.csv: which masses were in contact, and what the supports did, y up.
struct ContactRow {
  double time = 0.0;     ///< [s]
  double masses = 0.0;   ///< how many since the row before
  double x_min = 0.0;    ///< leftmost of them [m]; not a number if there are none
  double x_max = 0.0;    ///< rightmost [m]
  double force = 0.0;    ///< of all supports together [N]
  double impulse = 0.0;  ///< of all supports together [N s]
};
/// Most supports that have columns of their own in contact.csv; with more it has their sums.
constexpr std::size_t kSupportColumnsMax = 64;
[[nodiscard]] std::string contact_header(std::size_t supports);
/// @param force, impulse row after row, one for each support [N], [N s]
[[nodiscard]] std::string contact_rows(std::span<const ContactRow> rows, std::span<const double> force,
                                       std::span<const double> impulse);

/// @brief One row of envelope.csv: extremes at a node and in the element to its right.
struct EnvelopeRow {
  PetscInt node = 0;
  double x = 0.0;           ///< [m]
  double moment_min = 0.0;  ///< [N m]
  double moment_max = 0.0;
  double shear_min = 0.0;  ///< [N]; not a number at the last node
  double shear_max = 0.0;
  double stress_max = 0.0;       ///< [Pa]; not a number where it is not known, as the next
  double utilisation_max = 0.0;  ///< of the yield stress [-]
};
[[nodiscard]] std::string envelope_header();
[[nodiscard]] std::string envelope_rows(std::span<const EnvelopeRow> rows);

}  // namespace udar::io
