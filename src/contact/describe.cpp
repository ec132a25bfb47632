#include "udar/contact/describe.hpp"

#include <array>

namespace udar {

void describe(Description& all, std::span<const Support> supports) {
  const auto number = [&](std::string_view name, std::size_t index) {
    all.add_each(name, supports, [index](const Support& support) {
      const auto& [position, width, height, restitution, side, yield_speed, profile, motion, stiffness, damping] =
          support;
      static_cast<void>(profile);  // the lists below
      static_cast<void>(motion);
      return std::array{position,    width,       height,    static_cast<double>(side),
                        restitution, yield_speed, stiffness, damping}
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
}

}  // namespace udar
