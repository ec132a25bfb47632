#include <algorithm>
#include <functional>
#include <sstream>

#include "app/input/readers.hpp"
#include "udar/petsc/error.hpp"

namespace udar::app {

Numbers column(const io::Table& table, std::size_t index) {
  Numbers values(table.rows());
  for (std::size_t row = 0; row < values.size(); ++row) {
    values[row] = table.at(row, index);
  }
  return values;
}

void require_ascending(const char* option, const std::string& path, const Numbers& values, const char* what,
                       bool jumps) {
  auto found = std::ranges::adjacent_find(values, std::ranges::greater_equal{});
  while (jumps && found != values.end() && found[1] == found[0] && (values.end() - found < 3 || found[2] > found[1])) {
    found = std::adjacent_find(found + 1, values.end(), std::ranges::greater_equal{});
  }
  if (found != values.end()) {
    std::ostringstream message;
    message << "option " << option << ": '" << path << "': the " << what << " in column 1 must be "
            << (jumps ? "ascending, with at most two equal ones for a jump, " : "strictly ascending, ") << found[1]
            << " follows " << found[0];
    throw InputError{message.str()};
  }
}

}  // namespace udar::app
