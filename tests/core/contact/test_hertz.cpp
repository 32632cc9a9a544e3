#include <doctest/doctest.h>

#include <vector>

#include "explicit_real.hpp"
#include "rollerrig/contact/normal/hertz.hpp"
#include "rollerrig/math/dual.hpp"

using namespace rollerrig;
using test::ExplicitReal;

namespace {

Material const steel{210e9 / 2.0 / 1.28, 0.28};

struct Ellipse {
  double a, b, approach, pressure;
};

Ellipse ellipse(double load, double d1, double d2) {
  auto const h = hertz_contact(steel, d1, d2);
  double const approach = std::pow(load / h.stiffness, 2.0 / 3.0);
  double const a = h.a_per_root * std::sqrt(approach), b = h.b_per_root * std::sqrt(approach);
  return {a, b, approach, 1.5 * load / (pi * a * b)};
}

}  // namespace

TEST_CASE("Hertz ellipses of steel on steel to the five digits of the published check table") {
  struct Row {
    double load, d1, d2, a, b, approach, pressure;  // N, 1/m, mm, mm, mm, MPa
  };
  for (Row const& row : {Row{54546, .5 / .46, .5 / .3, 5.8763, 4.4203, 0.07010, 1002.7},
                         Row{54546, .5 * (1 / .46 + 1 / .725), .5 / .3, 4.6083, 4.8087, 0.07627, 1175.3},
                         Row{54546, .5 / .46, .5 / .08, 7.0088, 2.2161, 0.08409, 1676.8},
                         Row{10000, .5 / .46, .5 / .3, 3.3382, 2.5111, 0.02262, 569.6}}) {
    Ellipse const e = ellipse(row.load, row.d1, row.d2);
    CHECK(std::abs(1e3 * e.a - row.a) < 0.5001e-4);  // half of the last digit printed
    CHECK(std::abs(1e3 * e.b - row.b) < 0.5001e-4);
    CHECK(std::abs(1e3 * e.approach - row.approach) < 0.5001e-5);
    CHECK(std::abs(1e-6 * e.pressure - row.pressure) < 0.05001);
  }
}

TEST_CASE("two spheres of equal radius: the circle's closed form") {
  // a^2 = R_e d, N = 4/3 E* sqrt(R_e) d^1.5, with D1 = D2 = 1/(2 R_e) and E* = E / (2 (1 - nu^2)).
  double const radius = 0.3, load = 2e4;
  double const e_star = 210e9 / (2.0 * (1.0 - 0.28 * 0.28));
  double const approach = std::pow(3.0 * load / (4.0 * e_star * std::sqrt(radius)), 2.0 / 3.0);
  Ellipse const e = ellipse(load, 0.5 / radius, 0.5 / radius);
  CHECK(e.approach == doctest::Approx(approach).epsilon(1e-9));  // accuracy of the table
  CHECK(e.a == doctest::Approx(std::sqrt(radius * approach)).epsilon(1e-9));
  CHECK(e.b == doctest::Approx(e.a).epsilon(1e-9));
}

TEST_CASE("turning the contact by 90 degrees exchanges the semi-axes") {
  for (double ratio : {0.006, 0.1, 0.7, 1.0, 3.0, 150.0}) {
    auto const h = hertz_contact(steel, 1.3, 1.3 * ratio);
    auto const turned = hertz_contact(steel, 1.3 * ratio, 1.3);
    CHECK(h.a_per_root == doctest::Approx(turned.b_per_root).epsilon(1e-9));
    CHECK(h.b_per_root == doctest::Approx(turned.a_per_root).epsilon(1e-9));
    CHECK(h.stiffness == doctest::Approx(turned.stiffness).epsilon(1e-9));
    CHECK(std::abs(h.log_aspect + turned.log_aspect) < 3e-8);  // near the circle the ratio is known to 1e-8
  }
}

TEST_CASE("the ellipse is longer in the direction of the smaller curvature and its aspect is consistent") {
  auto const h = hertz_contact(steel, 1.0, 4.0);
  CHECK(h.a_per_root > h.b_per_root);
  CHECK(std::log(h.a_per_root / h.b_per_root) == doctest::Approx(h.log_aspect).epsilon(1e-9));
}

TEST_CASE("elliptic integrals at values of Abramowitz and Stegun") {
  // Complementary modulus g = sqrt(1 - m). Table 17.1: m = 0.5 and m = 0.99.
  auto const half = elliptic_integrals(std::sqrt(0.5));
  CHECK(half.k == doctest::Approx(1.854074677301372).epsilon(1e-14));
  CHECK(half.e == doctest::Approx(1.350643881047676).epsilon(1e-14));
  auto const near_one = elliptic_integrals(std::sqrt(0.01));
  CHECK(near_one.k == doctest::Approx(3.695637362989875).epsilon(1e-13));
  CHECK(near_one.e == doctest::Approx(1.015993545025224).epsilon(1e-13));
  CHECK(elliptic_integrals(1.0).k == doctest::Approx(pi / 2).epsilon(1e-15));
}

TEST_CASE("the axis ratio of a circle is one, and falls with the ratio of curvatures") {
  CHECK(axis_ratio(1.0) == 1.0);
  double last = 1.0;
  for (double ratio : {0.9, 0.5, 0.1, 0.01, 0.005}) {
    double const g = axis_ratio(ratio);
    CHECK(g < last);
    last = g;
  }
}

TEST_CASE("conformal and saddle contacts are limited, finite, and say so") {
  double const d1 = 2.0;
  auto const at_limit = hertz_contact(steel, d1, d1 / HertzTable::limit * 1.0000001);
  CHECK_FALSE(at_limit.limited);
  for (double d2 : {0.0, -5.0, d1 / 1000.0}) {
    auto const h = hertz_contact(steel, d1, d2);
    CHECK(h.limited);
    CHECK(h.stiffness == doctest::Approx(at_limit.stiffness).epsilon(1e-6));
    CHECK(h.b_per_root > h.a_per_root);
    CHECK(std::isfinite(h.b_per_root));
  }
  CHECK(hertz_contact(steel, d1, d1 * 1000.0).limited);
}

TEST_CASE("Hertz functions carry derivatives with respect to the curvatures") {
  for (double d2 : {0.2, 1.7, 30.0}) {
    auto const h = hertz_contact(steel, Dual<2>::variable(1.3, 0), Dual<2>::variable(d2, 1));
    auto const stiffness = [&](double x, double y) { return hertz_contact(steel, x, y).stiffness; };
    double const s1 = 1.3e-5, s2 = d2 * 1e-5;
    CHECK(h.stiffness.d[0] ==
          doctest::Approx((stiffness(1.3 + s1, d2) - stiffness(1.3 - s1, d2)) / (2 * s1)).epsilon(1e-6));
    CHECK(h.stiffness.d[1] ==
          doctest::Approx((stiffness(1.3, d2 + s2) - stiffness(1.3, d2 - s2)) / (2 * s2)).epsilon(1e-6));
  }
}

TEST_CASE("Hertz contact holds for a scalar with no implicit conversions") {
  auto const h = hertz_contact(steel, ExplicitReal(1.3), ExplicitReal(0.7));
  CHECK(h.stiffness.x == hertz_contact(steel, 1.3, 0.7).stiffness);
}

namespace {

/// Principal curvatures d1, d2 with the axis of d1 turned by an angle from the rolling direction.
template <class T>
CurvatureTensor<T> turned(double d1, double d2, T const& angle) {
  using std::cos;
  using std::sin;
  return curvature_tensor(T(d1), T(d2), Twist<T>{sin(angle), cos(angle)});
}

}  // namespace

TEST_CASE("a turned ellipse keeps its stiffness and area; its equivalent has its moments along and across rolling") {
  for (double ratio : {0.02, 0.5, 1.0, 1.7, 60.0})
    for (double angle : {0.0, 0.05, -0.4, 0.7}) {
      auto const straight = hertz_contact(steel, 2.0, 2.0 * ratio);
      auto const h = hertz_contact(steel, turned(2.0, 2.0 * ratio, angle));
      CAPTURE(ratio);
      CAPTURE(angle);
      // 1e-9 of the mean keeps the principal curvatures apart where they are equal.
      CHECK(h.stiffness == doctest::Approx(straight.stiffness).epsilon(1e-8));
      CHECK(h.a_per_root * h.b_per_root == doctest::Approx(straight.a_per_root * straight.b_per_root).epsilon(1e-8));
      double const a2 = square(straight.a_per_root), b2 = square(straight.b_per_root);
      double const c2 = square(std::cos(angle)), s2 = square(std::sin(angle));
      CHECK(square(h.a_per_root / h.b_per_root) ==
            doctest::Approx((a2 * c2 + b2 * s2) / (a2 * s2 + b2 * c2)).epsilon(1e-7));
      CHECK(h.log_aspect == doctest::Approx(std::log(h.a_per_root / h.b_per_root)).epsilon(1e-7).scale(1.0));
      CHECK(h.reach_per_root == doctest::Approx(std::sqrt(a2 * s2 + b2 * c2)).epsilon(1e-7));
    }
}

TEST_CASE("without a turn the tensor gives what the two curvatures give, to round-off") {
  for (double ratio : {0.001, 0.02, 0.7, 3.0, 150.0}) {
    auto const straight = hertz_contact(steel, 1.3, 1.3 * ratio);
    auto const h = hertz_contact(steel, CurvatureTensor<double>{1.3, 0.0, 1.3 * ratio});
    CHECK(h.stiffness == doctest::Approx(straight.stiffness).epsilon(1e-13));
    CHECK(h.a_per_root == doctest::Approx(straight.a_per_root).epsilon(1e-13));
    CHECK(h.b_per_root == doctest::Approx(straight.b_per_root).epsilon(1e-13));
    CHECK(h.log_aspect == doctest::Approx(straight.log_aspect).epsilon(1e-12));
    CHECK(h.limited == straight.limited);
  }
}

TEST_CASE("derivatives over the tensor are those of differences, through the circle too") {
  for (auto const& [along, mixed, across] :
       {std::array{1.3, 0.2, 40.0}, {1.3, 0.2, 1.3}, {1.3, 1e-4, 1.3002}, {3.0, -0.5, 0.4}}) {
    using D = Dual<3>;
    auto const h =
        hertz_contact(steel, CurvatureTensor<D>{D::variable(along, 0), D::variable(mixed, 1), D::variable(across, 2)});
    for (int i = 0; i < 3; ++i) {
      double const step = 1e-5;
      auto const at = [&](double by) {
        std::array<double, 3> q{along, mixed, across};
        q[static_cast<std::size_t>(i)] += by;
        return hertz_contact(steel, CurvatureTensor<double>{q[0], q[1], q[2]});
      };
      auto const up = at(step), down = at(-step);
      CAPTURE(along);
      CAPTURE(i);
      auto const slope = [&](double high, double low) { return (high - low) / (2.0 * step); };
      CHECK(h.stiffness.d[i] ==
            doctest::Approx(slope(up.stiffness, down.stiffness)).epsilon(1e-5).scale(1e-2 * up.stiffness));
      CHECK(h.a_per_root.d[i] ==
            doctest::Approx(slope(up.a_per_root, down.a_per_root)).epsilon(1e-5).scale(1e-2 * up.a_per_root));
      CHECK(h.log_aspect.d[i] == doctest::Approx(slope(up.log_aspect, down.log_aspect)).epsilon(1e-5).scale(1e-2));
    }
  }
}
