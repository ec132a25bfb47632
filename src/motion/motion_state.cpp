#include "udar/motion/motion_state.hpp"

#include <petscsys.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

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

/// What a number may be.
struct Bounds {
  double least = std::numeric_limits<double>::lowest();
  double most = std::numeric_limits<double>::max();
  bool whole = false;

  [[nodiscard]] bool allow(double value) const {
    return value >= least && value <= most && (!whole || value == std::floor(value));
  }
};

struct Named {
  std::string_view name;  ///< or its beginning
  Bounds bounds;
};

constexpr double kUnbounded = std::numeric_limits<double>::infinity();
constexpr Bounds kFinite{};
constexpr Bounds kCount{.least = 0.0, .most = static_cast<double>(std::numeric_limits<PetscInt>::max()), .whole = true};
constexpr Bounds kTime{.least = 0.0};
constexpr Bounds kAnyNumber{.least = -kUnbounded, .most = kUnbounded};

constexpr std::array kScalars{Named{"impacts", kCount},
                              Named{"merged impacts of a node", kCount},
                              Named{"rests", kCount},
                              Named{"releases", kCount},
                              Named{"resting", kCount},
                              Named{"event_steps", kCount},
                              Named{"steps", kCount},
                              Named{"repeated_steps", kCount},
                              Named{"rhs_evaluations", kCount},
                              Named{"counted ", kCount},
                              Named{"time", kTime},
                              Named{"last_row_time", kTime},
                              Named{"wanted_step", kTime},
                              Named{"next_step", kTime},
                              Named{"line_step", kTime},
                              Named{"scale_", kTime},
                              Named{"line_gap", kAnyNumber},
                              Named{"lost_in_", kFinite},
                              Named{"support_work", kFinite},
                              Named{"radiated", kFinite},
                              Named{"initial_", kFinite},
                              Named{"energy_scale", kFinite},
                              Named{"load_work", kFinite},
                              Named{"first_contact_time", kFinite},
                              Named{"last_contact_time", kFinite}};
// Forces of supports may have no number, and are judged where they are read.
constexpr std::array kTables{Named{"support_impulse", kFinite}, Named{"amplitude", kFinite},
                             Named{"contact_force", kFinite}, Named{"modal_", kAnyNumber}, Named{"hinge_", kFinite}};
constexpr std::array kFields{Named{"mass_", kFinite},
                             Named{"stretch", kFinite},
                             Named{"line_", kFinite},
                             Named{"contact_force_", kFinite},
                             Named{"last_contact", kAnyNumber},
                             Named{"merged_impact_", kFinite},
                             Named{"largest_compression", kTime}};

/// By the longest name that fits; null: none does.
template <std::size_t Count>
const Bounds* bounds_of(const std::array<Named, Count>& all, std::string_view name) {
  const Named* found = nullptr;
  for (const Named& named : all) {
    if (name.starts_with(named.name) && (found == nullptr || named.name.size() > found->name.size())) {
      found = &named;
    }
  }
  return found != nullptr ? &found->bounds : nullptr;
}

std::string refusal(const char* kind, const std::string& name, double value) {
  return std::string{"restart file: the "} + kind + " '" + name + "' holds " + std::to_string(value) +
         ", which no run writes";
}

/// How `ElasticTouches` writes a touch: eight times that above besides that below, each one of three, or four more.
bool is_touch(double value) {
  constexpr Bounds kCodes{.least = 0.0, .most = 63.0, .whole = true};
  return kCodes.allow(value) && static_cast<int>(value) % 4 < 3 && static_cast<int>(value) / 8 % 4 < 3;
}

}  // namespace

void MotionState::require_sound(MPI_Comm comm, std::size_t supports) const {
  std::string failure;
  const auto judge = [&failure](const char* kind, const std::string& name, double value, bool sound) {
    if (!sound && failure.empty()) {
      failure = refusal(kind, name, value);
    }
  };
  for (const auto& [name, value] : scalars) {
    const Bounds* const bounds = bounds_of(kScalars, name);
    judge("value", name, value, bounds == nullptr || bounds->allow(value));
  }
  for (const auto& [name, values] : tables) {
    const Bounds* const bounds = bounds_of(kTables, name);
    for (const double value : values) {
      judge("table", name, value, bounds == nullptr || bounds->allow(value));
    }
  }
  const Bounds resting{.least = 0.0, .most = static_cast<double>(supports), .whole = true};
  for (const auto& [name, values] : fields) {
    const Bounds* const bounds = bounds_of(kFields, name);
    for (const double value : values) {
      judge("field", name, value,
            name == "resting_on" ? resting.allow(value)
            : name == "touch"    ? is_touch(value)
                                 : bounds == nullptr || bounds->allow(value));
    }
  }
  throw_together<InputError>(comm, failure);
}

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
