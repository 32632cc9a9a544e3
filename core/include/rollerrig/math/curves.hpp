// math/curves.hpp - tables of points joined by straight lines, whose end slopes go on outside; cubics on uniform knots, and between
// breaks at any distance: value and derivatives.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "rollerrig/scalar.hpp"

namespace rollerrig {

struct PiecewiseLinear {
  std::vector<double> x;  ///< strictly increasing
  std::vector<double> y;

  bool empty() const { return x.empty(); }

  /// Index of the line that holds at u. At a corner the line to the right holds: that is where time goes.
  std::size_t line_of(double u) const {
    auto const after = std::upper_bound(x.begin(), x.end(), u) - x.begin();
    auto const last = static_cast<std::ptrdiff_t>(x.size()) - 2;
    return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(after - 1, 0, std::max<std::ptrdiff_t>(last, 0)));
  }

  double slope(double u) const {
    if (x.size() < 2) return 0.0;
    auto const i = line_of(u);
    return (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
  }

  template <Scalar T>
  T at(T const& u) const {
    if (x.empty()) return T(0.0);
    auto const i = line_of(value_of(u));
    return y[i] + slope(value_of(u)) * (u - x[i]);
  }

  /// Integral from 0 to u.
  double integral(double u) const {
    if (x.empty()) return 0.0;
    double const low = std::min(0.0, u);
    double const high = std::max(0.0, u);
    double sum = 0.0;
    double left = low;
    for (double corner : x) {
      if (corner <= left) continue;
      double const right = std::min(corner, high);
      sum += 0.5 * (right - left) * (at(left) + at(right));
      left = right;
      if (right >= high) break;
    }
    if (left < high) sum += 0.5 * (high - left) * (at(left) + at(high));
    return u < 0.0 ? -sum : sum;
  }
};

/// A quantity given over time: as PiecewiseLinear, but constant before the first and after the last point.
struct TimeTable {
  PiecewiseLinear points;

  bool empty() const { return points.empty(); }
  bool moving(double t) const { return points.x.size() > 1 && t >= points.x.front() && t < points.x.back(); }
  double rate(double t) const { return moving(t) ? points.slope(t) : 0.0; }

  template <Scalar T>
  T at(T const& t) const {
    if (points.empty()) return T(0.0);
    if (moving(value_of(t))) return points.at(t);
    return T(value_of(t) < points.x.front() ? points.y.front() : points.y.back());
  }

  /// Integral from 0 to t.
  double integral(double t) const { return points.empty() ? 0.0 : integral_to(t) - integral_to(0.0); }

 private:
  /// Integral from the first point to t.
  double integral_to(double t) const {
    double sum = points.y.front() * std::min(t - points.x.front(), 0.0);
    for (std::size_t i = 0; i + 1 < points.x.size() && points.x[i] < t; ++i) {
      double const end = std::min(t, points.x[i + 1]);
      sum += 0.5 * (end - points.x[i]) * (points.y[i] + at(end));
    }
    return sum + points.y.back() * std::max(t - points.x.back(), 0.0);
  }
};

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

/// Cubics between breaks at any distance, constant beyond both ends.
/// f(s) = c0 + c1 u + c2 u^2 + c3 u^3, u = s - start[i], from start[i] to start[i + 1]. Before the first break f keeps its
/// value there; from the last break on it is the last row's c0.
struct PiecewiseCubic {
  std::vector<double> start;  ///< strictly increasing
  std::vector<std::array<double, 4>> coefficient;

  bool empty() const { return start.empty(); }

  /// Index of the piece that holds at s, -1 before the first; at a break the piece that follows: there the vehicle goes.
  int piece_of(double s) const {
    return static_cast<int>(std::upper_bound(start.begin(), start.end(), s) - start.begin()) - 1;
  }
  bool is_last(int piece) const { return piece + 1 == static_cast<int>(start.size()); }

  template <Scalar T>
  CurvePoint<T> at(T const& s) const {
    if (empty()) return {T(0.0), T(0.0), T(0.0)};
    int const i = piece_of(value_of(s));
    if (i < 0) return {T(coefficient.front()[0]), T(0.0), T(0.0)};
    auto const& c = coefficient[static_cast<std::size_t>(i)];
    if (is_last(i)) return {T(c[0]), T(0.0), T(0.0)};
    T const u = s - start[static_cast<std::size_t>(i)];
    return {((c[3] * u + c[2]) * u + c[1]) * u + c[0], (3.0 * c[3] * u + 2.0 * c[2]) * u + c[1],
            6.0 * c[3] * u + 2.0 * c[2]};
  }

  /// The primitive of one piece from its start to s, for s within the piece.
  double primitive(int piece, double s) const {
    if (empty()) return 0.0;
    auto const i = static_cast<std::size_t>(std::max(piece, 0));
    double const u = s - start[i];
    auto const& c = coefficient[i];
    if (piece < 0 || is_last(piece)) return c[0] * u;
    return (((0.25 * c[3] * u + c[2] / 3.0) * u + 0.5 * c[1]) * u + c[0]) * u;
  }

  /// Where the piece ends; infinite for the last.
  double end_of(int piece) const;

  bool vanishes(double low, double high) const;
};

inline double PiecewiseCubic::end_of(int piece) const {
  auto const next = static_cast<std::size_t>(piece + 1);
  return next < start.size() ? start[next] : std::numeric_limits<double>::infinity();
}

inline bool PiecewiseCubic::vanishes(double low, double high) const {
  if (empty()) return true;
  for (int i = piece_of(low); i <= piece_of(high); ++i) {
    auto const& c = coefficient[static_cast<std::size_t>(std::max(i, 0))];
    if (c[0] != 0.0) return false;
    if (i >= 0 && !is_last(i) && (c[1] != 0.0 || c[2] != 0.0 || c[3] != 0.0)) return false;
  }
  return true;
}

}  // namespace rollerrig
