// math/spline.hpp - piecewise cubic on uniform knots: value and derivatives by one index computation.
#pragma once
#include <algorithm>
#include <array>
#include <vector>

#include "rollerrig/scalar.hpp"

namespace rollerrig {

/// Value and derivatives of a curve at one abscissa.
template <Scalar T>
struct CurvePoint {
  T value;   ///< f
  T slope;   ///< f'
  T second;  ///< f''
};

/// Coefficients of the cubic over a step from values and slopes at its ends.
inline std::array<double, 4> hermite(double step, double f0, double f1, double m0, double m1) {
  double const jump = (f1 - f0) / step;
  return {f0, m0, (3.0 * jump - 2.0 * m0 - m1) / step, (m0 + m1 - 2.0 * jump) / (step * step)};
}

/// f(y) = c0 + c1 t + c2 t^2 + c3 t^3, t = y - (start + i step). Outside its domain the last piece is extrapolated; callers ask
/// contains() where that matters.
struct UniformSpline {
  double start{0.0};
  double step{1.0};
  std::vector<std::array<double, 4>> pieces;

  double end() const { return start + step * static_cast<double>(pieces.size()); }
  bool contains(double y) const { return y >= start && y <= end(); }

  int piece_of(double y) const {
    auto const last = static_cast<double>(pieces.size() - 1);
    double const position = (y - start) * (1.0 / step);
    return static_cast<int>(position > 0.0 ? std::min(position, last) : 0.0);  // not a number: piece 0
  }

  template <Scalar T>
  CurvePoint<T> at(T const& y) const {
    int const i = piece_of(value_of(y));
    auto const& c = pieces[static_cast<std::size_t>(i)];
    T const t = y - (start + step * i);
    return {((c[3] * t + c[2]) * t + c[1]) * t + c[0], (3.0 * c[3] * t + 2.0 * c[2]) * t + c[1],
            6.0 * c[3] * t + 2.0 * c[2]};
  }
};

}  // namespace rollerrig
