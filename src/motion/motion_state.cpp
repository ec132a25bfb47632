#include "udar/motion/motion_state.hpp"

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

template <class Value>
const Value& find(const std::map<std::string, Value>& all, const char* kind, const std::string& name) {
  const auto found = all.find(name);
  if (found == all.end()) {
    throw InputError{std::string{"restart file: the "} + kind + " '" + name + "' is missing"};
  }
  return found->second;
}

}  // namespace

const std::vector<double>& MotionState::field(const std::string& name, std::size_t size, Where where) const {
  const auto& all = where == Where::points ? fields : cells;
  const auto found = all.find(name);
  if (found == all.end() || found->second.size() != size) {
    throw InputError{"restart file: the field '" + name + "' is missing or has another size"};
  }
  return found->second;
}

double MotionState::scalar(const std::string& name) const { return find(scalars, "value", name); }

const std::vector<double>& MotionState::table(const std::string& name) const { return find(tables, "table", name); }

const std::string& MotionState::text(const std::string& name) const { return find(texts, "text", name); }

}  // namespace udar
