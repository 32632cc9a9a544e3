// The stiff creep modes of a model are those of its Jacobian.
#include <doctest/doctest.h>

#include "integrate/problems.hpp"
#include "system/models.hpp"

using namespace rollerrig;
using namespace rollerrig::test;

namespace {

/// The stiff modes of a model in a state; derivative() has been called there.
StiffModes modes_of(Dynamics& dynamics, std::vector<double> const& x) {
  std::vector<double> x_dot(x.size());
  REQUIRE(dynamics.derivative(0.0, x.data(), x_dot.data(), nullptr) == Status::ok);
  StiffModes r = dynamics.stiff_modes();
  REQUIRE(dynamics.renew_stiff_modes({}, r));
  return r;
}

}  // namespace

TEST_CASE(
    "stiff modes are independent of each other, and are those of the Jacobian where creep is by far the stiffest") {
  for (double roller_radius : {0.0, 0.725})
    for (bool driven : {true, false}) {
      CAPTURE(roller_radius);
      CAPTURE(driven);
      auto const model = wheelset_model(
          {.roller_radius = roller_radius, .speed = 1.0, .friction = 100.0, .driven = driven});  // nothing saturates
      Dynamics dynamics(model);
      auto const start = solve_equilibrium(dynamics, 1.0, 0.0, {});
      REQUIRE(start.converged);
      auto const r = modes_of(dynamics, start.x);
      auto const nodes = static_cast<std::size_t>(dynamics.map().nodes);
      REQUIRE(r.size() >= nodes + 3);  // along and in yaw, across; a second one across where the contact angles differ
      auto const n = static_cast<Eigen::Index>(start.x.size());
      for (std::size_t i = 0; i < r.size(); ++i)
        for (std::size_t j = 0; j < r.size(); ++j) {
          Eigen::VectorXd u = Eigen::VectorXd::Zero(n + dynamics.sizes().quadratures);
          r.move(j, 1.0, u.data());
          // Products of two modes in their own units: rates differ by three powers of ten.
          double const scale = std::sqrt(r.rate(i) / r.rate(j));
          CHECK(std::abs(r.along(i, u.data()) - (i == j)) < 1e-9 * std::max(1.0, scale));
        }

      JacobianData jacobian(dynamics.sizes());
      REQUIRE(dynamics.jacobian(0.0, start.x.data(), jacobian) == Status::ok);
      double fastest = 0.0;
      for (std::size_t i = nodes; i < r.size(); ++i) fastest = std::max(fastest, r.rate(i));
      CHECK(fastest > 4e3);
      for (std::size_t i = nodes; i < r.size(); ++i) {
        if (r.rate(i) < 0.1 * fastest) continue;
        Eigen::VectorXd u = Eigen::VectorXd::Zero(n + dynamics.sizes().quadratures);
        r.move(i, 1.0, u.data());
        Eigen::VectorXd const v_dot = (jacobian.a * u.head(n)).tail(n - dynamics.map().coordinates);
        Eigen::VectorXd const rest = v_dot + r.rate(i) * u.head(n).tail(n - dynamics.map().coordinates);
        // Left over: the normal damping and spin creepage.
        CHECK(rest.norm() < 0.02 * r.rate(i) * u.head(n).norm());
      }
    }
}

TEST_CASE("rates go with 1/V, modes are kept until they have changed") {
  auto const model = wheelset_model({.speed = 10.0, .lateral_spring = 2e6});
  Dynamics dynamics(model);
  auto fastest = [&](double speed) {
    auto const start = solve_equilibrium(dynamics, speed, 0.0, {});
    auto const r = modes_of(dynamics, start.x);
    CHECK_FALSE(dynamics.renew_stiff_modes(r, *std::make_unique<StiffModes>()));
    double rate = 0.0;
    for (std::size_t i = static_cast<std::size_t>(dynamics.map().nodes); i < r.size(); ++i)
      rate = std::max(rate, r.rate(i));
    return rate;
  };
  double const fast = fastest(10.0);
  CHECK(fastest(2.0) == doctest::Approx(5.0 * fast).epsilon(0.02));  // V_s = 0.1 m/s, and the load is the same
  auto const start = solve_equilibrium(dynamics, 10.0, 0.0, {});
  auto const before = modes_of(dynamics, start.x);
  auto const slower = solve_equilibrium(dynamics, 9.0, 0.0, {});
  StiffModes after = dynamics.stiff_modes();
  std::vector<double> x_dot(slower.x.size());
  dynamics.derivative(0.0, slower.x.data(), x_dot.data(), nullptr);
  CHECK(dynamics.renew_stiff_modes(before, after));
}

TEST_CASE("a slow wheelset is stable in steps that rk4 cannot take, and moves as with short ones") {
  // Released 2 mm aside at 1 m/s: creep decays at up to 1e4 1/s, 20 times the step of 2 ms and more.
  auto const model = wheelset_model({.speed = 1.0});
  Dynamics dynamics(model);
  auto const start = solve_equilibrium(dynamics, 1.0, 0.0, {{0, coord_y, 2e-3}});
  REQUIRE(start.converged);
  auto const lateral_at_end = [&](Method method, double step) {
    Integrator integrator(dynamics, fixed(method, step, 0.5));
    integrator.start(0, start.x);
    if (integrator.advance(0.5) != Status::ok) return 1e9;
    return integrator.states()[dynamics.map().coordinate[0][coord_y]];
  };
  double const exact = lateral_at_end(Method::exponential_rk4, 5e-5);
  CHECK(std::abs(exact) < 2.1e-3);
  CHECK(std::abs(lateral_at_end(Method::exponential_rk4, 1e-3) - exact) < 2e-6);
  CHECK_FALSE(std::abs(lateral_at_end(Method::rk4, 1e-3) - exact) < 1e-4);
}
