#pragma once
/// @file
/// What every writer must know about a run: plain values, no time and no files.

#include <petscsys.h>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "udar/io/file_rows.hpp"
#include "udar/io/output_choice.hpp"
#include "udar/numerics/height_grid.hpp"
#include "udar/structure/description.hpp"
#include "udar/structure/field.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar {
struct MotionState;
}

namespace udar::io {

/// @brief A multiple of the largest size that a field reaches at each point: the bending stress |M| / W.
struct ScaledPeak {
  std::string name;            ///< "stress": stress_max in the envelope
  std::string unit;            ///< "Pa"
  std::string field;           ///< one with extremes at the points
  std::vector<double> factor;  ///< of this rank's points; not a number: not known
};

/// @brief The plain description of a run that all writers get. Equal on every rank but for what is said to be a rank's.
///
/// Files keep nodes in the user's numbering, one row a node, and name them by their number in the user's model.
struct RunLayout {
  /// @brief One support, or the floor.
  struct Support {
    double position = 0.0;      ///< centre along the beam [m]
    double width = 0.0;         ///< along the beam [m]; 0 for a point support
    double height = 0.0;        ///< of the contact face [m], y up; of a field the highest
    double restitution = 0.0;   ///< between 0 and 1
    int side = 1;               ///< +1 below the beam, -1 above
    std::int64_t striker = -1;  ///< which striker's face it is; -1: of none
    std::int64_t pair = -1;     ///< which pair's of nodes; -1: of none
    /// Of a support in space: normal x, y, z [-], what it touches from and to along y, then along z [m]; else empty.
    std::vector<double> space{};
    std::shared_ptr<const HeightGrid> field = nullptr;  ///< heights over `base`; null: none
    double base = 0.0;                                  ///< [m]
    std::function<double(double)> lift =
        nullptr;  ///< what its motion adds to the height [m] at a time [s]; empty: none
    /// @name For pictures
    /// @{
    double reach = 0.0;   ///< where what it touches first stands along its normal as long as nothing strains it [m]
    double radius = 0.0;  ///< how far that reaches towards it [m]
    /// @}
  };

  /// @brief Of each gauge.
  struct Gauges {
    std::vector<PetscInt> node{};                   ///< global point
    std::vector<std::vector<PointShare>> height{};  ///< what it reads
    std::vector<double> position{};                 ///< what was asked for [m]
  };

  /// @param of         borrowed; must outlive the writers
  /// @param topology_of them @param choice which of them have rows @note Collective.
  /// @throws InputError if none has
  RunLayout(const MassPoints& of, Topology topology_of, const RowChoice& choice = {});

  const MassPoints* points;              ///< never null
  Topology topology;                     ///< this rank's cells, whether they have rows or not
  bool tubes = false;                    ///< its cells have radii
  bool members = false;                  ///< and are pieces of members
  std::shared_ptr<const FileRows> rows;  ///< from this rank's points and cells to rows of the files
  std::vector<FieldInfo> fields;         ///< of the snapshots, in their order
  ContentChoice content{};
  std::vector<ScaledPeak> peaks;  ///< made of their extremes
  Gauges gauges{};
  /// How high the base is [m], and how fast it rises [m/s], at a time [s]; empty: it stays where it is.
  std::function<std::array<double, 2>(double)> base = nullptr;
  std::size_t places = 0;                    ///< that hold the structure and move, `Snapshot::places`
  std::vector<Support> supports;             ///< the floor, if any, is the last
  std::vector<double> ground_x;              ///< of the ground's profile [m]; empty: none
  std::vector<double> ground_height;         ///< as many [m]
  std::optional<double> filter_frequency{};  ///< [rad/s]; none: modes alone move
  double longest_sample = 0.0;               ///< extremes are looked for at least this often [s]; 0: at rows alone
  std::string options_text;                  ///< one `-key value` per line
  std::vector<Parameter> parameters;         ///< of the case, as restart files have them
  /// What the files stood at, of a run that goes on in them; null: they are made anew. It must outlive the writers'
  /// construction.
  const MotionState* earlier = nullptr;

  [[nodiscard]] MPI_Comm comm() const noexcept { return points->comm(); }
  /// This rank's rows of the nodes, and of the cells.
  [[nodiscard]] const NodeRange& nodes() const noexcept { return rows->nodes().range(); }
  [[nodiscard]] const NodeRange& cells() const noexcept { return rows->cells().range(); }
  /// Fields with rows that files have. @throws InputError if one that is wanted does not exist
  [[nodiscard]] std::vector<FileField> fields_in_files() const;
  /// The same, those of the line, then those of the masses.
  [[nodiscard]] std::vector<FileField> fields_in_pictures() const;
  /// Where some global points are, x, y, z of each, the same on every rank [m]. @note Collective: one reduction.
  [[nodiscard]] std::vector<double> places_of(std::span<const PetscInt> global) const;
  /// Numbers in the user's model of the nodes of some global points, the same on every rank. @note Collective: one
  /// reduction.
  [[nodiscard]] std::vector<std::int64_t> numbers_of(std::span<const PetscInt> global) const;
};

}  // namespace udar::io
