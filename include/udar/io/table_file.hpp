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

/// @brief The columns that a table must have: the first `needed` of the names, or more of them in this order.
struct Columns {
  std::vector<std::string> names;  ///< with units, as messages show them
  std::size_t needed = 2;
};

/// @brief Reads a table of numbers: columns separated by commas, by white space or, as spreadsheets do where the comma
/// is the decimal mark, by semicolons; `#` before a comment, blank lines ignored, and at most one header line, which
/// does not begin with a number.
/// @param[in] quantity what the table gives, for the messages ("load table")
/// @param[in] path    a relative one is looked for from the working directory, then beside the options files
/// @param[in] columns what is expected; a table with any more columns is refused, as nobody would read them
/// @note Collective; rank 0 reads, all get the table
/// @throws FileError on all ranks, naming quantity, file, line and column, if the file cannot be read, has no rows,
/// rows of different lengths, too few or too many columns, or something else than finite numbers
[[nodiscard]] Table read_table(MPI_Comm comm, const std::string& quantity, const std::string& path,
                               const Columns& columns);

}  // namespace udar::io
