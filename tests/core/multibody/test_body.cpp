// Newton and Euler of one body against closed forms and conservation laws.
#include <doctest/doctest.h>

#include <array>
#include <random>

#include "exact/symmetric_top.hpp"
#include "explicit_real.hpp"
#include "rollerrig/math/dual.hpp"
#include "rollerrig/multibody/body.hpp"

using namespace rollerrig;
using test::ExplicitReal;

namespace {

BodyMotion<double> motion_of(Body const& body, std::array<double, 6> const& q, std::array<double, 6> const& rate) {
  BodyMotion<double> m;
  m.q = q;
  m.rate = rate;
  update_motion(body, m);
  return m;
}

using State = std::array<double, 12>;

/// Free flight by RK4, no force and no moment.
State fly(Body const& body, State state, double duration, int steps) {
  auto const rate_of = [&](State const& s) {
    BodyMotion<double> m;
    for (std::size_t c = 0; c < 6; ++c) m.q[c] = s[c], m.rate[c] = s[6 + c];
    update_motion(body, m);
    double unused = 0.0;
    auto const a = accelerations(body, m, Wrench<double>{}, 0.0, unused);
    State out;
    for (std::size_t c = 0; c < 6; ++c) out[c] = s[6 + c], out[6 + c] = a[c];
    return out;
  };
  double const h = duration / steps;
  auto const plus = [](State a, State const& b, double f) {
    for (std::size_t c = 0; c < 12; ++c) a[c] += f * b[c];
    return a;
  };
  for (int i = 0; i < steps; ++i) {
    State const k1 = rate_of(state), k2 = rate_of(plus(state, k1, h / 2)), k3 = rate_of(plus(state, k2, h / 2)),
                k4 = rate_of(plus(state, k3, h));
    for (std::size_t c = 0; c < 12; ++c) state[c] += h / 6 * (k1[c] + 2 * k2[c] + 2 * k3[c] + k4[c]);
  }
  return state;
}

BodyMotion<double> motion_of(Body const& body, State const& s) {
  return motion_of(body, {s[0], s[1], s[2], s[3], s[4], s[5]}, {s[6], s[7], s[8], s[9], s[10], s[11]});
}

double rotational_energy(Body const& body, BodyMotion<double> const& m) {
  auto const& w = m.omega_body;
  return 0.5 * (body.inertia.x * w.x * w.x + body.inertia.y * w.y * w.y + body.inertia.z * w.z * w.z);
}

Vec3<double> momentum(Body const& body, BodyMotion<double> const& m) {
  auto const& w = m.omega_body;
  return m.R * Vec3<double>{body.inertia.x * w.x, body.inertia.y * w.y, body.inertia.z * w.z};
}

Body const frame{2615.0, {1722.0, 1476.0, 3067.0}, {0.0, 0.0, 0.6}, false};
Body const wheelset{1813.0, {1120.0, 112.0, 1120.0}, {0.0, 0.0, 0.46}, true};

void near(Vec3<double> const& a, Vec3<double> const& b, double tolerance) {
  CHECK(std::abs(a.x - b.x) < tolerance);
  CHECK(std::abs(a.y - b.y) < tolerance);
  CHECK(std::abs(a.z - b.z) < tolerance);
}

}  // namespace

TEST_CASE("the orientation is yaw, then roll, then pitch, and a rotation") {
  double const roll = 0.2, pitch = -0.3, yaw = 0.7;
  auto const m = motion_of(frame, {0, 0, 0, roll, pitch, yaw}, {});
  near(m.R.ey, {-std::sin(yaw) * std::cos(roll), std::cos(yaw) * std::cos(roll), std::sin(roll)}, 1e-15);
  near(cross(m.R.ex, m.R.ey), m.R.ez, 1e-15);
  CHECK(dot(m.R.ex, m.R.ex) == doctest::Approx(1.0).epsilon(1e-15));
  CHECK(m.R.ex.z == doctest::Approx(-std::sin(pitch) * std::cos(roll)));
}

TEST_CASE("the angular velocity is that of the turning frame") {
  // Columns of R turn as omega x column: checked against differences along the rates.
  std::array<double, 6> const q{0, 0, 0, 0.2, -0.3, 0.7}, rate{0, 0, 0, 0.5, -0.4, 0.9};
  double const h = 1e-6;
  std::array<double, 6> up = q, down = q;
  for (std::size_t c = 0; c < 6; ++c) up[c] += h * rate[c], down[c] -= h * rate[c];
  auto const m = motion_of(frame, q, rate);
  auto const a = motion_of(frame, up, rate), b = motion_of(frame, down, rate);
  near((1.0 / (2 * h)) * (a.R.ex - b.R.ex), cross(m.omega, m.R.ex), 1e-9);
  near((1.0 / (2 * h)) * (a.R.ez - b.R.ez), cross(m.omega, m.R.ez), 1e-9);
  near(m.R.transposed_times(m.omega), m.omega_body, 1e-15);
}

TEST_CASE("the angular acceleration of a body's frame is the rate of its angular velocity") {
  std::array<double, 6> const q{0.0, 0.0, 0.0, 0.3, -0.4, 0.7}, rate{0.0, 0.0, 0.0, 0.9, -1.1, 0.6},
      acceleration{0.0, 0.0, 0.0, -0.8, 1.3, 0.5};
  for (bool const axisymmetric : {false, true}) {
    Body body{.mass = 1.0, .inertia = {1.0, 2.0, 3.0}};
    body.axisymmetric = axisymmetric;
    auto const moved = [&](double t) {
      BodyMotion<double> m;
      for (std::size_t c = 0; c < 6; ++c) {
        m.q[c] = q[c] + t * rate[c] + 0.5 * t * t * acceleration[c];
        m.rate[c] = rate[c] + t * acceleration[c];
      }
      update_motion(body, m);
      return m;
    };
    double const h = 1e-5;
    Vec3<double> const found = frame_angular_acceleration(body, moved(0.0), acceleration);
    Vec3<double> const quotient = (0.5 / h) * (moved(h).frame_body - moved(-h).frame_body);
    CAPTURE(axisymmetric);
    // Central differences: error h^2, round-off 1e-16 / h.
    CHECK(found.x == doctest::Approx(quotient.x).epsilon(1e-9));
    CHECK(found.y == doctest::Approx(quotient.y).epsilon(1e-9));
    CHECK(found.z == doctest::Approx(quotient.z).epsilon(1e-9));
  }
}

TEST_CASE("a wheelset's frame does not take part in its spin, its angular velocity does") {
  auto const m = motion_of(wheelset, {0, 0, 0, 0.01, 123.0, 0.02}, {0, 0, 0, 0, 36.0, 0});
  auto const still = motion_of(wheelset, {0, 0, 0, 0.01, 0.0, 0.02}, {});
  near(m.R.ex, still.R.ex, 0.0 + 1e-16);
  near(m.omega, 36.0 * m.R.ey, 1e-13);
  near(m.frame_omega, {0, 0, 0}, 1e-15);
}

TEST_CASE("a force through the centre of mass accelerates the mass, a small moment its inertia") {
  double unused = 0.0;
  auto const a = accelerations(frame, motion_of(frame, {}, {}), {{1.0, 2.0, -3.0}, {5.0, 7.0, 11.0}}, 0.0, unused);
  CHECK(a[0] == doctest::Approx(1.0 / 2615.0));
  CHECK(a[2] == doctest::Approx(-3.0 / 2615.0));
  CHECK(a[3] == doctest::Approx(5.0 / 1722.0));
  CHECK(a[4] == doctest::Approx(7.0 / 1476.0));
  CHECK(a[5] == doctest::Approx(11.0 / 3067.0));
}

TEST_CASE("free asymmetric body: energy and angular momentum stay") {
  State const start{0, 0, 0, 0.2, -0.1, 0.4, 0.3, -0.2, 0.1, 0.5, 0.7, -0.6};
  auto const before = motion_of(frame, start);
  auto const after = motion_of(frame, fly(frame, start, 3.0, 6000));
  // RK4 at h = 0.5 ms and rates below 1 1/s: (h w)^4 per unit time, 1e-13.
  CHECK(rotational_energy(frame, after) == doctest::Approx(rotational_energy(frame, before)).epsilon(1e-11));
  near(momentum(frame, after), momentum(frame, before), 1e-8);
  CHECK(after.q[0] == doctest::Approx(0.9));
}

TEST_CASE("free wheelset: its axle goes round the angular momentum as a symmetric top's") {
  for (double spin : {0.0, 5.0, 40.0}) {
    State const start{0, 0, 0, 0.05, 0.0, 0.1, 0, 0, 0, 0.3, spin, -0.2};
    auto const m = motion_of(wheelset, start);
    exact::SymmetricTop const top{1120.0, 112.0, m.R.ey, m.omega};
    double const duration = 1.5;
    auto const end = motion_of(wheelset, fly(wheelset, start, duration, 6000));
    near(end.R.ey, top.axis_at(duration), 1e-10);
    CHECK(dot(end.omega, end.R.ey) == doctest::Approx(top.spin()).epsilon(1e-11));
    near(momentum(wheelset, end), top.momentum(), 1e-7);
  }
}

TEST_CASE("the spin angle of a wheelset acts on nothing") {
  double unused = 0.0;
  Wrench<double> const wrench{{10.0, 20.0, 30.0}, {40.0, 50.0, 60.0}};
  std::array<double, 6> q{0, 0, 0, 0.02, 0.0, 0.03}, rate{0, 0, 0, 0.4, 50.0, -0.3};
  auto const a = accelerations(wheelset, motion_of(wheelset, q, rate), wrench, 0.0, unused);
  q[coord_pitch] = 1e9;
  auto const b = accelerations(wheelset, motion_of(wheelset, q, rate), wrench, 0.0, unused);
  for (std::size_t c = 0; c < 6; ++c) CHECK(a[c] == b[c]);
}

TEST_CASE("a wheelset and the same body with its spin angle as a coordinate move alike") {
  double unused = 0.0;
  Body turning = wheelset;
  turning.axisymmetric = false;  // same inertia, but the frame turns with the spin
  Wrench<double> const wrench{{0, 0, 0}, {40.0, 50.0, 60.0}};
  for (double pitch : {0.0, 0.6, 2.5}) {
    std::array<double, 6> const q{0, 0, 0, 0.2, pitch, 0.3}, rate{0, 0, 0, 0.4, 5.0, -0.3};
    auto const a = accelerations(wheelset, motion_of(wheelset, q, rate), wrench, 0.0, unused);
    auto const b = accelerations(turning, motion_of(turning, q, rate), wrench, 0.0, unused);
    for (std::size_t c = 3; c < 6; ++c) CHECK(a[c] == doctest::Approx(b[c]).epsilon(1e-12));
  }
}

TEST_CASE("locked coordinates have exactly no acceleration and the rest moves as constrained") {
  double unused = 0.0;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int pattern = 0; pattern < 64; ++pattern) {
    Body body = frame;
    std::array<double, 6> q{}, rate{};
    for (std::size_t c = 0; c < 6; ++c) {
      body.locked[c] = (pattern >> c) & 1;
      q[c] = c < 3 ? any(random) : 0.3 * any(random);
      rate[c] = body.locked[c] ? 0.0 : any(random);
    }
    auto const m = motion_of(body, q, rate);
    Wrench<double> const wrench{{any(random), any(random), any(random)}, {any(random), any(random), any(random)}};
    auto const a = accelerations(body, m, wrench, 0.0, unused);
    for (std::size_t c = 0; c < 6; ++c)
      if (body.locked[c]) CHECK(a[c] == 0.0);
    // Power balance: what the wrench does goes into kinetic energy, locks do no work.
    double const h = 1e-6;
    State up{}, down{};
    for (std::size_t c = 0; c < 6; ++c) {
      up[c] = q[c] + h * rate[c] + 0.5 * h * h * a[c], down[c] = q[c] - h * rate[c] + 0.5 * h * h * a[c];
      up[6 + c] = rate[c] + h * a[c], down[6 + c] = rate[c] - h * a[c];
    }
    auto const kinetic = [&](State const& s) {
      auto const motion = motion_of(body, s);
      return rotational_energy(body, motion) + 0.5 * body.mass * dot(motion.v, motion.v);
    };
    double const power = dot(wrench.force, m.v) + dot(wrench.moment, m.omega);
    // Rounding: energies of 2e3 J over 2e-6 s.
    CHECK((kinetic(up) - kinetic(down)) / (2 * h) == doctest::Approx(power).epsilon(1e-5).scale(1.0));
  }
}

TEST_CASE("a speed-controlled spin is exactly the prescribed one, and the drive's torque is what Euler asks for") {
  Body roller = wheelset;
  roller.speed_controlled_radius = 0.5;
  for (std::size_t c : {0U, 1U, 2U, 3U, 5U}) roller.locked[c] = true;
  double torque = 0.0;
  auto const m = motion_of(roller, {}, {0, 0, 0, 0, -30.0, 0});
  auto const a = accelerations(roller, m, Wrench<double>{{}, {0.0, 25.0, 0.0}}, -0.7, torque);
  CHECK(a[coord_pitch] == -0.7);
  CHECK(torque == doctest::Approx(112.0 * -0.7 - 25.0));
}

TEST_CASE("a body on rigid bearings spins as the free one does about its axle") {
  Body roller = wheelset;
  for (std::size_t c : {0U, 1U, 2U, 3U, 5U}) roller.locked[c] = true;
  std::array<double, 6> const rate{0, 0, 0, 0, -30.0, 0};
  auto const m = motion_of(roller, {}, rate), free = motion_of(wheelset, {}, rate);
  for (auto axis : {&Rotation<double>::ex, &Rotation<double>::ey, &Rotation<double>::ez})
    for (auto component : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z})
      CHECK(m.R.*axis.*component == free.R.*axis.*component);
  for (auto vector : {&BodyMotion<double>::omega, &BodyMotion<double>::omega_body, &BodyMotion<double>::frame_omega,
                      &BodyMotion<double>::frame_body, &BodyMotion<double>::p, &BodyMotion<double>::v})
    for (auto component : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z})
      CHECK(m.*vector.*component == free.*vector.*component);
  double torque = 1.0, unused = 0.0;
  Wrench<double> const wrench{{1e3, 2e3, 3e3}, {0.0, 25.0, 0.0}};
  auto const a = accelerations(roller, m, wrench, 0.0, torque);
  CHECK(a == std::array<double, 6>{0, 0, 0, 0, accelerations(wheelset, free, wrench, 0.0, unused)[coord_pitch], 0});
  CHECK(torque == 0.0);
}

TEST_CASE("accelerations carry derivatives with respect to position, rate and load") {
  using D = Dual<16>;
  for (Body const& body : {frame, wheelset}) {
    std::array<double, 6> const q{0.1, 0.2, 0.3, 0.11, -0.07, 0.13}, rate{0.1, -0.2, 0.3, 0.5, 7.0, -0.4};
    Wrench<double> const wrench{{1e3, 2e3, 3e3}, {4e3, 5e3, 6e3}};
    BodyMotion<D> m;
    for (std::size_t c = 0; c < 6; ++c) {
      m.q[c] = D::variable(q[c], static_cast<int>(c));
      m.rate[c] = D::variable(rate[c], 6 + static_cast<int>(c));
    }
    update_motion(body, m);
    D moment(0.0);
    auto const a = accelerations(
        body, m, Wrench<D>{lift<D>(wrench.force), {D::variable(4e3, 12), D::variable(5e3, 13), D::variable(6e3, 14)}},
        D(0.0), moment);
    for (int seed = 0; seed < 15; ++seed) {
      double const h = seed < 12 ? 1e-5 : 1.0;
      auto const at = [&](double by) {
        auto qq = q;
        auto rr = rate;
        auto w = wrench;
        if (seed < 6)
          qq[static_cast<std::size_t>(seed)] += by;
        else if (seed < 12)
          rr[static_cast<std::size_t>(seed - 6)] += by;
        else
          (seed == 12 ? w.moment.x : seed == 13 ? w.moment.y : w.moment.z) += by;
        double unused = 0.0;
        return accelerations(body, motion_of(body, qq, rr), w, 0.0, unused);
      };
      auto const up = at(h), down = at(-h);
      for (std::size_t c = 0; c < 6; ++c)
        CHECK(std::abs(a[c].d[seed] - (up[c] - down[c]) / (2 * h)) < 1e-6);  // truncation h^2 and rounding 1e-16/h
    }
  }
}

TEST_CASE("body motion holds for a scalar with no implicit conversions") {
  BodyMotion<ExplicitReal> m;
  m.q[coord_roll] = ExplicitReal(0.1);
  m.rate[coord_pitch] = ExplicitReal(3.0);
  update_motion(frame, m);
  ExplicitReal unused(0.0);
  auto const a = accelerations(frame, m, Wrench<ExplicitReal>{}, ExplicitReal(0.0), unused);
  CHECK(std::isfinite(a[coord_yaw].x));
}

TEST_CASE("losses of an axle brake its spin, grow as they are said to, and let it rest") {
  Body axle;
  axle.loss_constant = 20.0, axle.loss_linear = 2.0, axle.loss_quadratic = 0.5;
  CHECK(axle.loss(10.0) == doctest::Approx(20.0 + 2.0 * 10.0 + 0.5 * 100.0).epsilon(1e-6));
  CHECK(axle.loss(-10.0) == -axle.loss(10.0));
  CHECK(axle.loss(0.0) == 0.0);
  CHECK(axle.loss(0.1) == doctest::Approx(20.0 + 0.2 + 0.005).epsilon(6e-3));  // the constant part is 0.5 % less there
  using D = Dual<1>;
  for (double w : {-30.0, -0.005, 0.0, 0.02, 12.0})
    CHECK(axle.loss(D::variable(w, 0)).d[0] ==
          doctest::Approx((axle.loss(w + 1e-5) - axle.loss(w - 1e-5)) / 2e-5).epsilon(1e-5));
  CHECK(axle.loss(ExplicitReal(10.0)).x == axle.loss(10.0));
  CHECK_FALSE(Body{}.has_losses());
}
