#pragma once
/// @file
/// What the rows of a run's files are: nodes and cells in the user's numbering, and how values of points become theirs.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "udar/io/output_choice.hpp"
#include "udar/io/point_order.hpp"
#include "udar/io/shown_rows.hpp"
#include "udar/structure/field.hpp"
#include "udar/structure/mass_points.hpp"

namespace udar::io {

/// @brief A field as files have it.
struct FileField : FieldInfo {
  /// How its values follow from those of a snapshot's field: they are these; sums over a node's points of axis times
  /// value; the same of how far they are from their places; of axes about which points turn; whether there is any at a
  /// node.
  enum class Form : std::uint8_t { given, vectors, displacement, rotation, any };

  std::size_t source = 0;  ///< which of the snapshot's fields
  Form form = Form::given;

  /// Where its rows stand in results.h5.
  [[nodiscard]] std::string path() const { return "/fields/" + std::string{name}; }
};

/// @brief From this rank's points and cells to rows of the files.
///
/// A node has a row, unless others are chosen. Where it is one point, so have the numbers of the point; of several that
/// move along axes of their own files have what they are together: vectors in global axes. Strikers have no row; nodes
/// that are struck have what they are by themselves.
class FileRows {
 public:
  /// @param points borrowed; must outlive it @note Collective. @throws InputError if nothing is chosen
  FileRows(const MassPoints& points, const Topology& topology, const RowChoice& choice = {});

  [[nodiscard]] const PointOrder& nodes() const noexcept { return nodes_; }
  [[nodiscard]] const PointOrder& cells() const noexcept { return cells_; }
  [[nodiscard]] const PointOrder& order_of(Where where) const noexcept {
    return where == Where::points ? nodes_ : cells_;
  }
  /// All points move along y: their positions are heights.
  [[nodiscard]] bool upright() const noexcept { return upright_; }
  /// Some node has several points.
  [[nodiscard]] bool grouped() const noexcept { return !node_.empty(); }
  /// One of the points of each of this rank's nodes that have rows.
  [[nodiscard]] const std::vector<std::size_t>& a_point() const noexcept { return a_point_; }
  /// Which of this rank's rows is that of a local point's node; empty: it has none.
  [[nodiscard]] std::optional<std::size_t> row(std::size_t point) const;
  /// Whether the node of a local point, or one beside it that a stride left, is one of those chosen.
  [[nodiscard]] bool covers(std::size_t point) const { return covered_.empty() || covered_[node(point)] != 0; }
  /// All nodes are covered. The same on every rank.
  [[nodiscard]] bool whole() const noexcept { return whole_; }
  /// All nodes and cells have rows. The same on every rank.
  [[nodiscard]] bool all() const noexcept { return all_; }
  /// The cells that have rows; corners count the nodes that have.
  [[nodiscard]] const Topology& topology() const noexcept { return shown_.topology; }
  /// Of values of all this rank's own points of a chain, or of all its cells, those that have rows.
  [[nodiscard]] std::vector<double> chosen(Where where, std::span<const double> values) const;
  /// Number of a local point's node in the user's model.
  [[nodiscard]] std::int64_t number(std::size_t point) const;
  /// Of a node's own local point, without what strikes it [kg].
  [[nodiscard]] double mass(std::size_t point) const { return mass_[point]; }
  /// @brief What files have over time of a snapshot's fields. Of points that do not all move along y they have
  /// displacements, vectors [m]; of nodes of several points these in place of positions. Where points turn there are
  /// rotations [rad] and their rates besides.
  [[nodiscard]] std::vector<FileField> fields(std::span<const FieldInfo> shown) const;
  /// Whether its values are those of the snapshot as they stand.
  [[nodiscard]] bool as_shown(const FileField& field) const {
    return field.form == FileField::Form::given && order_of(field.where).same() && points_->of_nodes_alone() && all_;
  }
  /// @name Values of such a field at this rank's nodes or cells @note Not collective.
  /// @{
  [[nodiscard]] std::vector<double> numbers(const FileField& field, std::span<const double> given) const;
  [[nodiscard]] std::vector<std::uint8_t> flags(const FileField& field, std::span<const std::uint8_t> given) const;
  /// @}

 private:
  [[nodiscard]] std::size_t node(std::size_t point) const;
  template <class Value>
  [[nodiscard]] std::vector<Value> chosen_of(Where where, std::vector<Value> values, std::size_t components) const;

  const MassPoints* points_;
  bool whole_;
  bool all_;
  std::vector<std::size_t> node_;            ///< of each point; empty: each is one
  std::vector<std::int64_t> number_;         ///< of each node if grouped
  std::size_t cells_of_all_;                 ///< of this rank
  std::vector<std::size_t> a_point_of_all_;  ///< of its nodes, whether they have rows or not
  ShownRows shown_;
  std::vector<std::size_t> a_point_{};  ///< of those that have rows
  std::vector<std::int64_t> row_;       ///< of each node, -1: none
  std::vector<std::uint8_t> covered_;   ///< of each node; empty: all are
  bool upright_ = true;
  bool turns_ = false;  ///< some point does
  std::vector<double> mass_;
  PointOrder nodes_;
  PointOrder cells_;
};

}  // namespace udar::io
