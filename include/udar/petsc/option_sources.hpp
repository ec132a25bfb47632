#pragma once
/// @file
/// Where options come from besides the words of the command line.

#include <mpi.h>

#include <map>
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
/// @note Collective. @throws InputError naming file, line and column
void insert_source(MPI_Comm comm, const OptionSource& source);

/// @brief The paths of the files inserted so far, in order.
[[nodiscard]] const std::vector<std::string>& inserted_files();

/// @brief Whether a key, with its dash, was given in a file of options, and nowhere that counts more.
[[nodiscard]] bool given_in_file(const std::string& key);

/// @brief The text of rank 0, such as that of an environment variable, on all ranks. @note Collective.
[[nodiscard]] std::string shared_text(MPI_Comm comm, const std::string& own);

/// @brief A key given again, outside of any file.
void forget_place(const std::string& option);

/// @brief Where the keys of a database stand in files, and which files these are, in order.
struct OptionOrigins {
  std::map<std::string, std::string> places;
  std::vector<std::string> files;
};

/// @brief Those of the database in force, for one that takes its place to put its own there.
[[nodiscard]] OptionOrigins& option_origins();

}  // namespace udar::petsc
