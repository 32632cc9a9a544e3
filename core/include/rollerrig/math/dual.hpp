// math/dual.hpp - a number that carries its derivatives with respect to N seeds (forward automatic differentiation).
//
// x = value + sum_i d_i e_i with e_i e_j = 0. Comparison looks at the value only.
// The derivative part is an Eigen array of fixed size, so it lives in registers and vectorises.
#pragma once
#include <Eigen/Core>

#include "rollerrig/scalar.hpp"

namespace rollerrig {

template <int N>
struct Dual {
  using Gradient = Eigen::Array<double, N, 1>;
  double value{0.0};
  Gradient d{Gradient::Zero()};

  Dual() = default;
  explicit Dual(double constant) : value{constant} {}
  Dual(double v, Gradient const& gradient) : value{v}, d{gradient} {}

  /// The independent variable number `seed`.
  static Dual variable(double v, int seed) {
    Dual x(v);
    x.d[seed] = 1.0;
    return x;
  }

  Dual& operator+=(Dual const& b) { return value += b.value, d += b.d, *this; }
  Dual& operator-=(Dual const& b) { return value -= b.value, d -= b.d, *this; }

  friend Dual operator-(Dual const& a) { return {-a.value, -a.d}; }
  friend Dual operator+(Dual const& a, Dual const& b) { return {a.value + b.value, a.d + b.d}; }
  friend Dual operator-(Dual const& a, Dual const& b) { return {a.value - b.value, a.d - b.d}; }
  friend Dual operator*(Dual const& a, Dual const& b) { return {a.value * b.value, a.d * b.value + b.d * a.value}; }
  friend Dual operator/(Dual const& a, Dual const& b) {
    double const inverse = 1.0 / b.value;
    double const quotient = a.value * inverse;
    return {quotient, (a.d - b.d * quotient) * inverse};
  }

  friend Dual operator+(Dual const& a, double b) { return {a.value + b, a.d}; }
  friend Dual operator+(double a, Dual const& b) { return {a + b.value, b.d}; }
  friend Dual operator-(Dual const& a, double b) { return {a.value - b, a.d}; }
  friend Dual operator-(double a, Dual const& b) { return {a - b.value, -b.d}; }
  friend Dual operator*(Dual const& a, double b) { return {a.value * b, a.d * b}; }
  friend Dual operator*(double a, Dual const& b) { return {a * b.value, b.d * a}; }
  friend Dual operator/(Dual const& a, double b) { return a * (1.0 / b); }
  friend Dual operator/(double a, Dual const& b) {
    double const quotient = a / b.value;
    return {quotient, b.d * (-quotient / b.value)};
  }

  friend bool operator<(Dual const& a, Dual const& b) { return a.value < b.value; }
  friend bool operator>(Dual const& a, Dual const& b) { return a.value > b.value; }
  friend bool operator<(Dual const& a, double b) { return a.value < b; }
  friend bool operator>(Dual const& a, double b) { return a.value > b; }

  friend Dual sqrt(Dual const& a) {
    double const root = std::sqrt(a.value);
    return {root, a.d * (0.5 / root)};
  }
  friend Dual sin(Dual const& a) { return {std::sin(a.value), a.d * std::cos(a.value)}; }
  friend Dual cos(Dual const& a) { return {std::cos(a.value), a.d * -std::sin(a.value)}; }
  friend Dual log(Dual const& a) { return {std::log(a.value), a.d / a.value}; }
  friend Dual exp(Dual const& a) {
    double const power = std::exp(a.value);
    return {power, a.d * power};
  }
  friend Dual asin(Dual const& a) { return {std::asin(a.value), a.d / std::sqrt(1.0 - a.value * a.value)}; }
  friend Dual atan2(Dual const& y, Dual const& x) {
    double const r2 = x.value * x.value + y.value * y.value;
    return {std::atan2(y.value, x.value), (y.d * x.value - x.d * y.value) / r2};
  }
};

template <int N>
double value_of(Dual<N> const& x) {
  return x.value;
}

/// The seeds used by the system's Jacobian: enough for one wheelset and its roller in one sweep.
using JacobianDual = Dual<16>;

}  // namespace rollerrig
