#include "udar/integrators/series_search.hpp"

#include <limits>

namespace udar {

double guessed_closing(const Kinematics& start) {
  const double pull = start.acceleration;
  const double square = start.velocity * start.velocity - 2.0 * pull * start.position;
  if (square >= 0.0) {
    const double root = std::sqrt(square);
    if (pull < 0.0) {
      return (start.velocity + root) / -pull;
    }
    if (start.velocity < 0.0) {
      return 2.0 * std::max(start.position, 0.0) / (root - start.velocity);
    }
  }
  return std::numeric_limits<double>::infinity();
}

bool comes_near(const Kinematics& start, const Kinematics& end, double length) {
  const double reach = 2.0 * length * std::max(std::abs(start.velocity), std::abs(end.velocity));
  return std::min(start.position, end.position) <= reach;
}

SeriesSample sample(const FreeMotion& motion, double time) {
  return {.time = time, .weights = {motion.weights(0, time), motion.weights(1, time), motion.weights(2, time)}};
}

std::vector<SeriesSample> samples_between(const FreeMotion& motion, double from, double to, std::size_t count) {
  std::vector<SeriesSample> samples;
  for (std::size_t i = 0; i <= count; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(count);
    samples.push_back(sample(motion, (1.0 - share) * from + share * to));
  }
  return samples;
}

std::size_t parts_of(const FreeMotion& motion, double length, double density) {
  constexpr double kOfRigidMotion = 16.0;  // a cubic in time
  const double parts = std::ceil(length * density);
  return static_cast<std::size_t>(std::max(1.0, motion.rigid() ? std::min(parts, kOfRigidMotion) : parts));
}

}  // namespace udar
