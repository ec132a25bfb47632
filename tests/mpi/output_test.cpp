// ranks: 1 2 3; size: medium
/// @file
/// What a run writes: the content of its files, read back without udar, on any number of ranks; and what is left of
/// them when the disk is full.

#include <gtest/gtest.h>
#include <hdf5.h>
#include <petscsys.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "support/world.hpp"
#include "udar/filter/bending_fields.hpp"
#include "udar/io/run_directory.hpp"
#include "udar/io/run_writers.hpp"
#include "udar/io/summary.hpp"
#include "udar/io/versions.hpp"
#include "udar/motion/motion_state.hpp"
#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

namespace fs = std::filesystem;

using test::failure_of;
using test::TemporaryFolder;
using test::world_rank;
using test::world_size;

std::string read_text(const std::string& path) {
  std::ifstream file{path, std::ios::binary};
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::vector<std::string> read_lines(const std::string& path) {
  std::istringstream text{read_text(path)};
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) {
    lines.push_back(line);
  }
  return lines;
}

/// A results file opened by one rank alone, as any other program would.
class SerialFile {
 public:
  explicit SerialFile(const std::string& path) : id_{H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT)} {
    EXPECT_GE(id_, 0) << path << " is not readable";
  }
  SerialFile(const SerialFile&) = delete;
  SerialFile& operator=(const SerialFile&) = delete;
  ~SerialFile() { H5Fclose(id_); }

  [[nodiscard]] std::vector<hsize_t> shape(const char* name) const {
    const hid_t data = H5Dopen2(id_, name, H5P_DEFAULT);
    const hid_t space = H5Dget_space(data);
    std::vector<hsize_t> extent(static_cast<std::size_t>(std::max(H5Sget_simple_extent_ndims(space), 0)));
    H5Sget_simple_extent_dims(space, extent.data(), nullptr);
    H5Sclose(space);
    H5Dclose(data);
    return extent;
  }

  template <class Value>
  [[nodiscard]] std::vector<Value> read(const char* name, hid_t type) const {
    hsize_t size = 1;
    for (const hsize_t length : shape(name)) {
      size *= length;
    }
    std::vector<Value> values(size);
    const hid_t data = H5Dopen2(id_, name, H5P_DEFAULT);
    EXPECT_GE(H5Dread(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0) << name;
    H5Dclose(data);
    return values;
  }

  [[nodiscard]] std::vector<double> doubles(const char* name) const { return read<double>(name, H5T_NATIVE_DOUBLE); }
  [[nodiscard]] std::vector<std::int64_t> integers(const char* name) const {
    return read<std::int64_t>(name, H5T_NATIVE_INT64);
  }

  /// One column of a table.
  [[nodiscard]] std::vector<double> column(const char* table, const char* name) const {
    const hid_t type = H5Tcreate(H5T_COMPOUND, sizeof(double));
    H5Tinsert(type, name, 0, H5T_NATIVE_DOUBLE);
    std::vector<double> values = read<double>(table, type);
    H5Tclose(type);
    return values;
  }

  [[nodiscard]] std::string text_attribute(const char* name) const {
    const hid_t attribute = H5Aopen(id_, name, H5P_DEFAULT);
    const hid_t type = H5Aget_type(attribute);
    std::string text(H5Tget_size(type), '\0');
    H5Aread(attribute, type, text.data());
    H5Tclose(type);
    H5Aclose(attribute);
    return text;
  }

  template <class Value>
  [[nodiscard]] Value attribute(const char* name, hid_t type) const {
    Value value{};
    const hid_t attribute = H5Aopen(id_, name, H5P_DEFAULT);
    EXPECT_GE(H5Aread(attribute, type, &value), 0) << name;
    H5Aclose(attribute);
    return value;
  }

 private:
  hid_t id_;
};

/// This rank's share of `total` nodes; with fewer nodes than ranks some have none.
NodeRange share(PetscInt total) {
  return {total * world_rank() / world_size(), total * (world_rank() + 1) / world_size(), total};
}

std::vector<FieldInfo> fields_of_a_beam() {
  std::vector<FieldInfo> fields{kMotionFields.begin(), kMotionFields.end()};
  fields.insert(fields.end(), kBendingFields.begin(), kBendingFields.end());
  fields.push_back(kRestingField);
  return fields;
}

/// Points half a metre apart that weigh as many kilograms as metres they are from the first, and the lines between
/// them; they live until the end of the test program.
RunLayout layout_of(PetscInt nodes) {
  static std::vector<std::unique_ptr<const PlacedPoints>> kept;
  const NodeRange own = share(nodes);
  PointTable table;
  Topology topology;
  for (PetscInt i = own.begin; i < own.end; ++i) {
    table.place.push_back({.x = 0.5 * static_cast<double>(i)});
    table.mass.push_back(table.place.back().x);
    if (i + 1 < nodes) {
      topology.corners.insert(topology.corners.end(), {i, i + 1});
    }
  }
  kept.push_back(std::make_unique<const PlacedPoints>(PETSC_COMM_WORLD, 1, table));
  RunLayout layout{*kept.back(), topology};
  layout.fields = fields_of_a_beam();
  const std::vector<double> unknown(table.mass.size(), std::numeric_limits<double>::quiet_NaN());
  layout.peaks = {{"stress", "Pa", "moment", unknown}, {"utilisation", "1", "moment", unknown}};
  layout.gauges.node = {nodes - 1, 0};
  layout.gauges.height = {{{nodes - 1, 1.0}}, {{0, 1.0}}};
  layout.gauges.position = {0.5 * static_cast<double>(nodes), 0.1};
  layout.supports = {{1.0, 0.2, -0.1, 0.5, 1}, {2.0, 0.0, 0.3, 0.25, -1}};
  layout.filter_frequency = 1000.0;
  layout.options_text = "-beam_elements 9\n-filter_frequency 1000\n";
  return layout;
}

/// Calls of fsync by this process, the libraries' included.
int waits_for_disk = 0;

/// Field values that tell quantity, row and node.
double field_value(int quantity, int row, PetscInt node) {
  return quantity + 10.0 * row + 0.0078125 * static_cast<double>(node);
}
std::uint8_t resting_value(int row, PetscInt node) { return (row + node) % 3 == 0 ? 1 : 0; }

/// The fields of a beam with these values.
std::vector<Field> fields_and_flags(const std::vector<std::span<const double>>& numbers,
                                    std::span<const std::uint8_t> resting) {
  std::vector<Field> shown;
  for (const FieldInfo& info : fields_of_a_beam()) {
    shown.push_back(info.flag ? Field{info, resting} : Field{info, numbers[shown.size()]});
  }
  return shown;
}

/// A state to be written, made of `field_value`.
class State {
 public:
  State(const State&) = delete;  // what is shown lies in it
  State& operator=(const State&) = delete;
  ~State() = default;
  State(const NodeRange& nodes, int row, double time) : time_{time} {
    for (PetscInt node = nodes.begin; node < nodes.end; ++node) {
      for (int quantity = 0; quantity < 4; ++quantity) {
        fields_[static_cast<std::size_t>(quantity)].push_back(field_value(quantity, row, node));
      }
      resting_.push_back(resting_value(row, node));
    }
    support_impulse_ = {1.0 * row, 0.0 - 2.0 * row};
    zone_ = {};
    for (PetscInt node = nodes.begin; node < nodes.end && row % 2 == 1; ++node) {  // in every second row
      ++zone_.masses;
      zone_.x_min = std::min(zone_.x_min, 0.5 * static_cast<double>(node));
      zone_.x_max = std::max(zone_.x_max, 0.5 * static_cast<double>(node));
    }
    // The shear is the third once more.
    shown_ = fields_and_flags({fields_[0], fields_[1], fields_[2], fields_[3], fields_[2]}, resting_);
    energy_ = {.kinetic = 2.0 + row, .load_potential = -1.0, .lost_in_impacts = 0.25, .initial = 1.0, .scale = 2.0};
  }
  [[nodiscard]] Snapshot snapshot() const {
    return {.time = time_, .fields = shown_, .energy = energy_, .support_impulse = support_impulse_, .zone = zone_};
  }

 private:
  double time_;
  std::array<std::vector<double>, 4> fields_;
  std::vector<std::uint8_t> resting_;
  std::vector<Field> shown_;
  EnergyLedger energy_;
  std::vector<double> support_impulse_;
  ContactZone zone_;
};

constexpr double kInterval = 0.125;  // exact in binary, so times are too

using Writers = std::vector<std::unique_ptr<Observer>>;

/// What a run does with its observers at one time.
void write_row(const Writers& writers, const NodeRange& nodes, int row) {
  const State state{nodes, row, kInterval * row};
  for (const auto& writer : writers) {
    if (writer->interval() > 0.0) {
      writer->snapshot(state.snapshot());
    }
  }
}

template <class Record>
void put(StepRecords<Record>& step, const std::vector<Record>& records) {
  for (const Record& record : records) {
    step.push_back(record);
  }
}

void write_events(const Writers& writers, const std::vector<ImpactRecord>& impacts,
                  const std::vector<RestRecord>& rests) {
  StepRecords<ImpactRecord> hits;
  StepRecords<RestRecord> stops;
  put(hits, impacts);
  put(stops, rests);
  std::array<PetscInt, 2> all{static_cast<PetscInt>(impacts.size()), static_cast<PetscInt>(rests.size())};
  MPI_Allreduce(MPI_IN_PLACE, all.data(), 2, MPIU_INT, MPI_SUM, PETSC_COMM_WORLD);
  for (const auto& writer : writers) {
    writer->events(hits, stops, {.impacts = all[0], .rests = all[1]});
  }
}

void finish(const Writers& writers) {
  for (const auto& writer : writers) {
    writer->finish();
  }
}

void expect_fields(const SerialFile& file, PetscInt nodes, int rows) {
  const std::vector<hsize_t> shape{static_cast<hsize_t>(rows), static_cast<hsize_t>(nodes)};
  const std::array names{"/fields/mass_position", "/fields/mass_velocity", "/fields/line_position", "/fields/moment"};
  ASSERT_EQ(file.shape("/fields/time"), std::vector<hsize_t>{shape[0]});
  const std::vector<double> times = file.doubles("/fields/time");
  for (int row = 0; row < rows; ++row) {
    EXPECT_EQ(times[static_cast<std::size_t>(row)], kInterval * row);
  }
  for (int quantity = 0; quantity < 4; ++quantity) {
    const char* name = names[static_cast<std::size_t>(quantity)];
    ASSERT_EQ(file.shape(name), shape) << name;
    const std::vector<double> values = file.doubles(name);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto row = static_cast<int>(i / shape[1]);
      const auto node = static_cast<PetscInt>(i % shape[1]);
      wrong += values[i] == field_value(quantity, row, node) ? 0 : 1;
    }
    EXPECT_EQ(wrong, 0U) << name;
  }
  ASSERT_EQ(file.shape("/fields/resting"), shape);
  const auto resting = file.read<std::uint8_t>("/fields/resting", H5T_NATIVE_UINT8);
  for (std::size_t i = 0; i < resting.size(); ++i) {
    ASSERT_EQ(resting[i], resting_value(static_cast<int>(i / shape[1]), static_cast<PetscInt>(i % shape[1])));
  }
}

/// No file of this process may grow beyond `bytes` while this lives: a full disk that needs no disk of its own.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(std::uint64_t bytes) {
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int) = SIG_DFL;
};

// The folder

TEST(RunDirectory, LosesNoFileWhileARunWrites) {
  const TemporaryFolder folder;
  if (world_rank() == 0) {
    for (const char* name : {"gauges.csv", "results.h5", "summary.json.tmp"}) {
      std::ofstream{folder / name} << name;
    }
  }
  const RunFiles files{PETSC_COMM_WORLD, folder.path()};
  if (world_rank() == 0) {
    std::ofstream{folder / "gauges.csv"} << "longer than before";
    fs::remove(folder / "summary.json.tmp");  // not open meanwhile
  }
  EXPECT_EQ(failure_of([&] { files.require_present(); }), "");
  for (const bool replaced : {false, true}) {
    if (world_rank() == 0) {
      std::ofstream{folder / "other.h5"} << "another run's";
      fs::remove(folder / "results.h5");
      if (replaced) {
        fs::rename(folder / "other.h5", folder / "results.h5");
      }
    }
    EXPECT_EQ(failure_of([&] { files.require_present(); }),
              "output directory: cannot write '" + folder / "results.h5" +
                  "': it was removed or replaced while the run wrote into it");
  }
}

TEST(RunDirectory, IsCreatedWithItsParents) {
  const TemporaryFolder folder;
  prepare_run_directory(PETSC_COMM_WORLD, folder / "a/b/c", false);
  EXPECT_TRUE(fs::is_directory(folder / "a/b/c"));
  EXPECT_TRUE(fs::is_empty(folder / "a/b/c"));
}

TEST(RunDirectory, ThatHoldsARunIsRefusedAndLeftAlone) {
  const TemporaryFolder folder;
  for (const std::string sign : {"summary.json", "results.h5", "gauges.csv"}) {
    if (world_rank() == 0) {
      std::ofstream{folder / sign} << "precious";
    }
    const std::string message = failure_of([&] { prepare_run_directory(PETSC_COMM_WORLD, folder.path(), false); });
    EXPECT_EQ(message, "output directory: '" + folder.path() + "' already holds a run (" + sign +
                           "); give `output overwrite` to replace it, or another folder");
    if (world_rank() == 0) {
      EXPECT_EQ(read_text(folder / sign), "precious");
      fs::remove(folder / sign);
    }
    MPI_Barrier(PETSC_COMM_WORLD);
  }
}

TEST(RunDirectory, LosesOnlyTheOldRunWhenOverwritten) {
  const TemporaryFolder folder;
  if (world_rank() == 0) {
    for (const char* name : {"gauges.csv", "results.h5", "summary.json", "restart.h5", "notes.txt"}) {
      std::ofstream{folder / name} << name;
    }
  }
  prepare_run_directory(PETSC_COMM_WORLD, folder.path(), true, folder / "restart.h5");
  EXPECT_FALSE(fs::exists(folder / "gauges.csv"));
  EXPECT_FALSE(fs::exists(folder / "results.h5"));
  EXPECT_FALSE(fs::exists(folder / "summary.json"));
  EXPECT_TRUE(fs::exists(folder / "restart.h5"));
  EXPECT_TRUE(fs::exists(folder / "notes.txt"));
}

TEST(RunDirectory, ThatCannotBeMadeIsReported) {
  const TemporaryFolder folder;
  if (world_rank() == 0) {
    std::ofstream{folder / "file"} << "x";
  }
  EXPECT_EQ(failure_of([&] { prepare_run_directory(PETSC_COMM_WORLD, folder / "file/below", false); }),
            "output directory: '" + folder / "file/below" + "' cannot be made a folder: Not a directory");
  EXPECT_EQ(failure_of([&] { prepare_run_directory(PETSC_COMM_WORLD, folder / "file", false); }),
            "output directory: '" + folder / "file" + "' cannot be made a folder: Not a directory");
}

// A run

TEST(RunWriters, DescribeTheRunInTheResultsFile) {
  const TemporaryFolder folder;
  const RunLayout layout = layout_of(10);
  finish(make_run_writers(layout, folder.path(), kInterval, kInterval));
  if (world_rank() == 0) {
    const SerialFile file{folder / "results.h5"};
    EXPECT_EQ(file.text_attribute("options"), layout.options_text);
    const auto versions = library_versions();
    for (const char* library : {"udar", "petsc", "hdf5", "mpi"}) {
      EXPECT_EQ(file.text_attribute((std::string{library} + "_version").c_str()), versions.at(library));
      EXPECT_NE(versions.at(library), "");
    }
    EXPECT_EQ(file.attribute<double>("filter_frequency", H5T_NATIVE_DOUBLE), 1000.0);
    EXPECT_EQ(file.attribute<std::int64_t>("elements", H5T_NATIVE_INT64), 9);
    EXPECT_EQ(file.attribute<std::int64_t>("ranks", H5T_NATIVE_INT64), world_size());
    EXPECT_EQ(file.doubles("/x"), (std::vector<double>{0, 0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4, 4.5}));
    EXPECT_EQ(file.doubles("/mass"), file.doubles("/x"));
    EXPECT_EQ(file.integers("/node"), (std::vector<std::int64_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
    EXPECT_EQ(file.integers("/gauge_node"), (std::vector<std::int64_t>{9, 0}));
    EXPECT_EQ(file.doubles("/gauge_position"), (std::vector<double>{5, 0.1}));
    EXPECT_EQ(file.doubles("/support_position"), (std::vector<double>{1, 2}));
    EXPECT_EQ(file.doubles("/support_width"), (std::vector<double>{0.2, 0}));
    EXPECT_EQ(file.doubles("/support_height"), (std::vector<double>{-0.1, 0.3}));
    EXPECT_EQ(file.doubles("/support_side"), (std::vector<double>{1, -1}));
    EXPECT_EQ(file.doubles("/support_restitution"), (std::vector<double>{0.5, 0.25}));
    EXPECT_EQ(file.shape("/fields/moment"), (std::vector<hsize_t>{0, 10}));
    EXPECT_EQ(file.shape("/impacts"), std::vector<hsize_t>{0});
  }
}

TEST(RunWriters, NeedNoGaugesAndNoSupports) {
  const TemporaryFolder folder;
  RunLayout layout = layout_of(4);
  layout.gauges.node.clear();
  layout.gauges.height.clear();
  layout.gauges.position.clear();
  layout.supports.clear();
  layout.options_text.clear();
  const Writers writers = make_run_writers(layout, folder.path(), kInterval, kInterval);
  write_row(writers, layout.nodes(), 0);
  finish(writers);
  if (world_rank() == 0) {
    const SerialFile file{folder / "results.h5"};
    EXPECT_EQ(file.shape("/gauge_node"), std::vector<hsize_t>{0});
    EXPECT_EQ(file.shape("/support_side"), std::vector<hsize_t>{0});
    EXPECT_EQ(read_text(folder / "gauges.csv"), "time\n0\n");
  }
}

TEST(RunWriters, WriteTheFieldsOfAllRanks) {
  for (const PetscInt nodes : {2, 100}) {  // with 2, the third rank has none
    const TemporaryFolder folder;
    const RunLayout layout = layout_of(nodes);
    const Writers writers = make_run_writers(layout, folder.path(), kInterval, kInterval);
    constexpr int kRows = 70;  // more than share a chunk
    for (int row = 0; row < kRows; ++row) {
      write_row(writers, layout.nodes(), row);
    }
    finish(writers);
    if (world_rank() == 0) {
      expect_fields(SerialFile{folder / "results.h5"}, nodes, kRows);
    }
  }
}

TEST(RunWriters, SplitLongRowsIntoSeveralChunks) {
  const TemporaryFolder folder;
  const RunLayout layout = layout_of(300001);  // 2.4 MB per row
  const Writers writers = make_run_writers(layout, folder.path(), kInterval, kInterval);
  write_row(writers, layout.nodes(), 0);
  write_row(writers, layout.nodes(), 1);
  finish(writers);
  if (world_rank() == 0) {
    expect_fields(SerialFile{folder / "results.h5"}, 300001, 2);
  }
}

/// Level of gzip of a dataset, 0 without, and the rows of a chunk.
std::array<hsize_t, 2> packing_of(const std::string& path, const char* name) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t data = H5Dopen2(file, name, H5P_DEFAULT);
  const hid_t creation = H5Dget_create_plist(data);
  std::array<hsize_t, 2> chunk{};
  H5Pget_chunk(creation, 2, chunk.data());
  std::array<unsigned, 1> level{};
  std::size_t values = level.size();
  unsigned flags = 0;
  if (H5Pget_nfilters(creation) == 2) {  // behind the shuffle
    H5Pget_filter_by_id2(creation, H5Z_FILTER_DEFLATE, &flags, &values, level.data(), 0, nullptr, nullptr);
  }
  H5Pclose(creation);
  H5Dclose(data);
  H5Fclose(file);
  return {level[0], chunk[0]};
}

TEST(RunWriters, CompressLongRowsOneByOne) {
  for (const PetscInt nodes : {511, 512, 300001}) {  // a row of 512 is 4 KiB, the last has several chunks
    const TemporaryFolder folder;
    RunLayout layout = layout_of(nodes);
    layout.content.compression = 3;
    const Writers writers = make_run_writers(layout, folder.path(), kInterval, kInterval);
    for (int row = 0; row < 3; ++row) {
      write_row(writers, layout.nodes(), row);
      writers.back()->flush();
      if (world_rank() == 0 && row == 1) {
        fs::copy_file(folder / "results.h5", folder / "copy.h5");  // what a kill now would leave
        expect_fields(SerialFile{folder / "copy.h5"}, nodes, 2);
      }
    }
    finish(writers);
    if (world_rank() == 0) {
      expect_fields(SerialFile{folder / "results.h5"}, nodes, 3);
      const auto [level, rows] = packing_of(folder / "results.h5", "/fields/moment");
      EXPECT_EQ(level, nodes < 512 ? 0U : 3U);
      EXPECT_EQ(rows, nodes < 512 ? 64U : 1U);
    }
  }
}

// In order of time, then node, whichever rank has it and whenever a table is written.
TEST(RunWriters, MergeImpactsOfAllRanks) {
  const TemporaryFolder folder;
  RunLayout layout = layout_of(12);
  layout.content.impacts = {.raw = false, .rests = false, .merged = true, .window = 1.0};
  const Writers writers = make_run_writers(layout, folder.path(), kInterval, 0.0);
  for (int instant = 0; instant < 40; ++instant) {
    std::vector<ImpactRecord> impacts;
    for (PetscInt node = layout.nodes().begin; node < layout.nodes().end; ++node) {
      impacts.push_back({0.25 * instant, node, 0.5 * static_cast<double>(node), 0, -1.0 - instant, 0.5, 2.0, 0.75});
    }
    write_events(writers, impacts, {});
    write_row(writers, layout.nodes(), instant);
  }
  finish(writers);
  if (world_rank() == 0) {
    EXPECT_FALSE(fs::exists(folder / "impacts.csv"));
    const std::vector<std::string> lines = read_lines(folder / "impacts_merged.csv");
    ASSERT_EQ(lines.size(), 121U);
    EXPECT_EQ(lines[0], "time,last_time,node,x,support,impacts,speed_max,impulse,energy_loss");
    EXPECT_EQ(lines[1], "0,0.75,0,0,0,4,4,8,3");
    EXPECT_EQ(lines[24], "1,1.75,11,5.5,0,4,8,8,3");
    const SerialFile file{folder / "results.h5"};
    EXPECT_EQ(file.shape("/impacts_merged"), std::vector<hsize_t>{120});
    EXPECT_EQ(file.column("/impacts_merged", "speed_max").at(119), 40.0);
  }
}

TEST(RunWriters, KeepTheResultsReadableWhileTheRunGoesOn) {
  const TemporaryFolder folder;
  const RunLayout layout = layout_of(50);
  const Writers writers = make_run_writers(layout, folder.path(), kInterval, kInterval);
  for (int row = 0; row < 3; ++row) {
    write_row(writers, layout.nodes(), row);
    for (const auto& writer : writers) {
      writer->flush();
    }
    if (world_rank() == 0) {
      fs::copy_file(folder / "results.h5", folder / "copy.h5", fs::copy_options::overwrite_existing);
      expect_fields(SerialFile{folder / "copy.h5"}, 50, row + 1);
      EXPECT_TRUE(read_text(folder / "results.xdmf").ends_with("</Xdmf>\n"));
    }
    MPI_Barrier(PETSC_COMM_WORLD);
  }
  finish(writers);
}

// A checkpoint is written after this, and a run that goes on from there writes none of these rows again.
TEST(RunWriters, HoldNothingBackWhenFlushed) {
  const TemporaryFolder folder;
  const RunLayout layout = layout_of(12);
  SupportForces forces{2, kInterval, kInterval};
  const Writers writers = make_run_writers(layout, folder.path(), kInterval, kInterval, &forces);
  constexpr int kRows = 70;  // in blocks of 1, 2, 4, ..., 32 and 7 rows that wait
  for (int row = 0; row < kRows; ++row) {
    write_row(writers, layout.nodes(), row);
  }
  const bool first = world_rank() == 0;
  write_events(writers, std::vector<ImpactRecord>(first ? 3 : 0), std::vector<RestRecord>(first ? 2 : 0));
  for (const auto& writer : writers) {
    writer->flush();
  }
  if (first) {
    for (const char* name : {"gauges.csv", "energy.csv", "contact.csv"}) {
      EXPECT_EQ(read_lines(folder / name).size(), kRows + 1U) << name;
    }
    EXPECT_EQ(read_lines(folder / "impacts.csv").size(), 4U);
    EXPECT_EQ(read_lines(folder / "rests.csv").size(), 3U);
    fs::copy_file(folder / "results.h5", folder / "copy.h5");  // what a kill now would leave
    const SerialFile file{folder / "copy.h5"};
    expect_fields(file, 12, kRows);
    EXPECT_EQ(file.shape("/energy"), std::vector<hsize_t>{kRows});
    EXPECT_EQ(file.shape("/contact"), std::vector<hsize_t>{kRows});
    EXPECT_EQ(file.shape("/supports/force"), (std::vector<hsize_t>{kRows, 2}));
    EXPECT_EQ(file.shape("/impacts"), std::vector<hsize_t>{3});
    EXPECT_EQ(file.shape("/rests"), std::vector<hsize_t>{2});
    const std::string xdmf = read_text(folder / "results.xdmf");
    EXPECT_NE(xdmf.find("<Time Value=\"8.625\"/>"), std::string::npos) << "of the last row";
  }
  finish(writers);
}

// Waiting for the disk after each row took most of the time of a small run.
TEST(RunWriters, WaitForTheDiskOnceASecond) {
  const TemporaryFolder folder;
  const RunLayout layout = layout_of(20);
  const auto start = std::chrono::steady_clock::now();
  const int before = waits_for_disk;
  {
    const Writers writers = make_run_writers(layout, folder.path(), kInterval, kInterval);
    for (int row = 0; row < 500; ++row) {
      write_row(writers, layout.nodes(), row);
    }
    finish(writers);
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  // Six text files, results.h5 at its start and twice at its end.
  EXPECT_LE(waits_for_disk - before, 9.0 + seconds.count());
}

TEST(RunWriters, LeaveOutTheFieldsIfAskedTo) {
  const TemporaryFolder folder;
  const RunLayout layout = layout_of(10);
  const Writers writers = make_run_writers(layout, folder.path(), kInterval, 0.0);
  write_row(writers, layout.nodes(), 0);
  finish(writers);
  if (world_rank() == 0) {
    EXPECT_FALSE(fs::exists(folder / "results.xdmf"));
    EXPECT_EQ(SerialFile{folder / "results.h5"}.shape("/fields/time"), std::vector<hsize_t>{0});
    EXPECT_EQ(read_lines(folder / "energy.csv").size(), 2U);
  }
}

TEST(RunWriters, WriteTheGaugesInTheirOrder) {
  const TemporaryFolder folder;
  const RunLayout layout = layout_of(10);
  const Writers writers = make_run_writers(layout, folder.path(), kInterval, 0.0);
  constexpr int kRows = 700;  // some blocks and a part of one
  for (int row = 0; row < kRows; ++row) {
    write_row(writers, layout.nodes(), row);
  }
  finish(writers);
  if (world_rank() == 0) {
    const std::vector<std::string> lines = read_lines(folder / "gauges.csv");
    ASSERT_EQ(lines.size(), kRows + 1U);
    EXPECT_EQ(lines[0], "time,mass_0,velocity_0,line_0,mass_1,velocity_1,line_1");
    EXPECT_EQ(lines[1], "0,0.0703125,1.0703125,2.0703125,0,1,2");
    EXPECT_EQ(lines[2], "0.125,10.0703125,11.0703125,12.0703125,10,11,12");
    EXPECT_EQ(lines[700], "87.375,6990.0703125,6991.0703125,6992.0703125,6990,6991,6992");
  }
}

TEST(RunWriters, ShowTheFirstRowsOfTheTablesAtOnce) {
  const TemporaryFolder folder;
  const RunLayout layout = layout_of(10);
  const Writers writers = make_run_writers(layout, folder.path(), kInterval, 0.0);
  const std::array<std::size_t, 4> written{1, 1, 3, 3};  // blocks of 1, 2, 4, ... rows
  for (int row = 0; row < 4; ++row) {
    write_row(writers, layout.nodes(), row);
    if (world_rank() == 0) {
      EXPECT_EQ(read_lines(folder / "gauges.csv").size(), 1 + written[static_cast<std::size_t>(row)]);
      EXPECT_EQ(read_lines(folder / "energy.csv").size(), 1 + written[static_cast<std::size_t>(row)]);
    }
  }
  finish(writers);
}

TEST(RunWriters, WriteNumbersThatReadBackToTheSameDouble) {
  const TemporaryFolder folder;
  RunLayout layout = layout_of(1);
  layout.gauges.node = {0};
  layout.gauges.height = {{{0, 1.0}}};
  layout.gauges.position = {0.0};
  const Writers writers = make_run_writers(layout, folder.path(), 0.1, 0.0);
  const double third = 1.0 / 3.0;
  const double huge = 1.2345678901234567e+300;
  const bool here = layout.nodes().count() == 1;
  const std::vector<double> position(here ? 1 : 0, third);
  const std::vector<double> velocity(here ? 1 : 0, -huge);
  const std::vector<double> line(here ? 1 : 0, std::numeric_limits<double>::denorm_min());
  const std::vector<std::uint8_t> resting(here ? 1 : 0, 0);
  const std::vector<Field> shown = fields_and_flags({position, velocity, line, position, line}, resting);
  for (const auto& writer : writers) {
    if (writer->interval() > 0.0) {
      writer->snapshot({0.1, shown, {}, {}, {}});
    }
  }
  finish(writers);
  if (world_rank() == 0) {
    const std::string row = read_lines(folder / "gauges.csv").at(1);
    EXPECT_TRUE(row.starts_with("0.1,")) << row;
    double time = 0.0;
    std::array<double, 3> values{};
    ASSERT_EQ(std::sscanf(row.c_str(), "%lf,%lf,%lf,%lf", &time, &values[0], &values[1], &values[2]), 4);
    EXPECT_EQ(time, 0.1);
    EXPECT_EQ(values[0], third);
    EXPECT_EQ(values[1], -huge);
    EXPECT_EQ(values[2], std::numeric_limits<double>::denorm_min());
  }
}

TEST(RunWriters, WriteTheEnergyLedger) {
  const TemporaryFolder folder;
  const RunLayout layout = layout_of(10);
  const Writers writers = make_run_writers(layout, folder.path(), kInterval, 0.0);
  for (int row = 0; row < 5; ++row) {
    write_row(writers, layout.nodes(), row);
  }
  finish(writers);
  if (world_rank() == 0) {
    const std::vector<std::string> lines = read_lines(folder / "energy.csv");
    ASSERT_EQ(lines.size(), 6U);
    EXPECT_EQ(lines[0],
              "time,kinetic,line_strain,fictitious_springs,load_potential,support_springs,load_work,support_work,"
              "base_work,lost_in_impacts,lost_in_dampers,radiated,lost_in_hinges,total,drift");
    EXPECT_EQ(lines[5], "0.5,6,0,0,-1,0,0,0,0,0.25,0,0,0,5,2.125");
    const SerialFile file{folder / "results.h5"};
    EXPECT_EQ(file.column("/energy", "time"), (std::vector<double>{0, 0.125, 0.25, 0.375, 0.5}));
    EXPECT_EQ(file.column("/energy", "kinetic"), (std::vector<double>{2, 3, 4, 5, 6}));
    EXPECT_EQ(file.column("/energy", "load_potential"), (std::vector<double>(5, -1.0)));
    EXPECT_EQ(file.column("/energy", "lost_in_impacts"), (std::vector<double>(5, 0.25)));
    EXPECT_EQ(file.column("/energy", "total"), (std::vector<double>{1, 2, 3, 4, 5}));
    EXPECT_EQ(file.column("/energy", "drift"), (std::vector<double>{0.125, 0.625, 1.125, 1.625, 2.125}));
  }
}

TEST(RunWriters, WriteTheEventsOfAllRanksInOrder) {
  const TemporaryFolder folder;
  const RunLayout layout = layout_of(12);
  const Writers writers = make_run_writers(layout, folder.path(), kInterval, 0.0);
  // At each instant every second node is hit, and rests or leaves; a rank reports its own from right to left.
  for (int instant = 0; instant < 3; ++instant) {
    std::vector<ImpactRecord> impacts;
    std::vector<RestRecord> rests;
    for (PetscInt node = layout.nodes().end - 1; node >= layout.nodes().begin; --node) {
      if (node % 2 == 0) {
        const double x = 0.5 * static_cast<double>(node);
        impacts.push_back({0.5 * instant, node, x, node % 4 / 2, -3.0, 1.5, 4.5, 0.75});
        rests.push_back({0.5 * instant, node, x, node % 4 / 2, instant % 2 == 1});
      }
    }
    write_events(writers, impacts, rests);
  }
  finish(writers);
  if (world_rank() == 0) {
    const std::vector<std::string> impacts = read_lines(folder / "impacts.csv");
    ASSERT_EQ(impacts.size(), 19U);
    EXPECT_EQ(impacts[0], "time,node,x,support,velocity_before,velocity_after,impulse,energy_loss");
    EXPECT_EQ(impacts[1], "0,0,0,0,-3,1.5,4.5,0.75");
    EXPECT_EQ(impacts[2], "0,2,1,1,-3,1.5,4.5,0.75");
    EXPECT_EQ(impacts[18], "1,10,5,1,-3,1.5,4.5,0.75");
    const std::vector<std::string> rests = read_lines(folder / "rests.csv");
    ASSERT_EQ(rests.size(), 19U);
    EXPECT_EQ(rests[0], "time,node,x,support,event");
    EXPECT_EQ(rests[6], "0,10,5,1,rest");
    EXPECT_EQ(rests[7], "0.5,0,0,0,release");

    const SerialFile file{folder / "results.h5"};
    std::vector<double> times;
    std::vector<double> nodes;
    for (int i = 0; i < 18; ++i) {
      const int instant = i / 6;
      times.push_back(0.5 * instant);
      nodes.push_back(i % 6 * 2);
    }
    EXPECT_EQ(file.column("/impacts", "time"), times);
    EXPECT_EQ(file.column("/impacts", "node"), nodes);
    EXPECT_EQ(file.column("/impacts", "energy_loss"), std::vector<double>(18, 0.75));
    EXPECT_EQ(file.column("/rests", "node"), nodes);
    EXPECT_EQ(file.column("/rests", "release").at(7), 1.0);
    EXPECT_EQ(file.column("/rests", "release").at(17), 0.0);
  }
}

TEST(RunWriters, WriteForcesOfSupportsAndTheContactZone) {
  const TemporaryFolder folder;
  const RunLayout layout = layout_of(10);
  SupportForces forces{2, kInterval, 2.0 * kInterval};
  const Writers writers = make_run_writers(layout, folder.path(), kInterval, 0.0, &forces);
  for (int row = 0; row < 5; ++row) {
    write_row(writers, layout.nodes(), row);
  }
  finish(writers);
  EXPECT_EQ(forces.peaks()[1], -16.0);
  if (world_rank() == 0) {
    const std::vector<std::string> lines = read_lines(folder / "contact.csv");
    ASSERT_EQ(lines.size(), 6U);
    EXPECT_EQ(lines[0], "time,masses,x_min,x_max,force_0,impulse_0,force_1,impulse_1");
    EXPECT_EQ(lines[1], "0,0,nan,nan,0,0,0,0");
    EXPECT_EQ(lines[2], "0.125,10,0,4.5,4,1,-8,-2");  // half a window after the start
    EXPECT_EQ(lines[3], "0.25,0,nan,nan,8,2,-16,-4");
    EXPECT_EQ(lines[4], "0.375,10,0,4.5,8,3,-16,-6");
    const SerialFile file{folder / "results.h5"};
    EXPECT_EQ(file.shape("/supports/force"), (std::vector<hsize_t>{5, 2}));
    EXPECT_EQ(file.doubles("/supports/force"), (std::vector<double>{0, 0, 4, -8, 8, -16, 8, -16, 8, -16}));
    EXPECT_EQ(file.doubles("/supports/impulse"), (std::vector<double>{0, 0, 1, -2, 2, -4, 3, -6, 4, -8}));
    EXPECT_EQ(file.column("/contact", "masses"), (std::vector<double>{0, 10, 0, 10, 0}));
    EXPECT_EQ(file.column("/contact", "x_max")[3], 4.5);
    EXPECT_TRUE(std::isnan(file.column("/contact", "x_min")[2]));
    EXPECT_EQ(file.column("/contact", "force"), (std::vector<double>{0, -4, -8, -8, -8}));
  }
}

TEST(RunWriters, WriteOnlySumsOfManySupportsAsText) {
  const TemporaryFolder folder;
  RunLayout layout = layout_of(10);
  layout.supports.resize(65);
  SupportForces forces{65, 1.0, 0.0};
  const Writers writers = make_run_writers(layout, folder.path(), 1.0, 0.0, &forces);
  const std::vector<double> impulse(65, 2.0);
  const State state{layout.nodes(), 1, 1.0};
  Snapshot snapshot = state.snapshot();
  snapshot.support_impulse = impulse;
  for (const auto& writer : writers) {
    if (writer->interval() > 0.0) {
      writer->snapshot(snapshot);
    }
  }
  finish(writers);
  if (world_rank() == 0) {
    const std::vector<std::string> lines = read_lines(folder / "contact.csv");
    EXPECT_EQ(lines.at(0), "time,masses,x_min,x_max,force,impulse");
    EXPECT_EQ(lines.at(1), "1,10,0,4.5,130,130");
    EXPECT_EQ((SerialFile{folder / "results.h5"}.doubles("/supports/force")), std::vector<double>(65, 2.0));
  }
}

TEST(RunWriters, WriteTheExtremesOfMomentAndShear) {
  const TemporaryFolder folder;
  RunLayout layout = layout_of(10);
  layout.peaks[0].factor.assign(layout.peaks[0].factor.size(), 2.0);
  Peaks peaks;
  MotionState kept;
  {
    const Writers before = make_run_writers(layout, folder.path(), kInterval, 0.0);
    write_row(before, layout.nodes(), 4);
    for (const auto& writer : before) {
      writer->save(kept);
    }
    finish(before);
  }
  const Writers writers = make_run_writers(layout, folder.path(), kInterval, 0.0, nullptr, &peaks);
  for (const auto& writer : writers) {
    writer->restore(kept);
  }
  for (const int row : {2, 3}) {
    write_row(writers, layout.nodes(), row);
  }
  finish(writers);
  EXPECT_EQ(peaks.at("stress").value, 86.140625) << "of the last node, equal on every rank";
  EXPECT_EQ(peaks.at("stress").x, 4.5);
  EXPECT_EQ(peaks.at("stress").time, 4 * kInterval) << "in the run before";
  EXPECT_FALSE(peaks.contains("utilisation")) << "nothing is known of the yield stress";
  if (world_rank() == 0) {
    const std::vector<std::string> lines = read_lines(folder / "envelope.csv");
    ASSERT_EQ(lines.size(), 11U);
    EXPECT_EQ(lines[0], "node,x,moment_min,moment_max,shear_min,shear_max,stress_max,utilisation_max");
    EXPECT_EQ(lines[3], "2,1,23.015625,43.015625,22.015625,42.015625,86.03125,nan");
    EXPECT_EQ(lines[10], "9,4.5,23.0703125,43.0703125,nan,nan,86.140625,nan");
    const SerialFile file{folder / "results.h5"};
    EXPECT_EQ(file.shape("/envelope/shear_min"), std::vector<hsize_t>{9});
    const std::vector<double> most = file.doubles("/envelope/moment_max");
    const std::vector<double> least = file.doubles("/envelope/shear_min");
    for (PetscInt node = 0; node < 10; ++node) {
      EXPECT_EQ(most[static_cast<std::size_t>(node)], field_value(3, 4, node));
      if (node < 9) {
        EXPECT_EQ(least[static_cast<std::size_t>(node)], field_value(2, 2, node));
      }
    }
  }
}

TEST(RunWriters, WriteAStepOfManyEventsFromAllRanksAtOnce) {
  const TemporaryFolder folder;
  const RunLayout layout = layout_of(12);
  const Writers writers = make_run_writers(layout, folder.path(), kInterval, 0.0);
  // A step of one event a rank, later ranks first; one of 100000 on rank 0, 50000 on rank 1, ...; another small one.
  const auto at = [](double time) { return ImpactRecord{time, world_rank(), 0.0, 0, -1.0, 1.0, 2.0, 0.0}; };
  write_events(writers, {at(1.0 - 0.125 * world_rank())}, {});
  const int count = 100000 / (world_rank() + 1);
  std::vector<ImpactRecord> many;
  many.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    many.push_back(at(2.0 + i));
  }
  write_events(writers, many, {});
  write_events(writers, {at(1e6)}, {});
  finish(writers);
  int total = 0;
  MPI_Allreduce(&count, &total, 1, MPI_INT, MPI_SUM, PETSC_COMM_WORLD);
  if (world_rank() == 0) {
    const auto size = static_cast<std::size_t>(world_size());
    EXPECT_EQ(read_lines(folder / "impacts.csv").size(), size + 1) << "the text ends before the large step";
    const SerialFile file{folder / "results.h5"};
    const std::vector<double> times = file.column("/impacts", "time");
    const std::vector<double> nodes = file.column("/impacts", "node");
    ASSERT_EQ(times.size(), static_cast<std::size_t>(total) + 2 * size);
    for (std::size_t i = 0; i < size; ++i) {
      EXPECT_EQ(nodes[i], static_cast<double>(size - 1 - i));
      EXPECT_EQ(nodes[nodes.size() - size + i], static_cast<double>(i));
    }
    std::size_t disorder = 0;
    for (std::size_t i = size + 1; i < times.size() - size; ++i) {
      disorder += nodes[i - 1] < nodes[i] || (nodes[i - 1] == nodes[i] && times[i - 1] < times[i]) ? 0 : 1;
    }
    EXPECT_EQ(disorder, 0U);
    EXPECT_EQ(times[size], 2.0);
    const int events_of_last = 100000 / static_cast<int>(size);
    EXPECT_EQ(times[times.size() - size - 1], 1.0 + events_of_last);
  }
}

TEST(RunWriters, WriteEventsBeforeTheyFillTheMemory) {
  const TemporaryFolder folder;
  const RunLayout layout = layout_of(12);
  const Writers writers = make_run_writers(layout, folder.path(), kInterval, 0.0);
  write_row(writers, layout.nodes(), 0);  // the first block: rows 1 and 2 would now wait for each other
  const bool last = world_rank() == world_size() - 1;
  write_events(writers, std::vector<ImpactRecord>(last ? 60000 : 0), {});
  write_events(writers, std::vector<ImpactRecord>(last ? 6000 : 0), {});
  if (world_rank() == 0) {
    EXPECT_EQ(read_lines(folder / "impacts.csv").size(), 60001U);
  }
  finish(writers);
}

/// What a structure with more to tell does: two entries in its list of fields.
TEST(Fields, ReachEveryFileByOneEntry) {
  const TemporaryFolder folder;
  RunLayout layout = layout_of(10);
  layout.fields.push_back({.name = "torque", .unit = "N m", .extremes = true, .gauge = "torque"});
  layout.fields.push_back({.name = "velocity", .unit = "m/s", .body = Body::masses, .components = 3});
  layout.fields.push_back({.name = "tension", .unit = "N", .where = Where::cells, .extremes = true});
  {
    const Writers writers = make_run_writers(layout, folder.path(), kInterval, kInterval);
    for (int row = 0; row < 2; ++row) {
      const State state{layout.nodes(), row, kInterval * row};
      std::vector<Field> shown{state.snapshot().fields.begin(), state.snapshot().fields.end()};
      std::vector<double> torque;
      std::vector<double> velocity;
      for (PetscInt node = layout.nodes().begin; node < layout.nodes().end; ++node) {
        torque.push_back(-field_value(5, row, node));
        for (int component = 0; component < 3; ++component) {
          velocity.push_back(field_value(6 + component, row, node));
        }
      }
      shown.push_back({layout.fields[6], std::span<const double>{torque}});
      shown.push_back({layout.fields[7], std::span<const double>{velocity}});
      shown.push_back({layout.fields[8], std::span<const double>{torque}});
      Snapshot snapshot = state.snapshot();
      snapshot.fields = shown;
      for (const auto& writer : writers) {
        if (writer->interval() > 0.0) {
          writer->snapshot(snapshot);
        }
      }
    }
    finish(writers);
  }
  if (world_rank() == 0) {
    const SerialFile file{folder / "results.h5"};
    EXPECT_EQ(file.shape("/fields/torque"), (std::vector<hsize_t>{2, 10}));
    EXPECT_EQ(file.doubles("/fields/torque")[13], -field_value(5, 1, 3));
    EXPECT_EQ(file.shape("/fields/velocity"), (std::vector<hsize_t>{2, 10, 3}));
    EXPECT_EQ(file.doubles("/fields/velocity")[3 * 13 + 2], field_value(8, 1, 3));
    EXPECT_EQ(file.doubles("/envelope/torque_min")[3], -field_value(5, 1, 3));
    EXPECT_EQ(read_lines(folder / "envelope.csv").at(0),
              "node,x,moment_min,moment_max,shear_min,shear_max,torque_min,torque_max,tension_min,tension_max,"
              "stress_max,utilisation_max");
    EXPECT_EQ(read_lines(folder / "gauges.csv").at(0),
              "time,mass_0,velocity_0,line_0,torque_0,mass_1,velocity_1,line_1,torque_1");
    const std::string xdmf = read_text(folder / "results.xdmf");
    EXPECT_NE(xdmf.find("<Attribute Name=\"torque\" AttributeType=\"Scalar\" Center=\"Node\">"), std::string::npos);
    EXPECT_NE(xdmf.find("<Attribute Name=\"velocity\" AttributeType=\"Vector\" Center=\"Node\">"), std::string::npos);
    EXPECT_NE(
        xdmf.find("Dimensions=\"2 10 3\" NumberType=\"Float\" Precision=\"8\" Format=\"HDF\">results.h5:/fields/"),
        std::string::npos);
    EXPECT_NE(xdmf.find("<Attribute Name=\"tension\" AttributeType=\"Scalar\" Center=\"Cell\">"), std::string::npos);
    EXPECT_EQ(file.shape("/fields/tension"), (std::vector<hsize_t>{2, 9}));
    EXPECT_EQ(file.doubles("/fields/tension")[9 + 3], -field_value(5, 1, 3));
    const SerialFile picture{folder / "results.vtkhdf"};
    constexpr std::size_t kPoints = 10 + 10 + 3;
    const std::vector<double> torque = picture.doubles("/VTKHDF/PointData/torque");
    const std::vector<double> velocity = picture.doubles("/VTKHDF/PointData/velocity");
    ASSERT_EQ(torque.size(), 2 * kPoints);
    ASSERT_EQ(velocity.size(), 3 * torque.size());
    EXPECT_EQ(torque[kPoints + 3], -field_value(5, 1, 3)) << "of the line";
    EXPECT_TRUE(std::isnan(torque[kPoints + 13]));
    EXPECT_EQ(velocity[3 * (kPoints + 13) + 1], field_value(7, 1, 3)) << "of the masses";
    EXPECT_TRUE(std::isnan(velocity[3 * (kPoints + 3)]));
    EXPECT_EQ(picture.integers("/VTKHDF/Steps/PointDataOffsets/velocity"),
              (std::vector<std::int64_t>{0, static_cast<std::int64_t>(kPoints)}));
    constexpr std::size_t kCells = 9 + 1 + 2;
    const std::vector<double> tension = picture.doubles("/VTKHDF/CellData/tension");
    ASSERT_EQ(tension.size(), 2 * kCells);
    EXPECT_EQ(tension[kCells + 3], -field_value(5, 1, 3));
    EXPECT_TRUE(std::isnan(tension[kCells + 9]));
    EXPECT_EQ(picture.integers("/VTKHDF/Steps/CellDataOffsets/tension"),
              (std::vector<std::int64_t>{0, static_cast<std::int64_t>(kCells)}));
  }
}

/// Four corners of a square in space, dealt and numbered against the ranks' order: files have the user's.
TEST(Structures, OfAnyShapeAreWrittenInTheUsersNumbers) {
  const TemporaryFolder folder;
  constexpr PetscInt kCorners = 4;
  constexpr std::array<std::int64_t, kCorners> kNumber{30, 20, 10, 0};
  const std::array<Place, kCorners> corner{{{0, 0, 1}, {2, 0, 1}, {2, 3, 1}, {0, 3, 1}}};
  const std::array direction{Direction::x, Direction::y, Direction::z, Direction::y};
  const NodeRange own = share(kCorners);
  PointTable table;
  std::vector<double> position;
  for (PetscInt i = own.begin; i < own.end; ++i) {
    const auto k = static_cast<std::size_t>(i);
    table.place.push_back(corner[k]);
    table.mass.push_back(1.0 + static_cast<double>(i));
    table.number.push_back(kNumber[k]);
    table.direction.push_back(direction[k]);
    position.push_back(0.25 + (direction[k] == Direction::y ? corner[k].y : 0.0));
  }
  const PlacedPoints points{PETSC_COMM_WORLD, 1, table};
  Topology topology{.name = "plate", .shape = Topology::Shape::quadrilateral, .corners = {}};
  if (world_rank() == world_size() - 1) {
    topology.corners = {0, 1, 2, 3};
  }
  RunLayout layout{points, topology};
  layout.fields = {kMotionFields[2]};
  layout.gauges.node = {1};
  layout.gauges.height = {{{1, 1.0}}};
  layout.gauges.position = {2.0};
  {
    const Writers writers = make_run_writers(layout, folder.path(), kInterval, kInterval);
    const std::vector<Field> shown{{layout.fields[0], std::span<const double>{position}}};
    for (const auto& writer : writers) {
      if (writer->interval() > 0.0) {
        writer->snapshot({.time = 0.0, .fields = shown, .energy = {}, .support_impulse = {}});
      }
    }
    std::vector<ImpactRecord> hit;
    if (own.begin <= 1 && 1 < own.end) {
      hit.push_back({.time = 0.5, .node = 1, .x = 2.0});
    }
    write_events(writers, hit, {});
    finish(writers);
  }
  if (world_rank() == 0) {
    const SerialFile file{folder / "results.h5"};
    EXPECT_EQ(file.integers("/node"), (std::vector<std::int64_t>{0, 10, 20, 30}));
    EXPECT_EQ(file.doubles("/x"), (std::vector<double>{0, 2, 2, 0}));
    EXPECT_EQ(file.doubles("/y"), (std::vector<double>{3, 3, 0, 0}));
    EXPECT_EQ(file.doubles("/z"), (std::vector<double>{1, 1, 1, 1}));
    EXPECT_EQ(file.doubles("/mass"), (std::vector<double>{4, 3, 2, 1}));
    EXPECT_EQ(file.integers("/cells"), (std::vector<std::int64_t>{3, 2, 1, 0})) << "rows, not numbers";
    EXPECT_EQ(file.doubles("/fields/line_position"), (std::vector<double>{3.25, 0.25, 0.25, 0.25}));
    EXPECT_EQ(file.doubles("/fields/displacement_of_line"),
              (std::vector<double>{0, 0.25, 0, 0, 0, 0.25, 0, 0.25, 0, 0.25, 0, 0}));
    EXPECT_EQ(file.integers("/gauge_node"), std::vector<std::int64_t>{20});
    EXPECT_EQ(file.column("/impacts", "node"), std::vector<double>{20.0});
    EXPECT_EQ(read_lines(folder / "gauges.csv").at(1), "0,0.25");
    const SerialFile picture{folder / "results.vtkhdf"};
    EXPECT_EQ(picture.integers("/VTKHDF/Types"), (std::vector<std::int64_t>{9, 2}));
    EXPECT_EQ(picture.integers("/VTKHDF/Connectivity"), (std::vector<std::int64_t>{3, 2, 1, 0, 0, 1, 2, 3}));
    const std::vector<double> place = picture.doubles("/VTKHDF/Points");
    EXPECT_EQ((std::vector<double>{place.begin(), place.begin() + 6}), (std::vector<double>{0, 3, 1, 2, 3, 1}));
    EXPECT_EQ(picture.doubles("/VTKHDF/PointData/displacement")[1], 0.25);
    const std::string xdmf = read_text(folder / "results.xdmf");
    EXPECT_NE(xdmf.find("TopologyType=\"Quadrilateral\" NumberOfElements=\"1\""), std::string::npos);
    EXPECT_NE(xdmf.find("<Attribute Name=\"displacement\" AttributeType=\"Vector\""), std::string::npos);
  }
}

/// Three nodes in a line, each of three points along y, x and z, and two members between them; all numbered against the
/// ranks' order.
struct NodesOfThreePoints {
  static constexpr PetscInt kNodes = 3;
  NodeRange own = share(kNodes);
  PointTable table;
  Topology topology{.name = "network", .shape = Topology::Shape::line, .corners = {}};
  std::vector<double> position;
  std::vector<double> velocity;
  std::vector<std::uint8_t> resting;
  std::vector<double> tension;

  NodesOfThreePoints() {
    constexpr std::array kBlocks{std::pair{Direction::y, 1}, std::pair{Direction::x, 0}, std::pair{Direction::z, 2}};
    for (const auto& [direction, axis] : kBlocks) {
      for (PetscInt i = own.begin; i < own.end; ++i) {
        const auto node = static_cast<double>(i);
        topology.node.push_back(static_cast<std::size_t>(i - own.begin));
        table.place.push_back({.x = node, .y = 1.0, .z = 2.0 * node});
        table.mass.push_back(1.0 + node);
        table.number.push_back(30 * (kNodes - 1 - i) + axis);
        table.direction.push_back(direction);
        position.push_back(0.25 * (axis + 1) + node + (axis == 1 ? 1.0 : 0.0));
        velocity.push_back(10.0 * axis + node);
        resting.push_back(axis == 2 && i == 1 ? 1 : 0);
        if (axis == 0 && i == 2) {
          table.fixed.push_back(table.mass.size() - 1);
        }
      }
    }
    for (PetscInt i = own.begin; i < own.end; ++i) {
      topology.node_number.push_back(10 * (kNodes - 1 - i));
      if (i + 1 < kNodes) {
        topology.corners.insert(topology.corners.end(), {i, i + 1});
        topology.cell_number.push_back(1 - i);
        topology.member.push_back(5 + i);
        topology.radius.push_back(0.25 * (1 + static_cast<double>(i)));
        tension.push_back(100.0 + static_cast<double>(i));
      }
    }
  }
};

TEST(Structures, NodesOfSeveralPointsHaveVectors) {
  const TemporaryFolder folder;
  const NodesOfThreePoints made;
  const PlacedPoints points{PETSC_COMM_WORLD, 1, made.table};
  RunLayout layout{points, made.topology};
  layout.fields = {kMotionFields.begin(), kMotionFields.end()};
  layout.fields.push_back({.name = "tension", .unit = "N", .where = Where::cells, .extremes = true});
  layout.fields.push_back(kRestingField);
  layout.gauges.node = {0};
  layout.gauges.height = {{{0, 1.0}}};
  layout.gauges.position = {0.0};
  layout.supports = {{1.0, 0.0, -0.5, 0.5, 1}, {1.0, 1.0, -0.25, 0.5, 1}};
  MotionState kept;
  {
    const Writers writers = make_run_writers(layout, folder.path(), kInterval, kInterval);
    const std::vector<Field> shown{{layout.fields[0], std::span{made.position}},
                                   {layout.fields[1], std::span{made.velocity}},
                                   {layout.fields[2], std::span{made.position}},
                                   {layout.fields[3], std::span{made.tension}},
                                   {layout.fields[4], std::span{made.resting}}};
    const std::vector<double> impulse(layout.supports.size(), 0.0);
    for (const auto& writer : writers) {
      if (writer->interval() > 0.0) {
        writer->snapshot({.time = 0.0, .fields = shown, .energy = {}, .support_impulse = impulse});
      }
      writer->save(kept);
    }
    std::vector<ImpactRecord> hit;
    if (made.own.begin <= 1 && 1 < made.own.end) {
      hit.push_back({.time = 0.5, .node = points.global(static_cast<std::size_t>(1 - made.own.begin)), .x = 1.0});
    }
    write_events(writers, hit, {});
    finish(writers);
  }
  EXPECT_EQ(kept.cells.at("tension_max"), made.tension);
  EXPECT_FALSE(fs::exists(folder / "envelope.csv")) << "tension is of cells";
  if (world_rank() == 0) {
    const SerialFile file{folder / "results.h5"};
    EXPECT_EQ(file.text_attribute("structure"), "network");
    EXPECT_EQ(file.integers("/node"), (std::vector<std::int64_t>{0, 10, 20}));
    EXPECT_EQ(file.doubles("/x"), (std::vector<double>{2, 1, 0}));
    EXPECT_EQ(file.doubles("/z"), (std::vector<double>{4, 2, 0}));
    EXPECT_EQ(file.doubles("/mass"), (std::vector<double>{3, 2, 1}));
    EXPECT_EQ(file.integers("/held"), (std::vector<std::int64_t>{1, 0, 0}));
    EXPECT_EQ(file.integers("/cells"), (std::vector<std::int64_t>{1, 0, 2, 1}));
    EXPECT_EQ(file.integers("/member"), (std::vector<std::int64_t>{6, 5}));
    EXPECT_EQ(file.doubles("/member_radius"), (std::vector<double>{0.5, 0.25}));
    EXPECT_EQ(file.doubles("/radius"), (std::vector<double>{0.5, 0.5, 0.25})) << "the largest that meet there";
    const std::vector<double> moved{2.25, 2.5, 2.75, 1.25, 1.5, 1.75, 0.25, 0.5, 0.75};
    EXPECT_EQ(file.shape("/fields/displacement_of_line"), (std::vector<hsize_t>{1, 3, 3}));
    EXPECT_EQ(file.doubles("/fields/displacement_of_line"), moved);
    EXPECT_EQ(file.doubles("/fields/displacement_of_masses"), moved);
    EXPECT_EQ(file.doubles("/fields/mass_velocity"), (std::vector<double>{2, 12, 22, 1, 11, 21, 0, 10, 20}));
    EXPECT_EQ(file.shape("/fields/resting"), (std::vector<hsize_t>{1, 3}));
    EXPECT_EQ(file.read<std::uint8_t>("/fields/resting", H5T_NATIVE_UINT8), (std::vector<std::uint8_t>{0, 1, 0}));
    EXPECT_EQ(file.doubles("/fields/tension"), (std::vector<double>{101, 100}));
    EXPECT_EQ(file.doubles("/envelope/tension_max"), (std::vector<double>{101, 100}));
    EXPECT_EQ(file.integers("/gauge_node"), std::vector<std::int64_t>{20});
    EXPECT_EQ(file.column("/impacts", "node"), std::vector<double>{10.0});

    const SerialFile picture{folder / "results.vtkhdf"};
    EXPECT_EQ(picture.integers("/VTKHDF/NumberOfPoints"), (std::vector<std::int64_t>{3, 3, 7}));
    const std::vector<double> place = picture.doubles("/VTKHDF/Points");
    EXPECT_EQ((std::vector<double>{place.begin(), place.begin() + 9}),
              (std::vector<double>{2, 1, 4, 1, 1, 2, 0, 1, 0}));
    EXPECT_EQ((std::vector<double>{place.begin() + 18, place.end()}),
              (std::vector<double>{1,   -0.5,  0, 1,   -0.5,  4,  // across, then around
                                   0.5, -0.25, 0, 1.5, -0.25, 0, 1.5, -0.25, 4, 0.5, -0.25, 4, 0.5, -0.25, 0}));
    const std::vector<double> displacement = picture.doubles("/VTKHDF/PointData/displacement");
    EXPECT_EQ((std::vector<double>{displacement.begin(), displacement.begin() + 9}), moved);
    const std::vector<double> radius = picture.doubles("/VTKHDF/PointData/radius");
    EXPECT_EQ((std::vector<double>{radius.begin(), radius.begin() + 4}), (std::vector<double>{0.5, 0.5, 0.25, 0.0}));
    EXPECT_EQ(picture.doubles("/VTKHDF/CellData/radius"), (std::vector<double>{0.5, 0.25, 0, 0, 0}));
    EXPECT_EQ(picture.integers("/VTKHDF/CellData/member"), (std::vector<std::int64_t>{6, 5, -1, -1, -1}));
    EXPECT_EQ(picture.integers("/VTKHDF/Steps/PointDataOffsets/radius"), std::vector<std::int64_t>{0});
    const std::string xdmf = read_text(folder / "results.xdmf");
    for (const char* text : {"\"displacement\" AttributeType=\"Vector\" Center=\"Node\"",
                             "\"mass_velocity\" AttributeType=\"Vector\" Center=\"Node\"",
                             "\"radius\" AttributeType=\"Scalar\" Center=\"Node\"", "results.h5:/member_radius"}) {
      EXPECT_NE(xdmf.find(text), std::string::npos) << text;
    }
  }
}

TEST(Xdmf, NamesOneRowOfTheFieldsPerTime) {
  const TemporaryFolder folder;
  const RunLayout layout = layout_of(10);
  const Writers writers = make_run_writers(layout, folder.path(), kInterval, kInterval);
  write_row(writers, layout.nodes(), 0);
  write_row(writers, layout.nodes(), 1);
  finish(writers);
  if (world_rank() == 0) {
    const std::string text = read_text(folder / "results.xdmf");
    EXPECT_NE(text.find("<Time Value=\"0.125\"/>"), std::string::npos);
    EXPECT_NE(text.find("<DataItem Dimensions=\"3 2\" Format=\"XML\">1 0 1 1 1 10</DataItem>"), std::string::npos);
    EXPECT_NE(text.find("results.h5:/fields/line_position"), std::string::npos);
    EXPECT_EQ(text.find("X_Y\""), std::string::npos) << "VTK's Xdmf3 readers crash on it";
    // Without these VTK would show the points of the first row at all times.
    EXPECT_NE(text.find("<!-- row 0 -->results.h5:/x"), std::string::npos);
    EXPECT_NE(text.find("<!-- row 1 -->results.h5:/x"), std::string::npos);
    EXPECT_EQ(text.find("</Xdmf>"), text.size() - std::string{"</Xdmf>\n"}.size());
  }
}

TEST(VtkHdf, ShowsEveryRowWithMassesAndSupports) {
  const TemporaryFolder folder;
  RunLayout layout = layout_of(10);
  layout.supports[1].lift = [](double time) { return 2.0 * time; };
  SupportForces forces{2, kInterval, kInterval};
  constexpr std::size_t kRows = 5;
  {
    const Writers writers = make_run_writers(layout, folder.path(), kInterval, kInterval, &forces);
    for (int row = 0; row < static_cast<int>(kRows); ++row) {
      write_row(writers, layout.nodes(), row);
    }
    finish(writers);
  }
  if (world_rank() == 0) {
    const SerialFile file{folder / "results.vtkhdf"};
    constexpr std::size_t kPoints = 10 + 10 + 3;  // of the line, the masses, a wide and a narrow support
    EXPECT_EQ(file.integers("/VTKHDF/NumberOfPoints"), (std::vector<std::int64_t>{10, 10, 3}));
    EXPECT_EQ(file.integers("/VTKHDF/NumberOfCells"), (std::vector<std::int64_t>{9, 1, 2}));
    EXPECT_EQ(file.integers("/VTKHDF/Offsets"),
              (std::vector<std::int64_t>{0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 0, 10, 0, 2, 3}));
    EXPECT_EQ(file.integers("/VTKHDF/Types"), (std::vector<std::int64_t>{3, 3, 3, 3, 3, 3, 3, 3, 3, 2, 4, 1}));
    EXPECT_EQ(file.integers("/VTKHDF/CellData/part"), (std::vector<std::int64_t>{0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2, 2}));
    EXPECT_EQ(file.doubles("/VTKHDF/Steps/Values"), (std::vector<double>{0, 0.125, 0.25, 0.375, 0.5}));
    std::vector<std::int64_t> first(kRows);
    for (std::size_t row = 0; row < kRows; ++row) {
      first[row] = static_cast<std::int64_t>(kPoints * row);
    }
    EXPECT_EQ(file.integers("/VTKHDF/Steps/PointDataOffsets/displacement"), first);
    EXPECT_EQ(file.integers("/VTKHDF/Steps/PointDataOffsets/mass"), std::vector<std::int64_t>(kRows, 0));
    const std::vector<std::int64_t> numbers = file.integers("/VTKHDF/Connectivity");
    const std::vector<double> points = file.doubles("/VTKHDF/Points");
    const std::vector<double> mass = file.doubles("/VTKHDF/PointData/mass");
    ASSERT_EQ(points.size(), 3 * kPoints);
    for (std::size_t node = 0; node < 10; ++node) {
      EXPECT_EQ(numbers[18 + node], static_cast<std::int64_t>(node)) << "the masses in one cell";
      EXPECT_TRUE(node == 9 || numbers[2 * node + 1] == static_cast<std::int64_t>(node) + 1) << "ends of a line";
      for (const std::size_t point : {node, node + 10}) {
        EXPECT_EQ(points[3 * point], 0.5 * static_cast<double>(node));
        EXPECT_EQ(points[3 * point + 1], 0.0);
      }
      EXPECT_TRUE(std::isnan(mass[node]));
      EXPECT_EQ(mass[node + 10], 0.5 * static_cast<double>(node));
    }
    EXPECT_EQ((std::vector<double>{points.begin() + 60, points.end()}),
              (std::vector<double>{0.9, -0.1, 0, 1.1, -0.1, 0, 2.0, 0.3, 0}));
    const std::vector<double> displacement = file.doubles("/VTKHDF/PointData/displacement");
    const std::vector<double> moment = file.doubles("/VTKHDF/PointData/moment");
    const std::vector<double> velocity = file.doubles("/VTKHDF/PointData/mass_velocity");
    const auto resting = file.read<std::uint8_t>("/VTKHDF/PointData/resting", H5T_NATIVE_UINT8);
    ASSERT_EQ(displacement.size(), 3 * kPoints * kRows);
    for (std::size_t i = 0; i < kPoints * kRows; ++i) {
      const auto row = static_cast<int>(i / kPoints);
      const std::size_t point = i % kPoints;
      const bool of_line = point < 10;
      const bool of_mass = !of_line && point < 20;
      const auto node = static_cast<PetscInt>(point % 10);
      const double lift = point == 22 ? 2.0 * kInterval * row : 0.0;
      EXPECT_EQ(displacement[3 * i + 1], of_line   ? field_value(2, row, node)
                                         : of_mass ? field_value(0, row, node)
                                                   : lift);
      EXPECT_EQ(displacement[3 * i], 0.0);
      EXPECT_EQ(displacement[3 * i + 2], 0.0);
      EXPECT_EQ(std::isnan(moment[i]), !of_line);
      EXPECT_TRUE(!of_line || moment[i] == field_value(3, row, node));
      EXPECT_EQ(std::isnan(velocity[i]), !of_mass);
      EXPECT_TRUE(!of_mass || velocity[i] == field_value(1, row, node));
      EXPECT_EQ(resting[i], of_mass ? resting_value(row, node) : 0);
    }
    const std::vector<double> shear = file.doubles("/VTKHDF/CellData/shear");
    ASSERT_EQ(shear.size(), 12 * kRows);
    for (std::size_t i = 0; i < shear.size(); ++i) {
      const bool of_line = i % 12 < 9;
      EXPECT_EQ(std::isnan(shear[i]), !of_line);
      EXPECT_TRUE(!of_line || shear[i] == field_value(2, static_cast<int>(i / 12), static_cast<PetscInt>(i % 12)));
    }
    EXPECT_FALSE(fs::exists(folder / "results.vtkhdf.tmp"));
  }
}

// When the disk takes no more

TEST(FullDisk, IsReportedByAllRanksAndLeavesTheRowsBefore) {
  const TemporaryFolder folder;
  const RunLayout layout = layout_of(20000);  // 660 kB per row of the fields, in chunks of several rows
  Writers writers = make_run_writers(layout, folder.path(), kInterval, kInterval);
  int written = 0;
  std::string message;
  {
    const FileSizeLimit limit{8 << 20};
    message = failure_of([&] {
      for (; written < 20; ++written) {
        write_row(writers, layout.nodes(), written);
      }
    });
    // Stays so, and so does the file.
    EXPECT_EQ(failure_of([&] { write_row(writers, layout.nodes(), written); }), message);
    writers.clear();
  }
  EXPECT_EQ(message, "output directory: cannot write '" + folder / "results.h5" + "': File too large");
  EXPECT_GT(written, 1);
  if (world_rank() == 0) {
    expect_fields(SerialFile{folder / "results.h5"}, 20000, written);
  }
}

TEST(FullDisk, LeavesOnlyWholeRowsInTheTables) {
  const TemporaryFolder folder;
  RunLayout layout = layout_of(10);
  layout.gauges.node.assign(100, 3);
  layout.gauges.height.assign(100, {{3, 1.0}});
  layout.gauges.position.assign(100, 1.5);
  const Writers writers = make_run_writers(layout, folder.path(), kInterval, 0.0);
  const std::unique_ptr<Observer>& gauges = writers.front();
  const FileSizeLimit limit{100000};
  const std::string message = failure_of([&] {
    for (int row = 0; row < 1000; ++row) {
      const State state{layout.nodes(), row, kInterval * row};
      gauges->snapshot(state.snapshot());
    }
  });
  EXPECT_EQ(message, "output directory: cannot write '" + folder / "gauges.csv" + "': File too large");
  if (world_rank() == 0) {
    const std::string text = read_text(folder / "gauges.csv");
    EXPECT_TRUE(text.ends_with('\n'));
    const std::vector<std::string> lines = read_lines(folder / "gauges.csv");
    EXPECT_GT(lines.size(), 2U);
    for (const std::string& line : lines) {
      ASSERT_EQ(std::count(line.begin(), line.end(), ','), 300);
    }
  }
}

TEST(FullDisk, IsReportedWhenTheFilesAreCreated) {
  const TemporaryFolder folder;
  const FileSizeLimit limit{4096};
  EXPECT_EQ(failure_of([&] {
              [[maybe_unused]] const Writers writers =
                  make_run_writers(layout_of(10), folder.path(), kInterval, kInterval);
            }),
            "output directory: cannot write '" + folder / "results.h5" + "': File too large");
}

TEST(RunWriters, ReportAFolderThatIsGone) {
  const TemporaryFolder folder;
  EXPECT_EQ(failure_of([&] {
              [[maybe_unused]] const Writers writers =
                  make_run_writers(layout_of(10), folder / "gone", kInterval, kInterval);
            }),
            "output directory: cannot write '" + folder / "gone/results.h5" + "': No such file or directory");
}

// The summary

TEST(Summary, IsReadBackAsItWas) {
  const TemporaryFolder folder;
  Summary summary;
  summary.completed = true;
  summary.end_time = 0.5;
  summary.elements = 100;
  summary.ranks = world_size();
  summary.counts.steps = 12;
  summary.counts.impacts = 3;
  summary.contact.first_contact_time = 0.1;
  summary.contact.last_contact_time = 0.30000000000000004;
  summary.contact.support_impulse = {1.5, 0.0};
  summary.contact.force_window = 0.032;
  summary.contact.peak_force_window = 0.016;
  summary.contact.peak_support_force = {-2e3, 0.0};
  summary.gauge_position = {0.33};
  summary.gauge_node_position = {0.35};
  summary.costs.wall_seconds = {{"setup", 0.5}, {"solve", 2.0}};
  summary.costs.wall_seconds_mean = {{"setup", 0.4}, {"solve", 1.5}};
  summary.costs.own_seconds = {{"other", 0.25}};
  summary.costs.communication = {{"stepping", {.messages = 12.0, .message_bytes = 384.0, .reductions = 7.0}}};
  summary.costs.peak_memory_bytes = std::uint64_t{1} << 40;
  summary.costs.largest_memory_bytes = 200;
  summary.costs.smallest_memory_bytes = 100;
  summary.versions = library_versions();
  write_summary(PETSC_COMM_WORLD, folder / "summary.json", summary);
  if (world_rank() == 0) {
    const nlohmann::json json = nlohmann::json::parse(read_text(folder / "summary.json"));
    EXPECT_EQ(json.at("completed"), true);
    EXPECT_EQ(json.at("elements"), 100);
    EXPECT_EQ(json.at("ranks"), world_size());
    EXPECT_EQ(json.at("steps"), 12);
    EXPECT_EQ(json.at("last_contact_time"), 0.30000000000000004);
    EXPECT_TRUE(json.at("min_line_gap").is_null());
    EXPECT_TRUE(json.at("min_line_gap_x").is_null());
    EXPECT_TRUE(json.at("min_line_gap_time").is_null());
    EXPECT_EQ(json.at("support_impulse"), (std::vector<double>{1.5, 0.0}));
    EXPECT_EQ(json.at("force_window"), 0.032);
    EXPECT_EQ(json.at("peak_force_window"), 0.016);
    EXPECT_EQ(json.at("peak_support_force"), (std::vector<double>{-2e3, 0.0}));
    EXPECT_EQ(json.at("gauge_node_position"), (std::vector<double>{0.35}));
    EXPECT_EQ(json.at("wall_seconds").at("solve"), 2.0);
    EXPECT_EQ(json.at("wall_seconds_mean").at("solve"), 1.5);
    EXPECT_EQ(json.at("own_seconds").at("other"), 0.25);
    EXPECT_EQ(json.at("communication").at("stepping").at("message_bytes"), 384.0);
    EXPECT_EQ(json.at("communication").at("stepping").at("reductions"), 7.0);
    EXPECT_EQ(json.at("peak_memory_bytes"), std::uint64_t{1} << 40);
    EXPECT_EQ(json.at("memory_per_rank").at("largest"), 200);
    EXPECT_EQ(json.at("memory_per_rank").at("smallest"), 100);
    EXPECT_EQ(json.at("versions").at("hdf5"), summary.versions.at("hdf5"));
    EXPECT_FALSE(fs::exists(folder / "summary.json.tmp"));
  }
}

TEST(Summary, ReportsAFolderThatIsGone) {
  const TemporaryFolder folder;
  EXPECT_EQ(failure_of([&] { write_summary(PETSC_COMM_WORLD, folder / "gone/summary.json", {}); }),
            "output directory: cannot write '" + folder / "gone/summary.json.tmp" + "': No such file or directory");
}

}  // namespace
}  // namespace udar::io

/// In the place of the system's, for all libraries of this program.
extern "C" int fsync(int fd) {
  ++udar::io::waits_for_disk;
  return static_cast<int>(syscall(SYS_fsync, fd));
}
