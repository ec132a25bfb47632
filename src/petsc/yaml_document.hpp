#pragma once
/// @file
/// Texts in YAML, with errors that name the place.

#include <yaml-cpp/yaml.h>

#include <string>

namespace udar::petsc {

/// @brief A YAML text that must be one map of keys.
class YamlDocument {
 public:
  /// @param title how messages begin: what the text is, and its name in quotes
  /// @param example of a line, for who gave something else than keys
  /// @throws InputError naming line and column of what is no YAML
  YamlDocument(std::string title, const std::string& text, const std::string& example);

  /// Null if the text is empty.
  [[nodiscard]] const YAML::Node& map() const noexcept { return map_; }
  /// @throws InputError naming line and column, and what is wrong there, which begins with a verb
  [[noreturn]] void refuse(const YAML::Mark& mark, const std::string& what) const;

 private:
  void refuse_other_encodings(const std::string& text) const;

  std::string title_;
  YAML::Node map_;
};

}  // namespace udar::petsc
