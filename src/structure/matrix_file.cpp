#include "udar/structure/matrix_file.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iomanip>
#include <iterator>
#include <limits>
#include <memory>
#include <sstream>
#include <string_view>
#include <type_traits>

#include "structure/cholmod_session.hpp"
#include "udar/petsc/error.hpp"

namespace udar {
namespace {

bool is_matrix_market(const std::string& path) { return path.ends_with(".mtx"); }

/// The file's first integers, as PETSc writes them: most significant byte first.
template <std::size_t Count>
bool read_header(std::ifstream& file, std::array<PetscInt, Count>& header) {
  for (PetscInt& value : header) {
    std::array<unsigned char, sizeof(PetscInt)> bytes{};
    if (!file.read(reinterpret_cast<char*>(bytes.data()), bytes.size())) {
      return false;
    }
    std::make_unsigned_t<PetscInt> number = 0;
    for (const unsigned char byte : bytes) {
      number = (number << 8U) | byte;
    }
    value = static_cast<PetscInt>(number);
  }
  return true;
}

/// Lengths of rows and numbers of columns, which PETSc's reader takes as they are.
std::string fault_of_numbers(std::ifstream& file, PetscInt rows, PetscInt columns, PetscInt nonzeros) {
  std::array<PetscInt, 1> number{};
  std::uintmax_t sum = 0;
  for (PetscInt row = 0; row < rows; ++row) {
    if (!read_header(file, number) || number[0] < 0 || number[0] > columns) {
      return "is damaged: row " + std::to_string(row) + " has " + std::to_string(number[0]) + " entries";
    }
    sum += static_cast<std::uintmax_t>(number[0]);
  }
  if (sum != static_cast<std::uintmax_t>(nonzeros)) {
    return "is damaged: its rows have " + std::to_string(sum) + " entries, its header announces " +
           std::to_string(nonzeros);
  }
  for (PetscInt entry = 0; entry < nonzeros; ++entry) {
    if (!read_header(file, number) || number[0] < 0 || number[0] >= columns) {
      return "is damaged: an entry stands in column " + std::to_string(number[0]) + " of " + std::to_string(columns);
    }
  }
  return {};
}

/// What is wrong with a PETSc binary file, whose own reader would leave the other ranks waiting; empty: nothing.
std::string fault_of_binary(const std::string& path) {
  std::ifstream file{path, std::ios::binary};
  if (!file) {
    return "cannot be opened";
  }
  std::array<PetscInt, 4> header{};  // class, rows, columns, nonzeros
  if (!read_header(file, header)) {
    return "ends within its header";
  }
  const auto& [kind, rows, columns, nonzeros] = header;
  if (kind != MAT_FILE_CLASSID || rows < 0 || columns < 0 || nonzeros < 0) {
    return "is not a sparse matrix in PETSc's binary form with " + std::to_string(8 * sizeof(PetscInt)) +
           "-bit integers (of Matrix Market the name ends in .mtx)";
  }
  const auto numbers = header.size() + static_cast<std::uintmax_t>(rows) + static_cast<std::uintmax_t>(nonzeros);
  const auto expected = numbers * sizeof(PetscInt) + static_cast<std::uintmax_t>(nonzeros) * sizeof(double);
  const std::uintmax_t size = std::filesystem::file_size(path);
  return size < expected ? "ends early: " + std::to_string(size) + " bytes of " + std::to_string(expected)
                         : fault_of_numbers(file, rows, columns, nonzeros);
}

/// What the sizes that stand before the entries cannot be: SuiteSparse and PETSc take memory for them at once.
std::string fault_of_sizes(std::ifstream& file, const std::string& path) {
  std::string line;
  while (std::getline(file, line) && (line.starts_with('%') || line.find_first_not_of(" \t\r") == std::string::npos)) {
  }
  std::istringstream words{line};
  std::array<double, 3> sizes{};  // rows, columns, entries
  if (!(words >> sizes[0] >> sizes[1] >> sizes[2])) {
    return "has no sizes before its entries: rows, columns, number of entries";
  }
  constexpr auto kCountable = static_cast<double>(std::numeric_limits<PetscInt>::max());
  constexpr double kShortest = 6.0;  // "1 1 1" and the end of the line [bytes]
  const auto bytes = static_cast<double>(std::filesystem::file_size(path));
  for (const double size : sizes) {
    if (!(size >= 0.0 && size <= kCountable)) {
      return "has sizes that are not counted: '" + line + "'";
    }
  }
  if (kShortest * sizes[2] > bytes + 1.0) {
    return "ends early: it announces " + line.substr(line.find_last_of(" \t") + 1) + " entries";
  }
  return {};
}

/// What is wrong with Matrix Market's first line, or the sizes.
std::string fault_of_head(const std::string& path) {
  std::ifstream file{path};
  std::string line;
  if (!file || !std::getline(file, line)) {
    return "cannot be read";
  }
  std::ranges::transform(line, line.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  std::istringstream text{line};
  const std::vector<std::string> words{std::istream_iterator<std::string>{text}, {}};
  const auto is = [&](std::size_t i, std::initializer_list<const char*> any) {
    return i < words.size() && std::ranges::find(any, words[i]) != any.end();
  };
  if (!is(0, {"%%matrixmarket"}) || !is(1, {"matrix"}) || !is(2, {"coordinate"}) || !is(3, {"real", "integer"}) ||
      !is(4, {"general", "symmetric"})) {
    return "is not a Matrix Market file of a coordinate real general or symmetric matrix";
  }
  return fault_of_sizes(file, path);
}

struct MarketMatrix {
  PetscInt rows = 0;
  PetscInt columns = 0;
  std::vector<MatrixEntry> entries;
};

/// @return what is wrong with the file; empty: nothing
std::string read_market(const std::string& path, MarketMatrix& matrix) {
  if (std::string fault = fault_of_head(path); !fault.empty()) {
    return fault;
  }
  CholmodSession session;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file{std::fopen(path.c_str(), "r"), std::fclose};
  if (file == nullptr) {
    return "cannot be opened";
  }
  cholmod_triplet* read = cholmod_read_triplet(file.get(), session.get());
  if (read == nullptr) {
    return "ends early or is damaged: it has not the numbers that its header announces";
  }
  matrix.rows = static_cast<PetscInt>(read->nrow);
  matrix.columns = static_cast<PetscInt>(read->ncol);
  const auto* rows = static_cast<const int*>(read->i);
  const auto* columns = static_cast<const int*>(read->j);
  const auto* values = static_cast<const double*>(read->x);
  for (std::size_t k = 0; k < read->nnz; ++k) {
    matrix.entries.push_back({.row = rows[k], .column = columns[k], .value = values[k]});
    if (read->stype != 0 && rows[k] != columns[k]) {
      matrix.entries.push_back({.row = columns[k], .column = rows[k], .value = values[k]});
    }
  }
  cholmod_free_triplet(&read, session.get());
  return {};
}

/// Adds the other triangle where only one is stored.
petsc::Matrix with_both_triangles(MPI_Comm comm, petsc::Matrix matrix) {
  std::vector<MatrixEntry> entries = local_entries(matrix);
  std::array<int, 2> found{0, 0};  // below the diagonal, above it
  for (const MatrixEntry& entry : entries) {
    found[0] |= entry.row > entry.column && entry.value != 0.0 ? 1 : 0;
    found[1] |= entry.row < entry.column && entry.value != 0.0 ? 1 : 0;
  }
  MPI_Allreduce(MPI_IN_PLACE, found.data(), 2, MPI_INT, MPI_MAX, comm);
  PetscInt rows = 0;
  PetscInt columns = 0;
  UDAR_CALL(MatGetSize(matrix, &rows, &columns));
  if (found[0] == found[1] || rows != columns) {
    return matrix;
  }
  const std::size_t stored = entries.size();
  for (std::size_t k = 0; k < stored; ++k) {
    if (entries[k].row != entries[k].column) {
      entries.push_back({.row = entries[k].column, .column = entries[k].row, .value = entries[k].value});
    }
  }
  return matrix_of(comm, rows, columns, entries);
}

petsc::Matrix read_binary(MPI_Comm comm, const std::string& path) {
  petsc::Handle<PetscViewer, PetscViewerDestroy> viewer;
  petsc::Matrix matrix;
  UDAR_CALL(PetscViewerBinaryOpen(comm, path.c_str(), FILE_MODE_READ, viewer.put()));
  UDAR_CALL(MatCreate(comm, matrix.put()));
  UDAR_CALL(MatSetType(matrix, MATAIJ));
  UDAR_CALL(MatLoad(matrix, viewer));
  return matrix;
}

}  // namespace

std::vector<MatrixEntry> local_entries(Mat matrix) {
  PetscInt begin = 0;
  PetscInt end = 0;
  UDAR_CALL(MatGetOwnershipRange(matrix, &begin, &end));
  std::vector<MatrixEntry> entries;
  for (PetscInt row = begin; row < end; ++row) {
    PetscInt count = 0;
    const PetscInt* columns = nullptr;
    const double* values = nullptr;
    UDAR_CALL(MatGetRow(matrix, row, &count, &columns, &values));
    for (PetscInt k = 0; k < count; ++k) {
      entries.push_back({.row = row, .column = columns[k], .value = values[k]});
    }
    UDAR_CALL(MatRestoreRow(matrix, row, &count, &columns, &values));
  }
  return entries;
}

std::vector<MatrixEntry> gathered_entries(Mat matrix) {
  MPI_Comm comm = MPI_COMM_NULL;
  UDAR_CALL(PetscObjectGetComm(reinterpret_cast<PetscObject>(matrix), &comm));
  int rank = 0;
  int size = 1;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &size);
  std::vector<MatrixEntry> own = local_entries(matrix);
  if (size == 1) {
    return own;
  }
  // In units of whole entries, so that counts stay below what an int holds.
  MPI_Datatype type = MPI_DATATYPE_NULL;
  MPI_Type_contiguous(sizeof(MatrixEntry), MPI_BYTE, &type);
  MPI_Type_commit(&type);
  const int count = static_cast<int>(own.size());
  std::vector<int> counts(static_cast<std::size_t>(size));
  MPI_Gather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, 0, comm);
  std::vector<int> places(counts.size(), 0);
  for (std::size_t k = 1; k < counts.size(); ++k) {
    places[k] = places[k - 1] + counts[k - 1];
  }
  std::vector<MatrixEntry> all(rank == 0 ? static_cast<std::size_t>(places.back() + counts.back()) : 0);
  MPI_Gatherv(own.data(), count, type, all.data(), counts.data(), places.data(), type, 0, comm);
  MPI_Type_free(&type);
  return all;
}

petsc::Matrix matrix_of(MPI_Comm comm, PetscInt rows, PetscInt columns, const std::vector<MatrixEntry>& entries,
                        PetscInt local_rows) {
  std::vector<PetscInt> i;
  std::vector<PetscInt> j;
  std::vector<double> values;
  for (const MatrixEntry& entry : entries) {
    i.push_back(entry.row);
    j.push_back(entry.column);
    values.push_back(entry.value);
  }
  petsc::Matrix matrix;
  UDAR_CALL(MatCreate(comm, matrix.put()));
  UDAR_CALL(MatSetSizes(matrix, local_rows, rows == columns ? local_rows : PETSC_DECIDE, rows, columns));
  UDAR_CALL(MatSetType(matrix, MATAIJ));
  UDAR_CALL(MatSetPreallocationCOO(matrix, static_cast<PetscCount>(i.size()), i.data(), j.data()));
  UDAR_CALL(MatSetValuesCOO(matrix, values.data(), ADD_VALUES));
  return matrix;
}

petsc::Matrix read_matrix(MPI_Comm comm, const std::string& quantity, const std::string& path, PetscInt most_rows) {
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  const bool market = is_matrix_market(path);
  MarketMatrix read;
  std::string fault;
  if (rank == 0) {
    fault = market ? read_market(path, read) : fault_of_binary(path);
    if (fault.empty() && std::max(read.rows, read.columns) > most_rows) {
      fault = "has " + std::to_string(std::max(read.rows, read.columns)) + " rows or columns, expected at most " +
              std::to_string(most_rows) + ", for which there is memory";
    }
  }
  const std::string name = quantity + ": '" + path + "' ";
  throw_together<FileError>(comm, fault.empty() ? fault : name + fault);
  petsc::Matrix matrix;
  if (market) {
    std::array<PetscInt, 2> sizes{read.rows, read.columns};
    MPI_Bcast(sizes.data(), 2, MPIU_INT, 0, comm);
    matrix = matrix_of(comm, sizes[0], sizes[1], read.entries);
  } else {
    matrix = read_binary(comm, path);
  }
  matrix = with_both_triangles(comm, std::move(matrix));
  for (const MatrixEntry& entry : local_entries(matrix)) {
    if (!std::isfinite(entry.value) && fault.empty()) {
      fault = name + "has something else than a finite number in row " + std::to_string(entry.row) + ", column " +
              std::to_string(entry.column) + " (counted from 0)";
    }
  }
  throw_together<FileError>(comm, fault);
  return matrix;
}

void write_matrix(Mat matrix, const std::string& path) {
  MPI_Comm comm = MPI_COMM_NULL;
  UDAR_CALL(PetscObjectGetComm(reinterpret_cast<PetscObject>(matrix), &comm));
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  std::string fault;
  if (!is_matrix_market(path)) {
    if (rank == 0 && !std::ofstream{path, std::ios::binary}) {
      fault = "'" + path + "' cannot be written";
    }
    throw_together<FileError>(comm, fault);
    petsc::Handle<PetscViewer, PetscViewerDestroy> viewer;
    UDAR_CALL(PetscViewerBinaryOpen(comm, path.c_str(), FILE_MODE_WRITE, viewer.put()));
    UDAR_CALL(PetscViewerBinarySetSkipInfo(viewer, PETSC_TRUE));
    UDAR_CALL(MatView(matrix, viewer));
    return;
  }
  PetscInt rows = 0;
  UDAR_CALL(MatGetSize(matrix, &rows, nullptr));
  std::vector<MatrixEntry> entries = gathered_entries(matrix);
  if (rank == 0) {
    std::erase_if(entries, [](const MatrixEntry& entry) { return entry.row < entry.column || entry.value == 0.0; });
    std::ofstream file{path};
    file << "%%MatrixMarket matrix coordinate real symmetric\n"
         << rows << ' ' << rows << ' ' << entries.size() << '\n'
         << std::setprecision(17);
    for (const MatrixEntry& entry : entries) {
      file << entry.row + 1 << ' ' << entry.column + 1 << ' ' << entry.value << '\n';
    }
    file.close();
    fault = file ? std::string{} : "'" + path + "' cannot be written";
  }
  throw_together<FileError>(comm, fault);
}

}  // namespace udar
