#pragma once
/// @file
/// Typed reading of udar's own options from the PETSc options database, with units, ranges and one-line errors.

#include <petscsys.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "udar/petsc/error.hpp"

namespace udar::petsc {

/// @brief The values an option may take, with the words that tell the user so.
struct Range {
  double lowest = -std::numeric_limits<double>::max();
  double highest = std::numeric_limits<double>::max();
  bool lowest_excluded = false;
  bool infinity_allowed = false;

  [[nodiscard]] bool contains(double value) const noexcept;
  [[nodiscard]] std::string text() const;
};
[[nodiscard]] constexpr Range any() { return {}; }
[[nodiscard]] constexpr Range positive() { return {.lowest = 0.0, .lowest_excluded = true}; }
[[nodiscard]] constexpr Range non_negative() { return {.lowest = 0.0}; }
[[nodiscard]] constexpr Range non_negative_or_infinite() { return {.lowest = 0.0, .infinity_allowed = true}; }
[[nodiscard]] constexpr Range positive_or_infinite() {
  return {.lowest = 0.0, .lowest_excluded = true, .infinity_allowed = true};
}
[[nodiscard]] constexpr Range at_least(double lowest) { return {.lowest = lowest}; }
[[nodiscard]] constexpr Range between(double lowest, double highest) { return {.lowest = lowest, .highest = highest}; }

/// @brief One group of options: each call reads one key into a variable that already holds the default, and prints
/// the key's manual line under `-help`.
///
/// PETSc's own `PetscOptionsBegin` family is not used because its help has no place for units and ranges and prints
/// the whole buffer of an array option.
/// @note Collective. Every method throws `InputError` naming option, value, range and unit.
class OptionGroup {
 public:
  /// @param title headline of the group in `-help`
  OptionGroup(MPI_Comm comm, const char* title);

  /// @param unit SI unit, or "-" for a pure number
  /// @return whether the key was given
  bool real(const char* key, double& value, const char* unit, Range range, const char* text);
  /// A number, or one of some words, which then leaves the number as it is.
  bool real_or_word(const char* key, double& value, std::string& word, const std::vector<std::string>& words,
                    const char* unit, Range range, const char* text);
  bool integer(const char* key, PetscInt& value, Range range, const char* text);
  bool boolean(const char* key, bool& value, const char* text);
  bool string(const char* key, std::string& value, const char* text);
  bool reals(const char* key, std::vector<double>& values, const char* unit, Range range, const char* text,
             const std::string& or_else = {});
  bool integers(const char* key, std::vector<PetscInt>& values, Range range, const char* text);
  bool strings(const char* key, std::vector<std::string>& values, const char* text);
  /// Prints the line of a key that others read, and makes it known.
  void explain(const char* key, const char* takes, const char* text);

  /// @brief One name out of a fixed list, stored as the value that stands beside it.
  template <class T>
  bool choice(const char* key, T& value, std::span<const std::pair<const char*, T>> names, const char* text) {
    std::vector<T> values{value};
    const bool given = choices<T>(key, values, names, text);
    if (values.size() != 1) {
      throw InputError{std::string{"option "} + key + " takes one value, " + std::to_string(values.size()) + " given"};
    }
    value = values.front();
    return given;
  }
  /// @brief A list of names out of a fixed list.
  template <class T>
  bool choices(const char* key, std::vector<T>& values, std::span<const std::pair<const char*, T>> names,
               const char* text) {
    std::vector<std::string> words;
    for (const T& value : values) {
      const auto found = std::ranges::find(names, value, [](const auto& entry) { return entry.second; });
      words.emplace_back(found != names.end() ? found->first : "?");
    }
    std::vector<std::string> allowed;
    for (const auto& entry : names) {
      allowed.emplace_back(entry.first);
    }
    if (!named(key, words, allowed, text)) {
      return false;
    }
    values.clear();
    for (const std::string& word : words) {
      values.push_back(
          std::ranges::find(names, word, [](const auto& entry) { return std::string{entry.first}; })->second);
    }
    return true;
  }

 private:
  bool named(const char* key, std::vector<std::string>& words, const std::vector<std::string>& allowed,
             const char* text);
  std::vector<std::string> raw(const char* key, bool& given) const;
  void help(const char* key, const std::string& now, const std::string& kind, const std::string& text);

  MPI_Comm comm_;
  std::string title_;  ///< until it is printed
  bool print_help_;
};

/// @brief `values` as one entry per item: a single value serves for all; any other count than `count` is refused.
/// @throws InputError naming `key`, the count given and what it must match
template <class T>
[[nodiscard]] std::vector<T> one_per(const char* key, const std::vector<T>& values, std::size_t count,
                                     const char* what) {
  if (values.size() == count) {
    return values;
  }
  if (count == 0) {
    throw InputError{std::string{"option "} + key + " has nothing to apply to: " + what};
  }
  if (values.size() == 1) {
    return std::vector<T>(count, values.front());
  }
  const std::string expected = std::to_string(count) + " (" + what + ")";
  if (values.empty()) {
    throw InputError{std::string{"option "} + key + " is needed: number of values " + expected};
  }
  throw InputError{std::string{"option "} + key + ": " + std::to_string(values.size()) + " values given, expected " +
                   (count > 1 ? "1 or " : "") + expected};
}

/// @brief Text split at blanks, as PETSc does: what stands in quotes is one word.
[[nodiscard]] std::vector<std::string> option_words(const std::string& text);

/// @brief Refuses words that PETSc would skip or take for something else: one that belongs to no option, `--key`,
/// `-key=value`. @param[in] place " in ...", where the words stand; empty: the command line
/// @throws InputError naming the word and the likely cause
void check_option_words(std::span<const std::string> words, const std::string& place = {});

/// @brief Tells the checks below that options of PETSc's solvers are read behind a prefix:
/// `add_solver_prefix("filter_",
/// {"ksp_", "pc_"})` for `-filter_ksp_type`; or that PETSc reads a key for us. Remembered for the whole process.
/// @note Not collective. May be called again.
void add_solver_prefix(const std::string& prefix, std::span<const char* const> groups);
void add_known_key(const std::string& key);

/// @brief Refuses, of the keys that nobody has read yet, those of PETSc's solvers that lack their prefix and names of
/// types that PETSc does not know, and names the nearest. @note Call before the first `SetFromOptions`.
/// @throws InputError
void check_petsc_options();

/// @brief Refuses a key that nobody has read if it is of one of udar's groups or one or two slips from a known one, and
/// names the nearest known key; others that nobody has read are reported on standard error.
/// @param[in] group judge only the keys that start so, for a program that reads the others later
/// @note Collective; call after the last `SetFromOptions` and set-up.
void check_unknown_options(MPI_Comm comm, std::string_view group = {});

/// @brief A key that begins so and that nobody has read yet, with its dash; empty: none. @note Not collective.
[[nodiscard]] std::string unread_option(std::string_view group);

/// @brief A message of the library in the words of the command line. The library names quantities: a message may begin
/// with some ("support damping: -3 is not allowed"), others stand in grave accents (`filter frequency`). Those that are
/// keys of options, known here or PETSc's, become them: "option -support_damping: -3 is not allowed".
[[nodiscard]] std::string with_option_keys(const std::string& message);

/// @brief All options in the database, one `-key value` per line.
[[nodiscard]] std::string effective_options();

}  // namespace udar::petsc
