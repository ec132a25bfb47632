#pragma once
/// @file
/// Options written in YAML.

#include <optional>
#include <string>
#include <vector>

namespace udar::petsc {

/// @brief One option as a text gave it.
struct GivenOption {
  std::string key;                   ///< with its dash
  std::optional<std::string> value;  ///< none: a bare flag
  int line = 0;                      ///< counted from 1
};

/// @brief The options of a YAML text, in its order: `beam: {length: 10}` is -beam_length 10, a list is its entries
/// with commas, a list of objects is one list for each of their keys, where `default` stands for what one lacks.
/// @param name of the text, for messages
/// @throws InputError naming line and column of what is no YAML, given twice or no list of plain values
[[nodiscard]] std::vector<GivenOption> read_yaml(const std::string& text, const std::string& name);

}  // namespace udar::petsc
