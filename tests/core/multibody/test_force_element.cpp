// Force elements: kinematics, action and reaction, power, Maxwell branches, rotations.
#include <doctest/doctest.h>

#include <random>
#include <set>

#include "explicit_real.hpp"
#include "rollerrig/math/dual.hpp"
#include "rollerrig/multibody/force_element.hpp"

using namespace rollerrig;
using test::ExplicitReal;

namespace {

Body const body{1000.0, {100.0, 200.0, 300.0}, {}, false};

BodyMotion<double> random_motion(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> any(-size, size);
  BodyMotion<double> m;
  for (std::size_t c = 0; c < 6; ++c) m.q[c] = any(random), m.rate[c] = any(random);
  update_motion(body, m);
  return m;
}

/// The same bodies a moment later, along their rates.
BodyMotion<double> later(BodyMotion<double> m, double dt) {
  for (std::size_t c = 0; c < 6; ++c) m.q[c] += dt * m.rate[c];
  update_motion(body, m);
  return m;
}

ForceElement element(bool clamped = false) {
  ForceElement e;
  e.body_a = 0, e.body_b = 1;
  e.r_b = {0.2, -1.0, -0.3};
  e.rotational = true;
  e.clamped = clamped;
  return e;
}

Vec3<double> const offset{0.1, 0.0, 0.8};  // b's centre of mass from a's, at design

}  // namespace

TEST_CASE("in the design position nothing is deflected") {
  BodyMotion<double> m;
  update_motion(body, m);
  auto const e = element_motion(element(), m, m, offset);
  for (std::size_t c = 0; c < 6; ++c) CHECK(std::abs(e.d[c]) < 1e-15);
}

TEST_CASE("bodies that move together as one rigid body deflect nothing") {
  std::mt19937 random(4);
  auto const a = random_motion(random, 0.2);
  BodyMotion<double> b = a;  // same orientation; its centre of mass is carried along by a
  Vec3<double> const moved = a.p + a.R * offset - offset;
  b.q[coord_x] = moved.x, b.q[coord_y] = moved.y, b.q[coord_z] = moved.z;
  Vec3<double> const v = a.v + cross(a.omega, a.R * offset);
  b.rate[coord_x] = v.x, b.rate[coord_y] = v.y, b.rate[coord_z] = v.z;
  update_motion(body, b);
  auto const e = element_motion(element(), a, b, offset);
  for (std::size_t c = 0; c < 6; ++c) {
    CHECK(std::abs(e.d[c]) < 1e-14);
    CHECK(std::abs(e.rate[c]) < 1e-14);
  }
}

TEST_CASE("deflection rates are the time derivatives of the deflections, rotations included") {
  std::mt19937 random(5);
  for (int i = 0; i < 40; ++i) {
    auto const a = random_motion(random, 0.3), b = random_motion(random, 0.3);
    auto const tested = element(i % 2 == 1);
    auto const e = element_motion(tested, a, b, offset);
    double const h = 1e-6;
    auto const up = element_motion(tested, later(a, h), later(b, h), offset);
    auto const down = element_motion(tested, later(a, -h), later(b, -h), offset);
    for (std::size_t c = 0; c < 6; ++c)
      CHECK(e.rate[c] == doctest::Approx((up.d[c] - down.d[c]) / (2 * h)).epsilon(1e-7).scale(1.0));
  }
}

TEST_CASE("relative angles are those of R_a^T R_b = Rz Rx Ry") {
  std::mt19937 random(6);
  auto const a = random_motion(random, 0.3), b = random_motion(random, 0.3);
  auto const e = element_motion(element(), a, b, offset);
  BodyMotion<double> between;
  between.q = {0, 0, 0, e.d[coord_roll], e.d[coord_pitch], e.d[coord_yaw]};
  update_motion(body, between);
  auto const R = relative(a.R, b.R);
  CHECK(std::abs(R.ex.x - between.R.ex.x) < 1e-14);
  CHECK(std::abs(R.ey.z - between.R.ey.z) < 1e-14);
  CHECK(std::abs(R.ez.y - between.R.ez.y) < 1e-14);
}

TEST_CASE("the power of forces and moments on both bodies is minus force times deflection rate") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int i = 0; i < 50; ++i) {
    auto const a = random_motion(random, 0.3), b = random_motion(random, 0.3);
    auto const e = element_motion(element(), a, b, offset);
    double f[6];
    for (double& value : f) value = any(random);
    Vec3<double> const force = a.R * Vec3<double>{f[0], f[1], f[2]};
    Vec3<double> const torque =
        a.R * (f[coord_roll] * e.roll_axis + f[coord_pitch] * e.pitch_axis + f[coord_yaw] * e.yaw_axis);
    double const power = dot(force, b.v) + dot(cross(e.arm_b, force) + torque, b.omega) - dot(force, a.v) -
                         dot(cross(e.arm_a, force) + torque, a.omega);
    double by_rates = 0.0;
    for (std::size_t c = 0; c < 6; ++c) by_rates += f[c] * e.rate[c];
    CHECK(power == doctest::Approx(by_rates).epsilon(1e-12).scale(1.0));
  }
}

TEST_CASE("a clamped element is the same seen from either end") {
  std::mt19937 random(11);
  auto const a = random_motion(random, 0.3), b = random_motion(random, 0.3);
  auto const e = element(true);
  ForceElement turned;
  turned.clamped = true;
  turned.r_b = offset + e.r_b;  // the same point of the first body
  auto const forth = element_motion(e, a, b, offset), back = element_motion(turned, b, a, -offset);
  for (std::size_t c = 0; c < 3; ++c) {
    CHECK(back.d[c] == doctest::Approx(-forth.d[c]).epsilon(1e-12).scale(1.0));
    CHECK(back.rate[c] == doctest::Approx(-forth.rate[c]).epsilon(1e-12).scale(1.0));
  }
}

TEST_CASE("action and reaction: no net force, no net moment") {
  std::mt19937 random(8);
  auto const a = random_motion(random, 0.3), b = random_motion(random, 0.3);
  auto const e = element_motion(element(), a, b, offset);
  // Both arms end at one point: P_b.
  Vec3<double> const from_a = a.p + e.arm_a, from_b = offset + b.p + e.arm_b;
  CHECK(std::abs(from_a.x - from_b.x) < 1e-15);
  CHECK(std::abs(from_a.y - from_b.y) < 1e-15);
  CHECK(std::abs(from_a.z - from_b.z) < 1e-15);
}

template <Scalar T>
struct Answer {
  T force, dissipated, node_rate;
};

/// Of a direction with one inner node or none.
template <Scalar T>
Answer<T> answer(DirectionLaw const& law, T const& d, T const& rate, T const& s) {
  T node_rate(0.0);
  auto const on_b = direction_force(law, d, rate, &s, &node_rate);
  return {on_b.force, on_b.dissipated, node_rate};
}

double stored(DirectionLaw const& law, double d, double s) { return potential(law, d, &s); }

/// One of each kind; a new law gets its line here.
std::vector<ForceLaw> every_law() {
  return {LinearSpring{1e6}, TabulatedSpring{{{-0.02, -0.01, 0.01, 0.02}, {-700.0, 0.0, 0.0, 300.0}}},
          LinearDamper{1e3}, TabulatedDamper{{{-1.0, 0.0, 1.0}, {-50.0, 0.0, 20.0}}}, SeriesDamper{2e3, 7e6}};
}

TEST_CASE("every force law is tried below") {
  std::set<std::size_t> tried;
  for (ForceLaw const& law : every_law()) tried.insert(law.index());
  CHECK(tried.size() == std::variant_size_v<ForceLaw>);
}

TEST_CASE("every force law stores or dissipates the work done on it, and never produces energy") {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (ForceLaw const& law : every_law()) {
    CAPTURE(law.index());
    DirectionLaw const direction{.preload = 30.0, .laws = {law}};
    for (int i = 0; i < 100; ++i) {
      double const d = 0.03 * any(random), rate = 2.0 * any(random), s = 0.03 * any(random), h = 1e-8;
      auto const on_b = answer(direction, d, rate, s);
      double const after = stored(direction, d + h * rate, s + h * on_b.node_rate);
      double const before = stored(direction, d - h * rate, s - h * on_b.node_rate);
      double const power = -on_b.force * rate;
      double const scale = std::abs(power) + on_b.dissipated + 1.0;
      CHECK(std::abs(power - (after - before) / (2 * h) - on_b.dissipated) < 1e-4 * scale);
      CHECK(on_b.dissipated >= 0.0);
    }
  }
}

TEST_CASE("every force law carries derivatives") {
  double const d = 0.013, rate = 0.3, s = 0.008, h = 1e-7;
  for (ForceLaw const& law : every_law()) {
    CAPTURE(law.index());
    DirectionLaw const direction{.laws = {law}};
    auto const dual = answer(direction, Dual<3>::variable(d, 0), Dual<3>::variable(rate, 1), Dual<3>::variable(s, 2));
    for (int i = 0; i < 3; ++i) {
      double const by[3] = {i == 0 ? h : 0.0, i == 1 ? h : 0.0, i == 2 ? h : 0.0};
      auto const after = answer(direction, d + by[0], rate + by[1], s + by[2]);
      auto const before = answer(direction, d - by[0], rate - by[1], s - by[2]);
      CHECK(dual.force.d[i] == doctest::Approx((after.force - before.force) / (2 * h)).epsilon(1e-6));
      CHECK(dual.dissipated.d[i] == doctest::Approx((after.dissipated - before.dissipated) / (2 * h)).epsilon(1e-6));
      CHECK(dual.node_rate.d[i] == doctest::Approx((after.node_rate - before.node_rate) / (2 * h)).epsilon(1e-6));
    }
  }
}

TEST_CASE("two laws with inner nodes in one direction keep them apart") {
  DirectionLaw const law{.laws = {SeriesDamper{2e3, 7e6}, LinearSpring{1e6}, SeriesDamper{5e3, 3e6}}};
  double const d = 1e-3, rate = 0.0, node[2] = {4e-4, -2e-4};
  double node_rate[2] = {0.0, 0.0};
  auto const on_b = direction_force(law, d, rate, node, node_rate);
  CHECK(on_b.force == doctest::Approx(-(1e6 * 1e-3 + 7e6 * 6e-4 + 3e6 * 1.2e-3)));
  CHECK(node_rate[0] == doctest::Approx(7e6 * 6e-4 / 2e3));
  CHECK(node_rate[1] == doctest::Approx(3e6 * 1.2e-3 / 5e3));
  CHECK(potential(law, d, node) == doctest::Approx(0.5 * (1e6 * 1e-6 + 7e6 * 3.6e-7 + 3e6 * 1.44e-6)));
}

TEST_CASE("a spring pulls back, a damper brakes, a preload pushes along its axis") {
  DirectionLaw const law{.preload = 100.0, .laws = {LinearSpring{1e6}, LinearDamper{1e3}}};
  CHECK(law.active());
  CHECK(answer(law, 0.0, 0.0, 0.0).force == 100.0);
  CHECK(answer(law, 1e-3, 0.0, 0.0).force == doctest::Approx(100.0 - 1000.0));
  auto const moving = answer(law, 0.0, 0.2, 0.0);
  CHECK(moving.force == doctest::Approx(100.0 - 200.0));
  CHECK(moving.dissipated == doctest::Approx(200.0 * 0.2));
  CHECK_FALSE(DirectionLaw{}.active());
}

TEST_CASE("tables add to the linear parts") {
  DirectionLaw law{.laws = {LinearSpring{1e3}, LinearDamper{10.0}}};
  law.laws.push_back(TabulatedSpring{{{-1.0, 0.0, 1.0}, {-5.0, 0.0, 5.0}}});
  law.laws.push_back(TabulatedDamper{{{-1.0, 0.0, 1.0}, {-50.0, 0.0, 20.0}}});
  CHECK(answer(law, 0.5, 0.0, 0.0).force == doctest::Approx(-502.5));
  CHECK(answer(law, 0.0, 0.5, 0.0).force == doctest::Approx(-15.0));
  CHECK(answer(law, 0.0, -0.5, 0.0).force == doctest::Approx(30.0));
}

TEST_CASE("elastic force is minus the slope of the potential") {
  DirectionLaw law{.preload = 50.0, .laws = {LinearSpring{1e4}, SeriesDamper{1e3, 1e5}}};
  law.laws.push_back(TabulatedSpring{{{-0.02, -0.01, 0.01, 0.02}, {-700.0, 0.0, 0.0, 300.0}}});
  for (double d : {-0.025, -0.015, 0.0, 0.015, 0.03}) {
    double const s = 0.3 * d, h = 1e-7;
    double const slope = (stored(law, d + h, s) - stored(law, d - h, s)) / (2 * h);
    CHECK(answer(law, d, 0.0, s).force == doctest::Approx(-slope).epsilon(1e-6));
  }
}

TEST_CASE("a Maxwell branch held at a step of deflection relaxes exponentially with c / k_s") {
  double const d = 1e-3, k = 60e6, c = 15e3, relaxation = c / k;
  DirectionLaw const law{.laws = {SeriesDamper{c, k}}};
  double s = 0.0, heat = 0.0;
  int const steps = 1000;
  double const h = 3.0 * relaxation / steps;
  for (int i = 0; i < steps; ++i) {  // midpoint rule, second order
    double const middle = s + 0.5 * h * answer(law, d, 0.0, s).node_rate;
    auto const out = answer(law, d, 0.0, middle);
    s += h * out.node_rate;
    heat += h * out.dissipated;
  }
  double const expected = -k * d * std::exp(-3.0);
  CHECK(answer(law, d, 0.0, s).force == doctest::Approx(expected).epsilon(1e-5));  // (h/c)^2 = 1e-5
  CHECK(heat == doctest::Approx(stored(law, d, 0.0) - stored(law, d, s)).epsilon(1e-5));
}

TEST_CASE("a harmonic Maxwell branch has the textbook's complex stiffness") {
  double const omega = 2 * pi * 20.0, c = 32e3, k = 6e6;
  DirectionLaw const law{.laws = {SeriesDamper{c, k}}};
  // d = cos(wt): s' = k (d - s) / c has the steady solution s = Re[1 / (1 + i w c/k) e^{iwt}].
  double const tau = c / k;
  auto const s_at = [&](double t) {
    return (std::cos(omega * t) + omega * tau * std::sin(omega * t)) / (1.0 + omega * omega * tau * tau);
  };
  for (double t : {0.0, 0.003, 0.011}) {
    double const h = 1e-7;
    auto const out = answer(law, std::cos(omega * t), 0.0, s_at(t));
    CHECK(out.node_rate == doctest::Approx((s_at(t + h) - s_at(t - h)) / (2 * h)).epsilon(1e-6));
  }
}

TEST_CASE("the dual torque axes are the gradients of the relative angles") {
  // axis_i . e_j = delta_ij, where e_j are the axes about which the angles turn.
  std::mt19937 random(10);
  auto const a = random_motion(random, 0.3), b = random_motion(random, 0.3);
  auto const e = element_motion(element(), a, b, offset);
  double const yaw = e.d[coord_yaw], roll = e.d[coord_roll];
  Vec3<double> const yaw_turns{0, 0, 1}, roll_turns{std::cos(yaw), std::sin(yaw), 0},
      pitch_turns{-std::sin(yaw) * std::cos(roll), std::cos(yaw) * std::cos(roll), std::sin(roll)};
  Vec3<double> const axes[] = {e.roll_axis, e.pitch_axis, e.yaw_axis}, turns[] = {roll_turns, pitch_turns, yaw_turns};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      CHECK(dot(axes[i], turns[j]) == doctest::Approx(i == j ? 1.0 : 0.0).epsilon(1e-13).scale(1.0));
}

TEST_CASE("element laws carry derivatives and hold for a scalar with no implicit conversions") {
  DirectionLaw law{.preload = 3.0, .laws = {LinearSpring{1e6}, LinearDamper{1e3}, SeriesDamper{2e3, 7e6}}};
  law.laws.push_back(TabulatedSpring{{{-1.0, 0.0, 1.0}, {-5.0, 0.0, 9.0}}});
  auto const out = answer(law, Dual<3>::variable(1e-3, 0), Dual<3>::variable(0.1, 1), Dual<3>::variable(4e-4, 2));
  CHECK(out.force.d[0] == doctest::Approx(-(1e6 + 9.0 + 7e6)));
  CHECK(out.force.d[1] == doctest::Approx(-1e3));
  CHECK(out.force.d[2] == doctest::Approx(7e6));
  CHECK(out.node_rate.d[2] == doctest::Approx(-3500.0));
  auto const plain = answer(law, 1e-3, 0.1, 4e-4);
  CHECK(answer(law, ExplicitReal(1e-3), ExplicitReal(0.1), ExplicitReal(4e-4)).force.x == plain.force);
}
