#include "udar/structure/field.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace udar {

const Field& find_field(std::span<const Field> fields, std::string_view name) {
  const auto found = std::ranges::find(fields, name, &Field::name);
  if (found == fields.end()) {
    throw std::out_of_range{"there is no field '" + std::string{name} + "'"};
  }
  return *found;
}

}  // namespace udar
