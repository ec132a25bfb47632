#include "udar/contact/power_law.hpp"

#include <algorithm>
#include <cmath>

namespace udar {
namespace {

constexpr int kNear = 0;  // closed, but the force does nothing that a motion shows: there it has no power series
constexpr int kPress = 1;
constexpr int kSlack = 2;  // closed, and the law would pull
// The energy of the force up to there, of that of the motion: below its rounding.
constexpr double kUnseen = 1e-16;

}  // namespace

PowerLaw::PowerLaw(const Parameters& parameters) : parameters_{parameters} {
  const auto& [k, n, c] = parameters_;
  require_of_law(k > 0.0 && std::isfinite(k), "contact stiffness", k, "a number > 0 [N/m^n]");
  require_of_law(n >= 1.0 && n <= 3.0, "contact exponent", n, "a number from 1 to 3");
  require_of_law(c >= 0.0 && std::isfinite(c), "contact damping", c, "a number >= 0 [s/m]");
}

std::vector<LawNumber> PowerLaw::numbers() const {
  return {{"stiffness [N/m^n]", {parameters_.stiffness}},
          {"exponent", {parameters_.exponent}},
          {"damping [s/m]", {parameters_.damping}}};
}

double PowerLaw::near(const LawMotion& motion) const {
  const double energy = 0.5 * motion.mass * motion.rate * motion.rate + stored(motion.compression, 0.0);
  const double power = parameters_.exponent + 1.0;
  return std::max(motion.resolution, std::pow(kUnseen * power * energy / parameters_.stiffness, 1.0 / power));
}

LawState PowerLaw::found(const LawMotion& motion, double /*largest*/) const {
  LawState state{.near = near(motion)};
  if (motion.compression > 0.0) {
    state.piece = motion.compression <= state.near                 ? kNear
                  : 1.0 + parameters_.damping * motion.rate >= 0.0 ? kPress
                                                                   : kSlack;
  }
  return state;
}

LawState PowerLaw::touch(const LawState& /*open*/, const LawMotion& motion) const {
  return {.piece = kNear, .near = near(motion), .zero = LawEnd::low};
}

LawPiece PowerLaw::piece(const LawState& state) const {
  const auto& [k, n, c] = parameters_;
  switch (state.piece) {
    case kNear:
      return {.low = 0.0, .high = state.near};
    case kPress:
      return {.low = state.near, .pulls = c > 0.0 ? 1.0 : 0.0, .coefficient = k, .exponent = n, .damping = c};
    default:
      return {.low = 0.0, .pulls = -1.0, .damping = c};
  }
}

LawState PowerLaw::next(const LawState& state, LawEnd end, double /*compression*/) const {
  LawState after{.near = state.near};
  if (end == LawEnd::pull) {
    after.piece = state.piece == kPress ? kSlack : kPress;
    after.zero = LawEnd::pull;
  } else if (state.piece == kPress) {
    after.piece = kNear;
    after.zero = LawEnd::high;
  } else if (end == LawEnd::high) {
    after.piece = kPress;
    after.zero = LawEnd::low;
  }
  return after;
}

double PowerLaw::stored(double compression, double /*largest*/) const {
  const double power = parameters_.exponent + 1.0;
  return parameters_.stiffness / power * std::pow(std::max(0.0, compression), power);
}

double PowerLaw::loss_rate(const LawState& state, double compression, double rate) const {
  const auto& [k, n, c] = parameters_;
  return state.piece == kPress ? k * std::pow(std::max(0.0, compression), n) * c * rate * rate : 0.0;
}

double PowerLaw::compression_for(double force) const {
  return std::pow(force / parameters_.stiffness, 1.0 / parameters_.exponent);
}

}  // namespace udar
