// math/estimates.hpp - 1/x and 1/sqrt(x) without the processor's units for division and roots, which are the narrow place where
// every operation acts on eight numbers: its estimate of 14 bits and two steps of Newton, to the last digit but one.
//
// Where there is no such estimate, and for plain and dual numbers, they are what they say. Source: any text on division by
// Newton's method; error below 2 units in the last place, tested.
#pragma once
#include "rollerrig/math/lane.hpp"

#if ROLLERRIG_LANES && defined(__AVX512F__) && defined(__AVX512VL__)
#define ROLLERRIG_ESTIMATES 1
#else
#define ROLLERRIG_ESTIMATES 0
#endif

// As in math/lane.hpp.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#endif

namespace rollerrig {

/// 1/x. In lanes for x neither zero, nor infinite, nor denormal.
template <class T>
T reciprocal(T const& x) {
  return 1.0 / x;
}

/// 1/sqrt(x), x > 0. In lanes neither infinite nor denormal.
template <class T>
T inverse_root(T const& x) {
  using std::sqrt;
  return 1.0 / sqrt(x);
}

#if ROLLERRIG_ESTIMATES
template <int W>
  requires(W == 4 || W == 8)
[[gnu::always_inline]] inline Lane<double, W> reciprocal(Lane<double, W> const& x) {
  using L = Lane<double, W>;
  L r;
  if constexpr (W == 8)
    r = std::bit_cast<L>(_mm512_rcp14_pd(std::bit_cast<__m512d>(x)));
  else
    r = std::bit_cast<L>(_mm256_rcp14_pd(std::bit_cast<__m256d>(x)));
  r = r + r * (1.0 - x * r);
  return r + r * (1.0 - x * r);
}

template <int W>
  requires(W == 4 || W == 8)
[[gnu::always_inline]] inline Lane<double, W> inverse_root(Lane<double, W> const& x) {
  using L = Lane<double, W>;
  L r;
  if constexpr (W == 8)
    r = std::bit_cast<L>(_mm512_rsqrt14_pd(std::bit_cast<__m512d>(x)));
  else
    r = std::bit_cast<L>(_mm256_rsqrt14_pd(std::bit_cast<__m256d>(x)));
  L const half = 0.5 * x;
  r = r + r * (0.5 - half * r * r);
  return r + r * (0.5 - half * r * r);
}
#endif

}  // namespace rollerrig

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif
