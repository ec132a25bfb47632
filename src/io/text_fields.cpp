#include "io/text_fields.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

namespace udar::io {
namespace {

constexpr std::string_view kBlanks = " \t\r\f\v";

}  // namespace

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  return begin == std::string_view::npos ? std::string_view{}
                                         : text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

std::vector<std::string_view> fields_of(std::string_view line, bool semicolons) {
  std::vector<std::string_view> fields;
  const char separator = semicolons ? ';' : ',';
  if (semicolons || line.find(separator) != std::string_view::npos) {
    for (;;) {
      const std::size_t end = line.find(separator);
      fields.push_back(trimmed(line.substr(0, end)));
      if (end == std::string_view::npos) {
        return fields;
      }
      line.remove_prefix(end + 1);
    }
  }
  while (!(line = trimmed(line)).empty()) {
    const std::size_t length = std::min(line.find_first_of(kBlanks), line.size());
    fields.push_back(line.substr(0, length));
    line.remove_prefix(length);
  }
  return fields;
}

Reading read_number(std::string_view field, bool decimal_comma, double& value) {
  std::string with_point;
  if (const std::size_t comma = field.find(','); decimal_comma && comma != std::string_view::npos) {
    with_point = field;
    with_point[comma] = '.';  // a point or comma besides is one too many, which is no number
    field = with_point;
  }
  if (field.size() > 1 && field[0] == '+' && field[1] != '-') {
    field.remove_prefix(1);
  }
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error == std::errc::result_out_of_range) {
    return Reading::out_of_range;
  }
  return error == std::errc{} && end == field.data() + field.size() ? Reading::number : Reading::not_a_number;
}

std::string read_finite(std::string_view field, bool decimal_comma, double& value) {
  const Reading reading = read_number(field, decimal_comma, value);
  if (reading == Reading::number && std::isfinite(value)) {
    return {};
  }
  return "'" + std::string{field} +
         (reading == Reading::out_of_range   ? "' is out of range"
          : reading == Reading::not_a_number ? "' is not a number"
                                             : "' is not a finite number");
}

}  // namespace udar::io
