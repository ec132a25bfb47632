#include "udar/io/csv.hpp"

#include <cstdint>

#include "io/text_file.hpp"

namespace udar::io {
namespace {

void append_field(std::string& text, double value) {
  text += ',';
  append_number(text, value);
}

void append_field(std::string& text, PetscInt value) {
  text += ',';
  append_number(text, static_cast<std::int64_t>(value));
}

/// A row: its time, then the other columns.
template <class... Fields>
void append_row(std::string& text, double time, Fields... fields) {
  append_number(text, time);
  (append_field(text, fields), ...);
  text += '\n';
}

}  // namespace

std::string gauge_header(std::size_t gauges, std::span<const std::string_view> columns) {
  std::string text = "time";
  for (std::size_t i = 0; i < gauges; ++i) {
    for (const std::string_view column : columns) {
      text.append(",").append(column).append("_").append(std::to_string(i));
    }
  }
  return text + '\n';
}

std::string gauge_rows(std::span<const double> times, std::span<const double> values) {
  std::string text;
  const std::size_t columns = times.empty() ? 0 : values.size() / times.size();
  for (std::size_t row = 0; row < times.size(); ++row) {
    append_number(text, times[row]);
    for (const double value : values.subspan(row * columns, columns)) {
      append_field(text, value);
    }
    text += '\n';
  }
  return text;
}

std::string energy_header() {
  return "time,kinetic,line_strain,fictitious_springs,load_potential,support_springs,load_work,support_work,base_work,"
         "lost_in_"
         "impacts,"
         "lost_in_dampers,radiated,lost_in_hinges,total,drift\n";
}

std::array<double, 14> energy_columns(const EnergyLedger& row) {
  return {row.kinetic,         row.line_strain,     row.fictitious_springs, row.load_potential,
          row.support_springs, row.load_work,       row.support_work,       row.base_work,
          row.lost_in_impacts, row.lost_in_dampers, row.radiated,           row.lost_in_hinges,
          row.total(),         row.drift()};
}

std::string energy_rows(std::span<const double> times, std::span<const EnergyLedger> rows) {
  std::string text;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    append_number(text, times[i]);
    for (const double column : energy_columns(rows[i])) {
      append_field(text, column);
    }
    text += '\n';
  }
  return text;
}

std::string impact_header() { return "time,node,x,support,velocity_before,velocity_after,impulse,energy_loss\n"; }

std::string impact_rows(std::span<const ImpactRecord> rows) {
  std::string text;
  for (const ImpactRecord& row : rows) {
    append_row(text, row.time, row.node, row.x, row.support, row.velocity_before, row.velocity_after, row.impulse,
               row.energy_loss);
  }
  return text;
}

std::string merged_header() { return "time,last_time,node,x,support,impacts,speed_max,impulse,energy_loss\n"; }

std::string merged_rows(std::span<const MergedImpact> rows) {
  std::string text;
  for (const MergedImpact& row : rows) {
    append_row(text, row.time, row.last_time, row.node, row.x, row.support, row.impacts, row.speed_max, row.impulse,
               row.energy_loss);
  }
  return text;
}

std::string rest_header() { return "time,node,x,support,event\n"; }

std::string rest_rows(std::span<const RestRecord> rows) {
  std::string text;
  for (const RestRecord& row : rows) {
    append_row(text, row.time, row.node, row.x, row.support);
    text.back() = ',';
    text += row.release ? "release\n" : "rest\n";
  }
  return text;
}

std::string contact_header(std::size_t supports) {
  std::string text = "time,masses,x_min,x_max";
  if (supports > kSupportColumnsMax) {
    return text + ",force,impulse\n";
  }
  for (std::size_t i = 0; i < supports; ++i) {
    const std::string number = std::to_string(i);
    text += ",force_" + number + ",impulse_" + number;
  }
  return text + '\n';
}

std::string contact_rows(std::span<const ContactRow> rows, std::span<const double> force,
                         std::span<const double> impulse) {
  std::string text;
  const std::size_t supports = rows.empty() ? 0 : force.size() / rows.size();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const ContactRow& row = rows[i];
    append_row(text, row.time, static_cast<PetscInt>(row.masses), row.x_min, row.x_max);
    text.pop_back();
    if (supports > kSupportColumnsMax) {
      append_field(text, row.force);
      append_field(text, row.impulse);
    } else {
      for (std::size_t k = i * supports; k < (i + 1) * supports; ++k) {
        append_field(text, force[k]);
        append_field(text, impulse[k]);
      }
    }
    text += '\n';
  }
  return text;
}

std::string envelope_header(std::span<const std::string> columns) {
  std::string text = "node,x";
  for (const std::string& column : columns) {
    text.append(",").append(column);
  }
  return text + '\n';
}

std::string envelope_rows(std::size_t columns, std::span<const double> values) {
  std::string text;
  const std::size_t width = columns + 2;
  for (std::size_t row = 0; row < values.size() / width; ++row) {
    append_number(text, static_cast<std::int64_t>(values[row * width]));
    for (const double value : values.subspan(row * width + 1, width - 1)) {
      append_field(text, value);
    }
    text += '\n';
  }
  return text;
}

}  // namespace udar::io
