#pragma once
/// @file
/// Tables for people: the text of gauges.csv, energy.csv, impacts.csv and rests.csv. Numbers have the fewest digits
/// that read back to the same double; every row ends with a newline.
/// @see docs/output.md

#include <cstddef>
#include <span>
#include <string>

#include "udar/dynamics/observer.hpp"

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

}  // namespace udar::io
