#include "udar/motion/motion_state.hpp"

#include "udar/petsc/error.hpp"

namespace udar {

const std::vector<double>& MotionState::field(const std::string& name, std::size_t size, Where where) const {
  const auto& all = where == Where::points ? fields : cells;
  const auto found = all.find(name);
  if (found == all.end() || found->second.size() != size) {
    throw InputError{"restart file: the field '" + name + "' is missing or has another size"};
  }
  return found->second;
}

double MotionState::scalar(const std::string& name) const {
  const auto found = scalars.find(name);
  if (found == scalars.end()) {
    throw InputError{"restart file: the value '" + name + "' is missing"};
  }
  return found->second;
}

}  // namespace udar
