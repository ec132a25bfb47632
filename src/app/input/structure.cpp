#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "app/input/readers.hpp"
#include "udar/app/memory_size.hpp"
#include "udar/petsc/error.hpp"
#include "udar/petsc/options.hpp"
#include "udar/petsc/session.hpp"

namespace udar::app {
namespace {

enum class Kind : std::uint8_t { beam, imported, network };

/// Places of the unknowns, and which way each moves.
void read_points(MPI_Comm comm, const std::string& path, ImportParameters& import) {
  const io::Table table =
      io::read_table(comm, "structure points", path, {.names = {"x [m]", "y [m]", "z [m]", "direction"}, .needed = 3});
  for (std::size_t row = 0; row < table.rows(); ++row) {
    import.places.push_back({.x = table.at(row, 0), .y = table.at(row, 1), .z = table.at(row, 2)});
    if (table.columns < 4) {
      continue;
    }
    const double direction = table.at(row, 3);
    if (!(direction >= 0.0 && direction <= 3.0) || direction != std::floor(direction)) {
      throw InputError{"option -structure_points: '" + path + "': a direction of " + std::to_string(direction) +
                       " in row " + std::to_string(row + 1) +
                       " is not allowed, expected 1 (along x), 2 (y, up), 3 (z) or 0 (no displacement)"};
    }
    import.directions.push_back(static_cast<Direction>(static_cast<int>(direction)));
  }
}

}  // namespace

StructureInput read_structure(MPI_Comm comm) {
  constexpr std::array kTypes{Names<Kind>{"beam", Kind::beam}, Names<Kind>{"import", Kind::imported},
                              Names<Kind>{"network", Kind::network}};
  constexpr std::array kLumpings{Names<Lumping>{"rows", Lumping::row}, Names<Lumping>{"hrz", Lumping::hrz}};
  petsc::OptionGroup group{comm, "Structure: a beam, a network (next groups), or stiffness and mass of any structure"};
  StructureInput input;
  ImportParameters import;
  std::string points;
  Kind kind = Kind::beam;
  group.choice<Kind>("-structure_type", kind, kTypes,
                     "beam, or in its place import: matrices from files, or network: members in space");
  const bool stiffness_given = group.string(
      "-structure_stiffness", import.stiffness,
      "for import: stiffness matrix, Matrix Market if the name ends in .mtx, else PETSc binary; one triangle or both");
  const bool mass_given =
      group.string("-structure_mass", import.mass,
                   "for import: mass matrix, lumped or consistent, in the same unknowns; some may have no mass");
  const bool points_given = group.string(
      "-structure_points", points,
      "for import: table x, y, z [m] and, if there is a fourth column, direction (1, 2, 3: along x, y, z; 0: none), a "
      "row for each unknown; y is up: gravity, supports and gauges are for unknowns along y, all of them without this "
      "column; without the file unknowns stand at x = 0, 1, 2, ...");
  const bool lumping_given = group.choice<Lumping>(
      "-structure_lumping", import.lumping, kLumpings,
      "for import: masses are the sums of rows, or the diagonal scaled to the same total, which is never negative");
  group.string("-structure_write", input.write,
               "for a beam: writes its matrices in displacements and rotations to files that begin so: -stiffness.mtx, "
               "-mass.mtx, -points.csv");
  group.real("-structure_memory", input.memory, "B", petsc::non_negative_or_infinite(),
             "memory of all ranks that a run may take by estimate before it is refused; 0: what the machines have "
             "available; inf: any");
  if (kind != Kind::imported && (stiffness_given || mass_given || points_given || lumping_given)) {
    throw InputError{
        "options -structure_stiffness, -structure_mass, -structure_points and -structure_lumping need "
        "-structure_type import"};
  }
  input.network = read_network(comm, kind == Kind::network, input.memory);
  if (kind == Kind::beam) {
    return input;
  }
  const std::string type = kind == Kind::network ? "network" : "import";
  if (!input.write.empty()) {
    throw InputError{"option -structure_write: '" + input.write + "' is not allowed with -structure_type " + type};
  }
  if (const std::string key = petsc::unread_option("beam_"); !key.empty() && !petsc::Session::help_requested()) {
    throw InputError{"option " + key + " is not allowed with -structure_type " + type + ", which has no beam"};
  }
  if (kind == Kind::network) {
    return input;
  }
  if (import.stiffness.empty() || import.mass.empty()) {
    throw InputError{"option -structure_type: import needs -structure_stiffness and -structure_mass"};
  }
  import.most_unknowns = most_unknowns(comm, input.memory);
  if (!points.empty()) {
    read_points(comm, points, import);
  }
  input.imported = std::move(import);
  return input;
}

}  // namespace udar::app
