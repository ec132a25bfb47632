#include "udar/io/layout.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace udar::io {

RunLayout::RunLayout(const MassPoints& of, Topology topology_of)
    : points{&of}, order{std::make_shared<const PointOrder>(of)}, topology{std::move(topology_of)} {
  const PetscInt own = topology.cells();
  MPI_Scan(&own, &cells.end, 1, MPIU_INT, MPI_SUM, of.comm());
  cells.begin = cells.end - own;
  MPI_Allreduce(&own, &cells.total, 1, MPIU_INT, MPI_SUM, of.comm());
  int all_upright = 1;
  for (std::size_t point = 0; point < of.points(); ++point) {
    all_upright &= of.direction(point) == Direction::y ? 1 : 0;
  }
  MPI_Allreduce(MPI_IN_PLACE, &all_upright, 1, MPI_INT, MPI_LAND, of.comm());
  upright = all_upright != 0;
}

std::vector<FieldInfo> RunLayout::fields_in_pictures() const {
  std::vector<FieldInfo> shown;
  for (const Body body : {Body::line, Body::masses}) {
    std::ranges::copy_if(fields, std::back_inserter(shown),
                         [body](const FieldInfo& field) { return field.body == body && field.rows; });
  }
  return shown;
}

std::vector<std::int64_t> RunLayout::numbers_of(std::span<const PetscInt> global) const {
  std::vector<std::int64_t> numbers(global.size(), -1);
  for (std::size_t i = 0; i < global.size(); ++i) {
    if (points->owns(global[i])) {
      numbers[i] = points->number(static_cast<std::size_t>(global[i] - points->begin()));
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, numbers.data(), static_cast<int>(numbers.size()), MPI_INT64_T, MPI_MAX, points->comm());
  return numbers;
}

std::string path_of(const FieldInfo& field) { return "/fields/" + std::string{field.name}; }

std::string displacement_path(Body body) {
  return body == Body::line ? "/fields/displacement_of_line" : "/fields/displacement_of_masses";
}

}  // namespace udar::io
