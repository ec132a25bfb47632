#include "app/run_output.hpp"

#include <algorithm>
#include <utility>

#include "app/run_layout.hpp"
#include "udar/app/progress_line.hpp"
#include "udar/io/run_writers.hpp"

namespace udar::app {

RunOutput::RunOutput(const Case& input, const FilteredStructure& line, ImpactDynamics& dynamics,
                     const MotionState* earlier)
    : forces_{input.supports.size(), input.output.interval, input.output.force_window,
              io::sampling_interval(input.output.interval, longest_sample(input))},
      observers_{io::make_run_writers(make_layout(input, line, dynamics.fields()), input.output.directory,
                                      input.output.interval, input.output.field_interval, &forces_, &peaks_)},
      files_{line.points().comm(), input.output.directory} {
  if (std::ranges::any_of(input.supports, [](const Support& support) { return support.field != nullptr; })) {
    auto errors = std::make_unique<FieldErrors>(line.points(), input);
    field_errors_ = errors.get();
    observers_.push_back(std::move(errors));
  }
  auto writer = std::make_unique<CheckpointWriter>(dynamics, input, line.structure(), observers_);
  checkpoint_ = writer.get();
  observers_.push_back(std::move(writer));
  observers_.push_back(std::make_unique<ProgressLine>(line.points().comm()));
  for (const auto& observer : observers_) {
    if (earlier != nullptr) {
      observer->restore(*earlier);
    }
    dynamics.add_observer(*observer);
  }
}

void RunOutput::keep_last_step() {
  for (const auto& observer : observers_) {
    if (observer.get() != checkpoint_) {
      observer->finish();
    }
  }
  checkpoint_->write();
}

}  // namespace udar::app
