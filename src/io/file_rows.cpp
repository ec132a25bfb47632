#include "udar/io/file_rows.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "udar/structure/striker.hpp"

namespace udar::io {
namespace {

constexpr std::size_t kVector = 3;  // components

/// One of the points of each node.
std::vector<std::size_t> points_of_nodes(const MassPoints& points, const Topology& topology) {
  std::vector<std::size_t> chosen(topology.node.empty() ? points.own_points() : topology.node_number.size());
  if (topology.node.empty()) {
    std::iota(chosen.begin(), chosen.end(), std::size_t{0});
  }
  for (std::size_t point = topology.node.size(); point-- > 0;) {  // the first stays
    chosen[topology.node[point]] = point;
  }
  return chosen;
}

bool all_upright(const MassPoints& points) {
  int all = 1;
  for (std::size_t point = 0; point < points.points(); ++point) {
    all &= points.direction(point) == Direction::y ? 1 : 0;
  }
  MPI_Allreduce(MPI_IN_PLACE, &all, 1, MPI_INT, MPI_LAND, points.comm());
  return all != 0;
}

bool any_turns(const MassPoints& points) {
  int any = 0;
  for (std::size_t point = 0; point < points.points(); ++point) {
    const Place about = points.turning(point);
    any |= about.x != 0.0 || about.y != 0.0 || about.z != 0.0 ? 1 : 0;
  }
  MPI_Allreduce(MPI_IN_PLACE, &any, 1, MPI_INT, MPI_LOR, points.comm());
  return any != 0;
}

/// What the points that turn have where others have this, vectors about global axes.
FileField rotation_of(const FileField& field) {
  FileField turned = field;
  turned.name = !field.position              ? "rotation_rate_of_masses"
                : field.body == Body::masses ? "rotation_of_masses"
                                             : "rotation_of_line";
  turned.unit = field.position ? "rad" : "rad/s";
  turned.label = {};
  turned.components = static_cast<int>(kVector);
  turned.position = turned.extremes = false;
  turned.form = FileField::Form::rotation;
  return turned;
}

std::vector<std::int64_t> numbers_of_nodes(const MassPoints& points, const Topology& topology) {
  if (!topology.node.empty()) {
    return topology.node_number;
  }
  std::vector<std::int64_t> numbers(points.own_points());
  for (std::size_t point = 0; point < numbers.size(); ++point) {
    numbers[point] = points.number(point);
  }
  return numbers;
}

/// Of some of this rank's nodes. What all ranks hold in the user's order they do so after some were left out.
PointOrder order_of_nodes(MPI_Comm comm, const std::vector<std::int64_t>& numbers,
                          const std::vector<std::size_t>& chosen) {
  const bool same = PointOrder{comm, range_of(comm, static_cast<PetscInt>(numbers.size())), numbers}.same();
  std::vector<std::int64_t> own;
  for (std::size_t i = 0; !same && i < chosen.size(); ++i) {
    own.push_back(numbers[chosen[i]]);
  }
  return {comm, range_of(comm, static_cast<PetscInt>(chosen.size())), own};
}

/// A mark for each of this rank's nodes that the choice has without its stride; empty: all.
std::vector<std::uint8_t> covered_nodes(const MassPoints& points, const Topology& topology,
                                        const std::vector<std::size_t>& a_point, RowChoice choice) {
  choice.stride = 1;
  std::vector<std::uint8_t> covered(choice.whole() ? 0 : a_point.size(), 0);
  if (!choice.whole()) {
    for (const std::size_t node : choose_rows(points, topology, a_point, choice).nodes) {
      covered[node] = 1;
    }
  }
  return covered;
}

std::vector<std::int64_t> rows_of_nodes(std::size_t nodes, const std::vector<std::size_t>& chosen) {
  std::vector<std::int64_t> rows(nodes, -1);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    rows[chosen[i]] = static_cast<std::int64_t>(i);
  }
  return rows;
}

}  // namespace

FileRows::FileRows(const MassPoints& points, const Topology& topology, const RowChoice& choice)
    : points_{&points},
      whole_{choice.whole()},
      all_{choice.all()},
      node_{topology.node},
      number_{topology.node_number},
      cells_of_all_{static_cast<std::size_t>(topology.cells())},
      a_point_of_all_{points_of_nodes(points, topology)},
      shown_{choose_rows(points, topology, a_point_of_all_, choice)},
      row_{rows_of_nodes(a_point_of_all_.size(), shown_.nodes)},
      covered_{covered_nodes(points, topology, a_point_of_all_, choice)},
      upright_{all_upright(points)},
      turns_{any_turns(points)},
      mass_{node_masses(points)},
      nodes_{order_of_nodes(points.comm(), numbers_of_nodes(points, topology), shown_.nodes)},
      cells_{points.comm(), shown_.topology} {
  for (const std::size_t node : shown_.nodes) {
    a_point_.push_back(a_point_of_all_[node]);
  }
}

std::size_t FileRows::node(std::size_t point) const {
  const std::size_t own = points_->own_point(point);
  return grouped() ? node_[own] : own;
}

std::optional<std::size_t> FileRows::row(std::size_t point) const {
  const std::int64_t row = row_[node(point)];
  return row >= 0 ? std::optional{static_cast<std::size_t>(row)} : std::nullopt;
}

template <class Value>
std::vector<Value> FileRows::chosen_of(Where where, std::vector<Value> values, std::size_t components) const {
  if (all_) {
    return values;
  }
  std::vector<Value> some;
  for (const std::size_t place : where == Where::points ? shown_.nodes : shown_.cells) {
    const auto from = values.begin() + static_cast<std::ptrdiff_t>(place * components);
    some.insert(some.end(), from, from + static_cast<std::ptrdiff_t>(components));
  }
  return some;
}

std::vector<double> FileRows::chosen(Where where, std::span<const double> values) const {
  return chosen_of(where, std::vector<double>{values.begin(), values.end()}, 1);
}

std::int64_t FileRows::number(std::size_t point) const {
  return grouped() ? number_[node(point)] : points_->number(node(point));
}

std::vector<FileField> FileRows::fields(std::span<const FieldInfo> shown) const {
  using Form = FileField::Form;
  std::vector<FileField> all;
  for (std::size_t i = 0; i < shown.size(); ++i) {
    FileField field{shown[i], i};
    if (!field.rows) {
      continue;
    }
    if (field.position && !upright_) {
      FileField moved = field;
      moved.name = field.body == Body::line ? "displacement_of_line" : "displacement_of_masses";
      moved.components = static_cast<int>(kVector);
      moved.position = false;
      moved.form = Form::displacement;
      all.push_back(moved);
    }
    if (turns_ && (field.position || field.name == "mass_velocity")) {
      all.push_back(rotation_of(field));
    }
    if (grouped() && field.where == Where::points) {
      field.form = field.flag ? Form::any : Form::vectors;
      field.components = field.flag ? 1 : static_cast<int>(kVector);
    }
    if (field.form != Form::vectors || !field.position) {
      all.push_back(field);
    }
  }
  return all;
}

std::vector<double> FileRows::numbers(const FileField& field, std::span<const double> given) const {
  std::vector<double> own{given.begin(), given.end()};
  if (field.where == Where::points && !field.gauge.empty()) {
    centres_to_nodes(*points_, own);
  }
  if (field.form == FileField::Form::given) {
    own.resize((field.where == Where::points ? a_point_of_all_.size() : cells_of_all_) *
               static_cast<std::size_t>(field.components));
    return chosen_of(field.where, std::move(own), static_cast<std::size_t>(field.components));
  }
  const bool moved = field.form == FileField::Form::displacement;
  const MassPoints& nodes = points_->nodes();
  std::vector<double> vectors(kVector * a_point_of_all_.size(), 0.0);
  for (std::size_t point = 0; point < points_->own_points(); ++point) {
    const Place axis = field.form == FileField::Form::rotation ? nodes.turning(point) : nodes.axis(point);
    const double value = own[point] - (moved ? nodes.reference(point) : 0.0);
    double* vector = &vectors[kVector * node(point)];
    vector[0] += axis.x * value;
    vector[1] += axis.y * value;
    vector[2] += axis.z * value;
  }
  return chosen_of(Where::points, std::move(vectors), kVector);
}

std::vector<std::uint8_t> FileRows::flags(const FileField& field, std::span<const std::uint8_t> given) const {
  std::vector<std::uint8_t> own{given.begin(), given.end()};
  each_own(*points_, [&](const Strike& /*strike*/, std::size_t centre, std::size_t gap) { own[centre] |= own[gap]; });
  if (field.form == FileField::Form::given) {
    own.resize(a_point_of_all_.size());
    return chosen_of(Where::points, std::move(own), 1);
  }
  std::vector<std::uint8_t> any(a_point_of_all_.size(), 0);
  for (std::size_t point = 0; point < points_->own_points(); ++point) {
    any[node(point)] |= own[point];
  }
  return chosen_of(Where::points, std::move(any), 1);
}

}  // namespace udar::io
