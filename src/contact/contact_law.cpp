#include "udar/contact/contact_law.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "udar/petsc/error.hpp"

namespace udar {

double LawPiece::at(double compression, double rate) const {
  return coefficient > 0.0 ? coefficient * std::pow(std::max(0.0, compression), exponent) * (1.0 + damping * rate)
                           : force + stiffness * (compression - from);
}

double LawPiece::tangent(double compression) const {
  return coefficient > 0.0 ? coefficient * exponent * std::pow(std::max(0.0, compression), exponent - 1.0) : stiffness;
}

double ContactLaw::force(const LawMotion& motion, double largest) const {
  const LawState state = found(motion, largest);
  return state.closed() ? piece(state).at(motion.compression, motion.rate) : 0.0;
}

void require_of_law(bool sound, const char* quantity, double value, const char* expected) {
  if (!sound) {
    std::ostringstream message;
    message << quantity << ": " << value << " is not allowed, expected " << expected;
    throw InputError{message.str()};
  }
}

}  // namespace udar
