#include "udar/io/recording.hpp"

#include <algorithm>
#include <sstream>
#include <utility>

#include "io/event_order.hpp"
#include "io/table_rows.hpp"
#include "io/writers.hpp"
#include "udar/io/run_writers.hpp"
#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

std::vector<std::string> columns_of(const std::string& header) {
  std::vector<std::string> columns;
  std::istringstream names{header.substr(0, header.find('\n'))};
  for (std::string name; std::getline(names, name, ',');) {
    columns.push_back(name);
  }
  return columns;
}

FileField field_called(const RunLayout& layout, const std::string& name) {
  std::string known;
  for (const FileField& field : layout.rows->fields(layout.fields)) {
    if (field.name == name && !field.flag) {
      return field;
    }
    known += field.flag ? "" : " " + std::string{field.name};
  }
  throw InputError{"field '" + name + "' is not allowed, expected one of" + known};
}

}  // namespace

Recording::Recording(RunLayout layout, double interval, double window, const std::vector<std::string>& fields)
    : layout_{std::move(layout)},
      interval_{interval},
      forces_{layout_.supports.size(), interval, window, sampling_interval(interval, layout_.longest_sample)},
      gauges_{std::make_unique<GaugeRows>(GaugeRows::of_gauges(layout_))},
      strikers_{std::make_unique<GaugeRows>(GaugeRows::of_strikers(layout_))},
      contact_{std::make_unique<ContactRows>(layout_, forces_)} {
  if (const double sampling = sampling_interval(interval, layout_.longest_sample); sampling < interval) {
    sampler_ = make_force_sampler(forces_, sampling);
  }
  for (const std::string& name : fields) {
    fields_.push_back({field_called(layout_, name)});
  }
}

Recording::~Recording() = default;

void Recording::snapshot(const Snapshot& state) {
  times_.push_back(state.time);
  energy_.push_back(state.energy);
  gauges_->add(state);
  strikers_->add(state);
  contact_->add(state);
  for (KeptField& field : fields_) {
    const std::vector<double> numbers = layout_.rows->numbers(field, state.fields[field.source].numbers());
    field.rows.insert(field.rows.end(), numbers.begin(), numbers.end());
  }
}

void Recording::events(const StepRecords<ImpactRecord>& impacts, const StepRecords<RestRecord>& rests,
                       const EventCounts& /*all*/) {
  for (const ImpactRecord& impact : impacts) {
    impacts_.push_back(in_user_numbers(impact, *layout_.points, *layout_.rows));
  }
  for (const RestRecord& rest : rests) {
    rests_.push_back(in_user_numbers(rest, *layout_.points, *layout_.rows));
  }
}

const Recording::KeptField& Recording::field(const std::string& name) const {
  const auto found = std::ranges::find(fields_, name, &KeptField::name);
  if (found == fields_.end()) {
    throw InputError{"field '" + name + "' is not allowed, expected one of those that the recording keeps"};
  }
  return *found;
}

RecordedTable Recording::energy() const {
  RecordedTable table{.columns = columns_of(energy_header()), .numbers = {}};
  for (std::size_t row = 0; row < times_.size(); ++row) {
    table.numbers.push_back(times_[row]);
    const auto energies = energy_columns(energy_[row]);
    table.numbers.insert(table.numbers.end(), energies.begin(), energies.end());
  }
  return table;
}

RecordedTable Recording::gauges() const {
  return {.columns = columns_of(gauges_->header()), .numbers = gauges_->numbers()};
}

RecordedTable Recording::strikers() const {
  return {.columns = columns_of(strikers_->header()), .numbers = strikers_->numbers()};
}

std::vector<ContactRow> Recording::contact() const { return shared(layout_.comm(), contact_->rows()); }

std::span<const double> Recording::support_force() const { return contact_->force(); }

std::span<const double> Recording::support_impulse() const { return contact_->impulse(); }

std::vector<ImpactRecord> Recording::impacts() const {
  return shared(layout_.comm(), on_first_rank(layout_.comm(), impacts_));
}

std::vector<RestRecord> Recording::rests() const {
  return shared(layout_.comm(), on_first_rank(layout_.comm(), rests_));
}

}  // namespace udar::io
