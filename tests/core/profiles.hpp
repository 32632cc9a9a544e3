// Profiles for the tests, from their published definitions, as the splines the core reads.
#pragma once
#include <cmath>
#include <vector>

#include "rollerrig/geometry/pair.hpp"

namespace rollerrig::test {

/// Natural cubic spline through f at uniform knots.
template <class F>
UniformSpline spline_of(F const& f, double start, double end, double step) {
  auto const n = static_cast<std::size_t>(std::lround((end - start) / step));
  std::vector<double> value(n + 1), second(n + 1, 0.0), ratio(n + 1, 0.0);
  for (std::size_t i = 0; i <= n; ++i) value[i] = f(start + step * static_cast<double>(i));
  for (std::size_t i = 1; i < n; ++i) {
    double const right = 6.0 * (value[i + 1] - 2.0 * value[i] + value[i - 1]) / (step * step);
    double const pivot = 4.0 - ratio[i - 1];
    ratio[i] = 1.0 / pivot;
    second[i] = (right - second[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i >= 1; --i) second[i] -= ratio[i] * second[i + 1];
  UniformSpline spline{start, step, {}};
  for (std::size_t i = 0; i < n; ++i)
    spline.pieces.push_back({value[i],
                             (value[i + 1] - value[i]) / step - step * (2.0 * second[i] + second[i + 1]) / 6.0,
                             0.5 * second[i], (second[i + 1] - second[i]) / (6.0 * step)});
  return spline;
}

/// S1002 of EN 13715, flange included: radius increase over the abscissa [m].
inline double s1002(double abscissa) {
  double const s = 1e3 * abscissa;
  auto const polynomial = [s](std::initializer_list<double> from_highest) {
    double sum = 0.0;
    for (double c : from_highest) sum = sum * s + c;
    return sum;
  };
  double z = 0.0;
  if (s >= 32.15796)
    z = 1.364323640 - 0.066666667 * s;
  else if (s >= -26.0)
    z = polynomial({2.646656573e-13, -5.957839843e-12, 5.309217349e-15, -1.562379023e-8, 5.844240864e-8,
                    -2.810427944e-5, 1.565681624e-3, -3.358537058e-2, 0.0});
  else if (s >= -35.0)
    z = polynomial({-2.252755540e-7, -4.687195829e-5, -4.169739389e-3, -2.054332446e-1, -6.051367875, -1.065501873e2,
                    -1.038384026e3, -4.320221063e3});
  else if (s >= -38.426669071)
    z = 16.446 - std::sqrt(13.0 * 13.0 - (s + 26.210665) * (s + 26.210665));
  else if (s >= -39.764473993)
    z = -93.576667419 - 2.747477419 * s;
  else if (s >= -49.662510381)
    z = 8.834924130 + std::sqrt(20.0 * 20.0 - (s + 58.558326413) * (s + 58.558326413));
  else
    z = 16.0 + std::sqrt(12.0 * 12.0 - (s + 55.0) * (s + 55.0));
  return 1e-3 * z;
}

/// Rail head of arcs R300, R80, R13 (UIC60 of the Manchester contact benchmark) inclined 1:40; height over the abscissa
/// from the highest point [m].
inline double uic60(double abscissa) {
  double const y = 1e3 * abscissa;
  double const tilt = std::atan(1.0 / 40.0);
  double const a1 = std::asin(10.5 / 300.0);
  double const y80 = 220.0 * std::sin(a1), z80 = -300.0 + 220.0 * std::cos(a1);
  double const a2 = std::asin((25.98803 - y80) / 80.0);
  double const y13 = y80 + 67.0 * std::sin(a2), z13 = z80 + 67.0 * std::cos(a2);
  // Positions from the centre of the crown's arc, turned.
  auto const turned_y = [&](double u, double v) { return u * std::cos(tilt) - (v + 300.0) * std::sin(tilt); };
  auto const turned_z = [&](double u, double v) { return u * std::sin(tilt) + (v + 300.0) * std::cos(tilt) - 300.0; };
  auto const arc = [&](double u, double v, double radius) {
    double const d = y - turned_y(u, v);
    return turned_z(u, v) + std::sqrt(radius * radius - d * d);
  };
  double const z1 = -300.0 + 300.0 * std::cos(a1), z2 = z80 + 80.0 * std::cos(a2);
  double const y2 = 25.98803;
  double z = 0.0;
  if (y < turned_y(-y2, z2))
    z = arc(-y13, z13, 13.0);
  else if (y < turned_y(-10.5, z1))
    z = arc(-y80, z80, 80.0);
  else if (y < turned_y(10.5, z1))
    z = arc(0.0, -300.0, 300.0);
  else if (y < turned_y(y2, z2))
    z = arc(y80, z80, 80.0);
  else
    z = arc(y13, z13, 13.0);
  return 1e-3 * z;
}

/// S1002 on the inclined head, back-to-back 1360 mm, gauge 1435 mm; kept alive with its splines.
struct BenchmarkPair {
  UniformSpline wheel = spline_of(s1002, -60e-3, 60e-3, 0.1e-3);
  UniformSpline rail = spline_of(uic60, -42.8e-3, 28.5e-3, 0.05e-3);
  WheelRollerPair pair{};

  explicit BenchmarkPair(double inverse_radius) { pair = {&wheel, &rail, 0.46, 0.75, 0.7605385, inverse_radius}; }
  BenchmarkPair(BenchmarkPair const&) = delete;
  BenchmarkPair& operator=(BenchmarkPair const&) = delete;
};

/// Pose of a wheelset that stands `height` above the crown level [m], R = Rz(yaw) Rx(roll).
template <Scalar T>
RelativePose<T> pose_of(T const& x, T const& y, T const& height, T const& roll, T const& yaw) {
  using std::cos;
  using std::sin;
  T const sr = sin(roll), cr = cos(roll), sy = sin(yaw), cy = cos(yaw);
  return {{x, y, height}, {{cy, sy, T(0.0)}, {-(sy * cr), cy * cr, sr}, {sy * sr, -(cy * sr), cr}}};
}

}  // namespace rollerrig::test
