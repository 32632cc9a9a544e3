// contact/normal/strip_tables.hpp - what the strips of a region look up: influence of a strip on its neighbours, and Hertz.
//
//   strip kernel;   Hertz' table -> start of the solution over ln(A/B)
//
// Few strips leave something out. It is a function of ln(A/B) where the gap is a paraboloid, known from Hertz; force,
// half-lengths, width and peak pressure are multiplied by the ratio, so that Hertz' contact comes out exactly. (S14)
#pragma once
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

#include "rollerrig/contact/normal/hertz.hpp"
#include "rollerrig/math/lane.hpp"
#include "rollerrig/math/lane_spline.hpp"

namespace rollerrig {

/// What a strip of pressure does to a half-space, as functions of distance over half-length.
///
/// A strip lies along the rolling direction x at y = 0: pressure semi-elliptic in x over |x| < a, line load w [N/m of y].
/// The surface at x = 0, a distance y beside it, deflects by (Q/pi) w psi(y/a) / a and is curved along x by
/// (Q/pi) w chi(y/a) / a^3. A strip of finite width is the integral over y; this table holds both integrals,
///
///     Psi(k) = int_0^k psi,   psi(k) = (4/pi) sqrt(1+k^2) (K - E)
///     Chi(k) = int_0^k chi = (4/pi) k/sqrt(1+k^2) K,   chi(k) = psi(k) / (1+k^2)          (S1), (S2)
///
/// with complete elliptic integrals K, E of modulus 1/sqrt(1+k^2). Both are odd. Cubic pieces, eight to an octave of k.
/// Other strips lie half a width away or more: over them psi and chi need no integral, but its mean over the width, which is
/// psi in the middle and what the logarithm in it adds.
/// Source: Boussinesq's point load, integrated; docs/theory/non_elliptic_contact.md.
class StripKernel {
 public:
  StripKernel();

  using Cubic = std::array<double, 4>;  ///< coefficients of the distance from the start of a piece
  /// What is tabulated over k.
  enum class Function { own_deflection, own_curvature, deflection };  // Psi, Chi, psi

  /// @param k  positive
  template <class T>
  T read(Function function, T const& k) const;

 private:
  static constexpr int lowest_octave = -16, octaves = 44;
  static constexpr double farthest = 1.0e8;  ///< below the end of the table

  std::array<std::vector<Cubic>, 3> cells_;  ///< the first one from zero
};

template <class T>
[[gnu::always_inline]] inline T StripKernel::read(Function function, T const& k) const {
  using N = NumberOf<T>;
  constexpr auto lanes = at(lanes_of<N>);
  Cubic const* const table = cells_[at(function)].data();
  N const x = clamped(value_of(k), std::ldexp(1.0, lowest_octave), farthest);
  alignas(64) std::array<double, lanes> number;
  store(x, number.data());
  // The exponent and the first three bits of the mantissa number the piece; without the other bits it is its start.
  alignas(64) std::array<std::uint64_t, lanes> bits;
  std::memcpy(bits.data(), number.data(), sizeof(bits));
  for (auto& b : bits) b >>= 49;
  RowsOf<N> row;
  for (std::size_t i = 0; i < lanes; ++i) row[i] = (table + (bits[i] - (8 * (1023 + lowest_octave) - 1)))->data();
  for (auto& b : bits) b <<= 49;
  std::memcpy(number.data(), bits.data(), sizeof(bits));
  N const t = x - loaded<N>(number.data());
  auto const c = turned(row);
  N const value = ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
  if constexpr (std::same_as<T, N>)
    return value;
  else
    return along(k, value, N((3.0 * c[3] * t + 2.0 * c[2]) * t + c[1]));
}

inline constexpr std::size_t strip_count = 16;  ///< of a region
inline constexpr int strip_passes = 4;          ///< of their solution

/// One number per strip.
template <class T, std::size_t n = strip_count>
using StripRow = std::array<T, n>;

/// Functions of x = ln(A/B).
enum class StartFunction {
  length,         ///< a^2 (A + B) over the approach [-]
  breadth,        ///< b^2 (A + B) over the approach [-]
  force,          ///< exact over that of the strips, of a parabola [-]
  half_length,    ///< the same of a [-]
  half_width,     ///< the same of b [-]
  peak_pressure,  ///< the same [-]
  width,          ///< the same of the loaded width [-]
};

class StripTables {
 public:
  StripTables();
  StripKernel kernel;

  /// Where all functions are read. Beyond Hertz' limits the end values hold.
  template <class T>
  struct Place {
    T x;
    RowsOf<NumberOf<T>> row;
    NumberOf<T> t, inside;  ///< from the piece's start; 1, 0 beyond the limits
  };
  /// @param x  ln(A/B)
  template <class T>
  Place<T> place(T const& x) const;
  template <class T>
  T at(StartFunction function, Place<T> const& place) const;

 private:
  static constexpr int functions = 7, pieces = 256;
  using Piece = std::array<std::array<double, 4>, functions>;
  template <class F>
  void tabulate(StartFunction function, F const& f);
  std::array<Piece, pieces> pieces_{};
};

StripTables const& strip_tables();

template <class T>
StripTables::Place<T> StripTables::place(T const& x) const {
  using N = NumberOf<T>;
  double const end = std::log(HertzTable::limit), step = 2.0 * end / pieces;
  Place<T> out{x, {}, N(0.0), N(1.0)};
  N const number = value_of(x);
  N const within = clamped(number, -end, end);
  auto const cell = table_place(clamped(N((within + end) * (1.0 / step)), 0.0, pieces - 1.0));
  for (std::size_t k = 0; k < out.row.size(); ++k)
    out.row[k] = pieces_[static_cast<std::size_t>(index_in(cell.index, k))].data()->data();
  out.t = within + end - step * cell.number;
  out.inside = select(number < within || number > within, N(0.0), N(1.0));
  return out;
}

template <class T>
T StripTables::at(StartFunction function, Place<T> const& place) const {
  using N = NumberOf<T>;
  RowsOf<N> row;
  for (std::size_t k = 0; k < row.size(); ++k) row[k] = place.row[k] + 4 * static_cast<int>(function);
  auto const c = turned(row);
  N const& t = place.t;
  return along(place.x, N(((c[3] * t + c[2]) * t + c[1]) * t + c[0]),
               N(place.inside * ((3.0 * c[3] * t + 2.0 * c[2]) * t + c[1])));
}

}  // namespace rollerrig
