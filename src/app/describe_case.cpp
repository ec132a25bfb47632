#include "udar/app/describe_case.hpp"

#include "udar/contact/describe.hpp"
#include "udar/filter/describe.hpp"
#include "udar/motion/describe.hpp"
#include "udar/structure/describe.hpp"
#include "udar/structure/structure.hpp"

namespace udar::app {

Description describe(const Case& input, const Structure& structure) {
  Description all;
  structure.describe(all);
  udar::describe(all, input.filter);
  all.add("corrected modes, lowest", static_cast<double>(input.exact.lowest));
  all.add_each("corrected modes", input.exact.named, [](PetscInt mode) { return mode; });
  all.add("gravity [m/s^2]", input.gravity);
  udar::describe(all, input.initial);
  udar::describe(all, input.damping);
  all.add("damping ratio", input.damping_ratio);
  udar::describe(all, input.contact);
  udar::describe(all, std::span{input.supports});
  udar::describe(all, std::span{input.loads});
  udar::describe(all, std::span{input.travelling_loads});
  udar::describe(all, std::span{input.base_motion});
  if (!input.held_motion.empty()) {
    udar::describe(all, std::span{input.held_motion});
  }
  if (!input.strikers.empty()) {
    udar::describe(all, std::span{input.strikers});
  }
  if (!input.pairs.empty()) {
    udar::describe(all, std::span{input.pairs});
  }
  return all;
}

}  // namespace udar::app
