#include <doctest/doctest.h>

#include "explicit_real.hpp"
#include "rollerrig/contact/creep/creep_query.hpp"
#include "rollerrig/math/dual.hpp"

using namespace rollerrig;
using test::ExplicitReal;

TEST_CASE("Kalker's table holds exactly at its knots, for each tabulated Poisson's ratio") {
  double const tabulated[] = {0.0, 0.25, 0.5};
  for (std::size_t nu = 0; nu < 3; ++nu) {
    KalkerTable const table(tabulated[nu]);
    for (auto const& row : kalker_rows) {
      auto const c = table.at(std::log(row.a_over_b));
      double const values[] = {c.c11, c.c22, c.c23, c.c33};
      for (std::size_t k = 0; k < 4; ++k) CHECK(values[k] == doctest::Approx(row.value[nu][k]).epsilon(1e-14));
    }
  }
}

TEST_CASE("for Poisson's ratio zero C11 equals C22 at every axis ratio") {
  KalkerTable const table(0.0);
  for (double x = -2.3; x < 2.3; x += 0.05) {
    auto const c = table.at(x);
    CHECK(c.c11 == doctest::Approx(c.c22).epsilon(1e-14));
  }
}

TEST_CASE("coefficients are smooth over the axis ratio: value, slope and curvature continuous at the knots") {
  KalkerTable const table(0.28);
  for (std::size_t i = 1; i + 1 < kalker_rows.size(); ++i) {
    double const x = std::log(kalker_rows[i].a_over_b);
    auto const slope = [&](double at) { return table.at(Dual<1>::variable(at, 0)).c23.d[0]; };
    double const h = 1e-6;
    CHECK(slope(x - h) == doctest::Approx(slope(x + h)).epsilon(1e-4));  // a slope of 10 turns by 1e-5 over 2h
    double const left = (slope(x - h) - slope(x - 2 * h)) / h, right = (slope(x + 2 * h) - slope(x + h)) / h;
    CHECK(left ==
          doctest::Approx(right).epsilon(2e-3));  // round-off 1e-10 of the differences, and the third derivative
  }
}

TEST_CASE("between its knots a coefficient does not overshoot its neighbours") {
  KalkerTable const table(0.28);
  for (std::size_t i = 0; i + 1 < kalker_rows.size(); ++i) {
    double const x0 = std::log(kalker_rows[i].a_over_b), x1 = std::log(kalker_rows[i + 1].a_over_b);
    for (double t : {0.2, 0.5, 0.8}) {
      auto const left = table.at(x0), mid = table.at(x0 + t * (x1 - x0)), right = table.at(x1);
      CHECK(mid.c11 >= left.c11 - 1e-12);
      CHECK(mid.c11 <= right.c11 + 1e-12);
      CHECK(mid.c33 <= left.c33 + 1e-12);
      CHECK(mid.c33 >= right.c33 - 1e-12);
    }
  }
}

TEST_CASE("outside the table the end values hold, and covers() says so") {
  KalkerTable const table(0.28);
  CHECK(table.at(std::log(0.01)).c11 == table.at(std::log(0.1)).c11);
  CHECK(table.at(std::log(50.0)).c33 == doctest::Approx(table.at(std::log(10.0)).c33).epsilon(1e-14));
  CHECK(table.covers(0.0));
  CHECK_FALSE(table.covers(std::log(0.09)));
  CHECK_FALSE(table.covers(std::log(11.0)));
  CHECK(table.at(Dual<1>::variable(std::log(50.0), 0)).c11.d[0] == 0.0);
}

TEST_CASE("Kalker's coefficients hold for a scalar with no implicit conversions") {
  KalkerTable const table(0.28);
  CHECK(table.at(ExplicitReal(0.3)).c23.x == table.at(0.3).c23);
}
