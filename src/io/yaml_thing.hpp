#pragma once
/// @file
/// Maps in YAML that describe one thing each, read key by key.

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "petsc/yaml_document.hpp"
#include "udar/petsc/options.hpp"

namespace udar::io {

/// @brief A value and where it stands.
template <class T>
struct Given {
  T value;
  YAML::Mark mark;
};

/// @brief One map: each reader asks for a key; what nobody asked for is refused by `finish`.
/// @note Every method throws InputError naming line and column.
class YamlThing {
 public:
  /// @param what the thing is, "section", for messages @param document borrowed
  YamlThing(const petsc::YamlDocument& document, const YAML::Node& map, std::string what);

  [[nodiscard]] const YAML::Mark& mark() const noexcept { return mark_; }
  [[nodiscard]] const std::string& what() const noexcept { return what_; }
  /// From now on messages name it.
  void call(const std::string& name) { what_ += " '" + name + "'"; }

  /// The key "name", which must be there; messages use it from now on.
  [[nodiscard]] Given<std::string> name();
  [[nodiscard]] std::optional<Given<std::string>> text(const char* key);
  [[nodiscard]] std::optional<Given<double>> number(const char* key, const char* unit, petsc::Range range);
  [[nodiscard]] std::optional<Given<std::size_t>> count(const char* key);
  /// A list of so many numbers; 0: of any.
  [[nodiscard]] std::optional<Given<std::vector<double>>> numbers(const char* key, const char* unit, petsc::Range range,
                                                                  std::size_t size);
  /// One word or a list of some.
  [[nodiscard]] std::optional<std::vector<Given<std::string>>> words(const char* key);
  /// A list of maps.
  [[nodiscard]] std::vector<YamlThing> things(const char* key, const char* each);

  /// Refuses what nobody asked for.
  void finish() const;
  [[noreturn]] void refuse(const YAML::Mark& mark, const std::string& what) const;
  /// Refuses the thing for want of something.
  [[noreturn]] void miss(const std::string& needed) const { refuse(mark_, "has no " + needed); }
  [[noreturn]] void refuse_value(const YAML::Node& value, const char* key, const std::string& expected) const;

 private:
  [[nodiscard]] std::optional<YAML::Node> take(const char* key);
  [[nodiscard]] double number_of(const YAML::Node& value, const char* key, const std::string& expected,
                                 petsc::Range range) const;

  const petsc::YamlDocument* document_;
  YAML::Mark mark_;
  std::string what_;
  std::map<std::string, std::pair<YAML::Mark, YAML::Node>> entries_;  // that nobody asked for yet
  std::vector<std::string> asked_;
};

}  // namespace udar::io
