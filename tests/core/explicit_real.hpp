// A double that refuses to become, or to be built from, a double by accident. Mixed arithmetic with double is what formulas
// may use (parameters stay double); anything else they ask for does not compile.
#pragma once
#include <cmath>

#include "rollerrig/scalar.hpp"

namespace rollerrig::test {

struct ExplicitReal {
  double x{0.0};
  ExplicitReal() = default;
  explicit constexpr ExplicitReal(double value) : x{value} {}

  ExplicitReal& operator+=(ExplicitReal b) { return *this = ExplicitReal(x + b.x); }
  ExplicitReal& operator-=(ExplicitReal b) { return *this = ExplicitReal(x - b.x); }
  friend ExplicitReal operator-(ExplicitReal a) { return ExplicitReal(-a.x); }

  friend ExplicitReal operator+(ExplicitReal a, ExplicitReal b) { return ExplicitReal(a.x + b.x); }
  friend ExplicitReal operator-(ExplicitReal a, ExplicitReal b) { return ExplicitReal(a.x - b.x); }
  friend ExplicitReal operator*(ExplicitReal a, ExplicitReal b) { return ExplicitReal(a.x * b.x); }
  friend ExplicitReal operator/(ExplicitReal a, ExplicitReal b) { return ExplicitReal(a.x / b.x); }
  friend ExplicitReal operator+(ExplicitReal a, double b) { return ExplicitReal(a.x + b); }
  friend ExplicitReal operator+(double a, ExplicitReal b) { return ExplicitReal(a + b.x); }
  friend ExplicitReal operator-(ExplicitReal a, double b) { return ExplicitReal(a.x - b); }
  friend ExplicitReal operator-(double a, ExplicitReal b) { return ExplicitReal(a - b.x); }
  friend ExplicitReal operator*(ExplicitReal a, double b) { return ExplicitReal(a.x * b); }
  friend ExplicitReal operator*(double a, ExplicitReal b) { return ExplicitReal(a * b.x); }
  friend ExplicitReal operator/(ExplicitReal a, double b) { return ExplicitReal(a.x / b); }
  friend ExplicitReal operator/(double a, ExplicitReal b) { return ExplicitReal(a / b.x); }

  friend bool operator<(ExplicitReal a, ExplicitReal b) { return a.x < b.x; }
  friend bool operator>(ExplicitReal a, ExplicitReal b) { return a.x > b.x; }
  friend bool operator<(ExplicitReal a, double b) { return a.x < b; }
  friend bool operator>(ExplicitReal a, double b) { return a.x > b; }
  friend bool operator==(ExplicitReal a, ExplicitReal b) { return a.x == b.x; }

  friend ExplicitReal sqrt(ExplicitReal a) { return ExplicitReal(std::sqrt(a.x)); }
  friend ExplicitReal sin(ExplicitReal a) { return ExplicitReal(std::sin(a.x)); }
  friend ExplicitReal cos(ExplicitReal a) { return ExplicitReal(std::cos(a.x)); }
  friend ExplicitReal log(ExplicitReal a) { return ExplicitReal(std::log(a.x)); }
  friend ExplicitReal exp(ExplicitReal a) { return ExplicitReal(std::exp(a.x)); }
  friend ExplicitReal asin(ExplicitReal a) { return ExplicitReal(std::asin(a.x)); }
  friend ExplicitReal atan2(ExplicitReal a, ExplicitReal b) { return ExplicitReal(std::atan2(a.x, b.x)); }
  friend double value_of(ExplicitReal a) { return a.x; }
};

static_assert(Scalar<ExplicitReal>);

}  // namespace rollerrig::test
