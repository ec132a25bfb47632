#include "udar/io/checkpoint.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <system_error>

#include "io/file_checksum.hpp"
#include "io/text_file.hpp"
#include "udar/io/hdf5_file.hpp"
#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

constexpr const char* kFormat = "udar checkpoint";
constexpr const char* kParameters = "/parameters";
constexpr const char* kOfPoints = "/node_fields";
constexpr const char* kOfCells = "/cell_fields";
constexpr const char* kScalars = "/scalars";
constexpr const char* kTime = "time";
constexpr const char* kTexts = "/texts";
constexpr std::int64_t kFormatVersion = 5;

/// Sum over all nodes, modulo 2^64, of the bits of each value times an odd number of its node: the same on any number
/// of ranks, and different if a value, or the place of one, is.
std::uint64_t checksum(MPI_Comm comm, const NodeRange& nodes, const std::vector<double>& values) {
  std::uint64_t sum = 0;
  auto weight = 2 * static_cast<std::uint64_t>(nodes.begin) + 1;
  for (const double value : values) {
    // A value of zero counts too.
    sum += (std::bit_cast<std::uint64_t>(value) + 1) * weight;
    weight += 2;
  }
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, comm);
  return sum;
}

/// Brings a file, or the entries of a folder, to the disk; returns errno, 0 if all went well.
int sync_path(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) {
    return errno;
  }
  const int error = fsync(descriptor) == 0 || errno == EINVAL ? 0 : errno;  // EINVAL: nothing to wait for
  close(descriptor);
  return error;
}

/// Puts the finished file in the place of the older one, which is kept; returns errno, 0 if all went well.
int replace(const std::string& finished, const std::string& path) {
  if (const int error = sync_path(finished); error != 0) {
    return error;
  }
  if (std::rename(path.c_str(), previous_checkpoint(path).c_str()) != 0 && errno != ENOENT) {
    return errno;
  }
  if (std::rename(finished.c_str(), path.c_str()) != 0) {
    return errno;
  }
  const std::string folder = std::filesystem::path{path}.parent_path().string();
  return sync_path(folder.empty() ? "." : folder);
}

using Fields = std::map<std::string, std::vector<double>>;

void write_fields(Hdf5File& file, const char* group, const PointOrder& order, const Fields& fields) {
  file.add_group(group);
  file.reserve(fields.size() * static_cast<std::uint64_t>(order.range().total) * sizeof(double));
  for (const auto& [name, own] : fields) {
    const std::string path = std::string{group} + "/" + name;
    const std::vector<double> values = order.to_user(own);
    file.add_node_values(path, order.range(), values);
    file.add_attribute(path, "checksum", checksum(order.comm(), order.range(), values));
  }
}

Fields read_fields(Hdf5File& file, const char* group, const PointOrder& order) {
  Fields fields;
  for (const std::string& name : file.dataset_names(group)) {
    const std::string path = std::string{group} + "/" + name;
    const std::vector<double> values = file.read_node_values(path, order.range());
    file.agree(checksum(order.comm(), order.range(), values) == file.read_uint(path, "checksum"), name + " is damaged");
    fields.emplace(name, order.from_user(values));
  }
  return fields;
}

void write_content(Hdf5File& file, const PointOrder& points, const PointOrder* cells, const MotionState& state) {
  file.add_attribute("/", "format", std::string{kFormat});
  file.add_attribute("/", "format_version", kFormatVersion);
  file.add_attribute("/", "units", std::string{"SI: m, kg, s, N, J"});
  file.add_attribute("/", "nodes", static_cast<std::int64_t>(points.range().total));
  file.add_attribute("/", "integrator", state.integrator);
  file.add_group(kParameters);
  for (const auto& [name, value] : state.parameters) {
    file.add_attribute(kParameters, name, value);
  }
  file.add_group(kScalars);
  for (const auto& [name, value] : state.scalars) {
    file.add_attribute(kScalars, name, value);
  }
  file.add_group("/tables");
  for (const auto& [name, values] : state.tables) {
    file.add_small("/tables/" + name, values);
  }
  file.add_group(kTexts);
  for (const auto& [name, text] : state.texts) {
    file.add_bytes(std::string{kTexts} + "/" + name, text);
  }
  write_fields(file, kOfPoints, points, state.fields);
  if (cells != nullptr) {
    write_fields(file, kOfCells, *cells, state.cells);
  }
  file.close();
}

std::string cannot_read(const std::string& path, const std::string& why) {
  return "restart file: cannot read '" + path + "': " + why;
}

/// One of this version.
std::unique_ptr<Hdf5File> open_checkpoint(MPI_Comm comm, const std::string& path) {
  auto file = std::make_unique<Hdf5File>(comm, path, Hdf5File::Access::read, "restart file");
  file->agree(file->has("/", "format") && file->read_text("/", "format") == kFormat, "not a checkpoint of udar");
  const std::int64_t version = file->read_int("/", "format_version");
  file->agree(version == kFormatVersion, "a checkpoint of format " + std::to_string(version) + ", known here is " +
                                             std::to_string(kFormatVersion));
  return file;
}

std::map<std::string, std::string> read_texts(Hdf5File& file) {
  std::map<std::string, std::string> texts;
  for (const std::string& name : file.dataset_names(kTexts)) {
    texts[name] = file.read_bytes(std::string{kTexts} + "/" + name);
  }
  return texts;
}

}  // namespace

void write_checkpoint(const PointOrder& points, const std::string& path, const MotionState& state,
                      const PointOrder* cells) {
  const MPI_Comm comm = points.comm();
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  const std::string unfinished = path + ".tmp";
  try {
    Hdf5File file{comm, unfinished, Hdf5File::Access::create};
    write_content(file, points, cells, state);
    const std::string failure = append_checksum(comm, unfinished);
    throw_together<FileError>(comm, failure.empty() ? "" : cannot_write(unfinished, failure));
  } catch (const FileError&) {
    if (rank == 0) {
      unlink(unfinished.c_str());
    }
    throw;
  }
  const int error = rank == 0 ? replace(unfinished, path) : 0;
  throw_together<FileError>(comm, error != 0 ? cannot_write(path, std::generic_category().message(error)) : "");
}

std::string previous_checkpoint(const std::string& path) {
  const std::filesystem::path file{path};
  return (file.parent_path() / (file.stem().string() + ".previous" + file.extension().string())).string();
}

std::string checkpoint_damage(MPI_Comm comm, const std::string& path) {
  const ChecksumFailure failure = checksum_failure(comm, path);
  throw_together<FileError>(comm, failure.unreadable ? cannot_read(path, failure.text) : "");
  return failure.text;
}

CheckpointHead read_checkpoint_head(MPI_Comm comm, const std::string& path) {
  const auto file = open_checkpoint(comm, path);
  CheckpointHead head{.texts = read_texts(*file), .begun = file->has(kScalars, kTime)};
  file->close();
  return head;
}

MotionState read_checkpoint(const PointOrder& points, const std::string& path,
                            const std::function<void(std::span<const Parameter>)>& accept, const PointOrder* cells) {
  const NodeRange& nodes = points.range();
  const std::string failure = checksum_failure(points.comm(), path).text;
  throw_together<FileError>(points.comm(), failure.empty() ? "" : cannot_read(path, failure));
  const auto opened = open_checkpoint(points.comm(), path);
  Hdf5File& file = *opened;
  MotionState state;
  for (const std::string& name : file.attribute_names(kParameters)) {
    state.parameters.push_back({.name = name, .value = file.read_text(kParameters, name)});
  }
  if (accept) {
    accept(state.parameters);
  }
  if (file.has("/", "integrator")) {
    state.integrator = file.read_text("/", "integrator");
  }
  file.agree(file.has(kScalars, kTime), "it was written before the first step of the run, which has to begin anew");
  const std::int64_t total = file.read_int("/", "nodes");
  file.agree(total == nodes.total,
             "a checkpoint of " + std::to_string(total) + " nodes, this run has " + std::to_string(nodes.total));
  for (const std::string& name : file.attribute_names(kScalars)) {
    state.scalars[name] = file.read_double(kScalars, name);
  }
  for (const std::string& name : file.dataset_names("/tables")) {
    state.tables[name] = file.read_small("/tables/" + name);
  }
  state.texts = read_texts(file);
  state.fields = read_fields(file, kOfPoints, points);
  if (cells != nullptr) {
    state.cells = read_fields(file, kOfCells, *cells);
  }
  file.close();
  return state;
}

}  // namespace udar::io
