#include "rollerrig/system/equilibrium.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "models.hpp"

using namespace rollerrig;
using namespace rollerrig::test;

namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::vector<double> derivative(std::shared_ptr<Model const> const& model, std::vector<double> const& x) {
  Dynamics dynamics(model);
  std::vector<double> x_dot(x.size());
  dynamics.derivative(0.0, x.data(), x_dot.data(), nullptr);
  return x_dot;
}

}  // namespace

TEST_CASE("without disturbances a run starts from the equilibrium") {
  auto const model = wheelset_model({.speed = 30.0});
  Dynamics dynamics(model);
  auto const start = starting_state(model, 0.0, {});
  CHECK(start.found == StartingState::ok);
  CHECK(start.x == solve_equilibrium(dynamics, 30.0, 0.0).x);
  CHECK(start.rest == start.x);
}

TEST_CASE("a disturbed coordinate is off the equilibrium by its offset, all else in equilibrium with it") {
  auto const model = wheelset_model({});
  std::vector<Disturbance> const disturbances{{0, coord_y, 2e-3}, {0, coord_yaw, 0.0}};
  auto const start = starting_state(model, 0.0, disturbances);
  REQUIRE(start.found == StartingState::ok);
  auto const& coordinate = model->map.coordinate[0];
  CHECK(start.x[at(coordinate[coord_y])] == start.rest[at(coordinate[coord_y])] + 2e-3);
  CHECK(start.x[at(coordinate[coord_yaw])] == start.rest[at(coordinate[coord_yaw])]);
  auto const x_dot = derivative(model, start.x);
  CHECK(std::abs(x_dot[at(model->map.rate[0][coord_z])]) < 1e-6);
  CHECK(std::abs(x_dot[at(model->map.rate[0][coord_roll])]) < 1e-6);
  CHECK(std::abs(x_dot[at(model->map.rate[0][coord_y])]) > 1e-3);
}

TEST_CASE("a body is set down where it is carried, from above and from below, and says where it is not") {
  auto const model = wheelset_model({});
  Dynamics dynamics(model);
  auto const rest = solve_equilibrium(dynamics, 20.0, 0.0).x;
  auto const z = at(model->map.coordinate[0][coord_z]);
  for (double const lift : {5e-3, -2e-4}) {
    auto x = rest;
    x[z] += lift;
    REQUIRE(set_down(dynamics, 0.0, x, 0, 0.03, 1e-12));
    CHECK(std::abs(x[z] - rest[z]) < 1e-10);  // 1e-7 N unbalanced over 1e9 N/m, and the resolution
  }
  auto x = rest;
  x[z] += 0.2;
  CHECK_FALSE(set_down(dynamics, 0.0, x, 0, 0.03, 1e-12));
}

TEST_CASE("a body that finds no support at its disturbance is named, and so is a coordinate that is none") {
  auto const model = wheelset_model({});
  std::vector<Disturbance> beside{{0, coord_y, 0.5}};
  auto const start = starting_state(model, 0.0, beside);
  CHECK(start.found == StartingState::no_support);
  CHECK(start.body == 0);
  for (Disturbance const none :
       {Disturbance{0, coord_pitch, 0.1}, Disturbance{7, coord_y, 0.1}, Disturbance{0, 6, 0.1}}) {
    beside = {none};
    CHECK_THROWS_AS(starting_state(model, 0.0, beside), std::invalid_argument);
  }
}

TEST_CASE("a model without an equilibrium says so") {
  Parts parts = wheelset_parts({});
  parts.described_contacts.clear();
  auto const start = starting_state(parts.build(), 0.0, {});
  CHECK(start.found == StartingState::no_equilibrium);
  CHECK(start.residual > 1e4);  // its weight
}

TEST_CASE("a train starts on level track, coasting: what resists it and what couples it to its rollers is left out") {
  Parts parts = wheelset_parts({});
  auto const plain = parts.build();
  CHECK(coasting_model(plain) == plain);
  parts.rolling_wheelsets = {0};
  auto const coupled = parts.build();
  auto const coasting = coasting_model(coupled);
  CHECK(coasting != coupled);
  CHECK(coasting->rolling_constraints.empty());
  CHECK(starting_state(coupled, 0.0, {}).x == starting_state(plain, 0.0, {}).x);
}
