#pragma once
/// @file
/// Options that are in force for a while.

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace udar::petsc {

/// Keys with their dash and values, empty for a key alone.
using Options = std::vector<std::pair<std::string, std::optional<std::string>>>;

/// @brief What the options database says of a key; empty if it is not there or has no value.
std::optional<std::string> option_value(const std::string& key);

/// @brief All options in the database, in its order.
[[nodiscard]] Options all_options();

/// @brief Adds those that are not in the database yet. @note Not collective: the database is that of the process.
void add_missing_options(const Options& options);

/// @brief Options in force as long as the object lives. @note Not collective: the database is that of the process.
class ScopedOptions {
 public:
  explicit ScopedOptions(const Options& options);
  ScopedOptions(const ScopedOptions&) = delete;
  ScopedOptions& operator=(const ScopedOptions&) = delete;
  ~ScopedOptions();

 private:
  struct Before {
    std::string key;
    bool given;
    std::optional<std::string> value;
  };
  std::vector<Before> before_;
};

}  // namespace udar::petsc
