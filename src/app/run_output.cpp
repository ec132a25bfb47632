#include "app/run_output.hpp"

#include <algorithm>
#include <utility>

#include "app/monitor_table.hpp"
#include "app/run_layout.hpp"
#include "udar/app/progress_line.hpp"
#include "udar/io/run_writers.hpp"

namespace udar::app {

/// The head of the restart file comes before all files, so that there is none of a run that nobody knows.
RunOutput::RunOutput(const Case& input, const Model& model, ImpactDynamics& dynamics, io::RunLayout layout,
                     const MotionState* earlier)
    : checkpoint_{dynamics, input, *model.structure},
      forces_{input.supports.size(), input.output.interval, input.output.force_window,
              io::sampling_interval(input.output.interval, longest_sample(input))} {
  layout.earlier = input.restart.in_place ? earlier : nullptr;
  const MassPoints& points = model.structure->points();
  if (earlier == nullptr) {
    checkpoint_.write_head();
  }
  observers_ = io::make_run_writers(layout, input.output.directory, input.output.interval, input.output.field_interval,
                                    &forces_, &peaks_);
  files_.emplace(points.comm(), input.output.directory);
  const auto add = [this]<class Kind>(std::unique_ptr<Kind> observer) {
    return static_cast<const Kind*>(observers_.emplace_back(std::move(observer)).get());
  };
  body_motion_ = add(std::make_unique<BodyMotion>(input, *model.structure, dynamics));
  support_contacts_ = add(std::make_unique<SupportContacts>(input, points));
  if (std::ranges::any_of(input.supports, [](const Support& support) { return support.field != nullptr; })) {
    field_errors_ = add(std::make_unique<FieldErrors>(points, input));
  }
  if (EdgeErrors::needed(input)) {
    edge_errors_ = add(std::make_unique<EdgeErrors>(points, input));
  }
  if (input.output.monitor_interval > 0.0) {
    add(std::make_unique<MonitorTable>(points.comm(), input.output.monitor_interval,
                                       input.strikers.size() + input.pairs.size()));
  } else {
    add(std::make_unique<ProgressLine>(points.comm()));
  }
  dynamics.add_observer(checkpoint_);
  for (const auto& observer : observers_) {
    checkpoint_.flush_before(*observer);
    dynamics.add_observer(*observer);
  }
  if (earlier != nullptr) {
    checkpoint_.restore(*earlier);
    std::ranges::for_each(observers_, [&](const auto& observer) { observer->restore(*earlier); });
    if (layout.earlier == nullptr) {  // what is in the folder belongs to these files from now on
      checkpoint_.write();
    }
  }
  dynamics.set_scratch_folder(input.output.directory);
  dynamics.set_checkpoint_request([this] { return checkpoint_.due(); });
}

void RunOutput::keep_last_step() {
  checkpoint_.write();
  std::ranges::for_each(observers_, [](const auto& observer) { observer->finish(); });
}

}  // namespace udar::app
