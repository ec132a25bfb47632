#include "udar/filter/chain_span.hpp"

#include <algorithm>

#include "numerics/wide.hpp"

namespace udar::chain {

// Notation of docs/theory.md: state s = (w, theta), r = (force, moment) of all that acts further right, A the transfer
// of an element, Q its compliance. Lengths are in units of h, forces in units of K = filter + ground stiffness.
Span::Span(const SpanKey& key) : key_{key}, gains_(inner()), weights_(8 * inner()), pair_weights_(8 * inner()) {
  const long double h = key.length;
  const double stiffness = key.filter_stiffness + key.ground_stiffness;
  const long double k = stiffness;
  const long double bend = k * h * h * h * key.flexural_compliance;
  const Symmetric q{bend / 3 + k * h * key.shear_compliance, bend / 2, bend};
  units_ = {.force_to_target = 1.0 / stiffness,
            .ground_ratio = key.ground_stiffness / stiffness,
            .right_to_target = 1.0 / (stiffness * key.scale[0]),
            .right_to_kink = key.length / key.scale[1],
            .shift_to_unknown = 1.0 / key.scale[0],
            .moment_to_unknown = stiffness * key.length / key.scale[1],
            .stiffness = stiffness,
            .moment = stiffness * key.length};

  // Left to right: compliance c behind each inner node, transfer f from the left joint to it, stiffness j gathered.
  const auto cross = [](const Symmetric& c, const Symmetric& added) {  // A c A' + added
    return Symmetric{c[0] + 2 * c[1] + c[2] + added[0], c[1] + c[2] + added[1], c[2] + added[2]};
  };
  struct Node {
    long double deflect, turn, release;
    Matrix2 transfer;  // from the left joint to just right of this node
  };
  std::vector<Node> nodes(inner());
  Symmetric c{};
  Matrix2 f{1, 0, 0, 1};
  Symmetric j{};
  for (std::size_t i = 0; i < inner(); ++i) {
    const Symmetric p = cross(c, q);
    f[0] += f[2];
    f[1] += f[3];
    const long double release = 1 / (p[0] + 1);
    const long double g0 = p[0] * release;
    const long double g1 = p[1] * release;
    j = {j[0] + f[0] * f[0] * release, j[1] + f[0] * f[1] * release, j[2] + f[1] * f[1] * release};
    f = {f[0] * release, f[1] * release, f[2] - g1 * f[0], f[3] - g1 * f[1]};
    transfer_determinant_ *= release;
    c = {g0, g1, p[2] - g1 * p[1]};
    nodes[i] = {.deflect = g0, .turn = g1, .release = release, .transfer = f};
    // 1 - g0 - g1, without rounding 1 - g0 when it is small.
    gains_[i] = {.keep = static_cast<double>(release - g1),
                 .forecast = static_cast<double>(g0 + g1),
                 .deflect = static_cast<double>(g0),
                 .turn = static_cast<double>(g1),
                 .release = static_cast<double>(release)};
  }
  c = cross(c, q);
  f = {f[0] + f[2], f[1] + f[3], f[2], f[3]};
  compliance_ = {c[0] / k, c[1] / (k * h), c[2] / (k * h * h)};
  transfer_ = {f[0], f[1] * h, f[2] / h, f[3]};
  stiffness_ = {j[0] * k, j[1] * k * h, j[2] * k * h * h};

  // Right to left: z, what a change of state just right of a node does to the state at the right joint; info, the
  // stiffness of what follows, which turns such a change into a reaction.
  Matrix2 z{1, 1, 0, 1};
  Symmetric info{};
  for (std::size_t i = inner(); i-- > 0;) {
    const Node& node = nodes[i];
    const Matrix2 before = i > 0 ? nodes[i - 1].transfer : Matrix2{1, 0, 0, 1};
    const auto put = [&](std::size_t row, long double kink, long double target) {
      weights_[row * inner() + i] = static_cast<double>(kink);
      weights_[(4 + row) * inner() + i] = static_cast<double>(target);
      pair_weights_[row * 2 * inner() + 2 * i] = static_cast<double>(target) * units_.right_to_target;
      pair_weights_[row * 2 * inner() + 2 * i + 1] = static_cast<double>(kink) * units_.right_to_kink;
    };
    put(0, z[1], z[0] * node.deflect + z[1] * node.turn);
    put(1, z[3], z[2] * node.deflect + z[3] * node.turn);
    // Reaction just right of the node to a kink there, and to the move that its own target causes; carried to the left
    // joint. A target also pushes directly, by release.
    const std::array<long double, 2> of_kink{-info[1], -info[2]};
    const std::array<long double, 2> of_target{-(info[0] * node.deflect + info[1] * node.turn),
                                               -(info[1] * node.deflect + info[2] * node.turn)};
    // Through the node and the element on its left: A' (1 - H' g').
    const auto through = [&](const std::array<long double, 2>& r, long double push) {
      const long double force = r[0] * node.release - node.turn * r[1] + push;
      return std::array<long double, 2>{force, force + r[1]};
    };
    const auto kink = through(of_kink, 0);
    const auto target = through(of_target, node.release);
    put(2, before[0] * kink[0] + before[2] * kink[1], before[0] * target[0] + before[2] * target[1]);
    put(3, before[1] * kink[0] + before[3] * kink[1], before[1] * target[0] + before[3] * target[1]);
    // info <- A' ((1 - H' g') info (1 - g H) + H' H release) A
    const long double i00 = node.release * (node.release * info[0] - node.turn * info[1]) -
                            node.turn * (node.release * info[1] - node.turn * info[2]) + node.release;
    const long double i01 = node.release * info[1] - node.turn * info[2];
    info = {i00, i00 + i01, i00 + 2 * i01 + info[2]};
    // z <- z (1 - g H) A
    const long double z0 = z[0] * node.release - z[1] * node.turn;
    const long double z2 = z[2] * node.release - z[3] * node.turn;
    z = {z0, z0 + z[1], z2, z2 + z[3]};
  }
}

namespace {

/// What is given at the nodes, and what is wanted.
enum class Mode { displacement, loaded, loaded_moment, system };

Mode mode_of(const Span& span, const FilterColumn& column) {
  if (column.right_hand_side != nullptr) {
    return Mode::system;
  }
  if (column.internal != nullptr) {
    return Mode::loaded_moment;
  }
  return column.force != nullptr || span.units().ground_ratio != 0.0 ? Mode::loaded : Mode::displacement;
}

using wide::load;
using wide::store;
using wide::transpose;

template <std::size_t W>
UDAR_INLINE void set(wide::Pack<W>& pack, std::size_t lane, double value) {
  reinterpret_cast<double*>(&pack)[lane] = value;
}

// Every pack below is written before it is read; zeroing them first would cost as much as the work.
// NOLINTBEGIN(cppcoreguidelines-pro-type-member-init)

/// So many numbers ahead is a page, where the processor's own prefetching ends.
constexpr std::size_t kAhead = 512;

/// Shown by B spans: weighted sums over their inner nodes. The weights are read once for all B.
template <std::size_t W, std::size_t B, Mode Given>
UDAR_INLINE void condense_some(const Span& span, const FilterColumn& column, std::size_t first, Ends* shown) {
  using V = wide::Pack<W>;
  const std::size_t inner = span.inner();
  const std::size_t pitch = span.key().elements;
  const Span::Units& units = span.units();
  std::array<std::array<V, 4>, B> sums{};
  const std::size_t count = Given == Mode::system ? 2 * inner : inner;
  const double* weights = Given == Mode::system ? span.pair_weights() : span.weights();
  for (std::size_t i = 0; i < count; i += W) {
    std::array<V, 4> weight;
    for (std::size_t row = 0; row < 4; ++row) {
      load<W>(weight[row], weights + row * count + i);
    }
    for (std::size_t b = 0; b < B; ++b) {
      const std::size_t node = first + b * pitch + 1;
      V value;
      if constexpr (Given == Mode::system) {
        load<W>(value, column.right_hand_side + 2 * node + i);
        __builtin_prefetch(column.right_hand_side + 2 * node + i + kAhead);
      } else {
        const double* y = column.displacement + node + i;
        __builtin_prefetch(y + kAhead);
        V left;
        V own;
        V right;
        load<W>(left, y - 1);
        load<W>(own, y);
        load<W>(right, y + 1);
        value = (own - left) - (right - own);
        if constexpr (Given != Mode::displacement) {
          V target = own * -units.ground_ratio;
          if (column.force != nullptr) {
            V force;
            load<W>(force, column.force + node + i);
            __builtin_prefetch(column.force + node + i + kAhead);
            target += force * units.force_to_target;
          }
          for (std::size_t row = 0; row < 4; ++row) {
            V pushed;
            load<W>(pushed, weights + (4 + row) * inner + i);
            sums[b][row] += pushed * target;
          }
        }
      }
      for (std::size_t row = 0; row < 4; ++row) {
        sums[b][row] += weight[row] * value;
      }
    }
  }
  for (std::size_t b = 0; b < B; ++b) {
    Ends total{};
    for (std::size_t row = 0; row < 4; ++row) {
      for (std::size_t lane = 0; lane < W; ++lane) {
        total[row] += reinterpret_cast<const double*>(&sums[b][row])[lane];
      }
    }
    shown[b] = {total[0], total[1] / span.key().length, total[2] * units.stiffness, total[3] * units.moment};
  }
}

/// The recursion inside M * W spans side by side: from left to right, and back.
template <std::size_t W, std::size_t M, Mode Given>
struct LaneRecursion {
  using V = wide::Pack<W>;
  using NodeBlock = std::array<std::array<V, 2 * W>, M>;  // of W nodes, two numbers each
  static constexpr bool kTarget = Given != Mode::displacement;
  static constexpr bool kMoment = Given == Mode::loaded_moment || Given == Mode::system;
  static constexpr std::size_t kWide = W * M;

  /// The state of each span: alone in its object, or the compiler leaves all of it in memory.
  struct State {
    std::array<V, M> deflection;  // predicted
    std::array<V, M> rise;        // predicted rotation times h
    std::array<V, M> force;
    std::array<V, M> moment;
    std::array<V, M> last;  // displacement of the node ahead, and by how much it is above its left neighbour
    std::array<V, M> step;
  };

  const Span& span;
  const FilterColumn& column;
  const Span::Gain* gains;
  std::size_t pitch;    // nodes from span to span
  std::size_t first;    // node: left joint of the first span
  double* innovations;  // by inner node, then lane
  double* targets;

  [[nodiscard]] UDAR_INLINE std::size_t left_joint(std::size_t m, std::size_t lane) const {
    return first + (m * W + lane) * pitch;
  }

  UDAR_INLINE void start(const Ends* told, State& state) const {
    const Span::Units& units = span.units();
    for (std::size_t m = 0; m < M; ++m) {
      for (std::size_t lane = 0; lane < W; ++lane) {
        const Ends& ends = told[m * W + lane];
        set<W>(state.rise[m], lane, ends[1] * span.key().length);
        set<W>(state.deflection[m], lane, ends[0] + ends[1] * span.key().length);
        set<W>(state.force[m], lane, ends[2] / units.stiffness);
        set<W>(state.moment[m], lane, ends[3] / units.moment);
        if constexpr (Given != Mode::system) {
          const double* y = column.displacement + left_joint(m, lane);
          set<W>(state.last[m], lane, y[1]);
          set<W>(state.step[m], lane, y[1] - y[0]);
        }
      }
    }
  }

  /// What is given at inner nodes i to i + W.
  UDAR_INLINE void read(std::size_t i, NodeBlock& given) const {
    const std::size_t ahead = kWide * pitch;
    for (std::size_t m = 0; m < M; ++m) {
      for (std::size_t lane = 0; lane < W; ++lane) {
        const std::size_t node = left_joint(m, lane) + 1 + i;
        if constexpr (Given == Mode::system) {
          load<W>(given[m][lane], column.right_hand_side + 2 * node);
          load<W>(given[m][W + lane], column.right_hand_side + 2 * node + W);
          __builtin_prefetch(column.right_hand_side + 2 * (node + ahead));
          __builtin_prefetch(column.right_hand_side + 2 * (node + ahead) + W);
        } else {
          load<W>(given[m][lane], column.displacement + node + 1);
          __builtin_prefetch(column.displacement + node + 1 + ahead);
          if constexpr (kTarget) {
            if (column.force != nullptr) {
              load<W>(given[m][W + lane], column.force + node);
              __builtin_prefetch(column.force + node + ahead);
            } else {
              given[m][W + lane] = V{};
            }
          }
        }
      }
      transpose<W>(given[m].data());
      if constexpr (kTarget) {
        transpose<W>(given[m].data() + W);
      }
    }
  }

  /// From left to right through these nodes.
  UDAR_INLINE void predict(std::size_t i, const NodeBlock& given, State& state) const {
    const Span::Units& units = span.units();
    for (std::size_t k = 0; k < W; ++k) {
      const std::size_t at = (i + k) * kWide;
      const Span::Gain gain = gains[i + k];
      for (std::size_t m = 0; m < M; ++m) {
        V ahead = state.rise[m];
        V target;
        if constexpr (Given == Mode::system) {
          target = given[m][2 * k] * units.right_to_target;
          ahead += given[m][2 * k + 1] * units.right_to_kink;
        } else {
          if constexpr (kTarget) {
            target = given[m][W + k] * units.force_to_target - state.last[m] * units.ground_ratio;
          }
          const V next = given[m][k] - state.last[m];
          ahead += state.step[m] - next;
          state.step[m] = next;
          state.last[m] = given[m][k];
        }
        if constexpr (kTarget) {
          const V innovation = target - state.deflection[m];
          store<W>(innovations + at + m * W, innovation);
          store<W>(targets + at + m * W, target);
          state.rise[m] = ahead + gain.turn * innovation;
          state.deflection[m] = gain.keep * state.deflection[m] + (ahead + gain.forecast * target);
        } else {
          store<W>(innovations + at + m * W, state.deflection[m]);
          state.rise[m] = ahead - gain.turn * state.deflection[m];
          state.deflection[m] = gain.keep * state.deflection[m] + ahead;
        }
      }
    }
  }

  /// Back through these nodes.
  UDAR_INLINE void smooth(std::size_t i, State& state, NodeBlock& found) const {
    const Span::Units& units = span.units();
    for (std::size_t k = W; k-- > 0;) {
      const std::size_t at = (i + k) * kWide;
      const Span::Gain gain = gains[i + k];
      for (std::size_t m = 0; m < M; ++m) {
        V innovation;
        load<W>(innovation, innovations + at + m * W);
        state.moment[m] += state.force[m];
        if constexpr (kTarget) {
          V target;
          load<W>(target, targets + at + m * W);
          const V spring = gain.release * innovation - gain.deflect * state.force[m] - gain.turn * state.moment[m];
          state.force[m] += spring;
          if constexpr (Given == Mode::system) {
            found[m][2 * k] = (target - spring) * units.shift_to_unknown;
            found[m][2 * k + 1] = state.moment[m] * units.moment_to_unknown;
          } else {
            found[m][k] = target - spring;
            if constexpr (kMoment) {
              found[m][W + k] = state.moment[m] * units.moment;
            }
          }
        } else {
          found[m][k] = gain.release * innovation + gain.deflect * state.force[m] + gain.turn * state.moment[m];
          state.force[m] -= found[m][k];
        }
      }
    }
  }

  UDAR_INLINE void write(std::size_t i, NodeBlock& found) const {
    const std::size_t ahead = kWide * pitch;
    for (std::size_t m = 0; m < M; ++m) {
      transpose<W>(found[m].data());
      if constexpr (kMoment) {
        transpose<W>(found[m].data() + W);
      }
      for (std::size_t lane = 0; lane < W; ++lane) {
        const std::size_t node = left_joint(m, lane) + 1 + i;
        if constexpr (Given == Mode::system) {
          store<W>(column.unknowns + 2 * node, found[m][lane]);
          store<W>(column.unknowns + 2 * node + W, found[m][W + lane]);
          __builtin_prefetch(column.unknowns + 2 * (node + ahead), 1);
          __builtin_prefetch(column.unknowns + 2 * (node + ahead) + W, 1);
        } else {
          store<W>(column.stretch + node, found[m][lane]);
          if constexpr (kMoment) {
            store<W>(column.internal + node, found[m][W + lane]);
          }
        }
      }
    }
  }
};

// NOLINTBEGIN(readability-non-const-parameter): `scratch` is written to by what it is handed on to, a dependent type
/// Inside M * W spans side by side.
template <std::size_t W, std::size_t M, Mode Given>
UDAR_INLINE void resolve_some(const Span& span, const FilterColumn& column, std::size_t first, const Ends* told,
                              double* scratch) {
  using Lanes = LaneRecursion<W, M, Given>;
  const std::size_t inner = span.inner();
  const Lanes lanes{.span = span,
                    .column = column,
                    .gains = span.gains().data(),
                    .pitch = span.key().elements,
                    .first = first,
                    .innovations = scratch,
                    .targets = scratch + Lanes::kWide * inner};
  typename Lanes::State state;
  lanes.start(told, state);
  for (std::size_t i = 0; i < inner; i += W) {
    typename Lanes::NodeBlock given;
    lanes.read(i, given);
    lanes.predict(i, given, state);
  }
  for (std::size_t done = 0; done < inner; done += W) {
    typename Lanes::NodeBlock found;
    lanes.smooth(inner - done - W, state, found);
    lanes.write(inner - done - W, found);
  }
}
// NOLINTEND(readability-non-const-parameter)

// NOLINTEND(cppcoreguidelines-pro-type-member-init)

template <std::size_t W, Mode Given>
UDAR_INLINE void condense_all(const Span& span, const FilterColumn& column, std::size_t first, std::size_t blocks,
                              Ends* shown, bool from_memory) {
  constexpr std::size_t kSpansAtOnce = 4;
  std::size_t done = 0;
  for (; !from_memory && done + kSpansAtOnce <= blocks; done += kSpansAtOnce) {
    condense_some<W, kSpansAtOnce, Given>(span, column, first + done * span.key().elements, shown + done);
  }
  for (; done < blocks; ++done) {
    condense_some<W, 1, Given>(span, column, first + done * span.key().elements, shown + done);
  }
}

template <std::size_t W, Mode Given>
UDAR_INLINE void resolve_all(const Span& span, const FilterColumn& column, std::size_t first, std::size_t blocks,
                             const Ends* told, double* scratch) {
  std::size_t done = 0;
  // Two groups of lanes hide the latency of each other's recursion.
  for (; done + 2 * W <= blocks; done += 2 * W) {
    resolve_some<W, 2, Given>(span, column, first + done * span.key().elements, told + done, scratch);
  }
  for (; done < blocks; done += W) {
    resolve_some<W, 1, Given>(span, column, first + done * span.key().elements, told + done, scratch);
  }
}

template <std::size_t W>
UDAR_INLINE void condense_any(const Span& span, const FilterColumn& column, std::size_t first, std::size_t blocks,
                              Ends* shown, bool from_memory) {
  switch (mode_of(span, column)) {
    case Mode::displacement:
      return condense_all<W, Mode::displacement>(span, column, first, blocks, shown, from_memory);
    case Mode::loaded:
    case Mode::loaded_moment:
      return condense_all<W, Mode::loaded>(span, column, first, blocks, shown, from_memory);
    case Mode::system:
      return condense_all<W, Mode::system>(span, column, first, blocks, shown, from_memory);
  }
}

template <std::size_t W>
UDAR_INLINE void resolve_any(const Span& span, const FilterColumn& column, std::size_t first, std::size_t blocks,
                             const Ends* told, double* scratch) {
  switch (mode_of(span, column)) {
    case Mode::displacement:
      return resolve_all<W, Mode::displacement>(span, column, first, blocks, told, scratch);
    case Mode::loaded:
      return resolve_all<W, Mode::loaded>(span, column, first, blocks, told, scratch);
    case Mode::loaded_moment:
      return resolve_all<W, Mode::loaded_moment>(span, column, first, blocks, told, scratch);
    case Mode::system:
      return resolve_all<W, Mode::system>(span, column, first, blocks, told, scratch);
  }
}

UDAR_TARGET("avx512f,avx512dq,avx512vl,fma")
void condense_8(const Span& span, const FilterColumn& column, std::size_t first, std::size_t blocks, Ends* shown,
                bool from_memory) {
  condense_any<8>(span, column, first, blocks, shown, from_memory);
}
UDAR_TARGET("avx512f,avx512dq,avx512vl,fma")
void resolve_8(const Span& span, const FilterColumn& column, std::size_t first, std::size_t blocks, const Ends* told,
               double* scratch) {
  resolve_any<8>(span, column, first, blocks, told, scratch);
}
UDAR_TARGET("avx2,fma")
void condense_4(const Span& span, const FilterColumn& column, std::size_t first, std::size_t blocks, Ends* shown,
                bool from_memory) {
  condense_any<4>(span, column, first, blocks, shown, from_memory);
}
UDAR_TARGET("avx2,fma")
void resolve_4(const Span& span, const FilterColumn& column, std::size_t first, std::size_t blocks, const Ends* told,
               double* scratch) {
  resolve_any<4>(span, column, first, blocks, told, scratch);
}

}  // namespace

int native_lanes() {
#if defined(__x86_64__)
  constexpr int kNarrow = 1;  // without AVX2 packs of four gain nothing
#else
  constexpr int kNarrow = 4;
#endif
  return wide::native() >= 4 ? wide::native() : kNarrow;
}

void condense(const Span& span, const FilterColumn& column, std::size_t first, std::size_t blocks, Ends* shown,
              int lanes, bool from_memory) {
  if (lanes == 1 || blocks == 1) {
    return condense_any<1>(span, column, first, blocks, shown, from_memory);
  }
  return lanes == 8 ? condense_8(span, column, first, blocks, shown, from_memory)
                    : condense_4(span, column, first, blocks, shown, from_memory);
}

void resolve(const Span& span, const FilterColumn& column, std::size_t first, std::size_t blocks, const Ends* told,
             double* scratch, int lanes) {
  if (lanes == 1 || blocks == 1) {
    return resolve_any<1>(span, column, first, blocks, told, scratch);
  }
  return lanes == 8 ? resolve_8(span, column, first, blocks, told, scratch)
                    : resolve_4(span, column, first, blocks, told, scratch);
}

}  // namespace udar::chain
