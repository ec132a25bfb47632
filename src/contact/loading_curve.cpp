#include "udar/contact/loading_curve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace udar {

LoadingCurve::LoadingCurve(Parameters parameters) : parameters_{std::move(parameters)} {
  const auto& [d, f, last, unloading] = parameters_;
  for (std::size_t i = 0; i < d.size(); ++i) {
    require_of_law(std::isfinite(d[i]) && (i > 0 ? d[i] > d[i - 1] : d[i] == 0.0), "contact table", d[i],
                   "compressions that ascend from 0 [m]");
    require_of_law(std::isfinite(f[i]) && (i > 0 ? f[i] > 0.0 : f[i] == 0.0), "contact table", f[i],
                   "forces of which the first is 0, the others > 0 [N]");
  }
  require_of_law(last >= 0.0 && std::isfinite(last), "contact table", last,
                 "a slope >= 0 between its last two rows [N/m]: it goes on with that");
  double steepest = 0.0;
  for (std::size_t piece = 0; piece < d.size(); ++piece) {
    steepest = std::max(steepest, slope(piece));
  }
  require_of_law(steepest > 0.0, "contact table", steepest, "a force that grows somewhere [N/m]");
  // Slopes by divisions: as steep as the steepest, but for their rounding.
  constexpr double kSlopeRounding = 8.0 * std::numeric_limits<double>::epsilon();
  require_of_law(unloading >= steepest * (1.0 - kSlopeRounding) && std::isfinite(unloading),
                 "contact unloading stiffness", unloading, "a number no less than any slope of loading [N/m]");
}

LoadingCurve::Parameters LoadingCurve::bilinear(double loading, double unloading) {
  require_of_law(loading > 0.0 && std::isfinite(loading), "contact stiffness", loading, "a number > 0 [N/m]");
  return {.compression = {0.0}, .force = {0.0}, .last_slope = loading, .unloading = unloading};
}

LoadingCurve::Parameters LoadingCurve::crush(const Crush& of) {
  const auto& [k, plateau, bottoming, bottoming_stiffness] = of;
  require_of_law(k > 0.0 && std::isfinite(k), "contact stiffness", k, "a number > 0 [N/m]");
  require_of_law(plateau > 0.0 && std::isfinite(plateau), "contact plateau force", plateau, "a number > 0 [N]");
  require_of_law(bottoming > plateau / k, "contact bottoming compression", bottoming,
                 "a number above the compression at which the plateau begins, its force over the stiffness [m]");
  require_of_law(bottoming_stiffness >= 0.0 && bottoming_stiffness <= k, "contact bottoming stiffness",
                 bottoming_stiffness, "a number from 0 to the elastic stiffness [N/m]");
  Parameters all{.compression = {0.0, plateau / k}, .force = {0.0, plateau}, .unloading = k};
  if (std::isfinite(bottoming)) {
    all.compression.push_back(bottoming);
    all.force.push_back(plateau);
    all.last_slope = bottoming_stiffness;
  }
  return all;
}

LoadingCurve::Parameters LoadingCurve::table(std::vector<double> compression, std::vector<double> force,
                                             double unloading) {
  const std::size_t rows = compression.size();
  require_of_law(rows > 1 && force.size() == rows, "contact table", static_cast<double>(rows), "two rows or more");
  const double last = (force[rows - 1] - force[rows - 2]) / (compression[rows - 1] - compression[rows - 2]);
  return {.compression = std::move(compression), .force = std::move(force), .last_slope = last, .unloading = unloading};
}

std::vector<LawNumber> LoadingCurve::numbers() const {
  return {{"compression [m]", parameters_.compression},
          {"force [N]", parameters_.force},
          {"last slope [N/m]", {parameters_.last_slope}},
          {"unloading slope [N/m]", {parameters_.unloading}}};
}

std::size_t LoadingCurve::piece_at(double compression) const {
  const auto& d = parameters_.compression;
  const auto after = std::upper_bound(d.begin() + 1, d.end(), compression);
  return static_cast<std::size_t>(after - d.begin()) - 1;
}

double LoadingCurve::slope(std::size_t piece) const {
  const auto& [d, f, last, unloading] = parameters_;
  return piece + 1 < d.size() ? (f[piece + 1] - f[piece]) / (d[piece + 1] - d[piece]) : last;
}

double LoadingCurve::loading_force(double compression) const {
  const std::size_t piece = piece_at(compression);
  return parameters_.force[piece] + slope(piece) * (compression - parameters_.compression[piece]);
}

double LoadingCurve::permanent_set(double largest) const {
  return largest > 0.0 ? std::max(0.0, largest - loading_force(largest) / parameters_.unloading) : 0.0;
}

LawState LoadingCurve::found(const LawMotion& motion, double largest) const {
  const double d = motion.compression;
  LawState state{.largest = std::max(largest, d)};
  if (d <= permanent_set(largest)) {
    state.largest = largest;
  } else if (d < largest || motion.rate < 0.0) {
    state.piece = unloading_piece();
  } else {
    state.piece = static_cast<int>(piece_at(d));
  }
  return state;
}

LawState LoadingCurve::touch(const LawState& open, const LawMotion& /*motion*/) const {
  return {.piece = open.largest > 0.0 ? unloading_piece() : 0, .largest = open.largest, .zero = LawEnd::low};
}

LawPiece LoadingCurve::piece(const LawState& state) const {
  const auto& [d, f, last, unloading] = parameters_;
  if (state.piece == unloading_piece()) {
    const double m = state.largest;
    return {.low = permanent_set(m), .high = m, .force = loading_force(m), .stiffness = unloading, .from = m};
  }
  const auto piece = static_cast<std::size_t>(state.piece);
  LawPiece all{.grows = true, .force = f[piece], .stiffness = slope(piece), .from = d[piece]};
  if (piece + 1 < d.size()) {
    all.high = d[piece + 1];
  }
  return all;
}

LawState LoadingCurve::next(const LawState& state, LawEnd end, double compression) const {
  LawState after{.largest = state.largest};
  if (end == LawEnd::turn) {
    after = {.piece = unloading_piece(), .largest = compression, .zero = LawEnd::high, .turned = true};
  } else if (end == LawEnd::high && state.piece == unloading_piece()) {
    after.piece = static_cast<int>(piece_at(state.largest));
    after.turned = state.turned;
  } else if (end == LawEnd::high) {
    after = {.piece = state.piece + 1, .largest = parameters_.compression[static_cast<std::size_t>(state.piece) + 1]};
  }
  return after;
}

double LoadingCurve::stored(double compression, double largest) const {
  const double most = std::max(compression, largest);
  const double force = loading_force(most) - parameters_.unloading * (most - compression);
  return compression > 0.0 && force > 0.0 ? 0.5 * force * force / parameters_.unloading : 0.0;
}

double LoadingCurve::loss_rate(const LawState& state, double compression, double rate) const {
  if (state.piece == unloading_piece()) {
    return 0.0;
  }
  const LawPiece now = piece(state);
  return now.at(compression, rate) * rate * (1.0 - now.stiffness / parameters_.unloading);
}

double LoadingCurve::compression_for(double force) const {
  const auto& [d, f, last, unloading] = parameters_;
  for (std::size_t piece = 0; piece < d.size(); ++piece) {
    const double end = piece + 1 < d.size() ? f[piece + 1] : std::numeric_limits<double>::infinity();
    const double rise = slope(piece);
    if (force <= end && (rise > 0.0 || force <= f[piece])) {
      return rise > 0.0 ? d[piece] + std::max(0.0, force - f[piece]) / rise : d[piece];
    }
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace udar
