#include "udar/io/table_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>

#include "io/input_file.hpp"
#include "io/text_fields.hpp"
#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // which spreadsheets put at the beginning

/// A header begins with a name: a misspelt number is not one.
bool is_name(std::string_view field) {
  double value = 0.0;
  return !field.empty() && std::string_view{"+-.0123456789"}.find(field[0]) == std::string_view::npos &&
         read_number(field, true, value) == Reading::not_a_number;
}

/// What is wrong with so many columns, if anything.
std::string complaint(std::size_t count, const Columns& columns) {
  if (count >= columns.needed && count <= columns.names.size()) {
    return {};
  }
  std::string text = " has " + std::to_string(count) + " column(s), expected ";
  for (std::size_t number = columns.needed; number <= columns.names.size(); ++number) {
    text += (number > columns.needed ? " or " : "") + std::to_string(number);
  }
  text += ":";
  for (std::size_t i = 0; i < columns.names.size(); ++i) {
    text += (i > 0 ? ", " : " ") + columns.names[i];
  }
  return text;
}

Table parse(std::string_view text, const Columns& columns) {
  if (text.substr(0, kByteOrderMark.size()) == kByteOrderMark) {
    text.remove_prefix(kByteOrderMark.size());
  }
  Table table;
  bool first = true;
  bool semicolons = false;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t length = std::min(text.find('\n'), text.size());
    const std::string_view whole = text.substr(0, length);
    text.remove_prefix(std::min(length + 1, text.size()));
    const std::string_view line = trimmed(whole.substr(0, whole.find('#')));
    if (line.empty()) {
      continue;
    }
    const std::string where = ", line " + std::to_string(number);
    semicolons = first ? line.find(';') != std::string_view::npos : semicolons;
    const std::vector<std::string_view> fields = fields_of(line, semicolons);
    if (first) {
      table.columns = fields.size();
      if (const std::string wrong = complaint(table.columns, columns); !wrong.empty()) {
        throw Complaint{where + wrong};
      }
    }
    if (fields.size() != table.columns) {
      throw Complaint{where + " has " + std::to_string(fields.size()) + " column(s), the lines before it have " +
                      std::to_string(table.columns)};
    }
    double value = 0.0;
    if (std::exchange(first, false) && is_name(fields[0])) {
      table.names.assign(fields.begin(), fields.end());
      continue;
    }
    for (std::size_t column = 0; column < fields.size(); ++column) {
      if (const std::string wrong = read_finite(fields[column], semicolons, value); !wrong.empty()) {
        throw Complaint{where + ", column " + std::to_string(column + 1) + ": " + wrong};
      }
      table.values.push_back(value);
    }
  }
  if (table.values.empty()) {
    throw Complaint{" has no rows of numbers"};
  }
  return table;
}

}  // namespace

Table read_table(MPI_Comm comm, const std::string& quantity, const std::string& path, const Columns& columns) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  Table table;
  std::string names;  // one per line
  std::string failure;
  if (rank == 0) {
    try {
      table = parse(read_file(path), columns);
      for (const std::string& name : table.names) {
        names += name + '\n';
      }
    } catch (const Complaint& complaint) {
      failure = quantity + ": '" + path + "'" + complaint.text;
    }
  }
  throw_together<FileError>(comm, failure);

  std::array<std::uint64_t, 3> sizes{table.columns, table.values.size(), names.size()};
  MPI_Bcast(sizes.data(), static_cast<int>(sizes.size()), MPI_UINT64_T, 0, comm);
  table.columns = sizes[0];
  table.values.resize(sizes[1]);
  names.resize(sizes[2]);
  broadcast(comm, table.values.data(), table.values.size() * sizeof(double));
  broadcast(comm, names.data(), names.size());
  if (rank != 0) {
    for (std::size_t begin = 0; begin < names.size(); begin = names.find('\n', begin) + 1) {
      table.names.push_back(names.substr(begin, names.find('\n', begin) - begin));
    }
  }
  return table;
}

}  // namespace udar::io
