#include "udar/io/layout.hpp"

#include <algorithm>
#include <utility>

namespace udar::io {

RunLayout::RunLayout(const MassPoints& of, Topology topology_of)
    : points{&of}, topology{std::move(topology_of)}, rows{std::make_shared<const FileRows>(of, topology)} {
  int some = topology.radius.empty() ? 0 : 1;
  MPI_Allreduce(MPI_IN_PLACE, &some, 1, MPI_INT, MPI_LOR, of.comm());
  tubes = some != 0;
}

std::vector<FileField> RunLayout::fields_in_pictures() const {
  std::vector<FileField> shown = rows->fields(fields);
  std::ranges::stable_partition(shown, [](const FileField& field) { return field.body == Body::line; });
  return shown;
}

std::vector<std::int64_t> RunLayout::numbers_of(std::span<const PetscInt> global) const {
  std::vector<std::int64_t> numbers(global.size(), -1);
  for (std::size_t i = 0; i < global.size(); ++i) {
    if (points->owns(global[i])) {
      numbers[i] = rows->number(static_cast<std::size_t>(global[i] - points->begin()));
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, numbers.data(), static_cast<int>(numbers.size()), MPI_INT64_T, MPI_MAX, points->comm());
  return numbers;
}

}  // namespace udar::io
