// Axles that are only simulated: against one axle, and their energy.
#include <doctest/doctest.h>

#include <cmath>

#include "rollerrig/mechatronics/simulated_axles.hpp"
#include "rollerrig/mechatronics/virtual_train.hpp"

using namespace rollerrig;

namespace {

constexpr double r = 0.46, J_w = 112.0, load = 109100.0, g = 9.81;

VirtualRail falling_rail(double recovery_width) {
  VirtualRail rail;
  rail.friction.law = FallingFriction{0.08, 0.4, 0.2};
  rail.wheel_load = 0.5 * load, rail.a = 6e-3, rail.b = 4e-3, rail.width = recovery_width, rail.cell = 0.05;
  rail.creepage_regularisation_speed = 0.1;
  rail.stiffness = kalker_stiffness(KalkerTable(0.28).at(std::log(1.5)), 82e9, rail.a, rail.b, 1.0);
  return rail;
}

SimulatedAxles axles_of(std::size_t count) {
  return {.wheelset_inertia = J_w,
          .wheel_radius = r,
          .gradient_force = 0.0,
          .static_load = std::vector<double>(count, load),
          .load_transfer = std::vector<double>(count, 0.0),
          .position = std::vector<double>(count, 0.0)};
}

/// A train of these axles alone, braked until some slide, over `seconds`.
struct Train {
  SimulatedAxles axles;
  SimulatedAxleStates states;
  VirtualRail rail = falling_rail(6e-3);
  RailCells energy{};
  double mass, speed = 20.0, distance = 0.0, brake = 0.0;

  explicit Train(std::size_t count)
      : axles{axles_of(count)}, states{axles, 20.0}, mass{static_cast<double>(count) * load / g} {
    energy.reset(0.05);
  }
  void run(double seconds) {
    double const h = 1e-3;
    for (int k = 0; k * h < seconds; ++k) {
      double const rate = states.force / mass;
      double const pads = 8000.0 * std::fmin(1.0, k * h);
      auto const torque = [](std::size_t) { return 0.0; };
      auto const held = [&](std::size_t, double w) { return -pads * w / std::sqrt(w * w + 0.01); };
      TrainStep const now{k * h, distance, speed + 0.5 * h * rate, rate};
      states.step(axles, rail, now, h, {.energy = {&energy, 1}}, torque, held);
      distance += h * now.speed, speed += h * rate;
    }
  }
};

}  // namespace

TEST_CASE("four identical axles move as one of a quarter of the train") {
  Train four(4), one(1);
  four.run(4.0), one.run(4.0);
  CHECK(one.speed - r * one.states.axle[0].wheels.speed > 1.0);  // they slide
  CHECK(four.speed == doctest::Approx(one.speed).epsilon(1e-12));
  for (std::size_t i = 0; i < 4; ++i)
    CHECK(four.states.axle[i].wheels.speed ==
          doctest::Approx(one.states.axle[0].wheels.speed).epsilon(1e-12));  // round-off of the sum of forces
}

TEST_CASE("an axle of the virtual train and a simulated one are the same under the same torque") {
  VirtualTrain train;
  train.mass = load / g, train.wheelset_inertia = J_w, train.wheel_radius = r;
  train.static_load = {load}, train.load_transfer = {0.0}, train.position = {0.0};
  VirtualTrainState state(train, 20.0);
  SimulatedAxles const axles = axles_of(1);
  SimulatedAxleStates simulated(axles, 20.0);
  VirtualRail const rail = falling_rail(6e-3);
  RailCells energy;
  energy.reset(0.05);
  double const h = 1e-3;
  for (int k = 0; k < 1000; ++k) {
    double const middle = std::fmax(0.0, state.speed + 0.5 * h * state.acceleration);
    simulated.step(
        axles, rail, {k * h, state.distance, middle, state.acceleration}, h, {.energy = {&energy, 1}},
        [](std::size_t) { return -3000.0; }, [](std::size_t, double) { return 0.0; });
    auto const law = [&](int, double slip, double speed, double carries) {
      return rail.force(slip, speed, carries, k * h, state.distance, 0.0, 0.0);
    };
    state.step(train, 1, {-3000.0}, nullptr, 0.0, h, law);
  }
  CHECK(simulated.axle[0].wheels.speed == state.axle[0].speed);
  CHECK(simulated.force == state.axle[0].force);
}

TEST_CASE("energy of a simulated axle closes, and its slip never gives any") {
  Train train(2);
  double const before = 0.5 * J_w * (20.0 / r) * (20.0 / r);
  train.run(6.0);
  for (std::size_t i = 0; i < 2; ++i) {
    auto const& axle = train.states.axle[i];
    double const gained = 0.5 * J_w * axle.wheels.speed * axle.wheels.speed - before;
    double const rest = axle.work - axle.to_train - axle.dissipated - gained;
    CHECK(std::fabs(rest) < 1e-9 * std::fabs(axle.work));  // round-off of six thousand steps
    CHECK(axle.dissipated > 0.0);
  }
}

TEST_CASE("what treads keep does not depend on how far the train has come") {
  Train here(1), far(1);
  here.rail.wheel_memory = far.rail.wheel_memory = 100.0;
  far.distance = 1e6;
  here.run(4.0), far.run(4.0);
  CHECK(here.states.axle[0].rail.wheels.energy > 0.0);
  CHECK(far.states.axle[0].rail.wheels.energy == here.states.axle[0].rail.wheels.energy);
}

TEST_CASE("pads hold a locked wheel of a running train without ringing") {
  Train train(1);
  train.run(8.0);
  CHECK(std::fabs(train.states.axle[0].wheels.speed) < 0.1);
  CHECK(train.speed > 5.0);
  CHECK(std::fabs(train.states.axle[0].wheels.rate) < 1e-2);
}
