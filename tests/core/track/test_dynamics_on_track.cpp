// The right-hand side in curves, on irregular and on elastic rails, wide, narrow and leaning: power, derivatives, symmetry, independence of the place.
#include <doctest/doctest.h>

#include <random>

#include "rollerrig/system/outputs.hpp"
#include "system/models.hpp"

using namespace rollerrig;
using test::curved_line;
using test::VehicleSetup;

namespace {

constexpr double when[] = {0.6, 1.3, 2.9, 4.6, 6.5};  // [s], at 20 m/s: transition, curve, reverse, behind the line

test::Parts everything(VehicleSetup const& setup) {
  auto model = test::vehicle_parts(setup);
  model.line = curved_line(setup.shift, setup.side);
  test::lay_rails(model.line, setup.shift, setup.side);
  model.irregularity = test::waves(setup.side);
  // A long table: the speed changes while the power is measured.
  model.speed = {{{0.0, 10.0}, {setup.speed, setup.speed + 10.0}}};
  return model;
}

std::vector<double> some_state(Dynamics& d, unsigned seed, double size) {
  auto x = solve_equilibrium(d, 20.0, 0.0).x;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  auto const& map = d.map();
  for (int i = 0; i < map.coordinates; ++i) x[static_cast<std::size_t>(i)] += size * any(random);
  for (int i = 0; i < map.rates; ++i) x[static_cast<std::size_t>(map.coordinates + i)] += 30 * size * any(random);
  for (int i = 0; i < map.nodes; ++i) x[x.size() - 1 - static_cast<std::size_t>(i)] += size * any(random);
  return x;
}

struct Rates {
  std::vector<double> x, z;
};
Rates rates_at(Dynamics& d, double t, std::vector<double> const& x) {
  auto const sizes = d.sizes();
  Rates r{std::vector<double>(static_cast<std::size_t>(sizes.states)),
          std::vector<double>(static_cast<std::size_t>(sizes.quadratures))};
  REQUIRE(d.derivative(t, x.data(), r.x.data(), r.z.data()) == Status::ok);
  return r;
}

}  // namespace

TEST_CASE("in a curve, on irregular and elastic rails, power put in is power stored and dissipated") {
  for (bool elastic : {false, true}) {
    auto const model = everything({.elastic_rails = elastic});
    Dynamics d(model);
    for (double t : when) {
      auto const x = some_state(d, 11, 3e-5);
      auto const rates = rates_at(d, t, x);
      auto const account = [&](Account a) { return rates.z[static_cast<std::size_t>(d.map().angles + a)]; };
      double const h = 1e-7;
      auto const energy = [&](double sign) {
        auto state = x;
        for (std::size_t i = 0; i < x.size(); ++i) state[i] += sign * h * rates.x[i];
        d.evaluate(t + sign * h, state.data());
        return kinetic_energy(d) + gravity_energy(d) + element_energy(d);
      };
      double const stored = (energy(1.0) - energy(-1.0)) / (2 * h);
      double const balance = account(work_of_drive) + account(work_of_torque) - account(dissipated_elements) -
                             account(dissipated_normal) - account(dissipated_creep) - account(stored_contacts);
      CAPTURE(t);
      // Energies of 1e6 J are known to 1e-10 J: 1e-3 W of the difference; powers are up to 1e5 W.
      CHECK(std::abs(stored - balance) < 0.05);
    }
  }
}

TEST_CASE("rollers that are moved and steered like rails keep the power balance") {
  for (bool elastic : {false, true})
    for (bool steered : {false, true}) {
      auto model = test::wheelset_parts({});
      model.irregularity = test::waves();
      model.irregularity->steered = steered;
      if (elastic) {
        model.bodies[1].locked = {true, false, false, true, false, false};
        ForceElement e;
        e.body_a = ground, e.body_b = 1;
        e.law[coord_y] = {.laws = {LinearSpring{1e8}, LinearDamper{1e4}}};
        e.law[coord_z] = {.preload = 13980.0 * 9.81, .laws = {LinearSpring{1e8}, LinearDamper{1e4}}};
        e.law[coord_yaw] = {.laws = {LinearSpring{1e8}, LinearDamper{1e4}}};
        model.elements.push_back(e);
      }
      Dynamics d(model);
      for (double t : {0.7, 1.4, 2.0}) {
        auto const x = some_state(d, 12, 3e-5);
        auto const rates = rates_at(d, t, x);
        auto const account = [&](Account a) { return rates.z[static_cast<std::size_t>(d.map().angles + a)]; };
        double const h = 1e-7;
        auto const energy = [&](double sign) {
          auto state = x;
          for (std::size_t i = 0; i < x.size(); ++i) state[i] += sign * h * rates.x[i];
          d.evaluate(t + sign * h, state.data());
          return kinetic_energy(d) + gravity_energy(d) + element_energy(d);
        };
        double const stored = (energy(1.0) - energy(-1.0)) / (2 * h);
        double const balance = account(work_of_drive) - account(dissipated_elements) - account(dissipated_normal) -
                               account(dissipated_creep) - account(stored_contacts);
        CHECK(std::abs(stored - balance) < 0.05);
      }
    }
}

TEST_CASE("the exact Jacobian and time derivative on curved, irregular, elastic track are those of differences") {
  auto model = everything({.elastic_rails = true});
  model.line.left = {}, model.line.right = {};  // test_rail_layout.cpp has them
  Dynamics d(model);
  for (double t : {1.3, 3.1}) {
    auto const x = some_state(d, 13, 2e-5);
    JacobianData j(d.sizes());
    REQUIRE(d.jacobian(t, x.data(), j) == Status::ok);
    for (std::size_t k = 0; k < x.size(); ++k) {
      auto const column = static_cast<Eigen::Index>(k);
      double const scale = 1e-5 * j.a.col(column).cwiseAbs().maxCoeff() + 1e-4;
      double smallest = 1e300;
      for (double step : {1.0, 0.1}) {  // the knots of the profiles are kinks; the shorter step stays clear of one
        bool const is_rate =
            static_cast<int>(k) >= d.map().coordinates && static_cast<int>(k) < d.map().coordinates + d.map().rates;
        double const h = step * (is_rate ? 2e-6 : 1e-8);
        auto up = x, down = x;
        up[k] += h, down[k] -= h;
        auto const f_up = rates_at(d, t, up), f_down = rates_at(d, t, down);
        double worst = 0.0;
        for (std::size_t i = 0; i < x.size(); ++i)
          worst = std::max(
              worst, std::abs(j.a(static_cast<Eigen::Index>(i), column) - (f_up.x[i] - f_down.x[i]) / (2 * h)) / scale);
        for (std::size_t i = 0; i < f_up.z.size(); ++i) {
          auto const row = static_cast<Eigen::Index>(i);
          double const size = 1e-5 * j.g.row(row).cwiseAbs().maxCoeff() + 1.0;
          worst = std::max(worst, std::abs(j.g(row, column) - (f_up.z[i] - f_down.z[i]) / (2 * h)) / size);
        }
        smallest = std::min(smallest, worst);
      }
      CAPTURE(t);
      CAPTURE(k);
      CHECK(smallest < 1.0);
    }
    double const h = 1e-7;
    auto const up = rates_at(d, t + h, x), down = rates_at(d, t - h, x);
    double const scale = j.f_t.cwiseAbs().maxCoeff();
    CHECK(scale > 1.0);
    for (std::size_t i = 0; i < x.size(); ++i) {
      CAPTURE(i);
      CHECK(std::abs(j.f_t[static_cast<Eigen::Index>(i)] - (up.x[i] - down.x[i]) / (2 * h)) < 1e-5 * scale);
    }
    double const power_scale = j.g_t.cwiseAbs().maxCoeff();
    for (std::size_t i = 0; i < up.z.size(); ++i)
      CHECK(std::abs(j.g_t[static_cast<Eigen::Index>(i)] - (up.z[i] - down.z[i]) / (2 * h)) < 1e-5 * power_scale);
  }
}

TEST_CASE("the mirrored vehicle in the mirrored curve on mirrored rails has mirrored accelerations") {
  auto const left = everything({.elastic_rails = true}), right = everything({.elastic_rails = true, .side = -1.0});
  Dynamics a(left), b(right);
  auto const& map = a.map();
  // Bodies and elements of one side change places with those of the other: rails 3..6 and the elements' nodes.
  int const twin[] = {0, 1, 2, 4, 3, 6, 5};
  auto const mirror = [&](std::vector<double> const& x) {
    std::vector<double> y(x.size());
    for (std::size_t body = 0; body < 7; ++body)
      for (std::size_t c = 0; c < 6; ++c) {
        double const sign = c == coord_y || c == coord_roll || c == coord_yaw ? -1.0 : 1.0;
        auto const other = static_cast<std::size_t>(twin[body]);
        for (auto const* index : {&map.coordinate, &map.rate})
          if (int const i = (*index)[body][c]; i >= 0)
            y[static_cast<std::size_t>((*index)[other][c])] = sign * x[static_cast<std::size_t>(i)];
      }
    std::size_t const n = x.size();
    for (std::size_t i : {std::size_t{1}, std::size_t{3}}) {
      y[n - i] = x[n - i - 1];
      y[n - i - 1] = x[n - i];
    }
    return y;
  };
  for (double t : when) {
    auto const x = some_state(a, 14, 1e-4);
    auto const f = rates_at(a, t, x), g = rates_at(b, t, mirror(x));
    auto const expected = mirror(f.x);
    double largest = 0.0;
    for (double v : f.x) largest = std::max(largest, std::abs(v));
    for (std::size_t i = 0; i < f.x.size(); ++i) CHECK(std::abs(expected[i] - g.x[i]) < 1e-11 * largest);
    for (int i = 0; i < account_count; ++i) {
      auto const k = static_cast<std::size_t>(map.angles + i);
      CHECK(f.z[k] == doctest::Approx(g.z[k]).epsilon(1e-10).scale(1.0));
    }
  }
}

TEST_CASE("a thousand kilometres on, everything is as it was at the start") {
  auto here = everything({}), there = everything({.shift = 1e6 + 20.0});  // 16 667 periods and 0 m
  there.irregularity = test::waves();
  there.start = here.start + 1e6 + 20.0;
  Dynamics a(here), b(there);
  for (double t : when) {
    auto const x = some_state(a, 15, 3e-5);
    auto const f = rates_at(a, t, x), g = rates_at(b, t, x);
    double largest = 0.0;
    for (double v : f.x) largest = std::max(largest, std::abs(v));
    // s is known to 1e-10 m there: with slopes of 1e-3 that moves a rail by 1e-13 m, under 1e9 N/m.
    for (std::size_t i = 0; i < f.x.size(); ++i) CHECK(std::abs(f.x[i] - g.x[i]) < 1e-7 * largest);
  }
}

TEST_CASE("where the line is straight and level, the frames of a curved line give what straight track gives") {
  // Behind the last wheel the line is curved: the general formulas run, with nothing in them.
  auto straight = test::vehicle_parts({}), curved = test::vehicle_parts({});
  double const tiny = 1e-16;
  curved.line.curvature = {{-100.0, 100.0}, {{{tiny, 0, 0, 0}, {tiny, 0, 0, 0}}}};
  straight.speed = curved.speed = {{{0.0, 10.0}, {20.0, 25.0}}};
  Dynamics a(straight), b(curved);
  auto const x = some_state(a, 16, 3e-5);
  auto const f = rates_at(a, 0.5, x), g = rates_at(b, 0.5, x);
  REQUIRE(b.work().curved);
  REQUIRE(!a.work().curved);
  double largest = 0.0;
  for (double v : f.x) largest = std::max(largest, std::abs(v));
  for (std::size_t i = 0; i < f.x.size(); ++i) CHECK(std::abs(f.x[i] - g.x[i]) < 1e-12 * largest);
  for (std::size_t i = 0; i < f.z.size(); ++i) CHECK(f.z[i] == doctest::Approx(g.z[i]).epsilon(1e-10).scale(1e-3));
}
