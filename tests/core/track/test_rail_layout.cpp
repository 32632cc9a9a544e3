// Rails whose gauge and inclination change along the line.
#include <doctest/doctest.h>

#include "track/models.hpp"

using namespace rollerrig;

namespace {

PiecewiseCubic constant(double value) { return {{0.0}, {{{value, 0.0, 0.0, 0.0}}}}; }

std::vector<double> accelerations(test::Parts const& parts, std::vector<double> const& x) {
  Dynamics d(parts);
  std::vector<double> x_dot(x.size()), z_dot(static_cast<std::size_t>(d.sizes().quadratures));
  REQUIRE(d.derivative(1.0, x.data(), x_dot.data(), z_dot.data()) == Status::ok);
  return x_dot;
}

void check_same(std::vector<double> const& a, std::vector<double> const& b, double tolerance) {
  double largest = 0.0;
  for (double v : a) largest = std::max(largest, std::abs(v));
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(std::abs(a[i] - b[i]) < tolerance * largest);
}

}  // namespace

TEST_CASE("rails laid apart and up by the same everywhere are rails of that gauge and height") {
  auto laid = test::vehicle_parts({}), built = laid;
  laid.line.left = {constant(5e-3), constant(1e-3), {}};
  laid.line.right = {constant(-5e-3), constant(1e-3), {}};
  for (auto& contact : built.contacts) contact.rail_origin_y += 5e-3;
  Dynamics d(built);
  auto x = solve_equilibrium(d, 20.0, 0.0).x;
  x[static_cast<std::size_t>(d.map().coordinate[0][coord_yaw])] = 1e-3;
  auto lifted = x;
  for (std::size_t body = 0; body < 3; ++body)
    lifted[static_cast<std::size_t>(d.map().coordinate[body][coord_z])] += 1e-3;
  // The wheels lie where they lay to 1e-16 m, under 1e9 N/m.
  check_same(accelerations(built, x), accelerations(laid, lifted), 1e-9);
}

TEST_CASE("a round rail head that leans is the same head, moved") {
  double const lean = 0.02, radius = 0.3;
  auto leaning = test::vehicle_parts({});
  leaning.profiles[0] = test::spline_of([](double s) { return -0.05 * s; }, -60e-3, 60e-3, 1e-3);
  leaning.profiles[1] =
      test::spline_of([&](double y) { return std::sqrt(radius * radius - y * y) - radius; }, -36e-3, 36e-3, 0.1e-3);
  auto moved = leaning;
  leaning.line.left = {{}, {}, constant(lean)};
  leaning.line.right = {{}, {}, constant(-lean)};
  double const aside = radius * std::sin(lean), up = radius * (1.0 - std::cos(lean));  // of the middle of its circle
  moved.line.left = {constant(aside), constant(up), {}};
  moved.line.right = {constant(-aside), constant(up), {}};
  Dynamics d(leaning);
  auto const e = solve_equilibrium(d, 20.0, 0.0);
  REQUIRE(e.converged);
  check_same(accelerations(leaning, e.x), accelerations(moved, e.x), 1e-5);  // what splines leave of a circle: 1e-8
}

TEST_CASE("under a wheelset that stays where it is, the gap changes by the rate that the forces see") {
  for (bool const on_flange : {false, true}) {
    auto parts = test::vehicle_parts({});
    test::lay_rails(parts.line);
    Dynamics d(parts);
    auto x = solve_equilibrium(d, 20.0, 0.0).x;
    for (int i = d.map().coordinates; i < d.map().coordinates + d.map().rates; ++i) {
      bool const spins = i == d.map().rate[0][coord_pitch] || i == d.map().rate[1][coord_pitch];
      if (!spins) x[static_cast<std::size_t>(i)] = 0.0;
    }
    if (on_flange)
      for (std::size_t body : {0, 1}) x[static_cast<std::size_t>(d.map().coordinate[body][coord_y])] = 5e-3;
    for (double t : {1.0, 1.6, 2.2}) {  // 16 to 48 m
      double const h = 1e-5;
      double gap[2] = {};
      for (int end : {0, 1}) {
        d.evaluate(t + (end ? h : -h), x.data());
        REQUIRE(d.patch_count(0) > 0);
        gap[end] = d.patch(0, 0).point.gap;
      }
      d.evaluate(t, x.data());
      double const rate = d.patch(0, 0).gap_rate;
      CAPTURE(t);
      CHECK(std::abs(rate) > 1e-3);
      // Without what leaning changes away from the head: 0.8e-3 1/m times 20 m/s times some mm, 1e-4 m/s.
      CHECK((gap[1] - gap[0]) / (2 * h) == doctest::Approx(rate).epsilon(1e-4).scale(1e-3));
    }
  }
}
