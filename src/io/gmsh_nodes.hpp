#pragma once
/// @file
/// Whether a Gmsh file is what PETSc takes it for.

#include <string>

namespace udar::io {

/// @brief What is wrong with an ASCII file of version 2.2 or 4.1, whose counts, numbers and types PETSc takes for
/// granted: a section that is cut short or says something else than it announces, a node given twice, an element with
/// one that is not given. Empty: nothing; other files are not looked into.
[[nodiscard]] std::string fault_of_mesh(const std::string& text);

}  // namespace udar::io
