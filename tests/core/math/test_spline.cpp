#include <doctest/doctest.h>

#include "explicit_real.hpp"
#include "profiles.hpp"
#include "rollerrig/math/curves.hpp"
#include "rollerrig/math/dual.hpp"

using namespace rollerrig;
using test::ExplicitReal;

namespace {

/// One cubic, cut into pieces.
double cubic(double y) { return 2.0 - 3.0 * y + 0.5 * y * y - 4.0 * y * y * y; }

UniformSpline cut_cubic() {
  UniformSpline s{-1.0, 0.25, {}};
  for (int i = 0; i < 8; ++i) {
    double const y = -1.0 + 0.25 * i;
    s.pieces.push_back({cubic(y), -3.0 + y - 12.0 * y * y, 0.5 - 12.0 * y, -4.0});
  }
  return s;
}

}  // namespace

TEST_CASE("a spline reproduces the cubic it was cut from, with its derivatives, inside and outside") {
  UniformSpline const s = cut_cubic();
  for (double y : {-1.7, -1.0, -0.75, -0.3333, 0.0, 0.25, 0.999, 1.0, 1.4}) {
    auto const p = s.at(y);
    CHECK(p.value == doctest::Approx(cubic(y)).epsilon(1e-14));
    CHECK(p.slope == doctest::Approx(-3.0 + y - 12.0 * y * y).epsilon(1e-14));
    CHECK(p.second == doctest::Approx(1.0 - 24.0 * y).epsilon(1e-14));
  }
}

TEST_CASE("a spline knows its domain, ends included") {
  UniformSpline const s = cut_cubic();
  CHECK(s.end() == 1.0);
  CHECK(s.contains(-1.0));
  CHECK(s.contains(1.0));
  CHECK_FALSE(s.contains(-1.0001));
  CHECK_FALSE(s.contains(1.0001));
  CHECK(s.piece_of(-5.0) == 0);
  CHECK(s.piece_of(1.0) == 7);
  CHECK(s.piece_of(1e300) == 7);
  CHECK(s.piece_of(std::nan("")) == 0);
}

TEST_CASE("value, slope and second derivative of a profile are continuous across its knots") {
  auto const wheel = test::spline_of(test::s1002, -60e-3, 60e-3, 0.1e-3);
  for (std::size_t i = 1; i < wheel.pieces.size(); ++i) {
    auto const& c = wheel.pieces[i - 1];
    double const h = wheel.step;
    CHECK(c[0] + h * (c[1] + h * (c[2] + h * c[3])) == doctest::Approx(wheel.pieces[i][0]).epsilon(1e-12));
    CHECK(c[1] + h * (2.0 * c[2] + 3.0 * h * c[3]) == doctest::Approx(wheel.pieces[i][1]).epsilon(1e-10));
    // Second derivatives are up to 1e4 1/m near the flange; 1e-8 of that is the tridiagonal solve's round-off.
    CHECK(std::abs(2.0 * c[2] + 6.0 * h * c[3] - 2.0 * wheel.pieces[i][2]) < 1e-4);
  }
}

TEST_CASE("a dual abscissa carries the derivatives of the curve") {
  UniformSpline const s = cut_cubic();
  auto const p = s.at(Dual<1>::variable(0.3, 0));
  CHECK(p.value.d[0] == doctest::Approx(p.slope.value).epsilon(1e-15));
  CHECK(p.slope.d[0] == doctest::Approx(p.second.value).epsilon(1e-15));
  CHECK(p.second.d[0] == doctest::Approx(-24.0).epsilon(1e-15));
}

TEST_CASE("the spline holds for a scalar with no implicit conversions") {
  CHECK(cut_cubic().at(ExplicitReal(0.3)).value.x == cut_cubic().at(0.3).value);
}
