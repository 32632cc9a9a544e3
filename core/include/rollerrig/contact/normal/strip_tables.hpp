// contact/normal/strip_tables.hpp - what the strips of a region look up: influence of a strip on its neighbours, and Hertz.
//
//   strip kernel;   Hertz' table -> start of the solution over ln(A/B)
//
// Few strips leave something out. It is a function of ln(A/B) where the gap is a paraboloid, known from Hertz; force,
// half-lengths, width and peak pressure are multiplied by the ratio, so that Hertz' contact comes out exactly. (S14)
#pragma once
#include "rollerrig/contact/normal/hertz.hpp"
#include "rollerrig/contact/normal/strip_kernel.hpp"
#include "rollerrig/math/estimates.hpp"
#include "rollerrig/math/lane_spline.hpp"

namespace rollerrig {

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

}  // namespace rollerrig
