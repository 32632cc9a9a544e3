// math/lane_spline.hpp - one spline per lane: rows of tables that each lane reads at a place of its own.
//
// N is what is looked up with: double, or lanes of it. T is what is computed: N, or a dual number of which N is the value.
#pragma once
#include <bit>
#include <cstring>

#include "rollerrig/math/curves.hpp"
#include "rollerrig/math/lane.hpp"

namespace rollerrig {

inline void set_lane(double& x, int, double value) { x = value; }
/// Within the limits; the lower one if it is not a number.
inline double clamped(double x, double low, double high) { return x > low ? std::min(x, high) : low; }
inline bool lane(bool x, int) { return x; }
/// Towards zero.
inline double whole(double x) { return std::trunc(x); }
#if ROLLERRIG_LANES
template <int W>
double lane(Lane<double, W> const& x, int i) {
  return x[i];
}
template <int W>
void set_lane(Lane<double, W>& x, int i, double value) {
  x.set(i, value);
}
template <int W>
[[gnu::always_inline]] inline Lane<double, W> whole(Lane<double, W> const& x) {
  return Lane<double, W>(typename Lane<double, W>::Register(simd::trunc(x.v)));
}
template <int W>
bool lane(Mask<W> const& x, int i) {
  return x[i];
}
template <int W>
[[gnu::always_inline]] inline Lane<double, W> clamped(Lane<double, W> const& x, Lane<double, W> const& low,
                                                      Lane<double, W> const& high) {
  return min(select(x > low, x, low), high);
}
template <int W>
[[gnu::always_inline]] inline Lane<double, W> clamped(Lane<double, W> const& x, double low, double high) {
  return clamped(x, Lane<double, W>(low), Lane<double, W>(high));
}
#endif

/// f(x) from value and slope at its number, with what derivatives x carries.
template <class T>
[[gnu::always_inline]] inline T along(T const& x, NumberOf<T> const& value, NumberOf<T> const& slope) {
  if constexpr (std::same_as<T, NumberOf<T>>)
    return value;
  else
    return value + slope * (x - value_of(x));
}

template <class N>
using RowsOf = std::array<double const*, static_cast<std::size_t>(lanes_of<N>)>;

/// Four neighbouring numbers per lane, turned into four lanes: row[k][i] becomes out[i][k].
inline std::array<double, 4> turned(std::array<double const*, 1> const& row) {
  return {row[0][0], row[0][1], row[0][2], row[0][3]};
}
#if ROLLERRIG_LANES
namespace lane_detail {
#if defined(__GNUC__) && defined(__has_builtin)
#if __has_builtin(__builtin_shufflevector)
#define ROLLERRIG_SHUFFLES 1
typedef double Four __attribute__((vector_size(32)));
typedef double Eight __attribute__((vector_size(64)));

/// Rows of four by four, turned.
[[gnu::always_inline]] inline std::array<Four, 4> turn_four(double const* const* row) {
  Four a, b, c, d;
  std::memcpy(&a, row[0], sizeof(a));
  std::memcpy(&b, row[1], sizeof(b));
  std::memcpy(&c, row[2], sizeof(c));
  std::memcpy(&d, row[3], sizeof(d));
  Four const ab_even = __builtin_shufflevector(a, b, 0, 4, 2, 6), ab_odd = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  Four const cd_even = __builtin_shufflevector(c, d, 0, 4, 2, 6), cd_odd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  return {__builtin_shufflevector(ab_even, cd_even, 0, 1, 4, 5), __builtin_shufflevector(ab_odd, cd_odd, 0, 1, 4, 5),
          __builtin_shufflevector(ab_even, cd_even, 2, 3, 6, 7), __builtin_shufflevector(ab_odd, cd_odd, 2, 3, 6, 7)};
}
#endif
#endif
}  // namespace lane_detail

template <std::size_t W>
  requires(W > 1)
[[gnu::always_inline]] inline std::array<Lane<double, static_cast<int>(W)>, 4> turned(
    std::array<double const*, W> const& row) {
  using L = Lane<double, static_cast<int>(W)>;
  std::array<L, 4> out;
#if defined(ROLLERRIG_SHUFFLES)
  if constexpr (W == 4) {
    auto const t = lane_detail::turn_four(row.data());
    for (std::size_t i = 0; i < 4; ++i) out[i] = std::bit_cast<L>(t[i]);
    return out;
  } else if constexpr (W == 8) {
    auto const a = lane_detail::turn_four(row.data()), b = lane_detail::turn_four(row.data() + 4);
    for (std::size_t i = 0; i < 4; ++i) {
      lane_detail::Eight const both = __builtin_shufflevector(a[i], b[i], 0, 1, 2, 3, 4, 5, 6, 7);
      out[i] = std::bit_cast<L>(both);
    }
    return out;
  }
#endif
  for (std::size_t i = 0; i < 4; ++i) out[i] = L(typename L::Register([&](auto k) { return row[k][i]; }));
  return out;
}
#endif

/// Where a table is read: its row and the number of that row.
template <class N>
struct TablePlace {
  Index<N> index;
  N number;
};
template <class N>
[[gnu::always_inline]] inline TablePlace<N> table_place(N const& position) {
  TablePlace<N> out;
  out.index = truncated(position);
  out.number = whole(position);
  return out;
}
inline int index_in(int index, std::size_t) { return index; }
template <std::size_t W>
int index_in(std::array<int, W> const& index, std::size_t k) {
  return index[k];
}

/// UniformSpline, one per lane.
template <class N>
struct LaneSpline {
  static constexpr int lanes = lanes_of<N>;
  RowsOf<N> first{};  ///< of each lane's coefficients
  N start{0.0}, step{1.0}, inverse_step{1.0}, last{0.0};

  void set(int i, UniformSpline const& spline) {
    first[static_cast<std::size_t>(i)] = spline.pieces.data()->data();
    set_lane(start, i, spline.start);
    set_lane(step, i, spline.step);
    set_lane(inverse_step, i, 1.0 / spline.step);
    set_lane(last, i, static_cast<double>(spline.pieces.size() - 1));
  }

  void set_all(UniformSpline const& spline) {
    first.fill(spline.pieces.data()->data());
    start = N(spline.start), step = N(spline.step), inverse_step = N(1.0 / spline.step);
    last = N(static_cast<double>(spline.pieces.size() - 1));
  }

  /// The piece that holds at y: its coefficients, and where it starts.
  struct Piece {
    std::array<N, 4> c;
    N origin;

    template <class T>
    [[gnu::always_inline]] CurvePoint<T> at(T const& y) const {
      N const t = value_of(y) - origin;
      N const value = ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
      N const slope = (3.0 * c[3] * t + 2.0 * c[2]) * t + c[1];
      N const second = 6.0 * c[3] * t + 2.0 * c[2];
      return {along(y, value, slope), along(y, slope, second), along(y, second, N(6.0 * c[3]))};
    }
    template <class T>
    [[gnu::always_inline]] T value(T const& y) const {
      N const t = value_of(y) - origin;
      N const slope = (3.0 * c[3] * t + 2.0 * c[2]) * t + c[1];
      return along(y, N(((c[3] * t + c[2]) * t + c[1]) * t + c[0]), slope);
    }
  };
  [[gnu::always_inline]] Piece piece(N const& y) const {
    auto const place = table_place(clamped(N((y - start) * inverse_step), N(0.0), last));
    RowsOf<N> row;
    for (std::size_t k = 0; k < row.size(); ++k) row[k] = first[k] + 4 * index_in(place.index, k);
    return {turned(row), start + step * place.number};
  }
  template <class T>
  [[gnu::always_inline]] CurvePoint<T> at(T const& y) const {
    return piece(value_of(y)).at(y);
  }
  template <class T>
  [[gnu::always_inline]] T value(T const& y) const {
    return piece(value_of(y)).value(y);
  }
  N end() const { return start + step * (last + 1.0); }
  auto contains(N const& y) const { return (y > start - 1e-12) && (y < end() + 1e-12); }
};

}  // namespace rollerrig
