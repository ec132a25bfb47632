#include "udar/io/file_rows.hpp"

#include <algorithm>
#include <numeric>

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

PointOrder order_of_nodes(const MassPoints& points, const Topology& topology) {
  if (topology.node.empty()) {
    std::vector<std::int64_t> numbers(points.own_points());
    for (std::size_t point = 0; point < numbers.size(); ++point) {
      numbers[point] = points.number(point);
    }
    return {points.comm(), range_of(points.comm(), static_cast<PetscInt>(numbers.size())), numbers};
  }
  const NodeRange range = range_of(points.comm(), static_cast<PetscInt>(topology.node_number.size()));
  return {points.comm(), range, topology.node_number};
}

}  // namespace

FileRows::FileRows(const MassPoints& points, const Topology& topology)
    : points_{&points},
      node_{topology.node},
      number_{topology.node_number},
      a_point_{points_of_nodes(points, topology)},
      upright_{all_upright(points)},
      turns_{any_turns(points)},
      mass_{node_masses(points)},
      nodes_{order_of_nodes(points, topology)},
      cells_{points.comm(), topology} {}

std::size_t FileRows::node(std::size_t point) const {
  const std::size_t own = points_->own_point(point);
  return grouped() ? node_[own] : own;
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
    own.resize(static_cast<std::size_t>(order_of(field.where).range().count()) *
               static_cast<std::size_t>(field.components));
    return own;
  }
  const bool moved = field.form == FileField::Form::displacement;
  std::vector<double> vectors(kVector * a_point_.size(), 0.0);
  for (std::size_t point = 0; point < points_->own_points(); ++point) {
    const Place axis = field.form == FileField::Form::rotation ? points_->turning(point) : points_->axis(point);
    const double value = own[point] - (moved ? points_->reference(point) : 0.0);
    double* vector = &vectors[kVector * node(point)];
    vector[0] += axis.x * value;
    vector[1] += axis.y * value;
    vector[2] += axis.z * value;
  }
  return vectors;
}

std::vector<std::uint8_t> FileRows::flags(const FileField& field, std::span<const std::uint8_t> given) const {
  std::vector<std::uint8_t> own{given.begin(), given.end()};
  each_own(*points_, [&](const Strike& /*strike*/, std::size_t centre, std::size_t gap) { own[centre] |= own[gap]; });
  if (field.form == FileField::Form::given) {
    own.resize(a_point_.size());
    return own;
  }
  std::vector<std::uint8_t> any(a_point_.size(), 0);
  for (std::size_t point = 0; point < points_->own_points(); ++point) {
    any[node(point)] |= own[point];
  }
  return any;
}

}  // namespace udar::io
