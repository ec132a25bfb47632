#include "udar/structure/imported.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <numeric>
#include <sstream>

#include "structure/pivots.hpp"
#include "udar/petsc/array.hpp"
#include "udar/petsc/error.hpp"
#include "udar/structure/matrix_file.hpp"

namespace udar {
namespace {

/// Unsymmetry of an entry, over the largest of its row, that is the rounding of whoever wrote ten digits or more.
constexpr double kUnsymmetry = 1e-10;
/// wf^2 over the largest K_ii / m_i that makes rigid motions definite: far above rounding, far below any stiffness that
/// could matter.
constexpr double kShift = 1e-10;

std::string text(double value) {
  std::ostringstream stream;
  stream << value;
  return stream.str();
}

std::array<PetscInt, 2> size_of(Mat matrix) {
  std::array<PetscInt, 2> size{};
  UDAR_CALL(MatGetSize(matrix, &size[0], &size[1]));
  return size;
}

void require_square(const std::string& quantity, Mat matrix) {
  const auto [rows, columns] = size_of(matrix);
  if (rows != columns || rows < 1) {
    throw InputError{quantity + ": a matrix of " + std::to_string(rows) + " rows and " + std::to_string(columns) +
                     " columns is not allowed, expected a square one"};
  }
}

/// Refuses an unsymmetric matrix; takes the mean of both triangles otherwise.
void make_symmetric(const std::string& quantity, MPI_Comm comm, Mat matrix) {
  petsc::Matrix other;
  UDAR_CALL(MatTranspose(matrix, MAT_INITIAL_MATRIX, other.put()));
  PetscInt begin = 0;
  UDAR_CALL(MatGetOwnershipRange(matrix, &begin, nullptr));
  std::map<PetscInt, double> largest;  // of each row
  for (const MatrixEntry& entry : local_entries(matrix)) {
    largest[entry.row] = std::max(largest[entry.row], std::abs(entry.value));
  }
  petsc::Matrix difference;
  UDAR_CALL(MatDuplicate(matrix, MAT_COPY_VALUES, difference.put()));
  UDAR_CALL(MatAXPY(difference, -1.0, other, DIFFERENT_NONZERO_PATTERN));
  std::string failure;
  int differs = 0;
  for (const MatrixEntry& entry : local_entries(difference)) {
    differs = entry.value != 0.0 ? 1 : differs;
    if (failure.empty() && std::abs(entry.value) > kUnsymmetry * largest[entry.row]) {
      failure = quantity + ": the matrix is not symmetric: entries (" + std::to_string(entry.row) + ", " +
                std::to_string(entry.column) + ") and (" + std::to_string(entry.column) + ", " +
                std::to_string(entry.row) + "), counted from 0, differ by " + text(std::abs(entry.value));
    }
  }
  throw_together<InputError>(comm, failure);
  MPI_Allreduce(MPI_IN_PLACE, &differs, 1, MPI_INT, MPI_MAX, comm);
  if (differs != 0) {
    UDAR_CALL(MatAXPY(matrix, 1.0, other, DIFFERENT_NONZERO_PATTERN));
    UDAR_CALL(MatScale(matrix, 0.5));
  }
}

/// Sum, modulo 2^64, of the bits of each entry times odd numbers of its place: the same on any number of ranks.
std::uint64_t checksum(MPI_Comm comm, Mat stiffness, Vec mass) {
  std::uint64_t sum = 0;
  const auto odd = [](PetscInt number) { return 2 * static_cast<std::uint64_t>(number) + 1; };
  for (const MatrixEntry& entry : local_entries(stiffness)) {
    sum += std::bit_cast<std::uint64_t>(entry.value) * odd(entry.row) * odd(entry.column);
  }
  PetscInt begin = 0;
  PetscInt end = 0;
  UDAR_CALL(VecGetOwnershipRange(mass, &begin, &end));
  const petsc::ReadArray masses{mass};
  for (PetscInt row = begin; row < end; ++row) {
    sum += std::bit_cast<std::uint64_t>(masses.values()[row - begin]) * odd(row);
  }
  MPI_Allreduce(MPI_IN_PLACE, &sum, 1, MPI_UINT64_T, MPI_SUM, comm);
  return sum;
}

petsc::Vector vector_for(Mat matrix) {
  petsc::Vector vector;
  UDAR_CALL(MatCreateVecs(matrix, nullptr, vector.put()));
  return vector;
}

/// All of a vector on rank 0, nothing on the others.
petsc::Vector on_first_rank(Vec vector) {
  petsc::Handle<VecScatter, VecScatterDestroy> scatter;
  petsc::Vector gathered;
  UDAR_CALL(VecScatterCreateToZero(vector, scatter.put(), gathered.put()));
  UDAR_CALL(VecScatterBegin(scatter, vector, gathered, INSERT_VALUES, SCATTER_FORWARD));
  UDAR_CALL(VecScatterEnd(scatter, vector, gathered, INSERT_VALUES, SCATTER_FORWARD));
  return gathered;
}

/// The same bits on any number of ranks.
double sum_of(MPI_Comm comm, Vec vector) {
  const petsc::Vector gathered = on_first_rank(vector);
  PetscInt count = 0;
  UDAR_CALL(VecGetLocalSize(gathered, &count));
  double sum = 0.0;
  {
    const petsc::ReadArray values{gathered};
    sum = std::accumulate(values.values(), values.values() + count, 0.0);
  }
  MPI_Bcast(&sum, 1, MPI_DOUBLE, 0, comm);
  return sum;
}

}  // namespace

ImportedStructure::ImportedStructure(MPI_Comm comm, const ImportParameters& parameters) : comm_{comm} {
  const std::string of_stiffness = "structure stiffness";
  const std::string of_mass = "structure mass";
  const petsc::Matrix stiffness = read_matrix(comm, of_stiffness, parameters.stiffness, parameters.most_unknowns);
  const petsc::Matrix mass = read_matrix(comm, of_mass, parameters.mass, parameters.most_unknowns);
  require_square(of_stiffness, stiffness);
  require_square(of_mass, mass);
  unknowns_ = size_of(stiffness)[0];
  if (size_of(mass)[0] != unknowns_) {
    throw InputError{of_mass + ": " + std::to_string(size_of(mass)[0]) + " unknowns are not allowed, expected " +
                     std::to_string(unknowns_) + " as in `" + of_stiffness + "`"};
  }
  const auto count = static_cast<std::size_t>(unknowns_);
  for (const auto& [given, what] :
       {std::pair{parameters.places.size(), " places"}, std::pair{parameters.directions.size(), " directions"}}) {
    if (given != 0 && given != count) {
      throw InputError{"structure points: " + std::to_string(given) + what +
                       " are not allowed, expected one for each of the " + std::to_string(unknowns_) + " unknowns"};
    }
  }
  make_symmetric(of_stiffness, comm, stiffness);
  make_symmetric(of_mass, comm, mass);
  const petsc::Vector masses = lumped(mass, parameters.lumping);
  check_unknowns(stiffness, masses);
  check_pivots(stiffness, masses);
  checksum_ = checksum(comm, stiffness, masses);
  grounded_ = resists_translation(stiffness, parameters.directions);
  order(stiffness, masses, parameters);
}

petsc::Vector ImportedStructure::lumped(Mat mass, Lumping lumping) {
  petsc::Vector sums = vector_for(mass);
  {
    PetscInt begin = 0;
    UDAR_CALL(MatGetOwnershipRange(mass, &begin, nullptr));
    UDAR_CALL(VecSet(sums, 0.0));
    const petsc::WriteArray values{sums};
    for (const MatrixEntry& entry : local_entries(mass)) {  // in the order of columns, whatever ranks have them
      values.values()[entry.row - begin] += entry.value;
    }
  }
  total_mass_ = sum_of(comm_, sums);
  if (lumping == Lumping::row) {
    return sums;
  }
  petsc::Vector diagonal = vector_for(mass);
  UDAR_CALL(MatGetDiagonal(mass, diagonal));
  const double trace = sum_of(comm_, diagonal);
  UDAR_CALL(VecScale(diagonal, trace != 0.0 ? total_mass_ / trace : 1.0));
  return diagonal;
}

/// What each unknown must have by itself: no negative mass, and mass or stiffness.
void ImportedStructure::check_unknowns(Mat stiffness, Vec mass) const {
  const petsc::Vector diagonal = vector_for(stiffness);
  UDAR_CALL(MatGetDiagonal(stiffness, diagonal));
  PetscInt begin = 0;
  PetscInt end = 0;
  UDAR_CALL(MatGetOwnershipRange(stiffness, &begin, &end));
  std::string failure;
  {
    const petsc::ReadArray masses{mass};
    const petsc::ReadArray stiffnesses{diagonal};
    for (PetscInt unknown = begin; unknown < end && failure.empty(); ++unknown) {
      const double m = masses.values()[unknown - begin];
      const std::string name = "unknown " + std::to_string(unknown) + " (counted from 0) ";
      if (m < 0.0) {
        failure = "structure mass: " + name + "has a lumped mass of " + text(m) +
                  " kg, which is not allowed; `structure lumping` hrz gives none below 0";
      } else if (m == 0.0 && stiffnesses.values()[unknown - begin] == 0.0) {
        failure = "structure stiffness: " + name + "has neither mass nor stiffness";
      }
    }
  }
  throw_together<InputError>(comm_, failure);
  if (!(total_mass_ > 0.0)) {
    throw InputError{"structure mass: the matrix has no mass"};
  }
  const double lumped = sum_of(comm_, mass);
  // Sums of the same numbers in another order.
  if (std::abs(lumped - total_mass_) > 1e-10 * total_mass_) {
    throw InputError{"structure mass: the lumped masses sum to " + text(lumped) + " kg and the matrix to " +
                     text(total_mass_) + " kg"};
  }
}

/// Rank 0 factors K + shift M, which is definite unless something negative is in K, or something without mass is loose.
void ImportedStructure::check_pivots(Mat stiffness, Vec mass) {
  const petsc::Vector diagonal = vector_for(stiffness);
  const petsc::Vector ratio = vector_for(stiffness);
  UDAR_CALL(MatGetDiagonal(stiffness, diagonal));
  {
    const petsc::ReadArray masses{mass};
    const petsc::ReadArray stiffnesses{diagonal};
    const petsc::WriteArray ratios{ratio};
    PetscInt count = 0;
    UDAR_CALL(VecGetLocalSize(mass, &count));
    for (PetscInt i = 0; i < count; ++i) {
      const double m = masses.values()[i];
      ratios.values()[i] = m > 0.0 ? stiffnesses.values()[i] / m : 0.0;
    }
  }
  double highest = 0.0;
  UDAR_CALL(VecMax(ratio, nullptr, &highest));
  const std::vector<MatrixEntry> entries = gathered_entries(stiffness);
  const petsc::Vector gathered = on_first_rank(mass);
  int rank = 0;
  MPI_Comm_rank(comm_, &rank);
  std::string failure;
  PetscInt small = 0;
  if (rank == 0) {
    const petsc::ReadArray masses{gathered};
    std::vector<double> added(static_cast<std::size_t>(unknowns_));
    std::ranges::transform(masses.values(), masses.values() + unknowns_, added.begin(),
                           [&](double m) { return kShift * highest * m; });
    const Pivots pivots = pivots_of(entries, added);
    small = pivots.small;
    if (pivots.failed) {
      const bool massless = added[static_cast<std::size_t>(*pivots.failed)] == 0.0;
      failure =
          "structure stiffness: the pivot of unknown " + std::to_string(*pivots.failed) +
          " (counted from 0) is not positive: " +
          (massless ? "it has no mass and is loose, or the stiffness is indefinite" : "the stiffness is indefinite");
    }
  }
  throw_together<InputError>(comm_, failure);
  MPI_Bcast(&small, 1, MPIU_INT, 0, comm_);
  constexpr PetscInt kOfOneBody = 6;
  rigid_modes_ = std::max(kOfOneBody, small);
}

bool ImportedStructure::resists_translation(Mat stiffness, const std::vector<Direction>& directions) const {
  constexpr double kRounding = 1e-13;  // of what a sum is made of, by whoever assembled it in double precision
  std::map<PetscInt, std::array<double, 2>> sums;  // of each row: of its entries, and of their sizes
  for (const MatrixEntry& entry : local_entries(stiffness)) {
    if (directions.empty() || directions[static_cast<std::size_t>(entry.column)] == Direction::y) {
      auto& [sum, size] = sums[entry.row];
      sum += entry.value;
      size += std::abs(entry.value);
    }
  }
  int resists = std::ranges::any_of(sums, [](const auto& row) {
    const auto& [sum, size] = row.second;
    return std::abs(sum) > kRounding * size;
  });
  MPI_Allreduce(MPI_IN_PLACE, &resists, 1, MPI_INT, MPI_LOR, comm_);
  return resists != 0;
}

void ImportedStructure::order(Mat stiffness, Vec mass, const ImportParameters& parameters) {
  const auto direction = [&](PetscInt row) {
    return parameters.directions.empty() ? Direction::y : parameters.directions[static_cast<std::size_t>(row)];
  };
  PetscInt first = 0;
  PetscInt last = 0;
  UDAR_CALL(MatGetOwnershipRange(stiffness, &first, &last));
  const auto count = static_cast<std::size_t>(last - first);
  std::vector<PetscInt> rows(count);  // old numbers in the new order
  std::iota(rows.begin(), rows.end(), first);
  PointTable table;
  {
    const petsc::ReadArray masses{mass};
    const auto without =
        std::ranges::stable_partition(rows, [&](PetscInt row) { return masses.values()[row - first] > 0.0; });
    std::ranges::stable_partition(rows.begin(), without.begin(),
                                  [&](PetscInt row) { return direction(row) == Direction::y; });
    for (const PetscInt row : rows) {
      if (const double m = masses.values()[row - first]; m > 0.0) {
        table.mass.push_back(m);
        table.number.push_back(row);
        table.direction.push_back(direction(row));
        table.place.push_back(parameters.places.empty() ? Place{.x = static_cast<double>(row)}
                                                        : parameters.places[static_cast<std::size_t>(row)]);
      }
    }
  }
  throw_together<InputError>(comm_, table.mass.empty()
                                        ? "structure mass: no unknown with mass on one of the ranks; use fewer ranks"
                                        : std::string{});
  points_ = std::make_unique<PlacedPoints>(comm_, 1, std::move(table));
  petsc::IndexSet order;
  UDAR_CALL(ISCreateGeneral(comm_, static_cast<PetscInt>(count), rows.data(), PETSC_COPY_VALUES, order.put()));
  UDAR_CALL(MatCreateSubMatrix(stiffness, order, order, MAT_INITIAL_MATRIX, stiffness_.put()));
  UDAR_CALL(MatSetOption(stiffness_, MAT_SYMMETRIC, PETSC_TRUE));
}

Topology ImportedStructure::topology() const {
  Topology topology{.name = "points", .shape = Topology::Shape::vertex, .corners = {}};
  for (PetscInt point = points_->begin(); point < points_->end(); ++point) {
    topology.corners.push_back(point);
  }
  return topology;
}

void ImportedStructure::describe(Description& all) const {
  all.add("structure", "import");
  all.add("unknowns", static_cast<double>(unknowns_));
  all.add("points", static_cast<double>(points_->total()));
  all.add("mass, of all directions [kg]", total_mass_);
  all.add("stiffness and masses, checksum", std::to_string(checksum_));
}

double ImportedStructure::largest_ratio() const {
  petsc::Vector diagonal;
  UDAR_CALL(MatCreateVecs(stiffness_, nullptr, diagonal.put()));
  UDAR_CALL(MatGetDiagonal(stiffness_, diagonal));
  double largest = 0.0;
  {
    const petsc::ReadArray stiffness{diagonal};
    const std::span<const double> mass = points_->mass();
    for (std::size_t i = 0; i < mass.size(); ++i) {
      largest = std::max(largest, stiffness.values()[i] / mass[i]);
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, &largest, 1, MPI_DOUBLE, MPI_MAX, comm_);
  return largest;
}

}  // namespace udar
