#include "tools/output.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "tools/timing.hpp"
#include "udar/filter/bending_fields.hpp"
#include "udar/io/results_file.hpp"
#include "udar/motion/observer.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/beam_chain.hpp"

namespace udar::bench {

PlainFile::~PlainFile() {
  close(descriptor_);
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

void PlainFile::write_bytes(std::size_t bytes) {
  while (bytes > 0) {
    const ssize_t written = write(descriptor_, block_.data(), std::min(bytes, block_.size()));
    if (written <= 0) {
      throw FileError{"'" + path_ + "' cannot be written: " + std::generic_category().message(errno)};
    }
    bytes -= static_cast<std::size_t>(written);
  }
}

void output(const BeamChain& beam, const std::string& directory, long repeats) {
  const MPI_Comm comm = beam.comm();
  int rank = 0;
  int ranks = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &ranks);
  const std::string path = (std::filesystem::path{directory} / "udar-bench.h5").string();
  nlohmann::ordered_json result{{"elements", beam.elements()}, {"ranks", ranks}};
  {
    const auto count = static_cast<std::size_t>(beam.local_nodes());
    io::RunLayout layout{beam.points(), beam.topology()};
    const std::vector<double> field(count, 1.0);
    const std::vector<std::uint8_t> resting(count);
    std::vector<Field> shown;
    std::vector<FieldInfo> infos{kMotionFields.begin(), kMotionFields.end()};
    infos.insert(infos.end(), kBendingFields.begin(), kBendingFields.end());
    infos.push_back(kRestingField);
    for (const FieldInfo& info : infos) {
      shown.push_back(info.flag ? Field{info, std::span<const std::uint8_t>{resting}}
                                : Field{info, std::span<const double>{field}});
      layout.fields.push_back(info);
    }
    io::ResultsFile results{layout, path};
    std::optional<PlainFile> plain;
    if (rank == 0) {
      plain.emplace(path + ".plain");
    }
    std::size_t bytes = 0;
    for (const FieldInfo& info : layout.fields) {
      const PetscInt places = info.where == Where::cells ? beam.elements() : beam.nodes();
      bytes += info.rows ? static_cast<std::size_t>(places) * info.bytes() : 0;
    }
    double time = 0.0;
    Timed fields{.body = [&] {
      results.append_fields({.time = time += 1.0, .fields = shown, .energy = {}, .support_impulse = {}});
    }};
    Timed one{.body = [&] {
      if (plain) {
        plain->write_bytes(bytes);
      }
    }};
    sample(comm, {&fields, &one}, repeats, 0.0);
    result["bytes_per_row"] = bytes;
    const auto put = [&](const char* name, const Timed& timed) {
      result[std::string{name} + "_seconds"] = {
          {"median", timed.median()}, {"low", timed.best()}, {"high", timed.worst()}};
      result[std::string{name} + "_bandwidth"] = static_cast<double>(bytes) / timed.median();
    };
    put("fields", fields);
    put("plain", one);
    result["fields_over_plain"] = one.median() / fields.median();
    results.close();
  }
  if (rank == 0) {
    std::filesystem::remove(path);
  }
  UDAR_CALL(PetscPrintf(comm, "%s\n", result.dump(2).c_str()));
}

}  // namespace udar::bench
