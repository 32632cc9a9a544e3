#include <doctest/doctest.h>

#include <random>

#include "explicit_real.hpp"
#include "rollerrig/contact/adhesion/friction.hpp"
#include "rollerrig/contact/creep/creep_law.hpp"
#include "rollerrig/math/dual.hpp"

using namespace rollerrig;
using test::ExplicitReal;

namespace {

KalkerTable const kalker(0.28);
double const G = 82e9;
double const a = 5e-3, b = 4e-3;
double const adhesion = 0.3 * 5e4;
KalkerStiffness<double> const f = kalker_stiffness(kalker.at(std::log(a / b)), G, a, b, 1.0);

template <class T>
CreepQuery<T> query(Creepage<T> const& e, KalkerStiffness<T> const& stiffness, T const& limit) {
  return {e, stiffness, limit, T(a), T(b), T(std::log(a / b)), T(1.0)};
}
CreepQuery<double> query(Creepage<double> const& e) { return query(e, f, adhesion); }

/// Without spin, so large that the linear force is tau times the adhesion.
Creepage<double> at_tau(double tau, double angle = 0.4) {
  double const force = tau * adhesion;
  return {force * std::cos(angle) / f.f11, force * std::sin(angle) / f.f22, 0.0};
}

double magnitude(CreepForce<double> const& force) { return std::hypot(force.longitudinal, force.lateral); }

}  // namespace

TEST_CASE("no creepage, no force") {
  for (CreepLaw const& law : {CreepLaw{KalkerLinear{}}, CreepLaw{KalkerSaturated{}}}) {
    auto const force = creep_force(law, query({0.0, 0.0, 0.0}));
    CHECK(force.longitudinal == 0.0);
    CHECK(force.lateral == 0.0);
    CHECK(force.spin_moment == 0.0);
    CHECK(force.saturation == doctest::Approx(1.0));
  }
}

TEST_CASE("stiffnesses are Kalker's coefficients times G and powers of the ellipse") {
  auto const c = kalker.at(std::log(a / b));
  CHECK(f.f11 == doctest::Approx(G * a * b * c.c11));
  CHECK(f.f22 == doctest::Approx(G * a * b * c.c22));
  CHECK(f.f23 == doctest::Approx(G * std::pow(a * b, 1.5) * c.c23));
  CHECK(f.f33 == doctest::Approx(G * std::pow(a * b, 2.0) * c.c33));
  auto const backward = kalker_stiffness(c, G, a, b, -1.0);
  CHECK(backward.f23 == -f.f23);  // spin pushes the other way when rolling the other way
  CHECK(backward.f22 == f.f22);
}

TEST_CASE("small creepages give Kalker's linear forces, signs as in equation (20)") {
  Creepage<double> const e{1e-9, 2e-9, 3e-8};
  auto const force = KalkerSaturated{}(query(e));
  // Saturation takes off tau / 3, here 2e-6.
  CHECK(force.longitudinal == doctest::Approx(-f.f11 * e.longitudinal).epsilon(1e-5));
  CHECK(force.lateral == doctest::Approx(-f.f22 * e.lateral - f.f23 * e.spin).epsilon(1e-5));
  CHECK(force.spin_moment == doctest::Approx(f.f23 * e.lateral - f.f33 * e.spin).epsilon(1e-12));
}

TEST_CASE("the force never exceeds the adhesion and reaches it at three times the linear limit") {
  CHECK(magnitude(KalkerSaturated{}(query(at_tau(3.0)))) == doctest::Approx(adhesion));
  CHECK(magnitude(KalkerSaturated{}(query(at_tau(300.0)))) == doctest::Approx(adhesion));
  double last = 0.0;
  for (double tau = 0.05; tau < 6.0; tau += 0.05) {
    double const force = magnitude(KalkerSaturated{}(query(at_tau(tau))));
    CHECK(force <= adhesion * (1.0 + 1e-14));
    CHECK(force >= last * (1.0 - 1e-14));  // grows all the way
    last = force;
  }
}

TEST_CASE("the force has the direction of the linear force whatever the saturation") {
  for (double tau : {0.1, 1.0, 2.9, 10.0}) {
    auto const force = KalkerSaturated{}(query(at_tau(tau, 0.7)));
    CHECK(std::atan2(-force.lateral, -force.longitudinal) == doctest::Approx(0.7).epsilon(1e-12));
  }
}

TEST_CASE("value and slope are continuous where the cubic meets gross sliding") {
  auto const along = [](double tau) {
    Creepage<double> const e = at_tau(tau, 0.0);
    auto const force = KalkerSaturated{}(query(
        Creepage<Dual<1>>{Dual<1>::variable(e.longitudinal, 0), Dual<1>(0.0), Dual<1>(0.0)},
        KalkerStiffness<Dual<1>>{Dual<1>(f.f11), Dual<1>(f.f22), Dual<1>(f.f23), Dual<1>(f.f33)}, Dual<1>(adhesion)));
    return force.longitudinal;
  };
  double const h = 1e-7;
  CHECK(along(3.0 - h).value == doctest::Approx(along(3.0 + h).value).epsilon(1e-12));
  CHECK(std::abs(along(3.0 - h).d[0] - along(3.0 + h).d[0]) < 1e-6 * f.f11);
}

TEST_CASE("creep without spin dissipates, for any creepage and load") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> exponent(-6.0, -1.0), sign(-1.0, 1.0);
  for (int i = 0; i < 2000; ++i) {
    Creepage<double> const e{std::pow(10.0, exponent(random)) * sign(random),
                             std::pow(10.0, exponent(random)) * sign(random), 0.0};
    auto const force = KalkerSaturated{}(query(e));
    CHECK(-(force.longitudinal * e.longitudinal + force.lateral * e.lateral) >= 0.0);
  }
}

TEST_CASE("linear creep with spin dissipates: the antisymmetric f23 does no work") {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int i = 0; i < 2000; ++i) {
    Creepage<double> const e{1e-3 * any(random), 1e-3 * any(random), any(random)};
    auto const force = KalkerLinear{}(query(e));
    double const power =
        -(force.longitudinal * e.longitudinal + force.lateral * e.lateral + force.spin_moment * e.spin);
    CHECK(power >= 0.0);
    CHECK(power == doctest::Approx(f.f11 * e.longitudinal * e.longitudinal + f.f22 * e.lateral * e.lateral +
                                   f.f33 * e.spin * e.spin)
                       .epsilon(1e-12));
  }
}

TEST_CASE("the spin moment is saturated only when asked for") {
  Creepage<double> const e{5e-3, 2e-3, 0.5};
  auto const linear = KalkerLinear{}(query(e));
  auto const paper = creep_force(KalkerSaturated{false}, query(e));
  auto const scaled = creep_force(KalkerSaturated{true}, query(e));
  CHECK(paper.spin_moment == linear.spin_moment);
  CHECK(scaled.spin_moment == doctest::Approx(paper.saturation * linear.spin_moment));
  CHECK(scaled.saturation < 1.0);
}

TEST_CASE("the law carries derivatives at zero creepage and in gross sliding") {
  using D = Dual<3>;
  KalkerStiffness<D> const stiffness{D(f.f11), D(f.f22), D(f.f23), D(f.f33)};
  for (auto const& e :
       {Creepage<double>{0.0, 0.0, 0.0}, Creepage<double>{1e-4, -2e-4, 0.05}, Creepage<double>{2e-2, 1e-2, -0.3}}) {
    auto const force = KalkerSaturated{}(
        query(Creepage<D>{D::variable(e.longitudinal, 0), D::variable(e.lateral, 1), D::variable(e.spin, 2)}, stiffness,
              D(adhesion)));
    for (int k = 0; k < 3; ++k) {
      double const h = k == 2 ? 1e-5 : 1e-8;
      auto const moved = [&](double by) {
        return KalkerSaturated{}(
            query({e.longitudinal + (k == 0) * by, e.lateral + (k == 1) * by, e.spin + (k == 2) * by}));
      };
      auto const up = moved(h), down = moved(-h);
      double const scale = k == 2 ? f.f23 : f.f11;  // differences near zero creepage miss by the curvature: 1e-4
      CHECK(std::abs(force.longitudinal.d[k] - (up.longitudinal - down.longitudinal) / (2 * h)) < 2e-4 * scale);
      CHECK(std::abs(force.lateral.d[k] - (up.lateral - down.lateral) / (2 * h)) < 2e-4 * scale);
    }
  }
}

TEST_CASE("creep laws and friction hold for a scalar with no implicit conversions") {
  using E = ExplicitReal;
  Creepage<E> const e{E(1e-3), E(-2e-3), E(0.2)};
  auto const stiffness = kalker_stiffness(kalker.at(E(std::log(a / b))), G, E(a), E(b), E(1.0));
  for (CreepLaw const& law : {CreepLaw{KalkerLinear{}}, CreepLaw{KalkerSaturated{true}}}) {
    auto const force = creep_force(law, query(e, stiffness, E(adhesion)));
    auto const plain = creep_force(law, query({1e-3, -2e-3, 0.2}));
    CHECK(force.longitudinal.x == plain.longitudinal);
    CHECK(force.lateral.x == plain.lateral);
    CHECK(force.spin_moment.x == plain.spin_moment);
  }
  CHECK(Friction{ConstantFriction{0.25}}(E(0.0), E(0.0), E(0.0), 0.0, 0.0).friction.x == 0.25);
}
