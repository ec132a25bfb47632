#include "udar/structure/time_law.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <functional>
#include <numbers>
#include <random>
#include <span>
#include <sstream>
#include <string>
#include <utility>

#include "udar/petsc/error.hpp"

namespace udar {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

void require_value(bool sound, const char* quantity, double value, const char* expected) {
  if (!sound) {
    std::ostringstream message;
    message << quantity << ": " << value << " is not allowed, expected " << expected;
    throw InputError{message.str()};
  }
}

/// a cos(w t + phase).
struct Wave {
  double amplitude = 0.0;  // [N]
  double speed = 0.0;      // [rad/s]
  double phase = 0.0;      // [rad]
};

/// Between two rows of a spectrum [N^2/Hz].
double density_at(const TimeLaw& law, double frequency) {
  const auto next = std::ranges::upper_bound(law.at, frequency);
  if (next == law.at.begin() || frequency > law.at.back()) {
    return 0.0;
  }
  const auto right = std::min(static_cast<std::size_t>(next - law.at.begin()), law.at.size() - 1);
  const double share = (frequency - law.at[right - 1]) / (law.at[right] - law.at[right - 1]);
  return (1.0 - share) * law.density[right - 1] + share * law.density[right];
}

/// Integral of a spectrum between two frequencies [N^2].
double variance_between(const TimeLaw& law, double from, double to) {
  double sum = 0.0;
  for (std::size_t row = 0; row + 1 < law.at.size(); ++row) {
    const double left = std::max(from, law.at[row]);
    const double right = std::min(to, law.at[row + 1]);
    sum += right > left ? (right - left) * density_at(law, 0.5 * (left + right)) : 0.0;
  }
  return sum;
}

/// Lines at multiples of 1 / period, each with the variance of half a distance to both sides; a constant is none.
/// Phases by the first 53 bits of a generator that is the same everywhere.
std::vector<Wave> waves_of(const TimeLaw& law) {
  std::mt19937_64 generator{law.seed};
  std::vector<Wave> waves;
  const auto last = static_cast<std::size_t>(std::floor(law.at.back() * law.period + 0.5));
  for (std::size_t line = 1; line <= last; ++line) {
    const double random = std::ldexp(static_cast<double>(generator() >> 11U), -53);
    const double middle = static_cast<double>(line) / law.period;
    const double half = 0.5 / law.period;
    const double variance = variance_between(law, line == 1 ? 0.0 : middle - half, middle + half);
    if (variance > 0.0) {
      waves.push_back({.amplitude = std::sqrt(2.0 * variance), .speed = kTurn * middle, .phase = kTurn * random});
    }
  }
  return waves;
}

/// Value and second derivative, as row by row in a table.
struct Rows {
  std::vector<double> value;
  std::vector<double> second;  // [N/s^2]
};

/// One wave after the other, turned from row to row; from time to time afresh, so that rounding does not add up.
Rows sum_of(std::span<const Wave> waves, std::size_t rows, double step) {
  constexpr std::size_t kFresh = 256;
  Rows sum{.value = std::vector<double>(rows, 0.0), .second = std::vector<double>(rows, 0.0)};
  for (const auto& [amplitude, speed, phase] : waves) {
    const std::complex<double> turn = std::polar(1.0, speed * step);
    for (std::size_t first = 0; first < rows; first += kFresh) {
      std::complex<double> now = std::polar(amplitude, speed * (step * static_cast<double>(first)) + phase);
      for (std::size_t row = first; row < std::min(rows, first + kFresh); ++row) {
        sum.value[row] += now.real();
        sum.second[row] -= speed * speed * now.real();
        now *= turn;
      }
    }
  }
  return sum;
}

/// A formula that is cheap, at one time: value and second derivative.
std::array<double, 2> formula_at(const TimeLaw& law, double time) {
  if (law.course == Course::friedlander) {
    const double share = time / law.duration;
    const double fall = law.amplitude * std::exp(-law.decay * share);
    return {fall * (1.0 - share), fall * law.decay * (law.decay * (1.0 - share) + 2.0) / (law.duration * law.duration)};
  }
  const double sweep = law.last_frequency > 0.0 ? (law.last_frequency - law.frequency) / (law.until - law.start) : 0.0;
  const double angle = kTurn * time * (law.frequency + 0.5 * sweep * time) + law.phase;
  const double speed = kTurn * (law.frequency + sweep * time);
  return {law.amplitude * std::sin(angle),
          law.amplitude * (kTurn * sweep * std::cos(angle) - speed * speed * std::sin(angle))};
}

Rows rows_of(const TimeLaw& law, std::span<const Wave> waves, std::size_t rows, double step) {
  if (law.course == Course::random) {
    return sum_of(waves, rows, step);
  }
  Rows all;
  for (std::size_t row = 0; row < rows; ++row) {
    const auto [value, second] = formula_at(law, step * static_cast<double>(row));
    all.value.push_back(value);
    all.second.push_back(second);
  }
  return all;
}

/// The largest second derivative of what has an amplitude of 1, of a random law the ratio of root mean squares [1/s^2].
double bend_of(const TimeLaw& law, std::span<const Wave> waves) {
  if (law.course == Course::friedlander) {
    return law.decay * (law.decay + 2.0) / (law.duration * law.duration);
  }
  if (law.course == Course::harmonic) {
    const double sweep = law.last_frequency > 0.0 ? std::abs(law.last_frequency - law.frequency) : 0.0;
    const double speed = kTurn * std::max(law.frequency, law.last_frequency);
    return speed * speed + (sweep > 0.0 ? kTurn * sweep / (law.until - law.start) : 0.0);
  }
  double value = 0.0;
  double second = 0.0;
  for (const auto& [amplitude, speed, phase] : waves) {
    value += amplitude * amplitude;
    second += std::pow(speed, 4) * amplitude * amplitude;
  }
  return value > 0.0 ? std::sqrt(second / value) : 0.0;
}

void require_law(const TimeLaw& law) {
  const auto positive = [](double value) { return value > 0.0 && std::isfinite(value); };
  require_value(law.start >= 0.0 && std::isfinite(law.start), "load start", law.start, "a number >= 0 [s]");
  require_value(law.until > law.start, "load until", law.until, "a time after `load start` [s]");
  require_value(positive(law.accuracy) && law.accuracy <= 0.1, "load accuracy", law.accuracy,
                "a number > 0, at most 0.1");
  if (law.course == Course::random) {
    const auto number = [](double value) { return value >= 0.0 && std::isfinite(value); };
    if (law.at.size() < 2 || law.density.size() != law.at.size() || !std::ranges::all_of(law.at, number) ||
        !std::ranges::all_of(law.density, number) ||
        std::ranges::adjacent_find(law.at, std::ranges::greater_equal{}) != law.at.end()) {
      throw InputError{
          "load spectrum: expected at least two rows of frequency, strictly ascending, >= 0 [Hz], and power spectral "
          "density >= 0 [N^2/Hz]"};
    }
    require_value(positive(law.period), "load period", law.period, "a number > 0 [s]");
    return;
  }
  require_value(std::isfinite(law.amplitude), "load amplitude", law.amplitude, "a number [N]");
  if (law.course == Course::friedlander) {
    require_value(positive(law.duration), "load duration", law.duration, "a number > 0 [s]");
    require_value(law.decay >= 0.0 && std::isfinite(law.decay), "load decay", law.decay, "a number >= 0 [-]");
    require_value(std::isfinite(law.until), "load until", law.until, "a finite one for a friedlander pulse [s]");
    return;
  }
  require_value(positive(law.frequency), "load frequency", law.frequency, "a number > 0 [Hz]");
  require_value(law.last_frequency == 0.0 || positive(law.last_frequency), "load last frequency", law.last_frequency,
                "a number > 0 [Hz]");
  require_value(law.last_frequency == 0.0 || std::isfinite(law.until), "load until", law.until,
                "a finite one with `load last frequency` [s]");
}

/// Even rows from the start of a law, up to the end of the run or of the law.
struct Grid {
  double step = 0.0;  // [s]
  std::size_t rows = 0;
  bool whole = false;  // the last row is the end of the law
};

Grid grid_of(const TimeLaw& law, std::span<const Wave> waves, double end) {
  constexpr double kMostRows = 1e7;    // a row is about 60 bytes on every rank, here and where kinks are kept
  constexpr double kMostTerms = 2e10;  // of rows times lines, about a nanosecond each
  const double bend = bend_of(law, waves);
  const double widest = bend > 0.0 ? std::sqrt(12.0 * law.accuracy / bend) : TimeLaw::kNever;
  const double length = law.until - law.start;
  const double pieces = std::isfinite(length) ? std::max(1.0, std::ceil(length / widest)) : TimeLaw::kNever;
  const double step = std::isfinite(length) ? length / pieces : widest;  // the same for any end
  const double used = std::min(pieces, std::max(1.0, std::ceil((end - law.start) / step)));
  if (!(used <= kMostRows) || !(used * static_cast<double>(waves.size()) <= kMostTerms)) {
    constexpr double kRowBytes = 60.0;
    std::ostringstream message;
    message << "load law: " << used << " rows, " << kRowBytes * used / 1e9 << " GB, ";
    if (!waves.empty()) {
      message << "of " << waves.size() << " waves ";
    }
    message << "are not allowed up to t = " << std::min(end, law.until) << " s, expected at most " << kMostRows
            << " rows";
    if (!waves.empty()) {
      message << " and " << kMostTerms << " rows times waves";
    }
    message << ": an earlier `load until` or a larger `load accuracy`";
    throw InputError{message.str()};
  }
  return {.step = step, .rows = static_cast<std::size_t>(used) + 1, .whole = used == pieces};
}

}  // namespace

std::shared_ptr<const TimeTable> law_table(const TimeLaw& law, double end) {
  require_law(law);
  constexpr double kMostLines = 1e6;
  if (law.course == Course::random) {
    require_value(law.at.back() * law.period <= kMostLines, "load period", law.period,
                  "one with at most 1e6 lines, 1 / `load period` apart, in the spectrum [s]");
  }
  const std::vector<Wave> waves = law.course == Course::random ? waves_of(law) : std::vector<Wave>{};
  require_value(law.course != Course::random || !waves.empty(), "load period", law.period,
                "one that brings lines, 1 / `load period` apart, into a spectrum that is not 0 [s]");
  const Grid grid = grid_of(law, waves, end);
  const Rows all = rows_of(law, waves, grid.rows, grid.step);
  std::vector<double> time;
  std::vector<double> value;
  const auto add = [&](double now, double force) {
    time.push_back(now);
    value.push_back(force);
  };
  for (std::size_t row = 0; row < grid.rows; ++row) {
    // What is linear between rows is (h^2 / 12) f'' off in the mean.
    const double force = all.value[row] - grid.step * grid.step / 12.0 * all.second[row];
    if (row == 0 && law.start > 0.0 && force != 0.0) {
      add(law.start, 0.0);
    }
    const bool last = grid.whole && row + 1 == grid.rows;
    add(last ? law.until : law.start + grid.step * static_cast<double>(row), force);
    if (last && force != 0.0) {
      add(law.until, 0.0);
    }
  }
  return time_table(std::move(time), std::move(value));
}

}  // namespace udar
