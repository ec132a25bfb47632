#include "app/checkpoint_writer.hpp"

#include <petscsys.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <ratio>
#include <sstream>

#include "app/continued_run.hpp"
#include "udar/app/describe_case.hpp"
#include "udar/io/checkpoint.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/warnings.hpp"
#include "udar/structure/description.hpp"

namespace udar::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kWarnings = "warnings";
constexpr const char* kGauges = "gauges";
constexpr double kLongestPause = 1e6;  // [min]: the clock holds it

std::vector<double> places_of(std::span<const Place> gauges) {
  std::vector<double> all;
  for (const Place& gauge : gauges) {
    all.insert(all.end(), {gauge.x, gauge.y, gauge.z});
  }
  return all;
}

/// The first gauge in which two lists differ, in words; empty: none.
std::string other_gauge(std::span<const double> there, std::span<const double> here) {
  const auto text = [](std::span<const double> places, std::size_t gauge) {
    if (3 * gauge >= places.size()) {
      return std::string{"none"};
    }
    std::ostringstream words;
    words << '(' << places[3 * gauge] << ", " << places[3 * gauge + 1] << ", " << places[3 * gauge + 2] << ") m";
    return words.str();
  };
  const auto differ = std::ranges::mismatch(there, here);
  if (differ.in1 == there.end() && differ.in2 == here.end()) {
    return "";
  }
  const auto gauge = static_cast<std::size_t>(differ.in1 - there.begin()) / 3;
  return "gauge " + std::to_string(gauge) + ": " + text(there, gauge) + " there, " + text(here, gauge) + " here";
}

}  // namespace

CheckpointWriter::CheckpointWriter(const ImpactDynamics& dynamics, const Case& input, const Structure& structure)
    : dynamics_{&dynamics},
      points_{structure.points()},
      cells_{structure.points().comm(), structure.topology()},
      path_{(std::filesystem::path{input.output.directory} / "restart.h5").string()},
      interval_{input.restart.interval},
      pause_{std::chrono::duration_cast<Clock::duration>(
          std::chrono::duration<double, std::ratio<60>>{std::min(input.restart.wall_minutes, kLongestPause)})},
      written_{Clock::now()},
      parameters_{describe(input, structure).parameters()},
      gauges_{places_of(input.gauges)},
      texts_{texts_to_go_on()} {
  int rank = 0;
  MPI_Comm_rank(points_.comm(), &rank);
  first_rank_ = rank == 0;
  set_next(0.0);
}

bool CheckpointWriter::due() const {
  return first_rank_ && pause_ > Clock::duration::zero() && Clock::now() - written_ >= pause_;
}

void CheckpointWriter::step(const Progress& progress) {
  const bool passed = interval_ > 0.0 && progress.time >= next_;
  if (passed) {
    set_next(progress.time);
  }
  if (passed || progress.checkpoint) {
    write();
  }
}

void CheckpointWriter::write() {
  for (Observer* other : others_) {
    other->flush();
  }
  MotionState state = dynamics_->save();
  state.parameters = parameters_;
  state.tables[kGauges] = gauges_;
  state.texts.insert(texts_.begin(), texts_.end());
  std::string& warnings = state.texts[kWarnings];
  for (const std::string& warning : petsc::warnings()) {
    warnings += warning + '\n';
  }
  io::write_checkpoint(points_, path_, state, &cells_);
  written_ = Clock::now();
}

void CheckpointWriter::write_head() const {
  MotionState head;
  head.parameters = parameters_;
  head.texts = texts_;
  io::write_checkpoint(points_, path_, head, &cells_);
}

void CheckpointWriter::restore(const MotionState& state) {
  set_next(state.scalar("time"));
  std::istringstream warnings{state.text(kWarnings)};
  for (std::string warning; std::getline(warnings, warning);) {
    petsc::keep_warning(warning);
  }
}

/// The least multiple of the interval above `time`, or `time` itself if their distance is below its last digit.
void CheckpointWriter::set_next(double time) {
  next_ = interval_ > 0.0 ? time + (interval_ - std::fmod(time, interval_)) : 0.0;
}

MotionState restore(ImpactDynamics& dynamics, const Case& input, const Structure& structure) {
  const auto accept = [&](std::span<const Parameter> there) {
    const std::string differ = differences(there, describe(input, structure).parameters());
    if (!differ.empty()) {
      throw InputError{std::string{"option "} + (input.restart.in_place ? "-continue" : "-restart_file") + ": '" +
                       input.restart.file + "' belongs to another case: " + differ};
    }
  };
  const io::PointOrder points{structure.points()};
  const io::PointOrder cells{points.comm(), structure.topology()};
  MotionState state = io::read_checkpoint(points, input.restart.file, accept, &cells);
  if (input.restart.in_place) {
    const std::string other = other_gauge(state.table(kGauges), places_of(input.gauges));
    if (!other.empty()) {
      throw InputError{"option -continue: the columns of gauges.csv stay as they are; " + other};
    }
  }
  if (!dynamics.goes_on_from(state.integrator)) {
    UDAR_CALL(
        PetscPrintf(points.comm(),
                    "udar: '%s' was written by -ts_type %s: %s takes over masses and contact, and begins anew with "
                    "what it keeps of its own\n",
                    input.restart.file.c_str(), state.integrator.c_str(), dynamics.integrator().c_str()));
  }
  dynamics.restore(state);
  return state;
}

}  // namespace udar::app
