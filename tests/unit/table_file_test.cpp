// ranks: 1; size: short
/// @file
/// Tables that the user gives: what is read, and what the messages say about what is not.

#include "udar/io/table_file.hpp"

#include <gtest/gtest.h>
#include <petscsys.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "udar/petsc/error.hpp"

namespace udar::io {
namespace {

/// A file with the given text, made by rank 0 for all and removed at the end.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& text)
      : path_{std::filesystem::temp_directory_path() / "udar-table-XXXXXX"} {
    MPI_Comm_rank(PETSC_COMM_WORLD, &rank_);
    if (rank_ == 0) {
      close(mkstemp(path_.data()));
      std::ofstream{path_, std::ios::binary} << text;
    }
    MPI_Bcast(path_.data(), static_cast<int>(path_.size()), MPI_CHAR, 0, PETSC_COMM_WORLD);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    if (rank_ == 0) {
      std::filesystem::remove(path_);
    }
  }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  int rank_ = 0;
  std::string path_;
};

const Columns kTwo{.names = {"time [s]", "force [N]"}};
const Columns kTwoOrThree{.names = {"time [s]", "height [m]", "velocity [m/s]"}};

Table read(const std::string& text, const Columns& columns = kTwo) {
  const TemporaryFile file{text};
  return read_table(PETSC_COMM_WORLD, "load table", file.path(), columns);
}

/// What the user reads about a table, without the path of the file.
std::string complaint(const std::string& text, const Columns& columns = kTwo) {
  const TemporaryFile file{text};
  try {
    [[maybe_unused]] const Table table = read_table(PETSC_COMM_WORLD, "load table", file.path(), columns);
  } catch (const FileError& error) {
    const std::string message = error.what();
    const std::string begin = "load table: '" + file.path() + "'";
    EXPECT_TRUE(message.starts_with(begin)) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message.substr(std::min(begin.size(), message.size()));
  }
  return "no complaint";
}

TEST(TableFile, ReadsCommasAndAHeader) {
  const Table table = read("time, force\n0,1.5\n1e-3 , -2\n");
  EXPECT_EQ(table.names, (std::vector<std::string>{"time", "force"}));
  ASSERT_EQ(table.rows(), 2U);
  ASSERT_EQ(table.columns, 2U);
  EXPECT_EQ(table.at(0, 1), 1.5);
  EXPECT_EQ(table.at(1, 0), 1e-3);
  EXPECT_EQ(table.at(1, 1), -2.0);
}

TEST(TableFile, ReadsWhiteSpaceCommentsBlankLinesAndAMissingLastNewline) {
  const Table table = read("# a comment\n\n  0\t1 2 # behind the numbers\r\n \n+3 4. .5", kTwoOrThree);
  EXPECT_TRUE(table.names.empty());
  EXPECT_EQ(table.columns, 3U);
  EXPECT_EQ(table.values, (std::vector<double>{0, 1, 2, 3, 4, 0.5}));
}

TEST(TableFile, ReadsWhatASpreadsheetSaves) {
  const Table table = read("\xEF\xBB\xBFx,y\r\n1,2\r\n");
  EXPECT_EQ(table.names, (std::vector<std::string>{"x", "y"}));
  EXPECT_EQ(table.values, (std::vector<double>{1, 2}));
}

TEST(TableFile, ReadsSemicolonsWithDecimalCommas) {
  const Table table = read("t;F\n0,5; -1,25e3\n1;2.5\n");
  EXPECT_EQ(table.names, (std::vector<std::string>{"t", "F"}));
  EXPECT_EQ(table.values, (std::vector<double>{0.5, -1250.0, 1.0, 2.5}));
  EXPECT_EQ(read("0,5;1,25\n").values, (std::vector<double>{0.5, 1.25}));
  EXPECT_EQ(complaint("0;1.234,5\n"), ", line 1, column 2: '1.234,5' is not a number");
  EXPECT_EQ(complaint("0;1\n1,2\n"), ", line 2 has 1 column(s), the lines before it have 2");
  EXPECT_EQ(complaint("0,1\n1,2;3\n"), ", line 2, column 2: '2;3' is not a number");
}

TEST(TableFile, KeepsEveryBitOfANumber) {
  EXPECT_EQ(read("0.1,2.2250738585072014e-308\n").values, (std::vector<double>{0.1, 2.2250738585072014e-308}));
}

TEST(TableFile, ReportsAMissingFile) {
  const auto missing = [] { return read_table(PETSC_COMM_WORLD, "load table", "/no/such/table.csv", kTwo); };
  try {
    missing();
    FAIL() << "read a file that is not there";
  } catch (const FileError& error) {
    EXPECT_STREQ(error.what(), "load table: '/no/such/table.csv' cannot be read: No such file or directory");
  }
}

TEST(TableFile, ReportsAFolder) {
  try {
    [[maybe_unused]] const Table table = read_table(PETSC_COMM_WORLD, "load table", "/", kTwo);
    FAIL() << "read a folder";
  } catch (const FileError& error) {
    EXPECT_STREQ(error.what(), "load table: '/' cannot be read: Is a directory");
  }
}

TEST(TableFile, ReportsATableWithoutRows) {
  EXPECT_EQ(complaint(""), " has no rows of numbers");
  EXPECT_EQ(complaint("# nothing\n\n"), " has no rows of numbers");
  EXPECT_EQ(complaint("time,force\n"), " has no rows of numbers");
}

TEST(TableFile, ReportsWhatIsNotANumberWithLineAndColumn) {
  EXPECT_EQ(complaint("t,f\n0,1\n1,x\n"), ", line 3, column 2: 'x' is not a number");
  EXPECT_EQ(complaint("0,1\n2,\n"), ", line 2, column 2: '' is not a number");
  EXPECT_EQ(complaint("0 1\n2 3m\n"), ", line 2, column 2: '3m' is not a number");
  EXPECT_EQ(complaint("t,f\nt,f\n"), ", line 2, column 1: 't' is not a number");
}

TEST(TableFile, TakesAMisspeltNumberForNoHeader) {
  EXPECT_EQ(complaint("0.0x,1\n1,2\n"), ", line 1, column 1: '0.0x' is not a number");
}

TEST(TableFile, ReportsNumbersThatAreNotFinite) {
  EXPECT_EQ(complaint("0,nan\n"), ", line 1, column 2: 'nan' is not a finite number");
  EXPECT_EQ(complaint("# c\n0,1\n-inf,1\n"), ", line 3, column 1: '-inf' is not a finite number");
  EXPECT_EQ(complaint("0,1e999\n"), ", line 1, column 2: '1e999' is out of range");
}

TEST(TableFile, ReportsRowsOfDifferentLength) {
  EXPECT_EQ(complaint("0,1\n1,2,3\n"), ", line 2 has 3 column(s), the lines before it have 2");
  EXPECT_EQ(complaint("t f\n0 1\n\n2\n"), ", line 4 has 1 column(s), the lines before it have 2");
}

TEST(TableFile, ReportsTooFewOrTooManyColumns) {
  EXPECT_EQ(complaint("0\n"), ", line 1 has 1 column(s), expected 2: time [s], force [N]");
  EXPECT_EQ(complaint("t,f,v\n0,1,2\n"), ", line 1 has 3 column(s), expected 2: time [s], force [N]");
  EXPECT_EQ(complaint("0,1,2,3\n", kTwoOrThree),
            ", line 1 has 4 column(s), expected 2 or 3: time [s], height [m], velocity [m/s]");
}

}  // namespace
}  // namespace udar::io
