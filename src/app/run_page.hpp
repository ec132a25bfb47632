#pragma once
/// @file
/// What a run came to, on one page of the terminal.

#include <string>

#include "udar/app/case.hpp"
#include "udar/io/summary.hpp"
#include "udar/structure/structure.hpp"

namespace udar::app {

/// @brief A number with four digits and its unit behind a prefix of thousands: "182.8 kN", "0.42 mm".
/// @param unit in SI that takes a prefix
[[nodiscard]] std::string with_unit(double value, const std::string& unit);

/// @brief Supports, largest values with place and time, rebound, energies and what to think of them: lines of at most
/// 120 columns, at most 24 of them.
[[nodiscard]] std::string run_page(const Case& input, const Structure& structure, const io::Summary& summary);

}  // namespace udar::app
