#include "udar/petsc/options.hpp"

#include <petscoptions.h>

#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <set>
#include <sstream>
#include <string_view>

#include "udar/petsc/session.hpp"
#include "udar/petsc/warnings.hpp"

namespace udar::petsc {
namespace {

constexpr std::array kOwnGroups = {"damping_", "ground_",  "beam_",  "structure_", "filter_", "support_",
                                   "contact_", "initial_", "load_",  "gauge_",     "output_", "restart_",
                                   "udar_",    "bench_",   "study_", "gravity",    "floor"};
/// What PETSc and SLEPc put behind the prefix of the line solver, nested solvers included.
constexpr std::array kSolverGroups = {"filter_ksp_",       "filter_pc_",         "filter_mat_",    "filter_sub_",
                                      "filter_mg_",        "filter_eps_",        "filter_st_",     "filter_redundant_",
                                      "filter_telescope_", "filter_fieldsplit_", "filter_esteig_", "filter_inner_",
                                      "filter_schwarz_",   "filter_moment_",     "contact_tao_"};
/// PETSc's that are often asked for, by name: a slip in one of them would go unseen, too.
constexpr std::array kPetscKeys = {"-ts_type",       "-ts_monitor",   "-ts_max_steps", "-ts_rk_type",
                                   "-ts_adapt_type", "-options_file", "-log_view",     "-ts_impact_moments"};
/// What PETSc reads when everything else is done.
constexpr std::array kLateGroups = {"ts_view", "options_", "log_",     "malloc",
                                    "memory_", "objects_", "mat_view", "mpidump"};
/// A key nobody has read that is so many slips from a known one is taken for it.
constexpr std::size_t kSlips = 2;

std::set<std::string>& known_keys() {
  static std::set<std::string> keys{kPetscKeys.begin(), kPetscKeys.end()};
  return keys;
}

std::string number(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

template <class T>
std::string joined(const std::vector<T>& values, const std::function<std::string(const T&)>& text) {
  std::string all;
  for (const T& value : values) {
    all += (all.empty() ? "" : ",") + text(value);
  }
  return all;
}

std::string with_unit(const char* unit) { return std::string_view{unit} == "-" ? "" : std::string{" ["} + unit + "]"; }

[[noreturn]] void refuse(const char* key, const std::string& word, const std::string& expected) {
  throw InputError{std::string{"option "} + key + ": '" + word + "' is not allowed, expected " + expected};
}

/// Fewest insertions, deletions, replacements and swaps of neighbours that turn one word into the other.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> cost(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        cost[i][j] = i + j;
        continue;
      }
      const std::size_t replaced = cost[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      cost[i][j] = std::min({replaced, cost[i - 1][j] + 1, cost[i][j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        cost[i][j] = std::min(cost[i][j], cost[i - 2][j - 2] + 1);
      }
    }
  }
  return cost[a.size()][b.size()];
}

bool starts_with_any(std::string_view key, std::span<const char* const> prefixes) {
  return std::ranges::any_of(prefixes, [key](const char* prefix) { return key.starts_with(prefix); });
}

}  // namespace

bool Range::contains(double value) const noexcept {
  if (std::isinf(value)) {
    return infinity_allowed && value > 0.0;
  }
  return (lowest_excluded ? value > lowest : value >= lowest) && value <= highest;  // false for NaN
}

std::string Range::text() const {
  const bool below = lowest > -std::numeric_limits<double>::max();
  const bool above = highest < std::numeric_limits<double>::max();
  if (below && above) {
    return lowest_excluded ? "> " + number(lowest) + " and <= " + number(highest)
                           : "from " + number(lowest) + " to " + number(highest);
  }
  if (below) {
    return (lowest_excluded ? "> " : ">= ") + number(lowest) + (infinity_allowed ? " or inf" : "");
  }
  return above ? "<= " + number(highest) : "finite";
}

OptionGroup::OptionGroup(MPI_Comm comm, const char* title) : comm_{comm}, print_help_{Session::help_requested()} {
  if (print_help_) {
    UDAR_CALL(PetscPrintf(comm_, "\n%s\n", title));
  }
}

std::vector<std::string> OptionGroup::raw(const char* key, bool& given) const {
  known_keys().insert(key);
  const char* value = nullptr;
  PetscBool set = PETSC_FALSE;
  UDAR_CALL(PetscOptionsFindPair(nullptr, nullptr, key, &value, &set));
  given = set == PETSC_TRUE;
  std::vector<std::string> words;
  std::stringstream text{value != nullptr ? value : ""};
  for (std::string word; std::getline(text, word, ',');) {
    const std::size_t first = word.find_first_not_of(" \t[]");
    const std::size_t last = word.find_last_not_of(" \t[]");
    words.push_back(first == std::string::npos ? "" : word.substr(first, last - first + 1));
  }
  return words;
}

void OptionGroup::help(const char* key, const std::string& now, const std::string& kind,
                       const std::string& text) const {
  if (print_help_) {
    UDAR_CALL(PetscPrintf(comm_, "  %-28s <%s>  %s\n      %s\n", key, now.c_str(), kind.c_str(), text.c_str()));
  }
}

bool OptionGroup::reals(const char* key, std::vector<double>& values, const char* unit, Range range, const char* text,
                        const std::string& or_else) {
  help(key, joined<double>(values, number), "number" + with_unit(unit) + ", " + range.text() + or_else, text);
  bool given = false;
  const std::vector<std::string> words = raw(key, given);
  if (!given) {
    return false;
  }
  const std::string expected = "a number " + range.text() + with_unit(unit) + or_else;
  if (words.empty()) {
    refuse(key, "", expected);
  }
  values.clear();
  for (const std::string& word : words) {
    double value = 0.0;
    const std::string_view digits = word.starts_with('+') ? std::string_view{word}.substr(1) : std::string_view{word};
    const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (status != std::errc{} || end != digits.data() + digits.size() || !range.contains(value)) {
      refuse(key, word, expected);
    }
    values.push_back(value);
  }
  return true;
}

bool OptionGroup::real(const char* key, double& value, const char* unit, Range range, const char* text) {
  std::vector<double> values{value};
  const bool given = reals(key, values, unit, range, text);
  if (values.size() != 1) {
    throw InputError{std::string{"option "} + key + " takes one value, " + std::to_string(values.size()) + " given"};
  }
  value = values.front();
  return given;
}

bool OptionGroup::real_or_word(const char* key, double& value, std::string& word, const std::vector<std::string>& words,
                               const char* unit, Range range, const char* text) {
  bool given = false;
  const std::vector<std::string> asked = raw(key, given);
  if (!print_help_ && asked.size() == 1 && std::ranges::find(words, asked.front()) != words.end()) {
    word = asked.front();
    return true;
  }
  std::string or_else;
  for (const std::string& allowed : words) {
    or_else += " or " + allowed;
  }
  std::vector<double> values{value};
  const bool numeric = reals(key, values, unit, range, text, or_else);
  if (values.size() != 1) {
    throw InputError{std::string{"option "} + key + " takes one value, " + std::to_string(values.size()) + " given"};
  }
  value = values.front();
  return numeric;
}

bool OptionGroup::integers(const char* key, std::vector<PetscInt>& values, Range range, const char* text) {
  help(key, joined<PetscInt>(values, [](const PetscInt& value) { return std::to_string(value); }),
       "whole number, " + range.text(), text);
  bool given = false;
  const std::vector<std::string> words = raw(key, given);
  if (!given) {
    return false;
  }
  const std::string expected =
      "a whole number " + range.text() + " and at most " + std::to_string(std::numeric_limits<PetscInt>::max());
  if (words.empty()) {
    refuse(key, "", expected);
  }
  values.clear();
  for (const std::string& word : words) {
    PetscInt value = 0;
    const auto [end, status] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (status != std::errc{} || end != word.data() + word.size() || !range.contains(static_cast<double>(value))) {
      refuse(key, word, expected);
    }
    values.push_back(value);
  }
  return true;
}

bool OptionGroup::integer(const char* key, PetscInt& value, Range range, const char* text) {
  std::vector<PetscInt> values{value};
  const bool given = integers(key, values, range, text);
  if (values.size() != 1) {
    throw InputError{std::string{"option "} + key + " takes one value, " + std::to_string(values.size()) + " given"};
  }
  value = values.front();
  return given;
}

bool OptionGroup::boolean(const char* key, bool& value, const char* text) {
  help(key, value ? "true" : "false", "true or false", text);
  bool given = false;
  const std::vector<std::string> words = raw(key, given);
  if (!given) {
    return false;
  }
  PetscBool parsed = PETSC_TRUE;
  if (!words.empty() && PetscOptionsStringToBool(words.front().c_str(), &parsed) != 0) {
    (void)take_error_message();
    refuse(key, words.front(), "true or false");
  }
  value = parsed == PETSC_TRUE;
  return true;
}

bool OptionGroup::strings(const char* key, std::vector<std::string>& values, const char* text) {
  help(key, joined<std::string>(values, [](const std::string& value) { return value; }), "text", text);
  bool given = false;
  std::vector<std::string> words = raw(key, given);
  if (!given) {
    return false;
  }
  if (words.empty() || std::ranges::any_of(words, &std::string::empty)) {
    throw InputError{std::string{"option "} + key + " needs a value: " + text};
  }
  values = std::move(words);
  return true;
}

bool OptionGroup::string(const char* key, std::string& value, const char* text) {
  std::vector<std::string> values;
  if (!value.empty()) {
    values.push_back(value);
  }
  if (!strings(key, values, text)) {
    return false;
  }
  value = joined<std::string>(values, [](const std::string& word) { return word; });
  return true;
}

bool OptionGroup::named(const char* key, std::vector<std::string>& words, const std::vector<std::string>& allowed,
                        const char* text) {
  const std::string list = joined<std::string>(allowed, [](const std::string& word) { return " " + word; });
  help(key, joined<std::string>(words, [](const std::string& word) { return word; }), "one of" + list, text);
  bool given = false;
  std::vector<std::string> found = raw(key, given);
  if (!given) {
    return false;
  }
  if (found.empty()) {
    refuse(key, "", "one of" + list);
  }
  for (const std::string& word : found) {
    if (std::ranges::find(allowed, word) == allowed.end()) {
      refuse(key, word, "one of" + list);
    }
  }
  words = std::move(found);
  return true;
}

void check_unknown_options(MPI_Comm comm, std::string_view group) {
  PetscInt count = 0;
  char** names = nullptr;
  char** values = nullptr;
  UDAR_CALL(PetscOptionsLeftGet(nullptr, &count, &names, &values));
  std::string unknown;
  std::string unused;
  std::string unread;
  std::string nearest;
  const auto add = [](std::string& list, std::string_view key) {
    list += std::string{list.empty() ? "-" : ", -"}.append(key);
  };
  for (const char* name : std::span{names, static_cast<std::size_t>(count)}) {
    const std::string_view key{name};
    if (!key.starts_with(group) || starts_with_any(key, kLateGroups) || !unknown.empty()) {
      continue;
    }
    const std::string option = "-" + std::string{key};
    nearest = *std::ranges::min_element(known_keys(), {},
                                        [&option](const std::string& known) { return edit_distance(option, known); });
    const std::size_t slips = edit_distance(option, nearest);
    if (slips == 0 || starts_with_any(key, kSolverGroups)) {
      add(unused, key);
    } else if (slips <= kSlips || starts_with_any(key, kOwnGroups)) {
      unknown = option;
    } else {
      add(unread, key);
    }
  }
  UDAR_CALL(PetscOptionsLeftRestore(nullptr, &count, &names, &values));
  if (!unknown.empty()) {
    throw InputError{"unknown option " + unknown + "; the nearest known option is " + nearest + " (see -help)"};
  }
  if (!unused.empty()) {
    warn(comm, "not used by the chosen solver: %s", unused.c_str());
  }
  if (!unread.empty()) {
    warn(comm, "read by nobody: %s", unread.c_str());
  }
}

std::string effective_options() {
  char* text = nullptr;
  UDAR_CALL(PetscOptionsGetAll(nullptr, &text));
  std::istringstream words{text != nullptr ? text : ""};
  UDAR_CALL(PetscFree(text));
  std::string lines;
  for (std::string word; words >> word;) {
    const bool key = word.size() > 1 && word[0] == '-' && std::isalpha(static_cast<unsigned char>(word[1])) != 0;
    lines += (lines.empty() ? "" : key ? "\n" : " ") + word;
  }
  return lines;
}

}  // namespace udar::petsc
