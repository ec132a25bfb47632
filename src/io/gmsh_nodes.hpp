#pragma once
/// @file
/// Whether the elements of a Gmsh file have their nodes.

#include <string>

namespace udar::io {

/// @brief What is wrong with the nodes of an ASCII file of version 2.2 or 4.1, which PETSc takes for granted: a node
/// given twice, an element with one that is not given. Empty: nothing that can be told; other files are not looked
/// into.
[[nodiscard]] std::string fault_of_nodes(const std::string& text);

}  // namespace udar::io
