// math/lane.hpp - W numbers side by side in a vector register: the scalar of formulas that are evaluated for several wheels
// or patches at once.
//
// Arithmetic acts on every lane; a comparison gives a Mask, and select(mask, yes, no) chooses lane by lane. A formula written
// for any Scalar, without an `if` on a T, runs in lanes as it stands; a table is read with truncated() and gather(). The same
// source with T = double is width 1.
//
// Source  ISO/IEC TS 19570 (std::experimental::simd). Where the standard library lacks it lanes are one wide, and a Lane of 1
//         is a plain double.
#pragma once
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <tuple>
#include <type_traits>

#include "rollerrig/scalar.hpp"

#if defined(__has_include)
#if __has_include(<experimental/simd>)
#include <experimental/simd>
#endif
#endif
#if defined(__cpp_lib_experimental_parallel_simd) && defined(__GLIBCXX__)
#define ROLLERRIG_LANES 1
#else
#define ROLLERRIG_LANES 0
#endif
#if ROLLERRIG_LANES && defined(__AVX512F__) && defined(__AVX512VL__)
#define ROLLERRIG_ESTIMATES 1
#else
#define ROLLERRIG_ESTIMATES 0
#endif

// GCC 12 trips over its own vector intrinsics (`__m512d __Y = __Y;`) wherever they are inlined.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#endif

namespace rollerrig {

#if ROLLERRIG_LANES
namespace simd = std::experimental::parallelism_v2;

/// How many doubles one register of this build holds: 8 with AVX-512, 4 with AVX2, 2 with SSE2 or NEON.
constexpr int native_lanes = static_cast<int>(simd::native_simd<double>::size());

/// What a comparison of lanes answers.
template <int W>
struct Mask {
  using Register = simd::simd_mask<double, simd::simd_abi::deduce_t<double, W>>;
  Register v;

  friend Mask operator&&(Mask a, Mask b) { return {a.v && b.v}; }
  friend Mask operator||(Mask a, Mask b) { return {a.v || b.v}; }
  friend Mask operator!(Mask a) { return {!a.v}; }
  friend bool any(Mask a) { return simd::any_of(a.v); }
  friend bool all(Mask a) { return simd::all_of(a.v); }
  bool operator[](int i) const { return v[at(i)]; }
};

template <class Number, int W>
struct Lane;

template <int W>
struct Lane<double, W> {
  using Register = simd::simd<double, simd::simd_abi::deduce_t<double, W>>;
  Register v;

  Lane() = default;  ///< not set, as a double
  explicit Lane(double x) : v(x) {}
  explicit Lane(Register const& x) : v(x) {}

  /// From W numbers in memory.
  static Lane load(double const* x) { return Lane(Register(x, simd::element_aligned)); }
  static Lane load(float const* x) { return Lane(Register(x, simd::element_aligned)); }
  void store(double* x) const { v.copy_to(x, simd::element_aligned); }
  double operator[](int i) const { return v[at(i)]; }
  void set(int i, double x) { v[at(i)] = x; }

  Lane& operator+=(Lane const& b) { return v += b.v, *this; }
  Lane& operator-=(Lane const& b) { return v -= b.v, *this; }
  friend Lane operator-(Lane const& a) { return Lane(-a.v); }
  friend Lane operator+(Lane const& a, Lane const& b) { return Lane(a.v + b.v); }
  friend Lane operator-(Lane const& a, Lane const& b) { return Lane(a.v - b.v); }
  friend Lane operator*(Lane const& a, Lane const& b) { return Lane(a.v * b.v); }
  friend Lane operator/(Lane const& a, Lane const& b) { return Lane(a.v / b.v); }
  friend Lane operator+(Lane const& a, double b) { return Lane(a.v + Register(b)); }
  friend Lane operator+(double a, Lane const& b) { return Lane(Register(a) + b.v); }
  friend Lane operator-(Lane const& a, double b) { return Lane(a.v - Register(b)); }
  friend Lane operator-(double a, Lane const& b) { return Lane(Register(a) - b.v); }
  friend Lane operator*(Lane const& a, double b) { return Lane(a.v * Register(b)); }
  friend Lane operator*(double a, Lane const& b) { return Lane(Register(a) * b.v); }
  friend Lane operator/(Lane const& a, double b) { return Lane(a.v / Register(b)); }
  friend Lane operator/(double a, Lane const& b) { return Lane(Register(a) / b.v); }

  friend Mask<W> operator<(Lane const& a, Lane const& b) { return {a.v < b.v}; }
  friend Mask<W> operator>(Lane const& a, Lane const& b) { return {a.v > b.v}; }
  friend Mask<W> operator<(Lane const& a, double b) { return {a.v < Register(b)}; }
  friend Mask<W> operator>(Lane const& a, double b) { return {a.v > Register(b)}; }

  friend Lane sqrt(Lane const& a) { return Lane(Register(simd::sqrt(a.v))); }
  friend Lane abs(Lane const& a) { return Lane(Register(simd::abs(a.v))); }
  friend Lane min(Lane const& a, Lane const& b) { return Lane(simd::min(a.v, b.v)); }
  friend Lane max(Lane const& a, Lane const& b) { return Lane(simd::max(a.v, b.v)); }
  friend Lane log(Lane const& a) {
    return each(a, [](double x) { return std::log(x); });
  }
  friend Lane exp(Lane const& a) {
    return each(a, [](double x) { return std::exp(x); });
  }
  friend Lane sin(Lane const& a) {
    return each(a, [](double x) { return std::sin(x); });
  }
  friend Lane cos(Lane const& a) {
    return each(a, [](double x) { return std::cos(x); });
  }
  friend Lane atan2(Lane const& a, Lane const& b) {
    return Lane(Register([&](auto i) { return std::atan2(a.v[i], b.v[i]); }));
  }

  template <class F>
  friend Lane each(Lane const& a, F const& f) {
    return Lane(Register([&](auto i) { return f(a.v[i]); }));
  }
};

template <int W>
[[gnu::always_inline]] inline Lane<double, W> select(Mask<W> const& condition, Lane<double, W> const& yes,
                                                     Lane<double, W> const& no) {
  Lane<double, W> out = no;
  simd::where(condition.v, out.v) = yes.v;
  return out;
}

/// W numbers that are searched and decided with: the lanes themselves.
template <int W>
Lane<double, W> value_of(Lane<double, W> const& x) {
  return x;
}

template <class T>
constexpr int lanes_of = 1;
template <int W>
constexpr int lanes_of<Lane<double, W>> = W;
#else
constexpr int native_lanes = 1;
template <class T>
constexpr int lanes_of = 1;
#endif

/// The scalar of W cases at once.
template <int W>
struct LanesOf {
#if ROLLERRIG_LANES
  using type = Lane<double, W>;
#endif
};
template <>
struct LanesOf<1> {
  using type = double;
};
template <int W>
using Lanes = typename LanesOf<W>::type;

inline bool any(bool condition) { return condition; }
inline bool all(bool condition) { return condition; }

/// Numbers from memory, as many as there are lanes, and back.
template <class T, class Number>
T loaded(Number const* x) {
  if constexpr (lanes_of<T> == 1)
    return static_cast<T>(*x);
  else
    return T::load(x);
}
template <class T>
void store(T const& x, double* to) {
  if constexpr (lanes_of<T> == 1)
    *to = x;
  else
    x.store(to);
}

/// A place in a table, of every lane.
template <class T>
struct IndexOf {
  using type = int;
};
#if ROLLERRIG_LANES
template <int W>
struct IndexOf<Lane<double, W>> {
  using type = std::array<int, at(W)>;
};
#endif
template <class T>
using Index = typename IndexOf<T>::type;

/// Towards zero; within +-2^31.
inline int truncated(double x) { return static_cast<int>(x); }
/// table[stride i].
inline double gather(double const* table, int i, int stride = 1) { return table[stride * i]; }

#if ROLLERRIG_LANES
template <int W>
[[gnu::always_inline]] inline Index<Lane<double, W>> truncated(Lane<double, W> const& x) {
  Index<Lane<double, W>> out;
  simd::static_simd_cast<simd::fixed_size_simd<int, W>>(x.v).copy_to(out.data(), simd::element_aligned);
  return out;
}
template <std::size_t W>
[[gnu::always_inline]] inline Lane<double, static_cast<int>(W)> gather(double const* table, std::array<int, W> const& i,
                                                                       int stride = 1) {
  using L = Lane<double, static_cast<int>(W)>;
  return L(typename L::Register([&](auto k) { return table[stride * i[k]]; }));
}

/// A struct that has nothing but lanes, as W structs of numbers.
template <template <class> class S, int W>
std::array<S<double>, at(W)> one_by_one(S<Lane<double, W>> const& s) {
  using L = Lane<double, W>;
  constexpr std::size_t n = sizeof(S<double>) / sizeof(double);
  static_assert(sizeof(S<L>) == n * sizeof(L));
  auto const* lanes = reinterpret_cast<L const*>(&s);  // a lane wider than a register has no bit_cast
  std::array<std::array<double, n>, at(W)> numbers;
  for (std::size_t f = 0; f < n; ++f)
    for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k][f] = lanes[f][static_cast<int>(k)];
  return std::bit_cast<std::array<S<double>, at(W)>>(numbers);
}

/// The other way round.
template <template <class> class S, std::size_t W>
S<Lane<double, static_cast<int>(W)>> side_by_side(std::array<S<double>, W> const& one) {
  using L = Lane<double, static_cast<int>(W)>;
  constexpr std::size_t n = sizeof(S<double>) / sizeof(double);
  auto const numbers = std::bit_cast<std::array<std::array<double, n>, W>>(one);
  static_assert(sizeof(S<L>) == n * sizeof(L));
  S<L> out;
  auto* lanes = reinterpret_cast<L*>(&out);
  for (std::size_t f = 0; f < n; ++f) lanes[f] = L(typename L::Register([&](auto k) { return numbers[k][f]; }));
  return out;
}

/// Calls a function of numbers lane by lane; not again where a lane repeats the one before, as those behind the last case do.
template <template <class> class Out, int W, class F, template <class> class... In>
Out<Lane<double, W>> each_lane(F const& f, In<Lane<double, W>> const&... in) {
  return std::apply(
      [&](auto const&... one) {
        auto const same = [](auto const& a, auto const& b) { return std::memcmp(&a, &b, sizeof(a)) == 0; };
        std::array<Out<double>, at(W)> out;
        for (std::size_t k = 0; k < out.size(); ++k)
          out[k] = k > 0 && (same(one[k], one[k - 1]) && ...) ? out[k - 1] : f(one[k]...);
        return side_by_side(out);
      },
      std::tuple{one_by_one(in)...});
}
#else
template <template <class> class Out, class... Any>
auto each_lane(Any const&... any);
#endif

// 1/x and 1/sqrt(x) without the processor's units for division and roots, which are the narrow place where every operation acts on
// eight numbers: its estimate of 14 bits and two steps of Newton, to the last digit but one. Where there is no such estimate, and
// for plain and dual numbers, they are what they say. Source: any text on division by Newton's method; error below 2 units in the
// last place, tested.

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

/// The number inside a scalar.
template <class T>
using NumberOf = std::remove_cvref_t<decltype(value_of(std::declval<T const&>()))>;

inline double lane(double x, int) { return x; }

}  // namespace rollerrig

#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif
