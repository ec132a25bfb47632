#include "app/checkpoint_writer.hpp"

#include <petscsys.h>

#include <cmath>
#include <filesystem>

#include "udar/app/describe_case.hpp"
#include "udar/io/checkpoint.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/description.hpp"

namespace udar::app {

CheckpointWriter::CheckpointWriter(const ImpactDynamics& dynamics, const Case& input, const Structure& structure,
                                   std::span<const std::unique_ptr<Observer>> others)
    : dynamics_{&dynamics},
      points_{structure.points()},
      cells_{structure.points().comm(), structure.topology()},
      path_{(std::filesystem::path{input.output.directory} / "restart.h5").string()},
      interval_{input.restart.interval},
      parameters_{describe(input, structure).parameters()} {
  for (const auto& other : others) {
    others_.push_back(other.get());
  }
  set_next(0.0);
}

void CheckpointWriter::step(const Progress& progress) {
  if (interval_ > 0.0 && progress.time >= next_) {
    for (Observer* other : others_) {
      other->flush();
    }
    write();
    set_next(progress.time);
  }
}
void CheckpointWriter::write() const {
  MotionState state = dynamics_->save();
  state.parameters = parameters_;
  io::write_checkpoint(points_, path_, state, &cells_);
}

/// The least multiple of the interval above `time`, or `time` itself if their distance is below its last digit.
void CheckpointWriter::set_next(double time) {
  next_ = interval_ > 0.0 ? time + (interval_ - std::fmod(time, interval_)) : 0.0;
}

MotionState restore(ImpactDynamics& dynamics, const Case& input, const Structure& structure) {
  const auto accept = [&](std::span<const Parameter> there) {
    const std::string differ = differences(there, describe(input, structure).parameters());
    if (!differ.empty()) {
      throw InputError{"option -restart_file: '" + input.restart.file + "' belongs to another case: " + differ};
    }
  };
  const io::PointOrder points{structure.points()};
  const io::PointOrder cells{points.comm(), structure.topology()};
  MotionState state = io::read_checkpoint(points, input.restart.file, accept, &cells);
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
