// contact/normal/strip_tables.hpp - what the strips of a region look up: influence of a strip on its neighbours, and Hertz.
//
//   strip kernel -> columns of influence over a/h;   Hertz' table -> start of the solution over ln(A/B)
//
// A column is what one strip, of half-length a and width h, does to the middles of the strips that lie k widths beside it,
// Psi((k + 1/2) h/a) - Psi((k - 1/2) h/a): a function of a/h alone, as cubic pieces with exact slopes, eight to an octave.
// Twelve strips are few. What they leave out is a function of ln(A/B) where the gap is a parabola, known from Hertz; force,
// half-lengths, width and peak pressure are multiplied by the ratio, so that Hertz' contact comes out exactly. (S14)
#pragma once
#include "rollerrig/contact/normal/hertz.hpp"
#include "rollerrig/contact/normal/strip_kernel.hpp"
#include "rollerrig/math/estimates.hpp"
#include "rollerrig/math/lane_spline.hpp"

namespace rollerrig {

inline constexpr std::size_t strip_count = 12;  ///< of a region

/// One number per strip.
template <class T>
using StripRow = std::array<T, strip_count>;

class StripColumns {
 public:
  enum class Kind { deflection, curvature };
  StripColumns(StripKernel const& kernel, Kind kind);

  /// @param over_width  a/h [-]
  template <class T>
  void read(T const& over_width, StripRow<T>& out) const;

 private:
  static constexpr int bits = 3, lowest_octave = -7, octaves = 20;
  struct alignas(64) Cell {
    std::array<StripRow<double>, 4> c;
  };
  std::vector<Cell> cells_;
};

/// Functions of x = ln(A/B) that a region starts from.
enum class StartFunction {
  conformity,     ///< q/A of Hertz' ellipse [-]
  length,         ///< a^2 (A + B) over the approach [-]
  edge,           ///< interpenetration at the ellipse's edge over the approach [-]
  force,          ///< exact over that of the strips, of a parabola [-]
  half_length,    ///< the same of a [-]
  half_width,     ///< the same of b [-]
  peak_pressure,  ///< the same [-]
  width,          ///< the same of the loaded width [-]
};

class StripTables {
 public:
  StripTables();
  StripColumns deflection, curvature;

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
  static constexpr int functions = 8, pieces = 256;
  using Piece = std::array<std::array<double, 4>, functions>;
  template <class F>
  void tabulate(StartFunction function, F const& f);
  std::array<Piece, pieces> pieces_{};
};

/// The tables, built once for all.
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

template <class T>
void StripColumns::read(T const& over_width, StripRow<T>& out) const {
  using N = NumberOf<T>;
  constexpr std::size_t lanes = static_cast<std::size_t>(lanes_of<N>);
  constexpr bool slopes = !std::same_as<T, N>;
  N const x = clamped(value_of(over_width), std::ldexp(1.0000001, lowest_octave),
                      std::ldexp(0.9999999, lowest_octave + octaves));
  alignas(64) std::array<std::array<double, strip_count>, lanes> value, slope;
  for (std::size_t k = 0; k < lanes; ++k) {
    // The exponent and the first bits of the mantissa number the cell.
    double const xk = lane(x, static_cast<int>(k));
    auto const word = std::bit_cast<std::uint64_t>(xk);
    auto const cell = static_cast<std::int64_t>(word >> (52 - bits)) - ((1023 + lowest_octave) * (1 << bits));
    double const t = xk - std::bit_cast<double>(word >> (52 - bits) << (52 - bits));
    auto const& c = cells_[static_cast<std::size_t>(cell)].c;
    for (std::size_t i = 0; i < strip_count; ++i) value[k][i] = ((c[3][i] * t + c[2][i]) * t + c[1][i]) * t + c[0][i];
    if constexpr (slopes)
      for (std::size_t i = 0; i < strip_count; ++i) slope[k][i] = (3.0 * c[3][i] * t + 2.0 * c[2][i]) * t + c[1][i];
  }
  if constexpr (lanes == 1) {
    for (std::size_t i = 0; i < strip_count; ++i) {
      if constexpr (slopes)
        out[i] = along(over_width, value[0][i], slope[0][i]);
      else
        out[i] = value[0][i];
    }
  } else {
    for (std::size_t i = 0; i < strip_count; i += 4) {
      RowsOf<N> row;
      for (std::size_t k = 0; k < lanes; ++k) row[k] = &value[k][i];
      auto const four = turned(row);
      for (std::size_t j = 0; j < 4; ++j) out[i + j] = four[j];
    }
  }
}

}  // namespace rollerrig
