// Rolling constraints: no slip, the balance of torques of the control law, energy, Jacobian.
#include <doctest/doctest.h>

#include <random>

#include "rollerrig/system/outputs.hpp"
#include "system/models.hpp"

using namespace rollerrig;
using test::wheelset_parts;

namespace {

struct Constrained {
  std::unique_ptr<Dynamics> dynamics;
  std::vector<double> x;

  /// A state near the equilibrium of the unconstrained wheelset, with torques on axle and roller.
  Constrained(bool elastic, unsigned seed, double size) {
    auto parts = wheelset_parts({.driven = false});
    parts.axle_torques.push_back({0, ground, {{{0.0}, {-3000.0}}}});
    parts.roller_torques.push_back({1, {{{0.0}, {1200.0}}}});
    if (elastic) {
      parts.bodies[1].locked = {false, false, false, false, false, false};
      ForceElement e;
      e.body_a = ground, e.body_b = 1;
      for (std::size_t c = 0; c < 6; ++c)
        if (c != coord_pitch) e.law[c].laws = {LinearSpring{5e7}};
      e.law[coord_z].preload = (2980.0 + 11000.0) * 9.81;
      parts.elements.push_back(e);
    }
    Dynamics unconstrained(parts);
    x = solve_equilibrium(unconstrained, 20.0, 0.0).x;
    parts.rolling_wheelsets = {0};
    dynamics = std::make_unique<Dynamics>(parts);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    auto const& map = dynamics->map();
    for (int i = 0; i < map.coordinates + map.rates; ++i)
      x[static_cast<std::size_t>(i)] += (i < map.coordinates ? 1.0 : 30.0) * size * any(random);
  }

  std::vector<double> derivative(std::vector<double> const& at, std::vector<double>& z) {
    std::vector<double> x_dot(at.size());
    z.resize(static_cast<std::size_t>(dynamics->sizes().quadratures));
    REQUIRE(dynamics->derivative(0.0, at.data(), x_dot.data(), z.data()) == Status::ok);
    return x_dot;
  }
  std::size_t spin(std::size_t body) const { return static_cast<std::size_t>(dynamics->map().rate[body][coord_pitch]); }
};

}  // namespace

TEST_CASE("an axle that rolls does not slip: whatever slip there is decays with its rate") {
  for (bool elastic : {false, true}) {
    Constrained axle(elastic, 5, 3e-5);
    std::vector<double> z;
    auto const f = axle.derivative(axle.x, z);
    double const slip = rolling_slip(*axle.dynamics, 0);
    auto up = axle.x, down = axle.x;
    double const h = 1e-6;
    for (std::size_t i = 0; i < f.size(); ++i) up[i] += h * f[i], down[i] -= h * f[i];
    axle.dynamics->evaluate(0.0, up.data());
    double const after = rolling_slip(*axle.dynamics, 0);
    axle.dynamics->evaluate(0.0, down.data());
    double const before = rolling_slip(*axle.dynamics, 0);
    CHECK(std::abs(slip) > 1e-5);
    // speeds of 20 m/s are known to 4e-15 m/s, the difference over 2e-6 s to 1e-8 m/s^2
    CHECK((after - before) / (2 * h) == doctest::Approx(-20.0 * slip).epsilon(1e-5).scale(1e-3));
  }
}

TEST_CASE("an axle that rolls in its middle position keeps the balance of torques of the control law") {
  Constrained axle(false, 0, 0.0);
  std::vector<double> z;
  auto const f = axle.derivative(axle.x, z);
  double const wheel = f[axle.spin(0)], roller = -f[axle.spin(1)];
  double const force = (705.0 * roller - 1200.0) / 0.725;                         // (D1)
  CHECK(112.0 * wheel == doctest::Approx(-3000.0 - 0.46 * force).epsilon(1e-9));  // (D2)
  double on_wheelset = axle.dynamics->evaluation().rolling_force[0];
  for (int c : {0, 1})
    for (int k = 0; k < axle.dynamics->patch_count(c); ++k) {
      auto const& patch = axle.dynamics->patch(c, k);  // its normal force, off the crown, turns nothing
      on_wheelset += patch.force.x - patch.normal.total() * patch.point.n.x;
    }
  CHECK(on_wheelset == doctest::Approx(force).epsilon(1e-9));
}

TEST_CASE("power put in is power stored and dissipated with a rolling constraint in place of creep") {
  for (bool elastic : {false, true})
    for (unsigned seed = 0; seed < 5; ++seed) {
      Constrained axle(elastic, seed, 3e-5);
      Dynamics& dynamics = *axle.dynamics;
      std::vector<double> z;
      auto const f = axle.derivative(axle.x, z);
      auto const account = [&](Account a) { return z[static_cast<std::size_t>(dynamics.map().angles + a)]; };
      double const h = 1e-8;
      auto up = axle.x, down = axle.x;
      for (std::size_t i = 0; i < f.size(); ++i) up[i] += h * f[i], down[i] -= h * f[i];
      auto const energy = [&](std::vector<double> const& state) {
        dynamics.evaluate(0.0, state.data());
        return kinetic_energy(dynamics) + gravity_energy(dynamics) + element_energy(dynamics);
      };
      double const stored = (energy(up) - energy(down)) / (2 * h);
      double const balance = account(work_of_drive) + account(work_of_torque) - account(dissipated_elements) -
                             account(dissipated_normal) - account(dissipated_creep) - account(stored_contacts);
      CHECK(stored == doctest::Approx(balance).epsilon(1e-6).scale(1e5));  // as without a tie
    }
}

TEST_CASE("the Jacobian of an axle that rolls is that of differences") {
  for (bool elastic : {false, true}) {
    Constrained axle(elastic, 3, 2e-5);
    Dynamics& dynamics = *axle.dynamics;
    JacobianData j(dynamics.sizes());
    REQUIRE(dynamics.jacobian(0.0, axle.x.data(), j) == Status::ok);
    for (std::size_t k = 0; k < axle.x.size(); ++k) {
      double const h = static_cast<int>(k) < dynamics.map().coordinates ? 1e-9 : 2e-6;
      auto up = axle.x, down = axle.x;
      up[k] += h, down[k] -= h;
      std::vector<double> z;
      auto const f_up = axle.derivative(up, z), f_down = axle.derivative(down, z);
      auto const column = static_cast<Eigen::Index>(k);
      double const scale = j.a.col(column).cwiseAbs().maxCoeff();
      for (std::size_t i = 0; i < axle.x.size(); ++i)
        CHECK(j.a(static_cast<Eigen::Index>(i), column) ==
              doctest::Approx((f_up[i] - f_down[i]) / (2 * h)).epsilon(1e-5).scale(10.0 * scale + 10.0));
    }
  }
}
