#include "udar/petsc/options.hpp"

#include <petscoptions.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

#include "petsc/help.hpp"
#include "petsc/option_keys.hpp"
#include "udar/petsc/session.hpp"

namespace udar::petsc {
namespace {

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
  throw InputError{std::string{"option "} + key + ": '" + word + "' is not allowed, expected " + expected +
                   place_of(key)};
}

/// What `word` stands for if it leaves an entry of a list to the default of its option.
template <class T>
std::optional<T> left_to_default(const char* key, const std::string& word, const std::vector<T>& defaults,
                                 const std::string& expected) {
  if (word != kDefaultWord) {
    return std::nullopt;
  }
  if (defaults.size() != 1) {
    refuse(key, word, expected + ": this option has no default, every entry needs a value");
  }
  return defaults.front();
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

OptionGroup::OptionGroup(MPI_Comm comm, const char* title)
    : comm_{comm}, title_{title}, print_help_{Session::help_requested()} {}

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

void OptionGroup::help(const char* key, const std::string& now, const std::string& kind, const std::string& text) {
  if (print_help_ && help_shows(key)) {
    const std::string title = std::exchange(title_, "");
    constexpr std::size_t kColumn = 28;
    std::string padded{key};
    padded.resize(std::max(padded.size(), kColumn), ' ');
    print_own_help(comm_, (title.empty() ? "" : "\n" + title + "\n") + "  " + padded + " <" + now + ">  " + kind +
                              "\n      " + text + "\n");
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
  const std::vector<double> defaults = std::exchange(values, {});
  for (const std::string& word : words) {
    if (const auto otherwise = left_to_default(key, word, defaults, expected)) {
      values.push_back(*otherwise);
      continue;
    }
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
  const std::vector<PetscInt> defaults = std::exchange(values, {});
  for (const std::string& word : words) {
    if (const auto otherwise = left_to_default(key, word, defaults, expected)) {
      values.push_back(*otherwise);
      continue;
    }
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

void OptionGroup::explain(const char* key, const char* takes, const char* text) {
  help(key, "", takes, text);
  known_keys().insert(key);
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
  for (std::string& word : words) {
    word = left_to_default(key, word, values, "text").value_or(word);
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
  for (std::string& word : found) {
    word = left_to_default(key, word, words, "one of" + list).value_or(word);
    if (std::ranges::find(allowed, word) == allowed.end()) {
      refuse(key, word, "one of" + list);
    }
  }
  words = std::move(found);
  return true;
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
