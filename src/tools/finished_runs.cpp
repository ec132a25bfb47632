#include "tools/finished_runs.hpp"

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"

namespace udar::study {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kName = "finished-";

std::vector<fs::path> files_in(const std::string& folder) {
  std::vector<fs::path> all;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator{folder, error}) {
    if (entry.path().filename().string().starts_with(kName)) {
      all.push_back(entry.path());
    }
  }
  return all;
}

/// All options that a run has but for where it writes.
std::string identity(const PlannedRun& run) {
  const ScopedOptions own{run.options};
  std::string text;
  for (const std::string& line : split(petsc::effective_options(), '\n')) {
    if (!line.starts_with("-output_directory") && !line.starts_with("-output_overwrite")) {
      text += line + "\n";
    }
  }
  return text;
}

std::string read_all(const std::string& folder) {
  std::string text;
  for (const fs::path& path : files_in(folder)) {
    std::ifstream file{path};
    text.append(std::istreambuf_iterator<char>{file}, {});
    text += '\n';  // behind a line that was cut short
  }
  return text;
}

}  // namespace

void FinishedRuns::clear() const {
  std::error_code error;
  for (const fs::path& path : files_in(folder_)) {
    fs::remove(path, error);
  }
}

std::map<std::size_t, Outcome> FinishedRuns::among(MPI_Comm comm, std::span<const PlannedRun> runs) const {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  std::string text = rank == 0 ? read_all(folder_) : "";
  auto size = static_cast<unsigned long>(text.size());
  MPI_Bcast(&size, 1, MPI_UNSIGNED_LONG, 0, comm);
  text.resize(size);
  MPI_Bcast(text.data(), static_cast<int>(size), MPI_CHAR, 0, comm);
  std::map<std::string, Json> kept;
  for (const std::string& line : split(text, '\n')) {
    const Json entry = Json::parse(line, nullptr, false);
    if (entry.is_object() && entry.contains("options") && entry.contains("outcome")) {
      kept[entry["options"]] = entry["outcome"];
    }
  }
  std::map<std::size_t, Outcome> found;
  for (const PlannedRun& run : runs) {
    if (const auto outcome = kept.find(identity(run)); !kept.empty() && outcome != kept.end()) {
      found[run.number] = unpacked(outcome->second);
    }
  }
  return found;
}

void FinishedRuns::add(const PlannedRun& run, const Outcome& outcome) const {
  const std::string path = folder_ + "/" + std::string{kName} + std::to_string(group_) + ".jsonl";
  std::ofstream file{path, std::ios::app};
  file << '\n'
       << Json{{"options", identity(run)}, {"outcome", packed(run.number, outcome)}}.dump() << '\n'
       << std::flush;
  if (!file.good()) {
    throw FileError{"option -output_directory: cannot write '" + path + "'"};
  }
}

}  // namespace udar::study
