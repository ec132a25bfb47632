#pragma once
/// @file
/// Design studies: which values the keys of a design take in each run.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace udar::study {

/// @brief A key that a design study varies, over a list or a range.
struct Variable {
  std::string key;                  ///< without dash
  std::vector<std::string> values;  ///< as options take them; empty: a range
  std::array<double, 2> range{};    ///< from and to
  bool logarithmic = false;         ///< its logarithm is spread evenly

  [[nodiscard]] bool listed() const noexcept { return !values.empty(); }
};

/// @brief Reads 'key: 1, 2, 3; key: 0.1..2; key: 1e6..1e9 log'; in a list, numbers that belong together stand apart by
/// spaces: 'support_position: 2 8, 1 9'. @throws InputError
[[nodiscard]] std::vector<Variable> read_variables(const std::string& text);

/// @brief How samples are taken: every variable in as many strata as there are samples, one sample in each (Latin
/// hypercube: McKay, Beckman, Conover, Technometrics 21 (1979) 239), or all by chance.
enum class Sampling : std::uint8_t { latin, random };

/// @brief Values of a variable in each run, the same for a seed on every machine.
/// @param index of the variable among all: each has random numbers of its own
[[nodiscard]] std::vector<std::string> sampled(const Variable& variable, Sampling sampling, std::size_t samples,
                                               std::uint64_t seed, std::size_t index);

}  // namespace udar::study
