#include "tools/study_design.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>
#include <random>
#include <string_view>
#include <utility>

#include "tools/study_plan.hpp"
#include "udar/petsc/error.hpp"

namespace udar::study {
namespace {

std::optional<double> finite_number(std::string_view word) {
  double value = 0.0;
  const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), value);
  return status == std::errc{} && end == word.data() + word.size() && std::isfinite(value) ? std::optional{value}
                                                                                           : std::nullopt;
}

/// Nine digits are enough for who makes something of that size, and to stay in a stratum.
std::string in_digits(double value) {
  constexpr int kDigits = 9;
  std::array<char, 32> text{};
  return {text.data(),
          std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, kDigits).ptr};
}

/// "0.1..2" or "0.1..2 log"
void read_range(const std::string& text, Variable& variable) {
  std::string range = text;
  if (range.ends_with(" log")) {
    variable.logarithmic = true;
    range = trimmed(range.substr(0, range.size() - 4));
  }
  const std::size_t dots = range.find("..");
  const auto from = finite_number(trimmed(range.substr(0, dots)));
  const auto to = finite_number(trimmed(range.substr(dots + 2)));
  if (!from || !to || !(*from < *to) || (variable.logarithmic && !(*from > 0.0))) {
    throw InputError{"option -study_vary: " + variable.key + ": '" + text +
                     "' is not allowed, expected a range FROM..TO of two numbers that rise, above 0 with log"};
  }
  variable.range = {*from, *to};
}

/// "1, 2, 3" or "2 8, 1 9"
void read_list(const std::string& text, Variable& variable) {
  for (const std::string& value : split(text, ',')) {
    std::string joined;
    for (const std::string& word : split(value, ' ')) {
      joined += word.empty() ? "" : (joined.empty() ? "" : ",") + word;
    }
    if (joined.empty() || std::ranges::find(variable.values, joined) != variable.values.end()) {
      throw InputError{"option -study_vary: " + variable.key + ": '" + text +
                       "' is not allowed, expected values that differ, with ',' between them, or a range FROM..TO"};
    }
    variable.values.push_back(std::move(joined));
  }
}

/// In [0, 1), by the upper bits of a generator that the standard defines to the last.
double uniform(std::mt19937_64& generator) { return static_cast<double>(generator() >> 11U) * 0x1p-53; }

/// 0 to count - 1 in any order.
std::vector<std::size_t> shuffled(std::size_t count, std::mt19937_64& generator) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t left = count; left > 1; --left) {
    const auto chosen = static_cast<std::size_t>(uniform(generator) * static_cast<double>(left));
    std::swap(order[left - 1], order[chosen]);
  }
  return order;
}

/// @param share of the list or the range, in [0, 1)
std::string value_at(const Variable& variable, double share) {
  if (variable.listed()) {
    return variable.values[static_cast<std::size_t>(share * static_cast<double>(variable.values.size()))];
  }
  const auto [from, to] = variable.range;
  return in_digits(variable.logarithmic ? from * std::pow(to / from, share) : from + share * (to - from));
}

}  // namespace

std::vector<Variable> read_variables(const std::string& text) {
  std::vector<Variable> all;
  for (const std::string& part : split(text, ';')) {
    if (part.empty()) {
      continue;
    }
    const std::size_t colon = part.find(':');
    Variable variable{.key = with_dash(trimmed(part.substr(0, colon))).substr(1), .values = {}};
    if (colon == std::string::npos || variable.key.empty() || variable.key.find(' ') != std::string::npos ||
        variable.key.starts_with("study_") || variable.key == "output_directory" ||
        std::ranges::find(all, variable.key, &Variable::key) != all.end()) {
      throw InputError{"option -study_vary: '" + part +
                       "' is not allowed, expected 'key: values' with ';' between keys of udar, each once"};
    }
    const std::string values = trimmed(part.substr(colon + 1));
    if (values.find("..") != std::string::npos) {
      read_range(values, variable);
    } else {
      read_list(values, variable);
    }
    all.push_back(std::move(variable));
  }
  return all;
}

std::vector<std::string> sampled(const Variable& variable, Sampling sampling, std::size_t samples, std::uint64_t seed,
                                 std::size_t index) {
  std::seed_seq own{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32U),
                    static_cast<std::uint32_t>(index)};
  std::mt19937_64 generator{own};
  const std::vector<std::size_t> strata = shuffled(samples, generator);
  std::vector<std::string> values;
  for (std::size_t i = 0; i < samples; ++i) {
    const double chance = uniform(generator);
    values.push_back(value_at(variable, sampling == Sampling::random ? chance
                                                                     : (static_cast<double>(strata[i]) + chance) /
                                                                           static_cast<double>(samples)));
  }
  return values;
}

}  // namespace udar::study
