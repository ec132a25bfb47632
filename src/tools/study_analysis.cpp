#include "tools/study_analysis.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace udar::study {

const char* name(Verdict verdict) {
  constexpr std::array kNames{"converges",    "constant",          "settled",    "slow",     "irregular",
                              "not monotone", "does not converge", "two values", "no values"};
  return kNames.at(static_cast<std::size_t>(verdict));
}

const char* name(Bound bound) {
  constexpr std::array kNames{"estimate", "changes", "at least", "unknown"};
  return kNames.at(static_cast<std::size_t>(bound));
}

std::optional<double> observed_order(std::span<const double, 3> size, std::span<const double, 3> value) {
  const double ratio = (value[1] - value[0]) / (value[2] - value[1]);
  const auto of_order = [&size](double p) {
    const double middle = std::pow(size[1] / size[0], p);
    const double last = std::pow(size[2] / size[0], p);
    return (1.0 - middle) / (middle - last);
  };
  const double of_order_zero = std::log(size[0] / size[1]) / std::log(size[1] / size[2]);
  constexpr double kHighest = 64.0;
  if (!(ratio > of_order_zero)) {  // also where it is not a number
    return std::nullopt;
  }
  double low = 0.0;
  double high = 1.0;
  while (of_order(high) < ratio) {
    high *= 2.0;
    if (high > kHighest) {
      return std::numeric_limits<double>::infinity();
    }
  }
  constexpr int kHalvings = 60;  // more than a double has bits
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (of_order(middle) < ratio ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

Trend trend(std::span<const double> size, std::span<const double> value, double scale) {
  // Sums over a run of some thousand steps are right to about this.
  constexpr double kRoundOff = 1e-12;
  // Below half an order the limit lies more than twice the last change away (halved sizes); beyond six there is no
  // method here.
  constexpr double kLowest = 0.5;
  constexpr double kHighest = 6.0;
  // Orders of successive triples that differ by more do not belong to one power of the size.
  constexpr double kSteady = 2.0;
  // What tends to zero is corrected by its own size; a limit well beyond zero is a guess.
  constexpr double kFarthest = 1.5;
  const std::size_t count = value.size();
  Trend result;
  if (count < 2) {
    return result;
  }
  std::vector<double> change;
  for (std::size_t i = 1; i < count; ++i) {
    change.push_back(value[i] - value[i - 1]);
  }
  const auto judge = [&result](Verdict verdict, double error, Bound bound) {
    result.verdict = verdict;
    result.error = error;
    result.bound = bound;
    return result;
  };
  const double noise = kRoundOff * std::max(scale, std::abs(value.back()));
  const auto last = std::span{change}.last(std::min<std::size_t>(change.size(), 3));
  const double last_change = std::abs(change.back());
  if (std::ranges::all_of(last, [noise](double d) { return std::abs(d) <= noise; })) {
    return judge(Verdict::constant, last_change, Bound::estimate);
  }
  for (std::size_t i = 0; i + 2 < count; ++i) {
    result.orders.push_back(observed_order(size.subspan(i).first<3>(), value.subspan(i).first<3>()));
  }
  if (count == 2) {
    return judge(Verdict::two_values, last_change, Bound::changes);
  }
  if (last_change <= noise) {
    return judge(Verdict::settled, last_change, Bound::estimate);
  }
  const auto [lowest, highest] = std::ranges::minmax(value.last(last.size() + 1));
  if (!std::ranges::all_of(last, [](double d) { return d > 0.0; }) &&
      !std::ranges::all_of(last, [](double d) { return d < 0.0; })) {
    return judge(Verdict::not_monotone, highest - lowest, Bound::changes);
  }
  const std::optional<double> order = result.orders.back();
  if (!order) {
    return judge(Verdict::diverges, last_change, Bound::at_least);
  }
  if (*order < kLowest) {
    return judge(Verdict::slow, last_change, Bound::at_least);
  }
  if (*order > kHighest) {
    return judge(Verdict::settled, last_change, Bound::estimate);
  }
  if (count > 3) {
    const std::optional<double> before = result.orders[count - 4];
    if (!before || std::max(*order, *before) > kSteady * std::min(*order, *before)) {
      return judge(Verdict::irregular, highest - lowest, Bound::changes);
    }
  }
  const double correction = change.back() / (std::pow(size[count - 2] / size[count - 1], *order) - 1.0);
  if (!(std::abs(correction) <= kFarthest * std::abs(value.back()))) {
    return judge(Verdict::slow, last_change, Bound::at_least);
  }
  result.limit = value.back() + correction;
  return judge(Verdict::converges, std::abs(correction), Bound::estimate);
}

Budget budget(double finest, std::span<const Trend> axes) {
  Budget result{.limit = finest};
  double correction = 0.0;
  for (const Trend& axis : axes) {
    correction += axis.limit ? *axis.limit - finest : 0.0;
    result.sum += axis.error;
    result.bound = std::max(result.bound, axis.bound);
  }
  result.limit += result.bound == Bound::estimate ? correction : 0.0;
  return result;
}

}  // namespace udar::study
