// The rig's control laws against the 1-D equations they were derived from.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "rollerrig/contact/adhesion/adhesion_map.hpp"
#include "rollerrig/mechatronics/contact_force_estimator.hpp"
#include "rollerrig/mechatronics/rig_controller.hpp"
#include "rollerrig/mechatronics/virtual_train.hpp"

using namespace rollerrig;

namespace {

constexpr double r = 0.46, R = 0.725, J_w = 112.0, J_r = 705.0;

VirtualTrain train_of_two_axles() {
  VirtualTrain train;
  train.axles = 2;
  train.mass = 22000.0;
  train.wheelset_inertia = J_w;
  train.wheel_radius = r;
  train.static_load = {109100.0, 109100.0};
  return train;
}

/// Falling friction, reached over a tenth of a metre per second: enough of a creep law for these tests.
double degraded_force(int, double slip, double, double load) {
  FallingFriction const mu{0.08, 0.4, 0.2};
  return mu(std::abs(slip)) * load * std::tanh(slip / 0.1);
}

}  // namespace

TEST_CASE("with ideal rolling and exact torque the rig's wheels turn as those of the virtual train") {
  auto const train = train_of_two_axles();
  VirtualTrainState virtual_train;
  virtual_train.reset(train, 120 / 3.6);
  RigFeedbackState feedback;
  feedback.reset();
  RigFeedback const none{.kind = FeedbackKind::none};
  double const period = 1e-3;
  double wheel = 120 / 3.6 / r;
  double worst = 0.0;
  for (int k = 0; k < 20000; ++k) {
    double const torque = -9000.0 * std::min(1.0, k * period / 2.0) * (1.0 + 0.2 * std::sin(7.0 * k * period));
    double const torques[] = {torque, torque};
    virtual_train.step(train, torques, period, degraded_force);
    double const feed_forward = J_r * r / R * virtual_train.axle_rate(0) - R * virtual_train.force(0);  // (D5)
    double const roller = feedback.step(none, feed_forward, virtual_train.axle_speed(0) - wheel, period);
    wheel += period * (torque + r / R * roller) / (J_w + J_r * (r / R) * (r / R));  // pure rolling
    worst = std::max(worst, std::abs(wheel - virtual_train.axle_speed(0)));
  }
  CHECK(virtual_train.speed() - r * wheel > 1.0);  // the wheels do slide on the virtual rail
  CHECK(worst < 1e-9);                             // round-off of twenty thousand additions
}

TEST_CASE("the virtual train stops in the distance of its adhesion") {
  auto train = train_of_two_axles();
  VirtualTrainState virtual_train;
  double const v0 = 20.0;
  virtual_train.reset(train, v0);
  double const locked[] = {-30000.0, -30000.0};  // far more than the rail can take: full sliding
  double const mu = 0.1;
  auto const coulomb = [&](int, double slip, double, double load) { return mu * load * std::tanh(slip / 1e-3); };
  double time = 0.0;
  while (virtual_train.speed() > 1.0) {
    virtual_train.step(train, locked, 1e-3, coulomb);
    time += 1e-3;
  }
  double const deceleration = mu * 2 * 109100.0 / 22000.0;
  double const v = virtual_train.speed();
  CHECK(time == doctest::Approx((v0 - v) / deceleration).epsilon(2e-3));  // the first moments build the slip up
  CHECK(virtual_train.distance() == doctest::Approx((v0 * v0 - v * v) / (2 * deceleration)).epsilon(2e-3));
}

TEST_CASE("the virtual axle is integrated to second order") {
  auto const train = train_of_two_axles();
  auto const end_speed = [&](double period) {
    VirtualTrainState state;
    state.reset(train, 30.0);
    int const steps = static_cast<int>(std::lround(1.0 / period));
    for (int k = 0; k < steps; ++k) {
      double const torques[] = {-4000.0, -6000.0};
      state.step(train, torques, period, degraded_force);
    }
    return state.axle_speed(1);
  };
  double const reference = end_speed(1e-5);
  double const coarse = std::abs(end_speed(4e-3) - reference);
  double const fine = std::abs(end_speed(2e-3) - reference);
  CHECK(coarse / fine > 3.0);
  CHECK(coarse < 1e-3);
}

TEST_CASE("the estimates settle on the contact force, as fast as their bandwidth says") {
  for (auto kind : {EstimatorKind::filtered_derivative, EstimatorKind::observer}) {
    ContactForceEstimator const p{.kind = kind,
                                  .bandwidth = 2 * pi * 20,
                                  .roller_inertia = J_r,
                                  .roller_radius = R,
                                  .wheelset_inertia = J_w,
                                  .wheel_radius = r};
    ContactForceEstimate estimate;
    double const period = 1e-3;
    double roller = 40.0, wheel = roller * R / r;
    estimate.reset(roller, wheel, 0.0);
    double const force = 5000.0, torque = -2000.0, axle_torque = 3000.0;  // constant from the start
    double reached = 0.0;
    for (int k = 1; k <= 400; ++k) {
      roller += period * (torque + R * force) / J_r;
      wheel += period * (axle_torque - r * force) / J_w;
      estimate.step(p, roller, wheel, torque, period);
      if (reached == 0.0 && estimate.force() > 0.632 * force) reached = k * period;
    }
    CHECK(estimate.force() == doctest::Approx(force).epsilon(1e-6));
    CHECK(estimate.axle_torque(p) == doctest::Approx(axle_torque).epsilon(1e-6));
    CHECK(reached > 0.5 / p.bandwidth);
    CHECK(reached < 2.5 / p.bandwidth);
  }
}

TEST_CASE("feedback does not wind up at the limit of the command") {
  RigFeedback const p{.proportional = 100.0, .integral = 1000.0, .largest = 500.0};
  RigFeedbackState state;
  state.reset();
  for (int k = 0; k < 1000; ++k) CHECK(std::abs(state.step(p, 0.0, 10.0, 1e-2)) <= 500.0);
  CHECK(state.step(p, 0.0, -1.0, 1e-2) < 500.0);
  double after = 500.0;
  for (int k = 0; k < 60; ++k) after = state.step(p, 0.0, -1.0, 1e-2);
  CHECK(after < 0.0);
}

TEST_CASE(
    "a virtual axle that grips firmly at low speed rolls with the train: no ringing, no jump to the other branch") {
  VirtualTrain train;
  train.axles = 1;
  train.static_load[0] = 109e3;
  train.mass = 11e3;
  VirtualTrainState state;
  state.reset(train, 5.0);
  double const torque = -5900.0;
  // Steep at small slip, flat beyond: 22 MN over the creepage, 33 kN at most.
  auto const law = [](int, double slip, double speed, double) {
    return 33e3 * std::tanh(22e6 / 33e3 * slip / std::hypot(speed, 1.0));
  };
  while (state.speed() > 0.5) {
    state.step(train, &torque, 1e-3, law);
    REQUIRE(std::fabs(train.wheel_radius * state.axle_speed(0) - state.speed()) < 0.02);
    REQUIRE(state.force(0) < 0.0);
  }
}
