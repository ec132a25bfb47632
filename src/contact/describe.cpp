#include "udar/contact/describe.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "udar/contact/contact_law.hpp"

namespace udar {

namespace {

/// Of supports with a law of contact: which, and its parameters, for each number of all laws that there are.
void describe_laws(Description& all, std::span<const Support> supports) {
  struct Numbers {
    std::string name;
    std::vector<std::vector<double>> of_supports;  // empty: of other laws
  };
  std::vector<Numbers> found;
  for (std::size_t i = 0; i < supports.size(); ++i) {
    const ContactLaw* law = supports[i].contact_law.get();
    if (law == nullptr) {
      continue;
    }
    for (const auto& [name, values] : law->numbers()) {
      const std::string full = "supports, " + std::string{law->name()} + ", " + std::string{name};
      auto at = std::ranges::find(found, full, &Numbers::name);
      if (at == found.end()) {
        at = found.insert(at, {.name = full, .of_supports = std::vector<std::vector<double>>(supports.size())});
      }
      at->of_supports[i] = values;
    }
  }
  for (const auto& [name, of_supports] : found) {
    all.add_all(name, of_supports, [](const std::vector<double>& values) { return std::span<const double>{values}; });
  }
}

}  // namespace

void describe(Description& all, std::span<const Support> supports) {
  const auto number = [&](std::string_view name, std::size_t index) {
    all.add_each(name, supports, [index](const Support& support) {
      const auto& [position, width, height, restitution, side, yield_speed, profile, field, motion, stiffness, damping,
                   friction, normal, x, y, z, contact_law, strike] = support;
      static_cast<void>(strike);
      static_cast<void>(profile);  // the lists below
      static_cast<void>(field);
      static_cast<void>(motion);
      static_cast<void>(contact_law);
      return std::array{position,    width,       height,    static_cast<double>(side),
                        restitution, yield_speed, stiffness, damping,
                        normal.x,    normal.y,    normal.z,  x.from,
                        x.to,        y.from,      y.to,      z.from,
                        z.to,        friction}
          .at(index);
    });
  };
  number("supports, positions [m]", 0);
  number("supports, widths [m]", 1);
  number("supports, heights [m]", 2);
  number("supports, sides (1 below, -1 above)", 3);
  number("supports, restitution", 4);
  number("supports, yield speeds [m/s]", 5);
  number("supports, stiffness [N/m]", 6);
  number("supports, damping [N s/m]", 7);
  if (std::ranges::any_of(supports, &Support::in_space)) {
    constexpr std::array kNames{"supports, normals, x", "supports, normals, y", "supports, normals, z",
                                "supports, x from [m]", "supports, x to [m]",   "supports, y from [m]",
                                "supports, y to [m]",   "supports, z from [m]", "supports, z to [m]",
                                "supports, friction"};
    for (std::size_t k = 0; k < kNames.size(); ++k) {
      number(kNames.at(k), 8 + k);
    }
  }
  describe_laws(all, supports);
  const auto motion = [](auto part) {
    return [part](const Support& s) {
      return s.motion ? std::span<const double>{((*s.motion).*part)()} : std::span<const double>{};
    };
  };
  all.add_all("supports, times of motion [s]", supports, motion(&SupportMotion::time));
  all.add_all("supports, heights of motion [m]", supports, motion(&SupportMotion::height));
  all.add_all("supports, velocities of motion [m/s]", supports, motion(&SupportMotion::velocity));
  const auto profile = [&](std::string_view name, bool places) {
    all.add_all(name, supports, [places](const Support& support) {
      const auto& [x, height] = support.profile;
      return std::span<const double>{places ? x : height};
    });
  };
  profile("ground profile, x [m]", true);
  profile("ground profile, heights [m]", false);
  const auto field = [&](std::string_view name, auto part) {
    all.add_all(name, supports, [part](const Support& support) {
      return support.field ? ((*support.field).*part)() : std::span<const double>{};
    });
  };
  if (std::ranges::any_of(supports, [](const Support& support) { return support.field != nullptr; })) {
    field("supports, height fields, x [m]", &HeightGrid::x);
    field("supports, height fields, z [m]", &HeightGrid::z);
    field("supports, height fields, heights [m]", &HeightGrid::height);
  }
}

}  // namespace udar
