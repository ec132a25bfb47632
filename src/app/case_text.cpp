#include "udar/app/case_text.hpp"

#include <array>
#include <charconv>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

namespace udar::app {
namespace {

/// A longer list is told by its hash.
constexpr std::size_t kReadable = 120;

void append(std::string& text, double value) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  text.append(text.empty() ? "" : " ").append(digits.data(), end);
}

std::string hash(std::string_view text) {
  constexpr std::uint64_t kBasis = 14695981039346656037U;
  constexpr std::uint64_t kPrime = 1099511628211U;
  std::uint64_t sum = kBasis;
  for (const char letter : text) {
    sum = (sum ^ static_cast<unsigned char>(letter)) * kPrime;
  }
  std::array<char, 32> digits{};
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), sum, 16).ptr};
}

class Text {
 public:
  void add(std::string_view name, const std::string& value) {
    text_.append(name).append(": ").append(value).append("\n");
  }
  void add(std::string_view name, double value) {
    std::string digits;
    append(digits, value);
    add(name, digits);
  }
  void add(std::string_view name, std::span<const double> values) {
    std::string all;
    for (const double value : values) {
      append(all, value);
    }
    add(name, all.empty()               ? "none"
              : all.size() <= kReadable ? all
                                        : std::to_string(values.size()) + " values with hash " + hash(all));
  }
  /// One value of each of many things.
  template <class Things, class Value>
  void add_each(std::string_view name, const Things& things, const Value& value) {
    std::vector<double> values;
    values.reserve(std::size(things));
    for (const auto& thing : things) {
      values.push_back(static_cast<double>(value(thing)));
    }
    add(name, values);
  }
  /// All values of many things, each thing's number of values before them.
  template <class Things, class Values>
  void add_all(std::string_view name, const Things& things, const Values& of) {
    std::vector<double> values;
    for (const auto& thing : things) {
      const std::span<const double> own = of(thing);
      values.push_back(static_cast<double>(own.size()));
      values.insert(values.end(), own.begin(), own.end());
    }
    add(name, values);
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

void add_beam(Text& text, const BeamParameters& beam) {
  text.add_each("segment lengths [m]", beam.segments, [](const auto& s) { return s.length; });
  text.add_each("elements of segments", beam.segments, [](const auto& s) { return s.elements; });
  text.add_each("bending stiffness EI [N m^2]", beam.segments, [](const auto& s) { return s.bending_stiffness; });
  text.add_each("mass per length rhoA [kg/m]", beam.segments, [](const auto& s) { return s.mass_per_length; });
  text.add_each("shear stiffness kGA [N]", beam.segments, [](const auto& s) { return s.shear_stiffness; });
  text.add_each("foundation [N/m^2]", beam.segments, [](const auto& s) { return s.foundation_stiffness; });
  text.add("tension [N]", beam.tension);
  const std::array ends{beam.left, beam.right};
  text.add_each("ends, stiffness against displacement [N/m]", ends,
                [](const BeamEnd& end) { return end.translational_stiffness; });
  text.add_each("ends, stiffness against rotation [N m/rad]", ends,
                [](const BeamEnd& end) { return end.rotational_stiffness; });
  text.add_each("point masses, positions [m]", beam.point_masses, [](const auto& p) { return p.position; });
  text.add_each("point masses [kg]", beam.point_masses, [](const auto& p) { return p.mass; });
  text.add_each("line supports, positions [m]", beam.line_supports, [](const auto& s) { return s.position; });
  text.add_each("line supports, stiffness [N/m]", beam.line_supports, [](const auto& s) { return s.stiffness; });
  text.add_each("weighted patches, begin [m]", beam.mass_patches, [](const auto& p) { return p.from; });
  text.add_each("weighted patches, end [m]", beam.mass_patches, [](const auto& p) { return p.to; });
}

void add_supports(Text& text, const std::vector<Support>& supports) {
  text.add_each("supports, positions [m]", supports, [](const Support& s) { return s.position; });
  text.add_each("supports, widths [m]", supports, [](const Support& s) { return s.width; });
  text.add_each("supports, heights [m]", supports, [](const Support& s) { return s.height; });
  text.add_each("supports, sides (1 below, -1 above)", supports, [](const Support& s) { return s.side; });
  text.add_each("supports, restitution", supports, [](const Support& s) { return s.restitution; });
  text.add_each("supports, yield speeds [m/s]", supports, [](const Support& s) { return s.yield_speed; });
  text.add_each("supports, stiffness [N/m]", supports, [](const Support& s) { return s.stiffness; });
  text.add_each("supports, damping [N s/m]", supports, [](const Support& s) { return s.damping; });
  const auto motion = [](auto part) {
    return [part](const Support& s) {
      return s.motion ? std::span<const double>{((*s.motion).*part)()} : std::span<const double>{};
    };
  };
  text.add_all("supports, times of motion [s]", supports, motion(&SupportMotion::time));
  text.add_all("supports, heights of motion [m]", supports, motion(&SupportMotion::height));
  text.add_all("supports, velocities of motion [m/s]", supports, motion(&SupportMotion::velocity));
  text.add_all("ground profile, x [m]", supports, [](const Support& s) { return std::span{s.profile.x}; });
  text.add_all("ground profile, heights [m]", supports, [](const Support& s) { return std::span{s.profile.height}; });
}

std::map<std::string, std::string, std::less<>> parameters(std::string_view text) {
  std::map<std::string, std::string, std::less<>> all;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    const std::size_t colon = line.find(": ");
    if (colon != std::string_view::npos) {
      all.emplace(line.substr(0, colon), line.substr(colon + 2));
    }
    text.remove_prefix(std::min(text.size(), line.size() + 1));
  }
  return all;
}

}  // namespace

std::string case_text(const Case& input, const BeamChain& beam) {
  Text text;
  text.add("nodes", static_cast<double>(beam.nodes()));
  add_beam(text, input.beam);
  text.add("filter", input.filter.unfiltered ? "none" : "filter springs");
  text.add(input.filter.unfiltered ? "2 / time step [1/s]" : "filter frequency [rad/s]", input.filter.filter_frequency);
  text.add("formulation", input.filter.formulation == Formulation::mixed ? "mixed" : "hermite");
  text.add("corrected modes, lowest", static_cast<double>(input.filter.correct_lowest));
  text.add_each("corrected modes", input.filter.correct, [](PetscInt mode) { return mode; });
  text.add("gravity [m/s^2]", input.gravity);
  text.add("initial height [m]", input.initial.height);
  text.add("initial slope", input.initial.slope);
  text.add("damping of masses [1/s]", input.damping.mass);
  text.add("damping of stiffness [s]", input.damping.stiffness);
  const bool line = input.contact.surface == ContactSurface::line || input.filter.unfiltered;
  text.add("contact surface", line ? "line" : "mass");
  text.add("contact nodes solved as few, at most", line ? static_cast<double>(input.contact.line_dense_max) : 0.0);
  add_supports(text, input.supports);
  text.add_each("loads, positions [m]", input.loads, [](const NodalLoad& load) { return load.position; });
  text.add_all("loads, times [s]", input.loads, [](const NodalLoad& load) { return std::span{load.time}; });
  text.add_all("loads, forces [N]", input.loads, [](const NodalLoad& load) { return std::span{load.force}; });
  return text.text();
}

std::string case_differences(std::string_view there, std::string_view here) {
  const auto then = parameters(there);
  auto now = parameters(here);
  std::string differences;
  const auto add = [&differences](const std::string& name, const std::string& before, const std::string& after) {
    differences += differences.empty() ? "" : "; ";
    differences += name;
    differences += ": ";
    differences += before;
    differences += " there, ";
    differences += after;
    differences += " here";
  };
  for (const auto& [name, value] : then) {
    const auto found = now.find(name);
    if (found == now.end()) {
      add(name, value, "none");
    } else if (found->second != value) {
      add(name, value, found->second);
    }
    now.erase(name);
  }
  for (const auto& [name, value] : now) {
    add(name, "none", value);
  }
  return differences;
}

}  // namespace udar::app
