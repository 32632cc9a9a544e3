#include <doctest/doctest.h>

#include <algorithm>
#include <random>

#include "exact/hertz_impact.hpp"
#include "explicit_real.hpp"
#include "rollerrig/contact/normal/normal_patch.hpp"
#include "rollerrig/math/dual.hpp"

using namespace rollerrig;
using test::ExplicitReal;

namespace {

double const stiffness = 1e11;  // [N/m^1.5]
NormalDamping const undamped{0.0, 1e-4};
NormalDamping const damped{1e5, 1e-4};

template <class T>
NormalForce<T> normal_force(NormalDamping const& law, T const& k, T const& gap, T const& gap_rate) {
  return rollerrig::normal_force(elastic_force(k, gap), law.force(gap_rate));
}

double force(NormalDamping const& law, double gap, double rate) {
  return normal_force(law, stiffness, gap, rate).total();
}

struct Impact {
  double duration{0.0}, deepest{0.0}, leaving{0.0}, heat{0.0};
};

/// A mass dropped on the contact, velocity Verlet until it leaves.
Impact drop(NormalDamping const& law, double mass, double speed, double step) {
  double p = 0.0, v = -speed;
  Impact out;
  do {
    double const a0 = force(law, p, v) / mass;
    double const before = p;
    p += step * v + 0.5 * step * step * a0;
    v += 0.5 * step * (a0 + force(law, p, v + step * a0) / mass);
    out.heat -= normal_force(law, stiffness, 0.5 * (p + before), v).damping * (p - before);
    out.duration += step;
    out.deepest = std::max(out.deepest, -p);
  } while (p < 0.0);
  out.leaving = v;
  return out;
}

}  // namespace

TEST_CASE("at rest the force is Hertz's") {
  CHECK(force(damped, -1e-4, 0.0) == doctest::Approx(stiffness * 1e-6));
  CHECK(force(damped, -4e-4, 0.0) == doctest::Approx(stiffness * 8e-6));
}

TEST_CASE("damping resists approach: equation (12) with its corner rounded by at most 5 N") {
  double const rest = force(damped, -1e-4, 0.0);
  CHECK(std::abs(force(damped, -1e-4, -0.1) - (rest + 1e4)) <= 5.0);
  CHECK(std::abs(force(damped, -1e-4, +0.1) - rest) <= 5.0);
}

TEST_CASE("the force never pulls, however fast the surfaces separate and however slight the contact") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> exponent(-12.0, -3.0), speed(-1.0, 1.0);
  for (int i = 0; i < 5000; ++i) {
    double const gap = -std::pow(10.0, exponent(random));
    double const rate = std::pow(10.0, exponent(random) + 3.0) * speed(random);
    auto const n = normal_force(damped, stiffness, gap, rate);
    CHECK(n.total() >= 0.0);
    CHECK(n.elastic >= 0.0);
    CHECK(n.damping * rate <= 0.0);  // damping never adds energy
  }
}

TEST_CASE("a wheel dropped on a roller: depth, duration and speed match Hertz impact theory") {
  exact::HertzImpact const impact{.m = 1500.0, .k = stiffness, .v0 = 0.1};
  Impact const found = drop(undamped, impact.m, impact.v0, impact.duration() / 4000);
  // Second order: (1/4000)^2 times order one, and the end of contact is known to half a step.
  CHECK(found.deepest == doctest::Approx(impact.max_depth()).epsilon(1e-6));
  CHECK(found.duration == doctest::Approx(impact.duration()).epsilon(5e-4));
  CHECK(found.leaving == doctest::Approx(impact.v0).epsilon(1e-4));
}

TEST_CASE("with damping the wheel leaves slower, and the heat is what it lost") {
  double const mass = 1500.0, speed = 0.1;
  exact::HertzImpact const impact{.m = mass, .k = stiffness, .v0 = speed};
  Impact const found = drop(damped, mass, speed, impact.duration() / 20000);
  CHECK(found.leaving < 0.99 * speed);
  double const lost = 0.5 * mass * (speed * speed - found.leaving * found.leaving);
  CHECK(found.heat == doctest::Approx(lost).epsilon(1e-2));  // heat by a midpoint rule at the end speed of each step
}

TEST_CASE("the slope at rest exists and is half that of the one-sided damper") {
  auto const n = normal_force(damped, Dual<2>(stiffness), Dual<2>::variable(-1e-4, 0), Dual<2>::variable(0.0, 1));
  CHECK(n.total().d[1] == doctest::Approx(-0.5 * damped.damping));
  CHECK(n.total().d[0] == doctest::Approx(-1.5 * stiffness * 1e-2));
}

TEST_CASE("derivatives of the normal force are those of differences") {
  for (double rate : {-0.02, -1e-4, 0.0, 3e-4, 0.05}) {
    auto const n = normal_force(damped, Dual<1>(stiffness), Dual<1>(-1e-4), Dual<1>::variable(rate, 0)).total();
    double const h = 1e-7;
    double const slope = (force(damped, -1e-4, rate + h) - force(damped, -1e-4, rate - h)) / (2 * h);
    CHECK(std::abs(n.d[0] - slope) < 1.0);  // [N s/m] of 1e5; rounding of 1e5 N over 2e-7 m/s is 0.1
  }
}

TEST_CASE("the formula holds for a scalar with no implicit conversions") {
  auto const n = normal_force(damped, ExplicitReal(stiffness), ExplicitReal(-1e-4), ExplicitReal(-0.1));
  CHECK(n.total().x == force(damped, -1e-4, -0.1));
}
