#pragma once
/// @file
/// What is known of keys: those that some group of options has asked for, and where the given ones stand.

#include <set>
#include <string>

namespace udar::petsc {

/// Stands in a list for the default of its option.
inline constexpr const char* kDefaultWord = "default";

/// All keys of udar asked for so far, and some of PETSc's, with their dash.
std::set<std::string>& known_keys();

/// " (case.yaml line 3)" for a key that a case file gave, else empty.
[[nodiscard]] std::string place_of(const std::string& option);

}  // namespace udar::petsc
