// math/piecewise_linear.hpp - a table of points joined by straight lines; the end slopes go on outside.
#pragma once
#include <algorithm>
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

}  // namespace rollerrig
