#include "app/continued_run.hpp"

#include <petscsys.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "udar/io/checkpoint.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/option_sources.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/scoped_options.hpp"
#include "udar/petsc/session.hpp"

namespace udar::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* kContinue = "-continue";
constexpr const char* kDirectory = "-output_directory";
constexpr const char* kRestart = "-restart_file";
constexpr const char* kOptions = "options";
constexpr const char* kPlace = "working directory";
constexpr char kBetween = '\0';  // keys and values; none of them has it

[[noreturn]] void refuse(const std::string& folder, const std::string& why) {
  throw InputError{"option -continue: '" + folder + "' is not allowed, expected the folder of a run: " + why};
}

/// The questions to the disk are rank 0's.
template <class Question>
bool first_rank_finds(MPI_Comm comm, const Question& question) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  int found = rank == 0 && question() ? 1 : 0;
  MPI_Bcast(&found, 1, MPI_INT, 0, comm);
  return found != 0;
}

bool exists(MPI_Comm comm, const fs::path& path) {
  std::error_code error;
  return first_rank_finds(comm, [&] { return fs::exists(path, error); });
}

/// The last restart file that is whole, in the place of the last one; empty: there is none at all.
std::string whole_file(MPI_Comm comm, const std::string& folder) {
  std::string path = (fs::path{folder} / "restart.h5").string();
  const std::string before = io::previous_checkpoint(path);
  if (!exists(comm, path) && !exists(comm, before)) {
    return "";
  }
  const std::string failure = exists(comm, path) ? io::checkpoint_damage(comm, path) : "it is missing";
  if (failure.empty()) {
    return path;
  }
  const std::string other = exists(comm, before) ? io::checkpoint_damage(comm, before) : "it is missing";
  if (!other.empty()) {
    refuse(folder, "restart.h5: " + failure + "; restart.previous.h5: " + other);
  }
  UDAR_CALL(PetscPrintf(comm, "udar: '%s': %s; the run goes on from the restart file before\n", path.c_str(),
                        failure.c_str()));
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  std::error_code error;
  if (rank == 0) {
    fs::rename(before, path, error);
  }
  throw_together<FileError>(comm, error ? "restart file: cannot rename '" + before + "': " + error.message() : "");
  return path;
}

petsc::Options options_of(std::string_view text) {
  petsc::Options options;
  const auto word = [&text] {
    const std::size_t end = text.find(kBetween);
    const std::string found{text.substr(0, end)};
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    return found;
  };
  while (!text.empty()) {
    std::string key = word();
    std::string value = word();
    options.emplace_back(std::move(key), value.empty() ? std::nullopt : std::optional{std::move(value)});
  }
  return options;
}

/// Files that options name are those of the run, from wherever it is continued.
void go_to(MPI_Comm comm, const std::string& place) {
  std::error_code error;
  if (fs::current_path(error) == place) {
    return;
  }
  fs::current_path(place, error);
  if (!error) {
    UDAR_CALL(PetscPrintf(comm, "udar: files are looked for from '%s', where the run began\n", place.c_str()));
  }
}

/// The run's own name for its folder, where that still leads there.
void keep_folder(MPI_Comm comm, const std::string& folder) {
  const std::string named = petsc::option_value(kDirectory).value_or("udar-output");
  std::error_code error;
  if (!first_rank_finds(comm, [&] { return fs::equivalent(named, folder, error); })) {
    UDAR_CALL(PetscOptionsSetValue(nullptr, kDirectory, folder.c_str()));
  }
}

/// A run that wrote no restart file is begun, if it is known which.
ContinuedRun begin(MPI_Comm comm, const std::string& folder) {
  if (first_rank_finds(comm, [&] { return io::holds_a_run(folder); })) {
    refuse(folder, "it holds results, and no restart.h5 that they belong to");
  }
  if (petsc::inserted_files().empty()) {
    refuse(folder, "it holds no restart.h5; with a case file the run would begin there");
  }
  UDAR_CALL(PetscPrintf(comm, "udar: there is no restart file in '%s': the run begins\n", folder.c_str()));
  UDAR_CALL(PetscOptionsSetValue(nullptr, kDirectory, folder.c_str()));
  return {.folder = folder, .file = "", .known = false};
}

}  // namespace

std::map<std::string, std::string> texts_to_go_on() {
  std::string options;
  // A log has begun before the options of a run are put back; a study deals its points out itself.
  constexpr std::array kNotOfTheRun{"-log_", "-study_", "-options_left", "-help"};
  for (const auto& [key, value] : petsc::all_options()) {
    if (std::ranges::any_of(kNotOfTheRun, [&key](const char* group) { return key.starts_with(group); })) {
      continue;
    }
    options.append(key).append(1, kBetween).append(value.value_or("")).append(1, kBetween);
  }
  std::error_code error;
  return {{kOptions, options}, {kPlace, fs::current_path(error).string()}};
}

std::optional<ContinuedRun> take_up_run(MPI_Comm comm) {
  std::string folder;
  petsc::OptionGroup group{comm, "To go on"};
  const bool given = group.string(kContinue, folder,
                                  "go on with the run in this folder, in its own files and with its own options; with "
                                  "a case file it begins there if it has not yet");
  if (!given || petsc::Session::help_requested()) {
    return std::nullopt;
  }
  for (const char* key : {kDirectory, kRestart}) {
    if (petsc::option_value(key) && !petsc::given_in_file(key)) {
      throw InputError{std::string{"option "} + key + " is not allowed with -continue, which names the run's folder"};
    }
  }
  folder = fs::absolute(folder).lexically_normal().string();
  UDAR_CALL(PetscOptionsClearValue(nullptr, kContinue));  // none of the run
  io::FolderLock lock;
  if (exists(comm, folder)) {
    lock = io::FolderLock{comm, folder};
  }
  const std::string file = whole_file(comm, folder);
  if (file.empty()) {
    ContinuedRun run = begin(comm, folder);
    run.lock = std::move(lock);
    return run;
  }
  for (const char* key : {kDirectory, kRestart}) {
    UDAR_CALL(PetscOptionsClearValue(nullptr, key));  // a case file's
  }
  const io::CheckpointHead head = io::read_checkpoint_head(comm, file);
  go_to(comm, head.texts.at(kPlace));
  petsc::add_missing_options(options_of(head.texts.at(kOptions)));
  keep_folder(comm, folder);
  if (!head.begun) {
    UDAR_CALL(PetscPrintf(comm, "udar: the run in '%s' has no step yet: it begins\n", folder.c_str()));
  }
  return ContinuedRun{.folder = folder, .file = head.begun ? file : "", .known = true, .lock = std::move(lock)};
}

}  // namespace udar::app
