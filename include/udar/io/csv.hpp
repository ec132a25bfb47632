#pragma once
/// @file
/// Tables for people: the text of gauges.csv, energy.csv, impacts.csv, impacts_merged.csv, rests.csv, contact.csv and
/// envelope.csv. Numbers have the fewest digits that read back to the same double; every row ends with a newline.
/// @see docs/output.md

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "udar/io/impact_merger.hpp"
#include "udar/motion/observer.hpp"

namespace udar::io {

/// @brief First line of gauges.csv for so many gauges. @param[in] columns of each, "mass" for mass_0, mass_1, ...
[[nodiscard]] std::string gauge_header(std::size_t gauges, std::span<const std::string_view> columns);
/// @brief Rows of gauges.csv.
/// @param[in] times  of the rows [s]
/// @param[in] values row after row: the columns of each gauge
[[nodiscard]] std::string gauge_rows(std::span<const double> times, std::span<const double> values);

[[nodiscard]] std::string energy_header();
/// @brief What a row of it has behind its time [J], [1].
[[nodiscard]] std::array<double, 14> energy_columns(const EnergyLedger& row);
[[nodiscard]] std::string energy_rows(std::span<const double> times, std::span<const EnergyLedger> rows);

[[nodiscard]] std::string impact_header();
[[nodiscard]] std::string impact_rows(std::span<const ImpactRecord> rows);

[[nodiscard]] std::string merged_header();
[[nodiscard]] std::string merged_rows(std::span<const MergedImpact> rows);

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

/// @param[in] columns "moment_min", ...; those before them are the point's number and place
[[nodiscard]] std::string envelope_header(std::span<const std::string> columns);
/// @param[in] values row after row: the point's number, its place [m], then as many values as the header has columns
[[nodiscard]] std::string envelope_rows(std::size_t columns, std::span<const double> values);

}  // namespace udar::io
