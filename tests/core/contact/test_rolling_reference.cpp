// The exact solver: influence numbers against quadrature, its linear limit against Kalker, its sliding limit against Coulomb.
#include <doctest/doctest.h>

#include <cmath>

#include "rollerrig/contact/creep/creep_query.hpp"
#include "rollerrig/contact/creep/rolling_reference.hpp"
#include "rollerrig/scalar.hpp"

using namespace rollerrig;

namespace {

/// Cerruti's displacement difference of both bodies under unit point forces, times G; integrated over the rectangle.
RectangleInfluence by_quadrature(double x, double y, double dx, double dy, double nu) {
  int const n = 400;
  RectangleInfluence sum{0, 0, 0};
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      double const px = x - dx * ((i + 0.5) / n - 0.5), py = y - dy * ((j + 0.5) / n - 0.5);
      double const r = std::hypot(px, py), w = dx * dy / (n * n) / (pi * r);
      sum.xx += w * (1 - nu + nu * px * px / (r * r));
      sum.xy += w * nu * px * py / (r * r);
      sum.yy += w * (1 - nu + nu * py * py / (r * r));
    }
  return sum;
}

}  // namespace

TEST_CASE("displacements of a loaded rectangle are those of Cerruti's integrals") {
  for (auto const& [x, y] : {std::pair{0.9, 0.4}, {0.3, -1.1}, {-2.0, 0.05}, {5.0, 4.0}}) {
    auto const exact = rectangle_influence(x, y, 0.6, 0.8, 0.28);
    auto const sum = by_quadrature(x, y, 0.6, 0.8, 0.28);  // midpoints: 1e-5 where the point is half a side away
    CHECK(exact.xx == doctest::Approx(sum.xx).epsilon(1e-4));
    CHECK(exact.xy == doctest::Approx(sum.xy).epsilon(1e-4));
    CHECK(exact.yy == doctest::Approx(sum.yy).epsilon(1e-4));
  }
  // At the centre of a square, nu = 0: 8 ln(1 + sqrt 2) / 2 sides over pi.
  auto const centre = rectangle_influence(0.0, 0.0, 1.0, 1.0, 0.0);
  CHECK(centre.xx == doctest::Approx(4.0 * std::log(1.0 + std::sqrt(2.0)) / pi));
  CHECK(centre.xy == 0.0);
}

TEST_CASE("the linear limit gives Kalker's coefficients") {
  // Kalker's table has three digits and is 1 % off the full solution itself (C33: 2 %).
  KalkerTable const kalker(0.25);
  for (double ratio : {0.1, 0.3, 1.0, 1.0 / 0.3}) {
    auto const table = kalker.at(std::log(ratio));
    RollingReference reference(ratio, 0.25);
    double const small = 1e-4;  // no slip but in the last element of each row
    auto const along = reference.solve({small, 0.0, 0.0}), across = reference.solve({0.0, small, 0.0}),
               spin = reference.solve({0.0, 0.0, small});
    CAPTURE(ratio);
    CHECK(-along.longitudinal / small == doctest::Approx(table.c11).epsilon(0.015));
    CHECK(-across.lateral / small == doctest::Approx(table.c22).epsilon(0.015));
    CHECK(-spin.lateral / small == doctest::Approx(table.c23).epsilon(0.015));
    CHECK(-spin.spin_moment / small == doctest::Approx(table.c33).epsilon(0.04));
  }
}

TEST_CASE("full sliding is Coulomb's: mu N against the slip, 3 pi/16 mu N a against spin on a circle") {
  RollingReference circle(1.0, 0.28, {12, 18});
  auto const oblique = circle.solve({300.0, 400.0, 0.0});
  CHECK(oblique.converged);
  CHECK(oblique.adhesion == 0.0);
  CHECK(oblique.longitudinal == doctest::Approx(-0.6).epsilon(1e-3));
  CHECK(oblique.lateral == doctest::Approx(-0.8).epsilon(1e-3));
  auto const spin = circle.solve({0.0, 0.0, 1e5});
  CHECK(spin.spin_moment == doctest::Approx(-3.0 * pi / 16.0).epsilon(2e-3));  // the midpoint of the rows
  CHECK(std::abs(spin.lateral) < 1e-3);
}

TEST_CASE(
    "tractions obey friction element by element: bounded where it sticks, at the bound against the slip where not") {
  RollingReference reference(1.5, 0.28, {10, 14});
  auto const s = reference.solve({0.15, 0.1, -0.2});
  CHECK(s.converged);
  CHECK(s.adhesion > 0.2);
  CHECK(s.adhesion < 0.95);
  for (std::size_t i = 0; i < reference.x.size(); ++i)
    CHECK(std::hypot(reference.traction_x[i], reference.traction_y[i]) <= reference.bound[i] * (1.0 + 1e-6));
}

TEST_CASE("mirror images: longitudinal creepage, and lateral with spin") {
  double const a_over_b = 0.6;
  auto const f = RollingReference(a_over_b, 0.28, {10, 14}).solve({0.1, 0.2, 0.15});
  auto const g = RollingReference(a_over_b, 0.28, {10, 14}).solve({-0.1, 0.2, 0.15});
  auto const h = RollingReference(a_over_b, 0.28, {10, 14}).solve({0.1, -0.2, -0.15});
  CHECK(g.longitudinal == doctest::Approx(-f.longitudinal));
  CHECK(g.lateral == doctest::Approx(f.lateral));
  CHECK(g.spin_moment == doctest::Approx(f.spin_moment));
  CHECK(h.longitudinal == doctest::Approx(f.longitudinal));
  CHECK(h.lateral == doctest::Approx(-f.lateral));
  CHECK(h.spin_moment == doctest::Approx(-f.spin_moment));
}

TEST_CASE("a solution does not depend on where the iteration starts") {
  RollingReference warm(2.0, 0.28, {8, 16});
  for (double size : {3.0, 1.0, 0.5}) warm.solve({0.2 * size, -0.1 * size, 0.1 * size});
  auto const a = warm.solve({0.05, 0.1, 0.1});
  auto const b = RollingReference(2.0, 0.28, {8, 16}).solve({0.05, 0.1, 0.1});
  CHECK(a.longitudinal == doctest::Approx(b.longitudinal).epsilon(1e-3));
  CHECK(a.lateral == doctest::Approx(b.lateral).epsilon(1e-3));
  CHECK(a.spin_moment == doctest::Approx(b.spin_moment).epsilon(1e-2));
}
