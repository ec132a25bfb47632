// A restart whose file is whole, and holds something else than a run would have written: numbers that are none, lists
// that are longer or shorter, names that are not there.

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "fuzz/falls.hpp"

namespace {

using namespace udar;

double any_number(fuzz::Bytes& bytes) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  constexpr std::array kNumbers{kNone, kInfinity, -kInfinity, -1.0, 0.0,  1.0,   2.5,  7.0,
                                1e300, -1e300,    1e-300,     4e9,  1e19, -1e19, 255.0};
  const std::size_t which = bytes.choice(kNumbers.size() + 1);
  return which < kNumbers.size() ? kNumbers.at(which) : bytes.number<double>();
}

void change(std::map<std::string, std::vector<double>>& lists, fuzz::Bytes& bytes) {
  if (lists.empty()) {
    return;
  }
  const auto list = std::next(lists.begin(), static_cast<std::ptrdiff_t>(bytes.choice(lists.size())));
  switch (bytes.choice(4)) {
    case 0:
      lists.erase(list);
      break;
    case 1:
      list->second.resize(bytes.choice(64), any_number(bytes));
      break;
    case 2:
      std::ranges::fill(list->second, any_number(bytes));
      break;
    default:
      if (!list->second.empty()) {
        list->second[bytes.choice(list->second.size())] = any_number(bytes);
      }
  }
}

void change(MotionState& state, fuzz::Bytes& bytes) {
  switch (bytes.choice(5)) {
    case 0:
      change(state.fields, bytes);
      break;
    case 1:
      change(state.cells, bytes);
      break;
    case 2:
      change(state.tables, bytes);
      break;
    case 3: {
      const auto scalar =
          std::next(state.scalars.begin(), static_cast<std::ptrdiff_t>(bytes.choice(state.scalars.size())));
      scalar->second = any_number(bytes);
      break;
    }
    default:
      state.integrator = bytes.text(4);
  }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes{data, size};
  const fuzz::Fall& fall = fuzz::falls()[bytes.choice(fuzz::falls().size())];
  MotionState state = fall.saved;
  while (!bytes.empty() && !state.scalars.empty()) {
    change(state, bytes);
  }
  fuzz::allow_refusal([&] {
    fuzz::insert_case(fall.yaml);
    ImpactDynamics dynamics{*fall.model};
    dynamics.restore(state);
    io::SupportForces forces = fall.forces();
    forces.restore(state);
    static_cast<void>(forces.add(state.scalar("time") + 1e-3, dynamics.support_impulses()));
    dynamics.solve();
    static_cast<void>(dynamics.save());
  });
  return 0;
}
