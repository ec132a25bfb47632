#include "udar/petsc/scoped_options.hpp"

#include <petscsys.h>

#include <algorithm>
#include <map>
#include <ranges>
#include <sstream>

#include "udar/petsc/error.hpp"

namespace udar::petsc {

std::optional<std::string> option_value(const std::string& key) {
  const char* value = nullptr;
  PetscBool set = PETSC_FALSE;
  UDAR_CALL(PetscOptionsFindPair(nullptr, nullptr, key.c_str(), &value, &set));
  return set == PETSC_TRUE && value != nullptr && *value != '\0' ? std::optional<std::string>{value} : std::nullopt;
}

Options all_options() {
  // Asking for a key makes it one that is used: values of the others come from the list of these.
  std::map<std::string, std::optional<std::string>> unused;
  PetscInt count = 0;
  char** names = nullptr;
  char** values = nullptr;
  UDAR_CALL(PetscOptionsLeftGet(nullptr, &count, &names, &values));
  for (PetscInt i = 0; i < count; ++i) {
    unused[std::string{"-"} + names[i]] = values[i] != nullptr ? std::optional<std::string>{values[i]} : std::nullopt;
  }
  UDAR_CALL(PetscOptionsLeftRestore(nullptr, &count, &names, &values));
  char* text = nullptr;
  UDAR_CALL(PetscOptionsGetAll(nullptr, &text));
  std::istringstream words{text != nullptr ? text : ""};
  UDAR_CALL(PetscFree(text));
  Options options;
  for (std::string word; words >> word;) {
    // A word of a value may look like a key: only the database knows.
    if (std::ranges::find(options, word, &Options::value_type::first) != options.end()) {
      continue;
    }
    PetscBool key = PETSC_FALSE;
    if (const auto found = unused.find(word); found != unused.end()) {
      options.emplace_back(word, found->second);
    } else if (word.size() > 1 && word.front() == '-') {
      UDAR_CALL(PetscOptionsHasName(nullptr, nullptr, word.c_str(), &key));
    }
    if (key == PETSC_TRUE) {
      options.emplace_back(word, option_value(word));
    }
  }
  return options;
}

void add_missing_options(const Options& options) {
  for (const auto& [key, value] : options) {
    PetscBool given = PETSC_FALSE;
    UDAR_CALL(PetscOptionsHasName(nullptr, nullptr, key.c_str(), &given));
    if (given == PETSC_FALSE) {
      UDAR_CALL(PetscOptionsSetValue(nullptr, key.c_str(), value ? value->c_str() : nullptr));
    }
  }
}

ScopedOptions::ScopedOptions(const Options& options) {
  for (const auto& [key, value] : options) {
    PetscBool set = PETSC_FALSE;
    UDAR_CALL(PetscOptionsHasName(nullptr, nullptr, key.c_str(), &set));
    before_.push_back({.key = key, .given = set == PETSC_TRUE, .value = option_value(key)});
    UDAR_CALL(PetscOptionsSetValue(nullptr, key.c_str(), value ? value->c_str() : nullptr));
  }
}

ScopedOptions::~ScopedOptions() {
  for (const Before& entry : before_ | std::views::reverse) {
    if (entry.given) {
      PetscOptionsSetValue(nullptr, entry.key.c_str(), entry.value ? entry.value->c_str() : nullptr);
    } else {
      PetscOptionsClearValue(nullptr, entry.key.c_str());
    }
  }
}

}  // namespace udar::petsc
