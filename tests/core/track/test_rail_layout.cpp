// Rails whose gauge and inclination change along the line.
#include <doctest/doctest.h>

#include "system/models.hpp"

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
  for (auto& contact : built.described_contacts) contact.rail_origin_y += 5e-3;
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
  auto e = solve_equilibrium(d, 20.0, 0.0);
  REQUIRE(e.converged);
  e.x[static_cast<std::size_t>(d.map().coordinate[0][coord_y])] += 1e-3;
  e.x[static_cast<std::size_t>(d.map().coordinate[0][coord_yaw])] += 1e-3;
  check_same(accelerations(leaning, e.x), accelerations(moved, e.x), 1e-6);  // what splines leave of a circle
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
      CHECK(std::abs(rate) > 2e-4);
      // Without what leaning changes away from the head: 0.8e-3 1/m times 20 m/s times some mm, 1e-4 m/s.
      CHECK((gap[1] - gap[0]) / (2 * h) == doctest::Approx(rate).epsilon(1e-4).scale(1e-3));
    }
  }
}

TEST_CASE("where rails widen, rise and lean, Jacobian and time derivative are those of differences") {
  auto parts = test::vehicle_parts({.elastic_rails = true});
  test::lay_rails(parts.line);
  parts.laws.normal = ElasticStrips{};
  Dynamics d(parts);
  auto const x = solve_equilibrium(d, 20.0, 0.0).x;
  auto const at = [&](double t, std::vector<double> const& state) {
    std::vector<double> x_dot(x.size()), z_dot(static_cast<std::size_t>(d.sizes().quadratures));
    REQUIRE(d.derivative(t, state.data(), x_dot.data(), z_dot.data()) == Status::ok);
    return x_dot;
  };
  double const t = 1.0, h = 1e-6;  // the wheelsets at 16 and 24 m
  JacobianData j(d.sizes());
  REQUIRE(d.jacobian(t, x.data(), j) == Status::ok);
  auto const up = at(t + h, x), down = at(t - h, x);
  double const largest = j.f_t.cwiseAbs().maxCoeff();
  REQUIRE(largest > 10.0);
  for (std::size_t i = 0; i < x.size(); ++i)
    CHECK(std::abs(j.f_t[static_cast<Eigen::Index>(i)] - (up[i] - down[i]) / (2 * h)) < 1e-3 * largest);
  for (std::size_t coordinate : {coord_y, coord_roll, coord_yaw}) {
    auto const k = static_cast<std::size_t>(d.map().coordinate[0][coordinate]);
    double const step = 1e-8;
    auto more = x, less = x;
    more[k] += step, less[k] -= step;
    auto const f = at(t, more), g = at(t, less);
    auto const column = j.a.col(static_cast<Eigen::Index>(k));
    for (std::size_t i = 0; i < x.size(); ++i)
      CHECK(std::abs(column[static_cast<Eigen::Index>(i)] - (f[i] - g[i]) / (2 * step)) <
            1e-3 * column.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("where one head becomes another, the gap changes by the rate that the forces see, and f_t by the rise") {
  auto parts = test::vehicle_parts({});
  parts.profiles.push_back(parts.profiles[1]);
  for (std::size_t i = 0; i < parts.profiles[2].pieces.size(); ++i) {  // 1 mm lower, 2 mm at the sides
    double const y = parts.profiles[2].start + parts.profiles[2].step * static_cast<double>(i), h = 0.03;
    auto& [c0, c1, c2, c3] = parts.profiles[2].pieces[i];
    c0 -= 1e-3 * (1.0 + y * y / (h * h)), c1 -= 2e-3 * y / (h * h), c2 -= 1e-3 / (h * h);
  }
  parts.laws.normal = ElasticStrips{};
  PiecewiseCubic const place{{20.0, 50.0}, {{{0.0, 0.0, 3.0 / 900.0, -2.0 / 27000.0}, {1.0, 0.0, 0.0, 0.0}}}};
  parts.left_heads = parts.right_heads = {{1, 2}, place};
  Dynamics d(parts);
  auto x = solve_equilibrium(d, 20.0, 0.0).x;
  for (int i = d.map().coordinates; i < d.map().coordinates + d.map().rates; ++i)
    if (i != d.map().rate[0][coord_pitch] && i != d.map().rate[1][coord_pitch]) x[static_cast<std::size_t>(i)] = 0.0;
  double const before = x[static_cast<std::size_t>(d.map().coordinate[0][coord_z])];
  for (double t : {0.9, 1.3, 1.7}) {  // the first wheelset at 22, 30, 38 m
    double const w = place.at(20.0 * t + 4.0).value, h = 1e-5;
    for (std::size_t body = 0; body < 3; ++body)  // it sinks with the head
      x[static_cast<std::size_t>(d.map().coordinate[body][coord_z])] = before - w * 1e-3;
    double gap[2] = {}, load[2] = {};
    for (int end : {0, 1}) {
      d.evaluate(t + (end ? h : -h), x.data());
      REQUIRE(d.patch_count(0) == 1);
      gap[end] = d.patch(0, 0).point.gap, load[end] = d.patch(0, 0).elastic;
    }
    d.evaluate(t, x.data());
    double const rate = d.patch(0, 0).gap_rate;
    CAPTURE(t);
    CHECK(rate > 2e-4);
    // The deepest point is not the centre of the pressures: 0.1 mm beside it the rise is another by 1 %.
    CHECK((gap[1] - gap[0]) / (2 * h) == doctest::Approx(rate).epsilon(0.03));
    JacobianData j(d.sizes());
    REQUIRE(d.jacobian(t, x.data(), j) == Status::ok);
    auto const acceleration = [&](double when) {
      std::vector<double> x_dot(x.size()), z_dot(static_cast<std::size_t>(d.sizes().quadratures));
      d.derivative(when, x.data(), x_dot.data(), z_dot.data());
      return x_dot[static_cast<std::size_t>(d.map().rate[0][coord_z])];
    };
    double const difference = (acceleration(t + h) - acceleration(t - h)) / (2 * h);
    // Without the turning of the head's slope, which moves the contact.
    CHECK(j.f_t[d.map().rate[0][coord_z]] == doctest::Approx(difference).epsilon(0.1));
    CHECK(load[1] < load[0]);
  }
}

TEST_CASE("heads are checked by name") {
  auto parts = test::vehicle_parts({});
  PiecewiseCubic const place = constant(0.5);
  auto const with_heads = [&](RailHeads const& heads) {
    parts.left_heads = heads;
    return parts.build();
  };
  CHECK_THROWS_WITH(with_heads({{1, 7}, place}), "heads: there is no profile 7");
  CHECK_THROWS_WITH(with_heads({{1, 0}, place}), "heads: profile 0 must have the knots of the first");
  CHECK_THROWS_WITH(with_heads({{1}, place}), "heads: place must be between the first and the last of them");
  CHECK_THROWS_WITH(with_heads({{1, 1}, {}}), "heads: place and profiles are needed together");
  CHECK_THROWS_AS(with_heads({{1, 1}, place}), std::invalid_argument);  // of Hertz' law
  parts.laws.normal = ElasticStrips{};
  CHECK(with_heads({{1, 1}, place}) != nullptr);
}
