// What engineers know of running in curves and over irregularities.
#include <doctest/doctest.h>

#include "rollerrig/system/outputs.hpp"
#include "system/models.hpp"

using namespace rollerrig;

namespace {

/// Wheels of a cone 1:20 on round rail heads.
void make_conical(test::Parts& model) {
  model.profiles[0] = test::spline_of([](double s) { return -0.05 * s; }, -60e-3, 60e-3, 1e-3);
  model.profiles[1] =
      test::spline_of([](double y) { return 0.3 * (std::sqrt(1.0 - y * y / 0.09) - 1.0); }, -40e-3, 40e-3, 1e-3);
  for (auto& c : model.described_contacts) c.tape_circle_y = c.rail_origin_y = 0.75;
}

/// A wheelset that is free but for a hold along the track.
test::Parts conical_wheelset(double speed) {
  auto model = test::wheelset_parts({.roller_radius = 0.0, .speed = speed, .lateral_spring = 0.0});
  make_conical(model);
  model.bodies[0].locked[coord_x] = true;
  return model;
}

PiecewiseCubic constant(double value) { return {{0.0}, {{{value, 0.0, 0.0, 0.0}}}}; }

double sum_of(Dynamics& d, double Vec3<double>::* component) {
  double sum = 0.0;
  for (int c = 0; c < static_cast<int>(d.model().contacts.size()); ++c) {
    double const sign =
        d.model().contacts[static_cast<std::size_t>(c)].right && component == &Vec3<double>::y ? -1.0 : 1.0;
    for (int k = 0; k < d.patch_count(c); ++k) sum += sign * (d.patch(c, k).force.*component);
  }
  return sum;
}

double vertical_load(Dynamics& d, int contact) {
  double sum = 0.0;
  for (int k = 0; k < d.patch_count(contact); ++k) sum += d.patch(contact, k).force.z;
  return sum;
}

}  // namespace

TEST_CASE("a free conical wheelset runs in a curve where its rolling radii fit: y = r0 l0 / (lambda R)") {
  for (double radius : {2000.0, 6000.0, -4000.0}) {
    double const speed = 15.0;
    auto model = conical_wheelset(speed);
    model.line.curvature = constant(1.0 / radius);
    model.line.cant = constant(1.5 * std::sin(std::atan(speed * speed / (9.81 * radius))));
    Dynamics d(model);
    auto const e = solve_equilibrium(d, speed, 0.0);
    REQUIRE(e.converged);
    double const y = e.x[static_cast<std::size_t>(d.map().coordinate[0][coord_y])];
    // To the outside of the curve. The cone's spin creepage pulls both wheels outwards by a balance of lateral forces that
    // leaves a yaw but no shift; the contact wanders on the round heads by lambda times their radius, which is 1 % of l0.
    double const expected = -0.46 * 0.75 / (0.05 * radius);
    CHECK(y == doctest::Approx(expected).epsilon(0.03));
  }
}

TEST_CASE("at zero cant excess the sum of the lateral wheel forces vanishes, beside it it is the uncompensated force") {
  double const speed = 30.0, radius = 900.0, weight = 11000.0 * 9.81;
  for (double excess : {0.0, 0.03, -0.03}) {
    auto model = test::wheelset_parts({.roller_radius = 0.0, .speed = speed, .lateral_spring = 0.0});
    model.bodies[0].locked[coord_x] = true;
    model.line.curvature = constant(1.0 / radius);
    // The centre of mass, half a metre up the canted plane and a little to the outside, runs on its own radius.
    double const angle = std::atan(speed * speed / (9.81 * radius)) + excess;
    model.line.cant = constant(1.5 * std::sin(angle));
    Dynamics d(model);
    auto const e = solve_equilibrium(d, speed, 0.0);
    REQUIRE(e.converged);
    d.evaluate(0.0, e.x.data());
    double const y = e.x[static_cast<std::size_t>(d.map().coordinate[0][coord_y])];
    double const z = 0.46 + e.x[static_cast<std::size_t>(d.map().coordinate[0][coord_z])];
    double const own_radius = radius - z * std::sin(angle) - y * std::cos(angle);
    double const centripetal = speed * speed / (radius * radius) * own_radius;
    double const expected = 11000.0 * (centripetal * std::cos(angle) - 9.81 * std::sin(angle));
    CHECK(sum_of(d, &Vec3<double>::y) == doctest::Approx(expected).epsilon(1e-6).scale(1.0));
    if (excess == 0.0) CHECK(std::abs(sum_of(d, &Vec3<double>::y)) < 1e-3 * weight);
  }
}

TEST_CASE("cant deficiency loads the outer wheels as in statics") {
  double const speed = 45.0, radius = 2500.0;
  auto model = test::vehicle_parts({.speed = speed, .wheelbase = 3.0});
  make_conical(model);
  for (auto& e : model.elements)  // stands upright
    for (int c : {int{coord_y}, int{coord_z}}) e.law[static_cast<std::size_t>(c)].laws[0] = LinearSpring{1e9};
  model.line.curvature = constant(1.0 / radius);
  Dynamics d(model);
  auto const e = solve_equilibrium(d, speed, 0.0);
  REQUIRE(e.converged);
  d.evaluate(0.0, e.x.data());
  // Moments about the x axis of the common frame; what the springs do between the frames cancels.
  double of_bodies = 0.0, weight = 0.0, shift = 0.0;
  double const turning = 2.0 * 112.0 * (speed / 0.46) * (speed / radius);  // spin of two wheelsets, turned by the curve
  for (std::size_t b = 0; b < 3; ++b) {
    auto const& f = d.work().frame[b];
    auto const& m = d.work().motion[b];
    Body const& body = model.bodies[b];
    Vec3<double> const place = f.origin + f.R * place_in_frame(body, m);
    Vec3<double> const force = f.R * (body.mass * (m.R * specific_force(d.model(), d.work(), static_cast<int>(b))));
    of_bodies += place.z * force.y - place.y * force.z;
    weight += body.mass * 9.81;
    shift += body.mass * m.p.y / 12600.0;
  }
  double inner = 0.0, outer = 0.0, of_contacts = 0.0, base = 0.0;
  for (int c = 0; c < 4; ++c)
    for (int k = 0; k < d.patch_count(c); ++k) {
      auto const& contact = d.model().contacts[static_cast<std::size_t>(c)];
      auto const& f = d.work().frame[static_cast<std::size_t>(contact.wheelset)];
      auto const own = [&](Vec3<double> const& v) { return contact.right ? mirrored(v) : v; };
      Vec3<double> const point = own(d.patch(c, k).point.p), force = own(d.patch(c, k).force);
      (contact.right ? outer : inner) += force.z;
      Vec3<double> const place = f.origin + f.R * point, turned = f.R * force;
      of_contacts += place.z * turned.y - place.y * turned.z;
      base += std::abs(point.y) / 4.0;
    }
  CHECK(inner + outer == doctest::Approx(weight).epsilon(1e-6));
  // The spin moments in the contacts, 10 N m, have a part of 1e-3 along x.
  CHECK(of_contacts == doctest::Approx(of_bodies + turning).epsilon(1e-4));
  // As in the books: force times height, the vehicle's shift to the outside, and the wheels' gyroscopic moment.
  double const height = (2.0 * 1800.0 * 0.46 + 9000.0 * 0.9) / 12600.0;
  double const moment = 12600.0 * speed * speed / radius * height - weight * shift + turning;
  CHECK(outer - inner == doctest::Approx(moment / base).epsilon(0.01));  // the springs still give way a little
}

TEST_CASE("a wheelset that follows a wave of both rails has no lateral creepage, on track and on steered rollers") {
  double const speed = 20.0;
  for (bool rig : {false, true})
    for (bool steered : {true, false}) {
      if (!rig && !steered) continue;
      auto model = test::wheelset_parts({.roller_radius = rig ? 0.725 : 0.0, .speed = speed, .lateral_spring = 0.0});
      auto irregularity = test::waves(1.0, 0.0);
      irregularity.right_y = irregularity.left_y;  // alignment: both rails alike
      irregularity.right_z = irregularity.left_z;
      irregularity.steered = steered;
      Dynamics plain(model);
      auto const rest = solve_equilibrium(plain, speed, 0.0).x;
      double const t = 0.8;
      plain.evaluate(t, rest.data());
      model.irregularity = irregularity;
      Dynamics d(model);
      auto const rail = irregularity.at(false, speed * t, 0.0);
      auto x = rest;
      auto const& q = d.map().coordinate[0];
      auto const& v = d.map().rate[0];
      auto const add = [&](int index, double value) { x[static_cast<std::size_t>(index)] += value; };
      add(q[coord_y], rail.y.value);
      add(q[coord_z], rail.z.value);
      add(v[coord_y], speed * rail.y.slope);
      add(v[coord_z], speed * rail.z.slope);
      if (steered) {
        add(q[coord_yaw], rail.y.slope);
        add(v[coord_yaw], speed * rail.y.second);
      }
      d.evaluate(t, x.data());
      REQUIRE(std::abs(rail.y.slope) > 2e-4);
      for (int c = 0; c < 2; ++c) {
        REQUIRE(d.patch_count(c) == plain.patch_count(c));
        for (int k = 0; k < d.patch_count(c); ++k) {
          auto const& p = d.patch(c, k);
          auto const& undisturbed = plain.patch(c, k);
          // Second order: the pitch of the rail times the heights, slope 1e-3.
          CHECK(std::abs(p.creepage.lateral - undisturbed.creepage.lateral) < 5e-6);
          CHECK(std::abs(p.gap_rate - undisturbed.gap_rate) < 1e-4);
          // 0.5 um of 30 um approach: the wheel stands on a slope of 1e-3.
          CHECK(p.normal.total() == doctest::Approx(undisturbed.normal.total()).epsilon(0.04));
        }
      }
    }
}

TEST_CASE("elastic rails give way by their load over their stiffness, and very stiff ones not at all") {
  auto soft = test::vehicle_parts({.elastic_rails = true}), rigid = test::vehicle_parts({});
  Dynamics a(soft), b(rigid);
  auto const ea = solve_equilibrium(a, 20.0, 0.0), eb = solve_equilibrium(b, 20.0, 0.0);
  REQUIRE(ea.converged);
  REQUIRE(eb.converged);
  a.evaluate(0.0, ea.x.data());
  for (int rail : {3, 4, 5, 6}) {
    double const z = ea.x[static_cast<std::size_t>(a.map().coordinate[static_cast<std::size_t>(rail)][coord_z])];
    CHECK(z == doctest::Approx(-vertical_load(a, rail - 3) / 6e7).epsilon(1e-6));
  }
  CHECK(vertical_load(a, 0) == doctest::Approx(12600.0 * 9.81 / 4.0).epsilon(1e-3));
  for (auto& e : soft.elements)
    if (e.body_a == ground)
      for (int direction : {coord_y, coord_z, coord_roll})
        e.law[static_cast<std::size_t>(direction)].laws[0] = LinearSpring{1e12};
  Dynamics c(soft);
  auto const ec = solve_equilibrium(c, 20.0, 0.0);
  REQUIRE(ec.converged);
  for (std::size_t body : {0U, 1U, 2U})
    for (std::size_t k = 0; k < 6; ++k)
      if (int const i = b.map().coordinate[body][k]; i >= 0)
        CHECK(std::abs(eb.x[static_cast<std::size_t>(i)] -
                       ec.x[static_cast<std::size_t>(c.map().coordinate[body][k])]) < 1e-7);  // 3e4 N over 1e12 N/m
}

TEST_CASE(
    "a vehicle finds its equilibrium in sharp curves, on its flanges, also where Newton's method alone does not") {
  struct Curve {
    double wheelbase, speed, cant, radius;
  };
  // The last three need the relaxation; tighter ones take the contact off the rail head of these tests.
  for (auto [wheelbase, speed, cant, radius] :
       {Curve{2.5, 18, 0.1, 1500}, Curve{2.5, 18, 0.1, 400}, Curve{2.5, 10, 0.1, 400}, Curve{4, 10, 0.1, 600},
        Curve{8, 10, 0.15, 400}}) {
    auto model = test::vehicle_parts({.speed = speed, .wheelbase = wheelbase});
    model.line.curvature = constant(1.0 / radius);
    model.line.cant = constant(cant);
    Dynamics d(model);
    auto const e = solve_equilibrium(d, speed, 0.0);
    CAPTURE(radius);
    CAPTURE(e.residual);
    CHECK(e.converged);
    double const leading = e.x[static_cast<std::size_t>(d.map().coordinate[0][coord_y])];
    CHECK(leading < (radius < 1000.0 ? -5.5e-3 : -1e-3));  // to the outside
  }
}
