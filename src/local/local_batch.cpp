#include "udar/local/local_batch.hpp"

#include <limits>

#include "numerics/wide.hpp"
#include "udar/contact/impact_law.hpp"
#include "udar/numerics/power_series.hpp"

namespace udar::local {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

constexpr auto kInverse = [] {
  std::array<double, kMostPowers + kMostTerms + 1> inverse{};
  for (std::size_t k = 1; k < inverse.size(); ++k) {
    inverse[k] = 1.0 / static_cast<double>(k);
  }
  return inverse;
}();

// NOLINTBEGIN(cppcoreguidelines-pro-type-member-init): packs are written before they are read
/// W lanes of a batch, from `first` on.
template <std::size_t W>
struct Side {
  using Pack = wide::Pack<W>;
  using Mask = wide::Mask<W>;
  std::size_t first = 0;

  UDAR_INLINE Pack& pack(Lanes& lanes) const { return *reinterpret_cast<Pack*>(lanes.data() + first); }

  UDAR_INLINE static bool any(const Mask& mask) {
    long long some = 0;
    for (std::size_t lane = 0; lane < W; ++lane) {
      some |= mask[lane];
    }
    return some != 0;
  }

  UDAR_INLINE static void absolute(const Pack& value, Pack& result) { result = value < 0.0 ? -value : value; }

  UDAR_INLINE static void square_root(Pack& value) {
    for (std::size_t lane = 0; lane < W; ++lane) {
      value[lane] = __builtin_sqrt(value[lane]);
    }
  }

  /// Value and slope of a power series; even and odd powers apart, as two chains of operations that do not wait for
  /// each other.
  UDAR_INLINE static void evaluate(const Pack* c, std::size_t count, const Pack& s, Pack& value, Pack& slope) {
    const Pack s2 = s * s;
    Pack even = {};
    Pack odd = {};
    Pack even_slope = {};  // by s^2
    Pack odd_slope = {};
    for (std::size_t k = (count + 1) / 2; k-- > 0;) {
      even_slope = even_slope * s2 + even;
      even = even * s2 + c[2 * k];
      odd_slope = odd_slope * s2 + odd;
      odd = 2 * k + 1 < count ? odd * s2 + c[2 * k + 1] : odd;
    }
    value = even + s * odd;
    slope = 2.0 * s * (even_slope + s * odd_slope) + odd;
  }

  /// `first_zero` in every lane of `wanted`: those that have one, and those it could not tell.
  UDAR_INLINE static void find_zero(const Pack* c, std::size_t count, const Pack& end, Mask wanted, Pack& zero,
                                    Mask& found, Mask& unknown) {
    constexpr int kMostAdvances = 30;
    Pack bound = {};
    Pack size = {};
    Pack power = Pack{} + 1.0;   // end^k
    Pack power2 = Pack{} + 1.0;  // end^(k-2)
    for (std::size_t k = 0; k < count; ++k) {
      Pack term;
      absolute(c[k], term);
      size += term * power;
      power *= end;
      if (k >= 2) {
        bound += static_cast<double>(k * (k - 1)) * term * power2;
        power2 *= end;
      }
    }
    found = Mask{};
    zero = Pack{};
    Pack s = {};
    for (int advance = 0; advance < kMostAdvances && any(wanted); ++advance) {
      Pack value;
      Pack slope;
      evaluate(c, count, s, value, slope);
      Pack root = slope * slope + 2.0 * bound * value;
      root = root > 0.0 ? root : Pack{};
      square_root(root);
      const Mask falls = slope < 0.0;
      const Pack up = bound > 0.0 ? (slope + root) / bound : end;
      Pack step = falls ? 2.0 * value / (root - slope) : up;
      const Mask near = falls & ((step <= 2.0 * kEpsilon * s) | (value <= kEpsilon * 0.01 * size));
      const Mask met = wanted & (near | (value < 0.0));
      zero = met ? s : zero;
      found |= met;
      wanted &= ~met;
      step = step < 1e-17 ? Pack{} + 1e-17 : step;
      s += step;
      wanted &= ~(s > end);
    }
    unknown = wanted;
  }

  /// Adds the moments of an arc: `add_legendre` in every lane.
  UDAR_INLINE static void add_moments(const Pack* series, std::size_t count, const Pack& tau, const Pack& length,
                                      std::size_t terms, Pack* moments) {
    std::array<Pack, kMostTerms> integral;
    Pack power = length;
    for (std::size_t i = 0; i < terms; ++i) {
      Pack sum = {};
      for (std::size_t k = count; k-- > 0;) {
        sum = sum * length + series[k] * kInverse[k + i + 1];
      }
      integral[i] = sum * power;
      power *= length;
    }
    for (std::size_t j = 0; j < terms; ++j) {
      std::array<Pack, kMostTerms> about;
      for (std::size_t k = 0; k <= j; ++k) {
        about[k] = Pack{} + kLegendre[j][k];
      }
      for (std::size_t from = 0; from < j; ++from) {
        for (std::size_t k = j; k-- > from;) {
          about[k] += tau * about[k + 1];
        }
      }
      Pack sum = {};
      for (std::size_t i = 0; i <= j; ++i) {
        sum += about[i] * integral[i];
      }
      moments[j] += static_cast<double>(2 * j + 1) * sum;
    }
  }

  UDAR_INLINE static void make_series(const Pack* line, std::size_t terms, double z2, std::size_t powers,
                                      Pack* series) {
    for (std::size_t k = 0; k + 2 < powers; ++k) {
      const Pack pull = k < terms ? line[k] - series[k] : -series[k];
      series[k + 2] = (z2 * kInverse[k + 1] * kInverse[k + 2]) * pull;
    }
  }

  UDAR_INLINE void advance(Batch& batch, double angle, std::size_t terms, std::size_t powers, double hop) const {
    const double z2 = angle * angle;
    const Pack one = Pack{} + 1.0;
    const Pack at = pack(batch.at);
    const Pack side = pack(batch.side);
    std::array<Pack, kMostTerms> line;
    std::array<Pack, kMostTerms> moments;
    for (std::size_t j = 0; j < terms; ++j) {
      line[j] = Pack{};
      for (std::size_t k = j; k < terms; ++k) {
        line[j] += kLegendre[k][j] * pack(batch.line[k]);
      }
      moments[j] = Pack{};
    }
    std::array<Pack, kMostPowers> series;
    std::array<Pack, kMostPowers> gap;
    series[0] = Pack{};
    series[1] = pack(batch.velocity);
    make_series(line.data(), terms, z2, powers, series.data());
    for (std::size_t k = 0; k < powers; ++k) {
      gap[k] = side * series[k];
    }
    gap[0] = -side * at;

    Pack tau;
    Mask hit;
    Mask unknown;
    find_zero(gap.data(), powers, one, ~Mask{}, tau, hit, unknown);
    tau = hit ? tau : one;
    Mask simple = ~unknown;
    add_moments(series.data(), powers, Pack{}, tau, terms, moments.data());
    Pack place;
    Pack velocity;
    evaluate(series.data(), powers, tau, place, velocity);
    pack(batch.before) = velocity;

    Mask rests = {};
    if (any(hit)) {
      const Pack before = side * velocity;
      Pack after;
      for (std::size_t lane = 0; lane < W; ++lane) {
        after[lane] =
            ImpactLaw{.restitution = batch.restitution[first + lane], .yield_speed = batch.yield_speed[first + lane]}
                .after(before[lane]);
      }
      for (std::size_t from = 0; from + 1 < terms; ++from) {
        for (std::size_t k = terms - 1; k-- > from;) {
          line[k] += tau * line[k + 1];
        }
      }
      const Pack left = one - tau;
      const Pack pull = side * (line[0] - at);
      rests = hit & (pull < 0.0) & (after * after <= -2.0 * z2 * pull * hop);
      // At rest for good if the line pulls it down all along.
      Pack most = pull;
      Pack power = left;
      for (std::size_t k = 1; k < terms; ++k) {
        Pack term;
        absolute(line[k], term);
        most += term * power;
        power *= left;
      }
      const Mask starts_well = (before < 0.0) & (rests ? most < 0.0 : after > 0.0);
      simple &= ~hit | starts_well;

      std::array<Pack, kMostPowers> second;
      second[0] = at;
      second[1] = side * after;
      make_series(line.data(), terms, z2, powers, second.data());
      for (std::size_t k = 1; k < powers; ++k) {
        second[k] = rests ? Pack{} : second[k];
        gap[k - 1] = side * second[k];  // the zero at the start is divided out
      }
      Pack again;
      Mask hit_again;
      find_zero(gap.data(), powers - 1, left, hit & ~rests, again, hit_again, unknown);
      simple &= ~(hit_again | unknown);
      std::array<Pack, kMostTerms> more{};
      add_moments(second.data(), powers, tau, left, terms, more.data());
      for (std::size_t j = 0; j < terms; ++j) {
        moments[j] = hit ? moments[j] + more[j] : moments[j];
      }
      Pack there;
      Pack speed;
      evaluate(second.data(), powers, left, there, speed);
      place = hit ? there : place;
      velocity = hit ? speed : velocity;
      pack(batch.after) = side * after;
    }
    place = side * (place - at) < 0.0 ? at : place;  // round-off may leave it below by its last bits
    for (std::size_t j = 0; j < terms; ++j) {
      pack(batch.moments[j]) = moments[j];
    }
    pack(batch.displacement) = place;
    pack(batch.end_velocity) = velocity;
    pack(batch.impact) = hit ? tau : one + one;
    pack(batch.rests) = rests ? one : Pack{};
    pack(batch.simple) = simple ? one : Pack{};
  }
};
// NOLINTEND(cppcoreguidelines-pro-type-member-init)

}  // namespace

void advance(Batch& batch, double angle, std::size_t terms, std::size_t powers, double hop_tolerance) {
  wide::run([&]<std::size_t W>() __attribute__((always_inline)) {
    for (std::size_t first = 0; first < kLanes; first += W) {
      Side<W>{first}.advance(batch, angle, terms, powers, hop_tolerance);
    }
  });
}

}  // namespace udar::local
