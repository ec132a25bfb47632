#pragma once
/// @file
/// Where options come from besides the words of the command line.

#include <string>
#include <vector>

namespace udar::petsc {

/// @brief A file or text that holds options.
struct OptionSource {
  enum class Kind { file, yaml_file, yaml_text };
  Kind kind = Kind::file;
  std::string text;  ///< path, or the text itself; empty: the key named nothing
};

/// @brief Takes -options_file, -options_file_yaml and -options_string_yaml with what they name out of `words`.
[[nodiscard]] std::vector<OptionSource> take_sources(std::vector<std::string>& words);

/// @brief Puts what a source holds into the database and remembers where each key stands.
/// @note Collective over `PETSC_COMM_WORLD`. @throws InputError naming file, line and column
void insert_source(const OptionSource& source);

/// @brief The paths of the files inserted so far, in order.
[[nodiscard]] const std::vector<std::string>& inserted_files();

/// @brief Whether a key, with its dash, was given in a file of options, and nowhere that counts more.
[[nodiscard]] bool given_in_file(const std::string& key);

/// @brief The text of an environment variable of rank 0, on all ranks. @note Collective over `PETSC_COMM_WORLD`.
[[nodiscard]] std::string shared_text(const std::string& own);

/// @brief A key given again, outside of any file.
void forget_place(const std::string& option);

}  // namespace udar::petsc
