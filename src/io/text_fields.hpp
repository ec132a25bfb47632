#pragma once
/// @file
/// The words and numbers on a line of a text file.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace udar::io {

/// Without blanks around it.
[[nodiscard]] std::string_view trimmed(std::string_view text);

/// @brief The fields of a line, which is not blank: between commas where there are any, else between blanks.
/// @param semicolons whether these separate the fields instead
[[nodiscard]] std::vector<std::string_view> fields_of(std::string_view line, bool semicolons);

enum class Reading : std::uint8_t { number, not_a_number, out_of_range };

/// @param decimal_comma whether a comma may stand for the point
[[nodiscard]] Reading read_number(std::string_view field, bool decimal_comma, double& value);

/// @brief The same of a finite number. @return what is wrong with it, "'nan' is not a finite number"; empty: nothing
[[nodiscard]] std::string read_finite(std::string_view field, bool decimal_comma, double& value);

}  // namespace udar::io
