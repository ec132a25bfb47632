#pragma once
/// @file
/// What a run shows of a structure, as data: who computes a quantity declares it once, files and pictures take whatever
/// is there.

#include <petscsystypes.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

namespace udar {

/// @brief What a field belongs to: the structure's massless elastic line, or the masses on their filter springs.
enum class Body : std::uint8_t { line, masses };

/// @brief Where a field has its values: at the points, or in the cells between them.
enum class Where : std::uint8_t { points, cells };

/// @brief What a quantity is; the same at every time of a run. Names and units are literals.
struct FieldInfo {
  std::string_view name;   ///< "moment": /fields/moment in results.h5, moment_min in envelope.csv
  std::string_view unit;   ///< "N m"; "1" of a number
  Body body = Body::line;  ///< which of the two it is shown on
  Where where = Where::points;
  int components = 1;           ///< values at a point, one behind the other
  bool flag = false;            ///< the values are bytes, 0 or 1
  bool position = false;        ///< the height of the body's points [m]: pictures show the points there
  bool rows = true;             ///< written over time
  bool extremes = false;        ///< of one component: its least and largest value at each place go to the envelope
  std::string_view gauge = {};  ///< its columns in gauges.csv, "mass" for mass_0, mass_1, ...; empty: none
  std::string_view label = {};  ///< what pictures call it, "bending moment"; empty: its name

  [[nodiscard]] std::size_t bytes() const noexcept {
    return static_cast<std::size_t>(components) * (flag ? 1 : sizeof(double));
  }
};

/// @brief A quantity at one time: `components` values for each point, or each cell, of this rank in order; what follows
/// the last cell has no meaning.
struct Field : FieldInfo {
  std::variant<std::span<const double>, std::span<const std::uint8_t>> values;

  [[nodiscard]] std::span<const double> numbers() const { return std::get<std::span<const double>>(values); }
  [[nodiscard]] std::span<const std::uint8_t> flags() const { return std::get<std::span<const std::uint8_t>>(values); }
  [[nodiscard]] const void* data() const noexcept {
    return flag ? static_cast<const void*>(std::get_if<1>(&values)->data()) : std::get_if<0>(&values)->data();
  }
};

/// @brief The field of that name. @throws std::out_of_range naming it if there is none
[[nodiscard]] const Field& find_field(std::span<const Field> fields, std::string_view name);

/// @brief How the points of a structure hang together, for files and pictures of it and for fields between the points:
/// cells of one shape between nodes, of both each rank's behind those of the rank before.
///
/// A node is a point by itself, or several of one rank that stand at one place and move along axes of their own: files
/// have one vector for their numbers.
struct Topology {
  enum class Shape : std::uint8_t { vertex, line, triangle, quadrilateral, tetrahedron, hexahedron };

  std::string_view name = "beam";
  Shape shape = Shape::line;
  std::vector<PetscInt> corners;  ///< global nodes of this rank's cells, one cell behind the other, in VTK's order
  /// @name Of this rank, each empty where there is no more to say
  /// @{
  std::vector<std::size_t> node{};          ///< of each point, of this rank's; empty: each point is a node
  std::vector<std::int64_t> node_number{};  ///< of each of these in the user's model
  std::vector<std::int64_t> cell_number{};  ///< of each cell in the user's model; empty: as they stand
  std::vector<std::int64_t> member{};       ///< which part of the user's model each cell is a piece of
  std::vector<double> radius{};             ///< of the tube that each cell is in pictures [m]
  /// @}

  /// Corners of one cell.
  [[nodiscard]] static constexpr PetscInt corners_of(Shape shape) {
    switch (shape) {
      case Shape::vertex:
        return 1;
      case Shape::line:
        return 2;
      case Shape::triangle:
        return 3;
      case Shape::quadrilateral:
      case Shape::tetrahedron:
        return 4;
      case Shape::hexahedron:
        break;
    }
    return 8;
  }
  /// Cells of this rank.
  [[nodiscard]] PetscInt cells() const { return static_cast<PetscInt>(corners.size()) / corners_of(shape); }
};

}  // namespace udar
