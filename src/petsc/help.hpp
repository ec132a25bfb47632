#pragma once
/// @file
/// `-help TOPIC`: the manual of some keys alone.

#include <mpi.h>

#include <string>

namespace udar::petsc {

/// @brief From here on the manual, PETSc's own part too, shows the keys alone that have `word` among the words between
/// their underscores; empty: all keys.
void set_help_topic(const std::string& word);

/// Whether the manual shows `key`, with or without its dash.
[[nodiscard]] bool help_shows(const std::string& key);

/// @brief Prints lines that `help_shows` has let through. @note Printed by rank 0 of `comm`.
void print_own_help(MPI_Comm comm, const std::string& text);

/// Whether a topic was asked for and no key of it has come up.
[[nodiscard]] bool help_found_nothing();

}  // namespace udar::petsc
