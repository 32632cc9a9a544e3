#include <doctest/doctest.h>

#include "rollerrig/math/curves.hpp"
#include "rollerrig/math/dual.hpp"

using namespace rollerrig;

namespace {

/// A bumpstop: 25 mm free, then stiffening; forces at corners of physics known by heart.
PiecewiseLinear bumpstop() { return {{-0.03, -0.025, 0.025, 0.03, 0.035}, {-600.0, 0.0, 0.0, 600.0, 1760.0}}; }

double numerical_integral(PiecewiseLinear const& table, double u) {
  int const n = 200000;
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += table.at(u * (i + 0.5) / n);
  return sum * u / n;
}

}  // namespace

TEST_CASE("a table is joined by straight lines and its end slopes go on") {
  auto const t = bumpstop();
  CHECK(t.at(0.0) == 0.0);
  CHECK(t.at(0.0275) == doctest::Approx(300.0));
  CHECK(t.at(0.030) == doctest::Approx(600.0));
  CHECK(t.at(0.040) == doctest::Approx(1760.0 + 1160.0));
  CHECK(t.at(-0.035) == doctest::Approx(-1200.0));
  CHECK(t.slope(0.03) == doctest::Approx(1160.0 / 0.005));  // at a corner the line to the right
  CHECK(t.at(Dual<1>::variable(0.0275, 0)).d[0] == doctest::Approx(600.0 / 0.005));
}

TEST_CASE("an empty table is zero, a table of one point constant") {
  PiecewiseLinear const none;
  CHECK(none.at(3.0) == 0.0);
  CHECK(none.integral(3.0) == 0.0);
  PiecewiseLinear const one{{2.0}, {5.0}};
  CHECK(one.at(-1.0) == 5.0);
  CHECK(one.slope(7.0) == 0.0);
  CHECK(one.integral(4.0) == doctest::Approx(20.0));
  CHECK(one.integral(-4.0) == doctest::Approx(-20.0));
}

TEST_CASE("the integral from zero is that of the lines, to either side and beyond the ends") {
  auto const t = bumpstop();
  for (double u : {-0.05, -0.0301, -0.0275, -0.01, 0.0, 0.02, 0.0275, 0.0333, 0.05}) {
    CAPTURE(u);
    // The midpoint sum is exact on each line; it misses at the few corners: 1e-5 of the step's contribution.
    CHECK(t.integral(u) == doctest::Approx(numerical_integral(t, u)).epsilon(1e-6));
  }
  PiecewiseLinear const aside{{1.0, 2.0}, {1.0, 3.0}};  // zero lies outside the table
  CHECK(aside.integral(1.0) == doctest::Approx(0.0));   // 2u - 1 from 0 to 1
  CHECK(aside.integral(3.0) == doctest::Approx(6.0));
  CHECK(aside.integral(-1.0) == doctest::Approx(2.0));
  PiecewiseLinear const below{{-2.0, -1.0}, {3.0, 1.0}};  // -2u - 1
  CHECK(below.integral(2.0) == doctest::Approx(-6.0));
  CHECK(below.integral(-3.0) == doctest::Approx(-6.0));
}

TEST_CASE("the integral's derivative is the table") {
  auto const t = bumpstop();
  for (double u : {-0.04, -0.028, 0.0, 0.026, 0.031, 0.04}) {
    double const h = 1e-6;
    CHECK((t.integral(u + h) - t.integral(u - h)) / (2.0 * h) == doctest::Approx(t.at(u)).epsilon(1e-6));
  }
}

TEST_CASE("a quantity over time is constant before its first and after its last point") {
  TimeTable const table{{{1.0, 5.0}, {0.0, 4000.0}}};
  CHECK(table.at(0.0) == 0.0);
  CHECK(table.at(1.0) == 0.0);
  CHECK(table.at(3.0) == doctest::Approx(2000.0));
  CHECK(table.at(5.0) == 4000.0);
  CHECK(table.at(1e9) == 4000.0);
  CHECK(table.rate(0.5) == 0.0);
  CHECK(table.rate(1.0) == doctest::Approx(1000.0));  // to the right: where time goes
  CHECK(table.rate(5.0) == 0.0);
  CHECK(TimeTable{}.at(3.0) == 0.0);
  CHECK(TimeTable{{{0.0}, {7.0}}}.at(3.0) == 7.0);
}
