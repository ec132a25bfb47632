#include "udar/integrators/free_motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace udar {
namespace {

// An answer this small beside the motion is the rounding of a line solve (measured: docs/theory.md).
constexpr double kAnswerRounding = 16.0 * std::numeric_limits<double>::epsilon();

double largest_of(std::span<const double> values) {
  double largest = 0.0;
  for (const double value : values) {
    largest = std::max(largest, std::abs(value));
  }
  return largest;
}

/// J_0(z) ... J_(2 pairs - 1)(z) by Miller's downward recurrence.
std::vector<double> bessel(double z, std::size_t pairs) {
  std::vector<double> values(2 * pairs, 0.0);
  values[0] = 1.0;
  if (z == 0.0) {
    return values;
  }
  // From an order so high that what is left out does not count: beyond z the functions fall faster than 2^-order.
  const auto top = std::max(2 * pairs, static_cast<std::size_t>(z)) + 60;
  constexpr double kLarge = 1e200;
  double above = 0.0;
  double here = 1e-280;
  double sum = 0.0;
  for (std::size_t order = top; order > 0; --order) {
    const double below = 2.0 * static_cast<double>(order) / z * here - above;
    above = here;
    here = below;
    if (order - 1 < values.size()) {
      values[order - 1] = here;
    }
    if ((order - 1) % 2 == 0) {
      sum += order == 1 ? here : 2.0 * here;
    }
    if (std::abs(here) > kLarge) {
      above /= kLarge;
      here /= kLarge;
      sum /= kLarge;
      for (double& value : values) {
        value /= kLarge;
      }
    }
  }
  for (double& value : values) {
    value /= sum;
  }
  return values;
}

}  // namespace

FreeMotion::FreeMotion(FilteredStructure& line, AlteredLine* held)
    : line_{&line},
      held_{held},
      bound_{held != nullptr ? held->frequency_bound() : line.frequency_bound()},
      gain_{line.filter_frequency() * line.filter_frequency() / (bound_ * bound_)},
      count_{line.mass().size()} {}

double FreeMotion::reach(std::size_t terms, double tolerance) const {
  // cos(t sqrt(A)) = J_0 + 2 sum (-1)^k J_2k(wf t) T_k; the others are integrals of it over time, whose tails are
  // smaller relative to t, t^2 / 2 and t^3 / 6. Below z = 2k the next terms fall by more than 1/2 each.
  const double order = 2.0 * static_cast<double>(terms);
  double low = 0.0;
  double high = order;
  for (int halving = 0; halving < 50; ++halving) {
    const double middle = 0.5 * (low + high);
    (4.0 * std::abs(std::cyl_bessel_j(order, middle)) > tolerance ? high : low) = middle;
  }
  return low / bound_;
}

FreeMotion::Weights FreeMotion::weights(int derivative, double time) const {
  // The coefficient of T_k in the n-fold integral of cos(t sqrt(A)) is (2 - delta_k0) (-1)^k wf^-n times the n-fold
  // integral of J_2k, by  integral of J_m = 2 (J_(m+1) + J_(m+3) + ...).
  if (rigid_) {
    return rigid_weights(derivative, time);
  }
  const double wf = bound_;
  const double z = wf * time;
  const std::size_t pairs = terms_ + 30 + static_cast<std::size_t>(0.5 * z);
  const std::vector<double> j = bessel(z, pairs);
  std::vector<double> even(pairs);
  std::vector<double> odd(pairs);
  for (std::size_t k = 0; k < pairs; ++k) {
    even[k] = j[2 * k];
    odd[k] = j[2 * k + 1];
  }
  Weights result;
  result.values_.assign(sequences_ * terms_, 0.0);
  const auto fill = [&](std::size_t sequence, double factor, const auto& value) {
    for (std::size_t k = 0; k < terms_; ++k) {
      result.values_[sequence * terms_ + k] = factor * (k == 0 ? 1.0 : 2.0) * (k % 2 == 0 ? 1.0 : -1.0) * value(k);
    }
  };
  const int last = static_cast<int>(sequences_) - derivative;
  double factor = 1.0;
  if (derivative == 2) {
    fill(0, wf, [&](std::size_t k) { return k == 0 ? -odd[0] : 0.5 * (odd[k - 1] - odd[k]); });
  }
  for (int n = 0; n <= last; ++n) {
    const int sequence = n + derivative - 1;
    if (sequence >= 0 && sequence < static_cast<int>(sequences_)) {
      fill(static_cast<std::size_t>(sequence), factor, [&](std::size_t k) { return even[k]; });
    }
    double even_sum = 0.0;  // of those above
    double odd_sum = 0.0;
    for (std::size_t k = pairs; k-- > 0;) {
      odd_sum += odd[k];
      const double integral = 2.0 * even_sum;
      even_sum += even[k];
      even[k] = 2.0 * odd_sum;
      odd[k] = integral;
    }
    factor /= wf;
  }
  return result;
}

/// Of A = 0: powers of time.
FreeMotion::Weights FreeMotion::rigid_weights(int derivative, double time) const {
  Weights result;
  for (int s = 0; s < static_cast<int>(sequences_); ++s) {
    double power = derivative <= s + 1 ? 1.0 : 0.0;
    for (int n = 1; n <= s + 1 - derivative; ++n) {
      power *= time / static_cast<double>(n);
    }
    result.values_.push_back(power);
  }
  return result;
}

void FreeMotion::start(const Start& start) {
  sequences_ = start.jerk.empty() ? 2 : 3;
  terms_ = 1;
  answered_ = 0;
  rigid_ = false;
  rows_.clear();
  resting_.clear();
  for (std::size_t i = 0; i < start.resting.size(); ++i) {
    if (start.resting[i] != 0) {
      resting_.push_back(i);
    }
  }
  const std::array<std::span<const double>, 3> first{start.velocity, start.acceleration, start.jerk};
  for (std::size_t s = 0; s < sequences_; ++s) {
    if (stored_[s].empty()) {
      stored_[s].emplace_back();
    }
    stored_[s][0].assign(first[s].begin(), first[s].end());
    for (const std::size_t i : resting_) {
      stored_[s][0][i] = 0.0;
    }
    stretch_[s].resize(count_);
    resting_stretch_[s].clear();
    amplitudes_[s].clear();
  }
}

void FreeMotion::answer() {
  if (answered_ == terms_) {
    return;
  }
  std::array<FilterColumn, 3> columns;
  for (std::size_t s = 0; s < sequences_; ++s) {
    columns[s] = {.displacement = stored_[s][terms_ - 1].data(), .stretch = stretch_[s].data()};
  }
  line_->solve({columns.data(), sequences_});
  const std::size_t modes = line_->corrected_modes().size();
  std::vector<double> amplitudes;
  for (std::size_t s = 0; s < sequences_; ++s) {
    const std::span<const double> of = line_->amplitudes(s);
    amplitudes.insert(amplitudes.end(), of.begin(), of.end());
  }
  if (held_ != nullptr) {
    held_->hold({columns.data(), sequences_}, amplitudes, rows_.emplace_back());
  }
  for (std::size_t s = 0; s < sequences_; ++s) {
    const auto from = amplitudes.begin() + static_cast<std::ptrdiff_t>(s * modes);
    amplitudes_[s].insert(amplitudes_[s].end(), from, from + static_cast<std::ptrdiff_t>(modes));
  }
  answered_ = terms_;
}

FreeMotion::Sizes FreeMotion::first_sizes() const {
  Sizes sizes{};
  for (std::size_t s = 0; s < sequences_; ++s) {
    sizes[s] = largest_of(stored_[s][0]);
    sizes[sequences_ + s] = largest_of(stretch_[s]);
  }
  return sizes;
}

void FreeMotion::end_if_rigid(const Sizes& sizes, double time, double negligible) {
  // The next terms of the power series are wf^2 t^(s+3) / (s+3)! d; with those beyond them they are less, mode by mode.
  const double wf = line_->filter_frequency();
  double power = wf * wf * time * time / 2.0;
  double way = 0.0;
  for (std::size_t s = 0; s < sequences_; ++s) {
    power *= time / static_cast<double>(s + 3);
    const bool rounding = sizes[sequences_ + s] <= kAnswerRounding * sizes[s];
    way += rounding ? 0.0 : power * sizes[sequences_ + s];
  }
  rigid_ = way <= negligible;
}

void FreeMotion::extend(std::size_t terms) {
  for (; terms_ < terms && !rigid_; ++terms_) {
    const std::size_t k = terms_;
    answer();
    // X p = -p - 2 d(p) (times the square of wf over a larger bound), then T_(k+1) = 2 X T_k - T_(k-1).
    for (std::size_t s = 0; s < sequences_; ++s) {
      if (stored_[s].size() <= k) {
        stored_[s].emplace_back(count_);
      }
      const double* now = stored_[s][k - 1].data();
      const double* before = stored_[s][k > 1 ? k - 2 : 0].data();
      const double* stretch = stretch_[s].data();
      double* next = stored_[s][k].data();
      const double factor = k == 1 ? -1.0 : -2.0;
      const double share = k == 1 ? 0.0 : 1.0;
      const double gain = 2.0 * gain_;
      for (std::size_t i = 0; i < count_; ++i) {
        next[i] = factor * (now[i] + gain * stretch[i]) - share * before[i];
      }
      for (const std::size_t i : resting_) {
        next[i] = 0.0;
        resting_stretch_[s].push_back(stretch[i]);
      }
    }
  }
}

double FreeMotion::at(const Weights& weights, std::size_t node) const {
  double sum = 0.0;
  for (std::size_t s = 0; s < sequences_; ++s) {
    for (std::size_t k = 0; k < terms_; ++k) {
      sum += weights.values_[s * terms_ + k] * stored_[s][k][node];
    }
  }
  return sum;
}

void FreeMotion::at(const Weights& weights, std::span<double> values) const {
  constexpr std::size_t kBlock = 1024;  // stays in the first cache while all terms are added
  for (std::size_t from = 0; from < values.size(); from += kBlock) {
    const std::size_t to = std::min(from + kBlock, values.size());
    std::fill(values.begin() + static_cast<std::ptrdiff_t>(from), values.begin() + static_cast<std::ptrdiff_t>(to),
              0.0);
    for (std::size_t s = 0; s < sequences_; ++s) {
      for (std::size_t k = 0; k < terms_; ++k) {
        const double weight = weights.values_[s * terms_ + k];
        const double* term = stored_[s][k].data();
        for (std::size_t i = from; i < to; ++i) {
          values[i] += weight * term[i];
        }
      }
    }
  }
}

void FreeMotion::integrals(std::span<const double> position, double time, std::span<double> values) const {
  at(weights(-1, time), values);
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] += time * position[i];
  }
}

double FreeMotion::amplitude(const Weights& weights, std::size_t mode) const {
  const std::size_t modes = line_->corrected_modes().size();
  double sum = 0.0;
  for (std::size_t s = 0; s < sequences_; ++s) {
    for (std::size_t k = 0; k + 1 < terms_; ++k) {
      sum += weights.values_[s * terms_ + k] * amplitudes_[s][k * modes + mode];
    }
  }
  return sum;
}

double FreeMotion::stretch(const Weights& weights, std::size_t node) const {
  const auto found = static_cast<std::size_t>(std::ranges::lower_bound(resting_, node) - resting_.begin());
  double sum = 0.0;
  for (std::size_t s = 0; s < sequences_; ++s) {
    for (std::size_t k = 0; k + 1 < terms_; ++k) {
      sum += weights.values_[s * terms_ + k] * resting_stretch_[s][k * resting_.size() + found];
    }
  }
  return sum;
}

double FreeMotion::row(const Weights& weights, std::size_t point) const {
  double sum = 0.0;
  for (std::size_t s = 0; s < sequences_; ++s) {
    for (std::size_t k = 0; k < rows_.size(); ++k) {
      sum += weights.values_[s * terms_ + k] * rows_[k][s * held_->points() + point];
    }
  }
  return sum;
}

}  // namespace udar
