#include "udar/petsc/option_sources.hpp"

#include <petscsys.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>
#include <string_view>
#include <utility>

#include "petsc/option_keys.hpp"
#include "petsc/yaml_options.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/session.hpp"

namespace udar::petsc {
namespace {

/// The whole file as rank 0 reads it, on all ranks.
std::string shared_file(MPI_Comm comm, const std::string& path) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  std::string failure;
  std::string text;
  if (rank == 0) {
    errno = 0;
    std::ifstream file{path, std::ios::binary};
    const bool empty = file.peek() == std::ifstream::traits_type::eof();  // opening a folder succeeds, reading does not
    if (file.is_open() && errno == 0 && !empty) {
      constexpr std::size_t kLongest = std::size_t{1} << 24U;  // a device has no end
      std::array<char, 4096> block{};
      while (text.size() <= kLongest && (file.read(block.data(), block.size()) || file.gcount() > 0)) {
        text.append(block.data(), static_cast<std::size_t>(file.gcount()));
      }
      if (text.size() > kLongest) {
        failure = "option -options_file: cannot read '" + path + "': it is longer than 16 MiB";
      }
    }
    if (failure.empty() && (!file.is_open() || errno != 0)) {
      failure = "option -options_file: cannot read '" + path + "': " + std::strerror(errno != 0 ? errno : EIO);
    }
  }
  throw_together<InputError>(comm, failure);
  return shared_text(comm, text);
}

/// As PETSc does: by the name, or by how the text starts.
bool is_yaml(const std::string& path, const std::string& text) {
  constexpr std::array kEnds{".yaml", ".yml", ".json"};
  return std::ranges::any_of(kEnds, [&path](const char* end) { return path.ends_with(end); }) ||
         text.starts_with("%YAML ") || text.starts_with("---");
}

void insert_yaml(const std::string& text, const std::string& name) {
  for (const GivenOption& option : read_yaml(text, name)) {
    UDAR_CALL(PetscOptionsSetValue(nullptr, option.key.c_str(), option.value ? option.value->c_str() : nullptr));
    option_origins().places[option.key] = " (" + name + " line " + std::to_string(option.line) + ")";
  }
}

}  // namespace

std::vector<OptionSource> take_sources(std::vector<std::string>& words) {
  using Kind = OptionSource::Kind;
  constexpr std::array kKeys{std::pair{"-options_file", Kind::file}, std::pair{"-options_file_yaml", Kind::yaml_file},
                             std::pair{"-options_string_yaml", Kind::yaml_text}};
  std::vector<OptionSource> sources;
  for (auto word = words.begin(); word != words.end();) {
    const auto* const found = std::ranges::find(kKeys, *word, [](const auto& key) { return std::string{key.first}; });
    if (found == kKeys.end()) {
      ++word;
      continue;
    }
    const bool named = word + 1 != words.end() && !(word + 1)->starts_with('-');
    sources.push_back({.kind = found->second, .text = named ? *(word + 1) : ""});
    word = words.erase(word, word + (named ? 2 : 1));
  }
  return sources;
}

void insert_source(MPI_Comm comm, const OptionSource& source) {
  if (source.text.empty()) {
    throw InputError{"option -options_file needs a value: the name of a case file"};
  }
  if (source.kind == OptionSource::Kind::yaml_text) {
    insert_yaml(source.text, "-options_string_yaml");
    return;
  }
  std::string path = source.text;
  constexpr std::string_view kForced{":yaml"};
  const bool forced = source.kind == OptionSource::Kind::yaml_file || path.ends_with(kForced);
  path.resize(path.ends_with(kForced) ? path.size() - kForced.size() : path.size());
  const std::string text = shared_file(comm, path);
  option_origins().files.push_back(path);
  if (forced || is_yaml(path, text)) {
    insert_yaml(text, path);
    return;
  }
  std::string failure;
  if (PetscOptionsInsertFile(comm, nullptr, path.c_str(), PETSC_TRUE) != 0) {
    failure = "option -options_file: '" + path +
              "' is neither YAML (its name ends in .yaml or .yml) nor a PETSc options file: " + take_error_message();
  }
  throw_together<InputError>(comm, failure);
}

OptionOrigins& option_origins() {
  static OptionOrigins origins;
  return origins;
}

bool given_in_file(const std::string& key) { return option_origins().places.contains(key); }

const std::vector<std::string>& inserted_files() { return option_origins().files; }

std::string shared_text(MPI_Comm comm, const std::string& own) {
  auto length = static_cast<unsigned long long>(own.size());
  MPI_Bcast(&length, 1, MPI_UNSIGNED_LONG_LONG, 0, comm);
  std::string text = own;
  text.resize(length);
  MPI_Bcast(text.data(), static_cast<int>(length), MPI_CHAR, 0, comm);
  return text;
}

std::string place_of(const std::string& option) {
  const std::map<std::string, std::string>& places = option_origins().places;
  const auto found = places.find(option);
  return found == places.end() ? "" : found->second;
}

void forget_place(const std::string& option) { option_origins().places.erase(option); }

}  // namespace udar::petsc
