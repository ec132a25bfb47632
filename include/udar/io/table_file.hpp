#pragma once
/// @file
/// Tables of numbers that the user gives as a file.

#include <mpi.h>

#include <cstddef>
#include <string>
#include <vector>

namespace udar::io {

/// @brief A table of numbers, equal on every rank.
struct Table {
  std::vector<std::string> names;  ///< of the columns, as in the header line; empty if there is none
  std::size_t columns = 0;
  std::vector<double> values;  ///< row after row

  [[nodiscard]] std::size_t rows() const noexcept { return columns > 0 ? values.size() / columns : 0; }
  [[nodiscard]] double at(std::size_t row, std::size_t column) const { return values.at(row * columns + column); }
};

/// @brief Reads a table of numbers: columns separated by commas or by white space, `#` before a comment, blank lines
/// ignored, and at most one header line, which does not begin with a number.
/// @param[in] option      the option that names the file, for the messages
/// @param[in] path        a relative one is looked for from the working directory, then beside the options files
/// @param[in] min_columns least number of columns that make sense
/// @note Collective; rank 0 reads, all get the table
/// @throws FileError on all ranks, naming option, file, line and column, if the file cannot be read, has no rows, rows
/// of different lengths, too few columns, or something else than finite numbers
[[nodiscard]] Table read_table(MPI_Comm comm, const std::string& option, const std::string& path, int min_columns);

}  // namespace udar::io
