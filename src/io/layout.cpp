#include "udar/io/layout.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "udar/petsc/error.hpp"

namespace udar::io {

RunLayout::RunLayout(const MassPoints& of, Topology topology_of, const RowChoice& choice)
    : points{&of}, topology{std::move(topology_of)}, rows{std::make_shared<const FileRows>(of, topology, choice)} {
  std::array<int, 2> some{topology.radius.empty() ? 0 : 1, topology.member.empty() ? 0 : 1};
  MPI_Allreduce(MPI_IN_PLACE, some.data(), 2, MPI_INT, MPI_LOR, of.comm());
  tubes = some[0] != 0;
  members = some[1] != 0;
}

std::vector<FileField> RunLayout::fields_in_files() const {
  std::vector<FileField> all = rows->fields(fields);
  if (content.fields.empty()) {
    return all;
  }
  for (const std::string& name : content.fields) {
    if (std::ranges::find(all, name, &FileField::name) == all.end()) {
      std::string known;
      for (const FileField& field : all) {
        known.append(known.empty() ? "" : ", ").append(field.name);
      }
      throw InputError{"output fields: '" + name + "' is not one of this run, expected some of " + known};
    }
  }
  std::erase_if(all, [this](const FileField& field) { return std::ranges::count(content.fields, field.name) == 0; });
  return all;
}

std::vector<FileField> RunLayout::fields_in_pictures() const {
  std::vector<FileField> shown = fields_in_files();
  std::ranges::stable_partition(shown, [](const FileField& field) { return field.body == Body::line; });
  return shown;
}

std::vector<double> RunLayout::places_of(std::span<const PetscInt> global) const {
  std::vector<double> found(3 * global.size(), 0.0);
  for (std::size_t i = 0; i < global.size(); ++i) {
    if (points->owns(global[i])) {
      const auto [x, y, z] = points->place(static_cast<std::size_t>(global[i] - points->begin()));
      std::ranges::copy(std::array{x, y, z}, found.begin() + static_cast<std::ptrdiff_t>(3 * i));
    }
  }
  MPI_Allreduce(MPI_IN_PLACE, found.data(), static_cast<int>(found.size()), MPI_DOUBLE, MPI_SUM, points->comm());
  return found;
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
