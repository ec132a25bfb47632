#include "udar/modal/modal_motion.hpp"

#include <algorithm>
#include <functional>

namespace udar {

void ModalFlow::add(const ModalFlow& more) {
  support_work += more.support_work;
  in_supports += more.in_supports;
  in_modes += more.in_modes;
  radiated += more.radiated;
  const auto sum = [](std::vector<double>& to, const std::vector<double>& what) {
    std::ranges::transform(to, what, to.begin(), std::plus{});
  };
  sum(amplitude, more.amplitude);
  sum(rest_force, more.rest_force);
  sum(impulse, more.impulse);
}

}  // namespace udar
