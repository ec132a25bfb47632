#pragma once
/// @file
/// Numbers side by side in registers as wide as the processor's, for several generations of processors in one binary.

#include <array>
#include <cstddef>
#include <utility>

#include "numerics/clones.hpp"

#if defined(__x86_64__)
#define UDAR_TARGET(features) __attribute__((target(features)))
#else
#define UDAR_TARGET(features)
#endif
// Sanitizers make these functions large: minutes each for every width. All run the same source.
#if defined(__SANITIZE_ADDRESS__) || UDAR_HAS_FEATURE(address_sanitizer)
#define UDAR_ONE_WIDTH
#endif
// What is inlined into a function compiled for one kind of processor is compiled for it too.
#define UDAR_INLINE [[gnu::always_inline]] inline

namespace udar::wide {

/// W numbers side by side, and the same anywhere in memory. Wider ones than the processor's would stay in memory.
template <std::size_t W>
struct Vector {
  using Type __attribute__((vector_size(8 * W))) = double;
  using Compared __attribute__((vector_size(8 * W))) = long long;
  using Loose [[gnu::vector_size(8 * W), gnu::aligned(8), gnu::may_alias]] = double;
};
template <>
struct Vector<1> {
  using Type = double;
  using Loose [[gnu::may_alias]] = double;
};

template <std::size_t W>
using Pack = typename Vector<W>::Type;
/// What comparisons of packs give.
template <std::size_t W>
using Mask = typename Vector<W>::Compared;

template <std::size_t W>
UDAR_INLINE void load(Pack<W>& pack, const double* from) {
  pack = *reinterpret_cast<const typename Vector<W>::Loose*>(from);
}
template <std::size_t W>
UDAR_INLINE void store(double* to, const Pack<W>& pack) {
  *reinterpret_cast<typename Vector<W>::Loose*>(to) = pack;
}

/// @brief Calls `each` with 0 to Count - 1 as constants: what loops over arrays of packs would keep in memory stays in
/// registers. @param each a generic lambda of a `std::integral_constant`, always inlined
template <std::size_t Count, class Each>
UDAR_INLINE void unrolled(const Each& each) {
  [&]<std::size_t... I>(std::index_sequence<I...>) __attribute__((always_inline)) {
    (each(std::integral_constant<std::size_t, I>{}), ...);
  }(std::make_index_sequence<Count>{});
}

// NOLINTBEGIN(cppcoreguidelines-pro-type-member-init): packs are written before they are read
/// Rows of W packs become columns.
template <std::size_t W>
UDAR_INLINE void transpose(Pack<W>* r) {
  using V = Pack<W>;
  if constexpr (W == 8) {
    std::array<V, 8> t;
    std::array<V, 8> s;
    for (std::size_t k = 0; k < 8; k += 2) {
      t[k] = __builtin_shufflevector(r[k], r[k + 1], 0, 8, 2, 10, 4, 12, 6, 14);
      t[k + 1] = __builtin_shufflevector(r[k], r[k + 1], 1, 9, 3, 11, 5, 13, 7, 15);
    }
    for (std::size_t k = 0; k < 8; k += 4) {
      for (std::size_t q = k; q < k + 2; ++q) {
        s[q] = __builtin_shufflevector(t[q], t[q + 2], 0, 1, 8, 9, 4, 5, 12, 13);
        s[q + 2] = __builtin_shufflevector(t[q], t[q + 2], 2, 3, 10, 11, 6, 7, 14, 15);
      }
    }
    for (std::size_t q = 0; q < 4; ++q) {
      r[q] = __builtin_shufflevector(s[q], s[q + 4], 0, 1, 2, 3, 8, 9, 10, 11);
      r[q + 4] = __builtin_shufflevector(s[q], s[q + 4], 4, 5, 6, 7, 12, 13, 14, 15);
    }
  } else if constexpr (W == 4) {
    std::array<V, 4> t;
    for (std::size_t k = 0; k < 4; k += 2) {
      t[k] = __builtin_shufflevector(r[k], r[k + 1], 0, 4, 2, 6);
      t[k + 1] = __builtin_shufflevector(r[k], r[k + 1], 1, 5, 3, 7);
    }
    for (std::size_t q = 0; q < 2; ++q) {
      r[q] = __builtin_shufflevector(t[q], t[q + 2], 0, 1, 4, 5);
      r[q + 2] = __builtin_shufflevector(t[q], t[q + 2], 2, 3, 6, 7);
    }
  } else if constexpr (W == 2) {
    const V first = r[0];
    r[0] = __builtin_shufflevector(first, r[1], 0, 2);
    r[1] = __builtin_shufflevector(first, r[1], 1, 3);
  }
}
// NOLINTEND(cppcoreguidelines-pro-type-member-init)

namespace detail {
extern const int kNativeLanes;
}
/// Numbers in a register of this processor: 8, 4 or 2, and no more than `UDAR_LANES` of the environment says.
[[nodiscard]] inline int native() { return detail::kNativeLanes; }

template <class Run>
UDAR_TARGET("avx512f,avx512dq,avx512vl,fma")
void run_8(const Run& run) {
  run.template operator()<8>();
}
template <class Run>
UDAR_TARGET("avx2,fma")
void run_4(const Run& run) {
  run.template operator()<4>();
}

/// @brief Calls `run` for vectors of W numbers, and compiled for a processor that has them. @param run a generic
/// lambda, `[&]<std::size_t W>() __attribute__((always_inline))`, of functions that are `UDAR_INLINE`
template <class Run>
void run(const Run& run) {
#ifdef UDAR_ONE_WIDTH
  run.template operator()<4>();
#else
  switch (native()) {
    case 8:
      return run_8(run);
    case 4:
      return run_4(run);
    default:
      return run.template operator()<2>();
  }
#endif
}

}  // namespace udar::wide
