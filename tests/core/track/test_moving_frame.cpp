// Bodies in travelling frames: conservation laws in the ground, and what an accelerometer feels.
#include <doctest/doctest.h>

#include "integrate/problems.hpp"
#include "rollerrig/simulate/recorder.hpp"
#include "rollerrig/system/outputs.hpp"
#include "system/models.hpp"

using namespace rollerrig;
using test::curved_line;

namespace {

struct Ground {
  Vec3<double> position, velocity, momentum;  ///< momentum: angular, about the centre of mass
  Rotation<double> axes;
};

/// What a body does, seen from the ground: the frames are summed from the start of the line.
Ground seen_from_the_ground(Dynamics& d, double t, std::vector<double> const& x, int body) {
  d.evaluate(t, x.data());
  auto const b = static_cast<std::size_t>(body);
  Body const& data = d.model().bodies[b];
  auto const& m = d.work().motion[b];
  auto const travel = travel_now(d.model(), {}, t);
  double const s = travel.s + data.position.x;
  PlanStep sum;
  for (double at = -20.0; at < s; at += 2.0) {
    auto const step = plan_step(d.model().line.curvature, at, std::min(2.0, s - at));
    double const c = std::cos(sum.heading), n = std::sin(sum.heading);
    sum = {sum.x + c * step.x - n * step.y, sum.y + n * step.x + c * step.y, sum.heading + step.heading};
  }
  auto const f = track_frame(d.model().line, Travel<double>{s, travel.speed, travel.acceleration}, 0.0);
  double const c = std::cos(sum.heading), n = std::sin(sum.heading);
  auto const up = [&](Vec3<double> const& in_frame) {
    Vec3<double> const v = f.R * in_frame;
    return Vec3<double>{c * v.x - n * v.y, n * v.x + c * v.y, v.z};
  };
  Vec3<double> const place = place_in_frame(data, m);
  Vec3<double> const w = m.omega_body + m.R.transposed_times(f.omega);
  Vec3<double> const momentum{data.inertia.x * w.x, data.inertia.y * w.y, data.inertia.z * w.z};
  double const rise = centre_rise(d.model().line.cant.at(s).value).value;
  return {Vec3<double>{sum.x, sum.y, rise} + up(place),
          up(f.v + m.v + cross(f.omega, place)),
          up(m.R * momentum),
          {up(m.R.ex), up(m.R.ey), up(m.R.ez)}};
}

double size(Vec3<double> const& v) { return std::sqrt(dot(v, v)); }

}  // namespace

TEST_CASE("free bodies fly straight on and keep their angular momentum while the track curves and cants under them") {
  // Two wheelsets (spinning) and a frame, in the air and without springs or weight, through transitions and a reverse
  // curve, at a speed that changes.
  auto model = test::vehicle_parts({});
  model.elements.clear();
  for (auto& b : model.bodies) b.locked = {};
  model.gravity = 0.0;
  model.contact_loss_limit = 1e9;
  model.line = curved_line();
  model.speed = {{{0.0, 2.0, 5.0}, {20.0, 30.0, 25.0}}};
  Dynamics d(model);
  std::vector<double> x(static_cast<std::size_t>(d.sizes().states), 0.0);
  auto const set = [&](int body, int c, double q, double rate) {
    auto const b = static_cast<std::size_t>(body), k = static_cast<std::size_t>(c);
    if (int const i = d.map().coordinate[b][k]; i >= 0) x[static_cast<std::size_t>(i)] = q;
    x[static_cast<std::size_t>(d.map().rate[b][k])] = rate;
  };
  for (int b = 0; b < 3; ++b) {
    set(b, coord_z, 0.5, 0.02);
    set(b, coord_y, 0.1, -0.3);
    set(b, coord_roll, 0.02, 0.03);
    set(b, coord_yaw, -0.03, 0.05);
    set(b, coord_pitch, 0.01, b == 2 ? -0.04 : 45.0);
  }
  std::vector<Ground> start;
  for (int b = 0; b < 3; ++b) start.push_back(seen_from_the_ground(d, 0.0, x, b));
  integrate::Options options;
  options.method = integrate::Method::dormand_prince;
  options.relative_tolerance = 1e-12;
  options.absolute_tolerance.assign(x.size(), 1e-12);
  options.final_time = 2.6;  // 65 m on: the transition, the curve and into the next
  options.output_step = 2.6;
  options.breakpoints = {2.0};
  test::Integrator integrator(d, options);
  integrator.start(0.0, x);
  REQUIRE(integrator.advance(2.6) == Status::ok);
  std::vector<double> const end(integrator.states(), integrator.states() + x.size());
  for (int b = 0; b < 3; ++b) {
    auto const g = seen_from_the_ground(d, 2.6, end, b);
    auto const& s = start[static_cast<std::size_t>(b)];
    CAPTURE(b);
    // Over 65 m; the state has moved by metres from the track, which the integrator followed to 1e-12 of that.
    CHECK(size(g.position - s.position - 2.6 * s.velocity) < 1e-8);
    CHECK(size(g.velocity - s.velocity) < 1e-8);
    CHECK(size(g.momentum - s.momentum) < 1e-7 * size(s.momentum));
  }
}

TEST_CASE("at rest on level track an accelerometer feels 1 g, in a curve it feels the uncompensated acceleration") {
  auto const model = test::vehicle_model({.speed = 0.0});
  Dynamics d(model);
  auto const e = solve_equilibrium(d, 0.0, 0.0);
  REQUIRE(e.converged);
  d.evaluate(0.0, e.x.data());
  for (int b = 0; b < 3; ++b) {
    CHECK(std::abs(specific_force(d.model(), d.work(), b).y) < 1e-6);
    CHECK(specific_force(d.model(), d.work(), b).z == doctest::Approx(9.81).epsilon(1e-6));
  }
  // A frame that is held to a track of 100 mm cant and 500 m radius.
  auto held = test::vehicle_parts({.speed = 30.0});
  held.bodies[2].locked = {true, true, true, true, true, true};
  held.line.curvature = {{0.0}, {{{1.0 / 500.0, 0, 0, 0}}}};
  held.line.cant = {{0.0}, {{{0.1, 0, 0, 0}}}};
  Dynamics h(held);
  std::vector<double> const x(static_cast<std::size_t>(h.sizes().states), 0.0);
  h.evaluate(0.0, x.data());
  double const angle = std::asin(0.1 / 1.5);
  // 0.9 m up the canted plane is nearer to the centre of the curve.
  double const centripetal = (30.0 / 500.0) * (30.0 / 500.0) * (500.0 - 0.9 * std::sin(angle));
  CHECK(specific_force(h.model(), h.work(), 2).y ==
        doctest::Approx(centripetal * std::cos(angle) - 9.81 * std::sin(angle)).epsilon(1e-12));
  CHECK(specific_force(h.model(), h.work(), 2).z ==
        doctest::Approx(centripetal * std::sin(angle) + 9.81 * std::cos(angle)).epsilon(1e-12));
}

TEST_CASE(
    "a point high above the rails of a cant ramp feels what its path in the ground says, by the turning of its body") {
  // h(s) of the cant a cubic; a body held to the track at a height H above the rails. In the ground the point is at
  // y = -H sin(chi) = H h / b, z = h / 2 + H cos(chi), and V is constant: y_dd = V^2 H h'' / b.
  double const V = 30.0, b = 1.5, H = 2.4, s = 12.0;
  std::array<double, 4> const c{0.02, 1.5e-3, 4e-5, -1.2e-6};
  auto held = test::vehicle_parts({.speed = V});
  held.bodies[2].locked = {true, true, true, true, true, true};
  double const ahead = held.bodies[2].position.x;
  held.line.cant = {{s + ahead, s + ahead + 40.0}, {c, {0.1, 0.0, 0.0, 0.0}}};
  held.line.cant_base = b;
  held.start = s;
  Dynamics d(held);
  std::vector<double> const x(static_cast<std::size_t>(d.sizes().states), 0.0);
  auto const height = [&](double at) { return c[0] + at * (c[1] + at * (c[2] + at * c[3])); };
  auto const z = [&](double at) {
    double const sine = height(at) / b;
    return 0.5 * height(at) + H * std::sqrt(1.0 - sine * sine);
  };
  for (double const t : {0.05, 0.2, 0.4}) {
    d.evaluate(t, x.data());
    double const along = V * t, step = 1e-2;
    double const slope = c[1] + along * (2.0 * c[2] + 3.0 * c[3] * along);
    double const second = 2.0 * c[2] + 6.0 * c[3] * along;
    double const sine = -height(along) / b, cosine = std::sqrt(1.0 - sine * sine);
    double const sideways = V * V * H * second / b;
    double const upwards = V * V * (z(along + step) - 2.0 * z(along) + z(along - step)) / (step * step) + 9.81;
    auto const [rate, acceleration] = inertial_turning(d.model(), d.work(), 2);
    CHECK(rate.x == doctest::Approx(-V * slope / b / cosine).epsilon(1e-12));
    Vec3<double> const arm{0.0, 0.0, H - held.bodies[2].position.z};
    Vec3<double> const felt =
        specific_force(d.model(), d.work(), 2) + cross(acceleration, arm) + cross(rate, cross(rate, arm));
    CAPTURE(t);
    CHECK(felt.y == doctest::Approx(cosine * sideways + sine * upwards).epsilon(1e-7));  // second difference in z
    CHECK(felt.z == doctest::Approx(cosine * upwards - sine * sideways).epsilon(1e-7));
  }
}

TEST_CASE("a body in free flight does not turn faster or slower against the ground, whatever the track under it does") {
  auto model = test::vehicle_parts({});
  model.elements.clear();
  for (auto& b : model.bodies) b.locked = {};
  model.bodies[2].inertia = {2000.0, 2000.0, 2000.0};  // of a ball: no gyroscopic moment
  model.contact_loss_limit = 1e9;
  model.line = curved_line();
  Dynamics d(model);
  std::vector<double> x(static_cast<std::size_t>(d.sizes().states), 0.0);
  for (int b = 0; b < 3; ++b)
    x[static_cast<std::size_t>(d.map().coordinate[static_cast<std::size_t>(b)][coord_z])] = 0.5;
  for (int const c : {coord_roll, coord_pitch, coord_yaw})
    x[static_cast<std::size_t>(d.map().rate[2][static_cast<std::size_t>(c)])] = 0.01 * c;
  for (double const t : {1.0, 2.0, 4.4}) {
    d.evaluate(t, x.data());
    CHECK(size(inertial_turning(d.model(), d.work(), 2).rate) > 0.01);
    CHECK(size(inertial_turning(d.model(), d.work(), 2).acceleration) < 1e-14);
    CHECK(size(specific_force(d.model(), d.work(), 2)) < 1e-12);
  }
}
