// The assembled system: state map, equilibrium, Jacobian, symmetry, power balance, validity.
#include <doctest/doctest.h>

#include <random>

#include "rollerrig/system/outputs.hpp"
#include "system/models.hpp"

using namespace rollerrig;
using test::Setup;
using test::wheelset_model;

namespace {

std::vector<double> derivative(Dynamics& dynamics, std::vector<double> const& x, std::vector<double>* z = nullptr) {
  auto const sizes = dynamics.sizes();
  std::vector<double> x_dot(static_cast<std::size_t>(sizes.states)), z_dot(static_cast<std::size_t>(sizes.quadratures));
  REQUIRE(dynamics.derivative(0.0, x.data(), x_dot.data(), z_dot.data()) == Status::ok);
  if (z) *z = z_dot;
  return x_dot;
}

std::vector<double> disturbed(std::vector<double> x, StateMap const& map, unsigned seed, double size) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int i = 0; i < map.coordinates; ++i) x[static_cast<std::size_t>(i)] += size * any(random);
  for (int i = 0; i < map.rates; ++i) x[static_cast<std::size_t>(map.coordinates + i)] += 30 * size * any(random);
  return x;
}

}  // namespace

TEST_CASE("the state holds coordinates without the cyclic angle, rates with the spin, and damper nodes") {
  auto const model = wheelset_model({});
  Dynamics dynamics(model);
  auto const& map = dynamics.map();
  CHECK(map.coordinates == 5);  // wheelset without pitch; the roller only spins
  CHECK(map.rates == 7);
  CHECK(map.nodes == 2);
  CHECK(dynamics.sizes().quadratures == 2 + account_count);  // two angles
  for (int i = 0; i < dynamics.kinematic_states(); ++i)
    CHECK(dynamics.velocity_column(i) >= dynamics.kinematic_states());
}

TEST_CASE("at the equilibrium all accelerations but those of the rollers vanish and the load is carried") {
  for (double radius : {0.725, 0.0}) {
    for (double speed : {0.0, 0.1, 20.0}) {
      auto const model = wheelset_model({.roller_radius = radius, .speed = speed});
      Dynamics dynamics(model);
      auto const e = solve_equilibrium(dynamics, speed, 0.0);
      REQUIRE(e.converged);
      auto const x_dot = derivative(dynamics, e.x);
      for (double rate : x_dot) CHECK(std::abs(rate) < 1e-6);
      CHECK(e.iterations <= 3);  // Jacobians: what they cost is most of a short run's start
      double vertical = 0.0;
      for (int c = 0; c < 2; ++c)
        for (int k = 0; k < dynamics.patch_count(c); ++k) vertical += dynamics.patch(c, k).force.z;
      CHECK(vertical == doctest::Approx(11000.0 * 9.81).epsilon(1e-9));
    }
  }
}

TEST_CASE("a held coordinate stays where it is put") {
  auto const model = wheelset_model({});
  Dynamics dynamics(model);
  for (double y : {0.5e-3, 2e-3, 3e-3, 6e-3}) {  // without roll only one wheel would stand there
    auto const e = solve_equilibrium(dynamics, 20.0, 0.0, {{0, coord_y, y}});
    CHECK(e.x[static_cast<std::size_t>(dynamics.map().coordinate[0][coord_y])] == y);
    CHECK(e.converged);
    auto const x_dot = derivative(dynamics, e.x);
    CHECK(std::abs(x_dot[static_cast<std::size_t>(dynamics.map().rate[0][coord_roll])]) < 1e-6);
  }
}

TEST_CASE("an equilibrium near a known one is the same as from scratch, and is found from a bad start too") {
  auto const model = wheelset_model({.roller_radius = 0.725});
  Dynamics dynamics(model);
  auto const slow = solve_equilibrium(dynamics, 20.0, 0.0);
  auto const from_scratch = solve_equilibrium(dynamics, 25.0, 0.0);
  auto lifted = slow.x;
  lifted[static_cast<std::size_t>(dynamics.map().coordinate[0][coord_z])] += 1.0;  // no contact there
  for (auto const& start : {slow.x, lifted, std::vector<double>(slow.x.size(), std::nan(""))}) {
    auto const found = solve_equilibrium(dynamics, 25.0, 0.0, {}, start);
    REQUIRE(found.converged);
    // both leave at most 1e-7 N unbalanced; the softest stiffness is far above 1e3 N/m
    for (std::size_t i = 0; i < found.x.size(); ++i)
      CHECK(found.x[i] == doctest::Approx(from_scratch.x[i]).epsilon(1e-9).scale(1.0));
    CHECK(found.iterations < 12);  // not until the limit, where only rounding is left
  }
}

TEST_CASE("the exact Jacobian is that of differences") {
  for (double radius : {0.725, 0.0}) {
    auto const model = wheelset_model({.roller_radius = radius, .driven = false});
    Dynamics dynamics(model);
    auto const x = disturbed(solve_equilibrium(dynamics, 20.0, 0.0).x, dynamics.map(), 3, 2e-5);
    JacobianData j(dynamics.sizes());
    REQUIRE(dynamics.jacobian(0.0, x.data(), j) == Status::ok);
    for (std::size_t k = 0; k < x.size(); ++k) {
      auto const column = static_cast<Eigen::Index>(k);
      double const a_scale = 1e-5 * j.a.col(column).cwiseAbs().maxCoeff() + 1e-4;
      double smallest = 1e300;
      // The knots of the profiles are kinks of the forces; the shorter step stays clear of one that is near.
      for (double step : {1.0, 0.1}) {
        double const h = step * (static_cast<int>(k) < dynamics.map().coordinates ? 1e-8 : 2e-6);
        auto up = x, down = x;
        up[k] += h, down[k] -= h;
        std::vector<double> z_up, z_down;
        auto const f_up = derivative(dynamics, up, &z_up), f_down = derivative(dynamics, down, &z_down);
        double worst = 0.0;
        for (std::size_t i = 0; i < x.size(); ++i)
          worst = std::max(
              worst, std::abs(j.a(static_cast<Eigen::Index>(i), column) - (f_up[i] - f_down[i]) / (2 * h)) / a_scale);
        for (std::size_t i = 0; i < z_up.size(); ++i) {
          auto const row = static_cast<Eigen::Index>(i);
          double const size = 1e-5 * j.g.row(row).cwiseAbs().maxCoeff() + 1.0;
          worst = std::max(worst, std::abs(j.g(row, column) - (z_up[i] - z_down[i]) / (2 * h)) / size);
        }
        smallest = std::min(smallest, worst);
      }
      CAPTURE(k);
      CHECK(smallest < 1.0);
    }
  }
}

TEST_CASE("the time derivative of the right-hand side is that of the speed and torque tables") {
  auto model = test::wheelset_parts({.roller_radius = 0.0});
  model.speed = {{{0.0, 10.0}, {20.0, 30.0}}};
  model.axle_torques.push_back({0, ground, {{{0.0, 4.0}, {0.0, 4000.0}}}});
  Dynamics dynamics(model);
  auto const x = disturbed(solve_equilibrium(dynamics, 21.0, 1.0).x, dynamics.map(), 4, 1e-5);
  JacobianData j(dynamics.sizes());
  dynamics.jacobian(1.0, x.data(), j);
  double const h = 1e-6;
  std::vector<double> up(x.size()), down(x.size());
  dynamics.derivative(1.0 + h, x.data(), up.data(), nullptr);
  dynamics.derivative(1.0 - h, x.data(), down.data(), nullptr);
  for (std::size_t i = 0; i < x.size(); ++i) {
    double const exact = j.f_t[static_cast<Eigen::Index>(i)];
    CHECK(exact == doctest::Approx((up[i] - down[i]) / (2 * h)).epsilon(1e-5).scale(10.0));
  }
}

TEST_CASE("power put in is power stored and dissipated, at any state") {
  for (double radius : {0.725, 0.0}) {
    auto const model = wheelset_model({.roller_radius = radius, .driven = false});
    Dynamics dynamics(model);
    for (unsigned seed = 0; seed < 10; ++seed) {
      auto const x = disturbed(solve_equilibrium(dynamics, 20.0, 0.0).x, dynamics.map(), seed, 3e-5);
      std::vector<double> z;
      auto const x_dot = derivative(dynamics, x, &z);
      auto const account = [&](Account a) { return z[static_cast<std::size_t>(dynamics.map().angles + a)]; };
      double const h = 1e-8;
      auto up = x, down = x;
      for (std::size_t i = 0; i < x.size(); ++i) up[i] += h * x_dot[i], down[i] -= h * x_dot[i];
      auto const energy = [&](std::vector<double> const& state) {
        dynamics.evaluate(0.0, state.data());
        return kinetic_energy(dynamics) + gravity_energy(dynamics) + element_energy(dynamics);
      };
      double const stored = (energy(up) - energy(down)) / (2 * h);
      double const balance = account(work_of_drive) + account(work_of_torque) - account(dissipated_elements) -
                             account(dissipated_normal) - account(dissipated_creep) - account(stored_contacts);
      // Kinetic energy 7e5 J is known to 1e-10 J: 1e-2 W of the difference; powers are up to 1e5 W.
      CHECK(stored == doctest::Approx(balance).epsilon(1e-6).scale(1e5));
      CHECK(account(dissipated_elements) >= 0.0);
      CHECK(account(dissipated_normal) >= 0.0);
    }
  }
}

TEST_CASE("the mirrored state of a wheelset has mirrored accelerations") {
  auto const model = wheelset_model({});
  Dynamics dynamics(model);
  auto const& map = dynamics.map();
  auto const x = disturbed(solve_equilibrium(dynamics, 20.0, 0.0).x, map, 8, 1e-4);
  auto const mirror = [&](std::vector<double> s) {
    for (int c : {int{coord_y}, int{coord_roll}, int{coord_yaw}}) {
      s[static_cast<std::size_t>(map.coordinate[0][static_cast<std::size_t>(c)])] *= -1.0;
      s[static_cast<std::size_t>(map.rate[0][static_cast<std::size_t>(c)])] *= -1.0;
    }
    std::swap(s[s.size() - 1], s[s.size() - 2]);
    return s;
  };
  auto const f = derivative(dynamics, x), g = mirror(derivative(dynamics, mirror(x)));
  for (std::size_t i = 0; i < f.size(); ++i) CHECK(f[i] == doctest::Approx(g[i]).epsilon(1e-11).scale(10.0));
}

TEST_CASE("elastic rollers held by stiff springs move like rollers on rigid bearings") {
  auto const rigid = wheelset_model({});
  auto elastic = test::wheelset_parts({});
  auto& roller = elastic.bodies[1];
  roller.locked = {true, false, false, true, false, false};
  ForceElement e;
  e.body_a = ground, e.body_b = 1;
  for (int c : {int{coord_y}, int{coord_z}, int{coord_yaw}})
    e.law[static_cast<std::size_t>(c)].laws = {LinearSpring{1e16}};
  e.law[coord_z].preload = (2980.0 + 11000.0) * 9.81;
  elastic.elements.push_back(e);
  Dynamics a(rigid), b(elastic);
  auto const ea = solve_equilibrium(a, 20.0, 0.0), eb = solve_equilibrium(b, 20.0, 0.0);
  REQUIRE(ea.converged);
  REQUIRE(eb.converged);
  for (int c : {int{coord_x}, int{coord_y}, int{coord_z}, int{coord_roll}, int{coord_yaw}}) {
    auto const i = static_cast<std::size_t>(c);
    CHECK(std::abs(ea.x[static_cast<std::size_t>(a.map().coordinate[0][i])] -
                   eb.x[static_cast<std::size_t>(b.map().coordinate[0][i])]) < 1e-10);
  }
}

TEST_CASE("a wheelset lifted off its rollers is reported lost after the limit, with its wheel") {
  auto const model = wheelset_model({.lateral_spring = 0.0});
  Dynamics dynamics(model);
  auto x = solve_equilibrium(dynamics, 20.0, 0.0).x;
  x[static_cast<std::size_t>(dynamics.map().coordinate[0][coord_z])] = 5e-3;
  dynamics.reset_run();
  CHECK(dynamics.accept(0.0, x.data()) == Status::ok);
  CHECK(dynamics.accept(0.1, x.data()) == Status::ok);
  CHECK(dynamics.accept(0.21, x.data()) == Status::contact_lost);
  CHECK(dynamics.failed_contact() == 0);
  dynamics.reset_run();
  CHECK(dynamics.accept(0.3, x.data()) == Status::ok);
}

TEST_CASE("spells without contact are kept per wheel: how many, how long, and when the longest began") {
  auto const model = wheelset_model({.lateral_spring = 0.0});
  Dynamics dynamics(model);
  auto const down = solve_equilibrium(dynamics, 20.0, 0.0).x;
  auto up = down;
  up[static_cast<std::size_t>(dynamics.map().coordinate[0][coord_z])] = 5e-3;
  dynamics.reset_run();
  for (auto const& [t, lifted] : {std::pair{0.0, false},
                                  {0.1, true},
                                  {0.2, true},
                                  {0.25, false},
                                  {0.3, true},
                                  {0.33, true},
                                  {0.34, false},
                                  {0.4, true},
                                  {0.45, true}})
    CHECK(dynamics.accept(t, (lifted ? up : down).data()) == Status::ok);
  for (auto const& loss : dynamics.contact_losses()) {
    CHECK(loss.spells == 3);
    CHECK(loss.total == doctest::Approx(0.15 + 0.04 + 0.05));  // the last one goes on
    CHECK(loss.longest == doctest::Approx(0.15));
    CHECK(loss.longest_from == doctest::Approx(0.1));
  }
  dynamics.reset_run();
  CHECK(dynamics.contact_losses()[0].spells == 0);
}

TEST_CASE("a wheel climbs past the rail's flank, whose end is near in width alone, and derails on its flange tip") {
  auto const model = wheelset_model({});
  Dynamics dynamics(model);
  auto x = solve_equilibrium(dynamics, 20.0, 0.0).x;
  auto const at = [&](int c) {
    return static_cast<std::size_t>(dynamics.map().coordinate[0][static_cast<std::size_t>(c)]);
  };
  /// The left wheel just loaded, so far to the left [m].
  auto const status_at = [&](double y) {
    x[at(coord_y)] = y;
    double low = -5e-3, high = 40e-3;
    for (int i = 0; i < 50; ++i) {
      x[at(coord_z)] = 0.5 * (low + high);
      dynamics.evaluate(0.0, x.data());
      (dynamics.patch_count(0) > 0 ? low : high) = x[at(coord_z)];
    }
    x[at(coord_z)] = low - 1e-6;
    return dynamics.accept(y, x.data());
  };
  double y = 0.0, farthest = 0.0;
  for (; y < 60e-3 && status_at(y) == Status::ok; y += 0.25e-3)
    for (int k = 0; k < dynamics.patch_count(0); ++k) farthest = std::min(farthest, dynamics.patch(0, k).point.rail_y);
  CHECK(farthest < model->contacts[0].pair.rail->start + 0.5e-3);  // the steepest of the flange, 2 mm above that end
  CHECK(status_at(y) == Status::derailed);  // the wheel stands on its flange, whose tip is at -55 mm
  CHECK(dynamics.failed_contact() == 0);
  CHECK(std::abs(dynamics.patch(0, 0).point.wheel_s - -54e-3) < 0.05e-3);
}

TEST_CASE("evaluating twice gives the same to round-off, and an accepted run counts what it saw") {
  auto const model = wheelset_model({});
  Dynamics dynamics(model);
  auto const x = disturbed(solve_equilibrium(dynamics, 20.0, 0.0).x, dynamics.map(), 5, 1e-5);
  auto const a = derivative(dynamics, x), b = derivative(dynamics, x);
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i] == doctest::Approx(b[i]).epsilon(1e-11).scale(10.0));
  dynamics.reset_run();
  dynamics.accept(0.0, x.data());
  CHECK(dynamics.counters().checked == 2);
  CHECK(dynamics.counters().several_patches == 2);
  CHECK(dynamics.counters().lost == 0);
}

TEST_CASE("a random pose never gives a force that is not finite or pulls") {
  auto const model = wheelset_model({});
  Dynamics dynamics(model);
  auto const start = solve_equilibrium(dynamics, 20.0, 0.0).x;
  std::mt19937 random(6);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  int patches = 0;
  for (int i = 0; i < 3000; ++i) {
    auto x = start;
    auto const& q = dynamics.map().coordinate[0];
    x[static_cast<std::size_t>(q[coord_x])] += 5e-3 * any(random);
    x[static_cast<std::size_t>(q[coord_y])] += 12e-3 * any(random);
    x[static_cast<std::size_t>(q[coord_z])] += 2e-3 * any(random);
    x[static_cast<std::size_t>(q[coord_roll])] += 5e-3 * any(random);
    x[static_cast<std::size_t>(q[coord_yaw])] += 50e-3 * any(random);
    for (int k = 0; k < 5; ++k) x[static_cast<std::size_t>(dynamics.map().coordinates + k)] += 0.5 * any(random);
    for (double value : derivative(dynamics, x)) CHECK(std::isfinite(value));
    for (int c = 0; c < 2; ++c)
      for (int k = 0; k < dynamics.patch_count(c); ++k) {
        auto const& p = dynamics.patch(c, k);
        CHECK(p.normal.total() >= 0.0);
        CHECK(p.point.gap <= 0.0);
        CHECK(model->contacts[0].pair.wheel->contains(p.point.wheel_s));
        CHECK(model->contacts[0].pair.rail->contains(p.point.rail_y));
        CHECK(p.weight >= 0.0);
        CHECK(p.weight <= 1.0);
        ++patches;
      }
  }
  CHECK(patches > 1000);
}

TEST_CASE("a rig with every peculiarity of its rollers left out is the track") {
  auto rig = test::wheelset_parts({});
  auto const rails = wheelset_model({.roller_radius = 0.0});
  rig.laws.roller = {.curvature = false, .conicity = false, .spin = false, .yaw = false};
  Dynamics on_rig(rig), on_rails(rails);
  auto const start = solve_equilibrium(on_rails, 20.0, 0.0).x;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int sample = 0; sample < 50; ++sample) {
    auto x = start;
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += (i < 5 ? 1e-4 : 1e-2) * any(random);
    // The same wheelset in the rig's states, which hold the roller's rate besides.
    std::vector<double> on_roller(static_cast<std::size_t>(on_rig.map().states()), 0.0);
    std::vector<std::pair<int, int>> same;
    for (std::size_t c = 0; c < 6; ++c) {
      same.emplace_back(on_rails.map().coordinate[0][c], on_rig.map().coordinate[0][c]);
      same.emplace_back(on_rails.map().rate[0][c], on_rig.map().rate[0][c]);
    }
    for (int k = 0; k < on_rails.map().nodes; ++k)
      same.emplace_back(on_rails.map().states() - 1 - k, on_rig.map().states() - 1 - k);
    for (auto const& [from, to] : same)
      if (from >= 0) on_roller[static_cast<std::size_t>(to)] = x[static_cast<std::size_t>(from)];
    on_roller[static_cast<std::size_t>(on_rig.map().rate[1][coord_pitch])] = -20.0 / 0.725;
    auto const a = derivative(on_rails, x), b = derivative(on_rig, on_roller);
    for (auto const& [from, to] : same)
      if (from >= 0)
        CHECK(b[static_cast<std::size_t>(to)] == doctest::Approx(a[static_cast<std::size_t>(from)])
                                                     .epsilon(1e-10)
                                                     .scale(100.0));  // round-off of V / R times R
  }
}

TEST_CASE("a loaded spring clamped at both ends: forces of the closed form, and power equal to force times rate") {
  // Two free bodies, the spring's middle between them; gravity off so that only the spring acts.
  double const k = 160e3, load = 78.48e3, inertia = 1000.0, mass = 2000.0;
  test::Parts model;
  model.gravity = 0.0;
  for (double z : {0.6, 1.8}) model.bodies.push_back({mass, {inertia, inertia, inertia}, {0.0, 0.0, z}});
  ForceElement spring;
  spring.body_a = 1, spring.body_b = 0, spring.r_b = {0.0, 0.0, 0.8275 - 0.6}, spring.clamped = true;
  spring.law[coord_y] = {.laws = {LinearSpring{k}}};
  spring.law[coord_z] = {.preload = -load, .laws = {LinearSpring{430e3}}};
  model.elements = {spring};
  Dynamics dynamics(model);

  // The upper body leans by theta about its end of the spring, the lower one stands: no deflection, and the load acts along the
  // mean of both seats' axes, theta/2 from the upright.
  double const theta = 1e-3, arm = 1.8 - 0.8275;
  std::vector<double> x(static_cast<std::size_t>(dynamics.map().states()), 0.0);
  auto const place = [&](int body, int c) -> double& {
    return x[static_cast<std::size_t>(
        dynamics.map().coordinate[static_cast<std::size_t>(body)][static_cast<std::size_t>(c)])];
  };
  auto const rate = [&](int body, int c) {
    return static_cast<std::size_t>(dynamics.map().rate[static_cast<std::size_t>(body)][static_cast<std::size_t>(c)]);
  };
  place(1, coord_roll) = theta;
  place(1, coord_y) = -arm * std::sin(theta);
  place(1, coord_z) = -arm * (1.0 - std::cos(theta));
  auto x_dot = derivative(dynamics, x);
  double const lateral = load * 0.5 * theta;                                        // on the lower body, to the left
  CHECK(mass * x_dot[rate(0, coord_y)] == doctest::Approx(lateral).epsilon(1e-5));  // theta^2
  CHECK(mass * x_dot[rate(1, coord_y)] == doctest::Approx(-lateral).epsilon(1e-5));

  // Both upright, sheared by delta: both seats take k delta times their arm and half of the load times delta.
  std::fill(x.begin(), x.end(), 0.0);
  double const delta = 2e-3;
  place(1, coord_y) = delta;
  x_dot = derivative(dynamics, x);
  double const below = 0.8275 - 0.6;
  CHECK(mass * x_dot[rate(1, coord_y)] == doctest::Approx(-k * delta).epsilon(1e-12));
  CHECK(inertia * x_dot[rate(0, coord_roll)] == doctest::Approx(-(k * below + 0.5 * load) * delta).epsilon(1e-12));
  CHECK(inertia * x_dot[rate(1, coord_roll)] == doctest::Approx(-(k * arm + 0.5 * load) * delta).epsilon(1e-12));

  // Energy: kinetic and elastic change at opposite rates, wherever the bodies are.
  std::mt19937 random(12);
  std::uniform_real_distribution<double> any(-0.05, 0.05);
  for (int i = 0; i < 20; ++i) {
    for (double& value : x) value = any(random);
    x_dot = derivative(dynamics, x);
    double energy[2];
    double const h = 1e-6;
    for (int side : {0, 1}) {
      auto moved = x;
      for (std::size_t j = 0; j < x.size(); ++j) moved[j] += (side == 1 ? h : -h) * x_dot[j];
      dynamics.evaluate(0.0, moved.data());
      energy[side] = kinetic_energy(dynamics) + element_energy(dynamics);
    }
    CHECK((energy[1] - energy[0]) / (2 * h) ==
          doctest::Approx(0.0).scale(1.0).epsilon(1e-3));  // round-off / h, of some kW
  }
}
