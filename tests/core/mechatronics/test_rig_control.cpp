// The rig's control laws against the 1-D equations they were derived from.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "rollerrig/mechatronics/estimators.hpp"
#include "rollerrig/mechatronics/motor.hpp"
#include "rollerrig/mechatronics/rig_controller.hpp"
#include "rollerrig/mechatronics/rig_laws.hpp"
#include "rollerrig/plant/controller_plant.hpp"

using namespace rollerrig;

namespace {

constexpr double r = 0.46, R = 0.725, J_w = 112.0, J_r = 705.0;

VirtualTrain train_of_two_axles() {
  VirtualTrain train;
  train.mass = 22000.0;
  train.wheelset_inertia = J_w;
  train.wheel_radius = r;
  train.static_load = {109100.0, 109100.0};
  train.load_transfer = {0.0, 0.0};
  return train;
}

/// Falling friction, reached over a tenth of a metre per second: enough of a creep law for these tests.
double degraded_force(int, double slip, double, double load) {
  FallingFriction const mu{0.08, 0.4, 0.2};
  return mu(std::abs(slip)) * load * std::tanh(slip / 0.1);
}

/// Without feedback, on a rail of falling friction.
RigController controller_of_two_axles(AnyEstimator const& estimator, double largest, double regularisation_speed) {
  RigController controller{
      .assumed = {.roller_inertia = J_r, .roller_radius = R, .wheelset_inertia = J_w, .wheel_radius = r},
      .estimator = estimator,
      .feedback = NoFeedback{},
      .largest = largest,
      .train = train_of_two_axles()};
  controller.train.position = {1.3, -1.3};
  VirtualRail& rail = controller.rail;
  rail.friction.law = FallingFriction{0.08, 0.4, 0.2};
  rail.wheel_load = 54546.0, rail.a = 6e-3, rail.b = 4e-3, rail.width = 6e-3, rail.cell = 0.05;
  rail.creepage_regularisation_speed = regularisation_speed;
  rail.stiffness = kalker_stiffness(KalkerTable(0.28).at(std::log(1.5)), 82e9, rail.a, rail.b, 1.0);
  return controller;
}

}  // namespace

TEST_CASE("with pure rolling and exact torque the rig's wheels turn as those of the virtual train") {
  RigController controller = controller_of_two_axles(ExactForces{}, 1e9, 0.1);

  double const period = 1e-3, reduced = J_w + J_r * (r / R) * (r / R);
  Measurements now{.axles = 2, .under_test = 2};
  double wheel = 120 / 3.6 / r;
  now.axle_speed = {wheel, wheel};
  auto state = controller.start(now, 120 / 3.6, period);
  PerAxle<double> roller{};
  double worst = 0.0;
  for (int k = 0; k < 20000; ++k) {
    double const torque = -9000.0 * std::min(1.0, k * period / 2.0) * (1.0 + 0.2 * std::sin(7.0 * k * period));
    now.time = k * period;
    now.axle_speed = {wheel, wheel};
    now.true_torque = {torque, torque};
    controller.step(state, now, period, roller);
    wheel += period * (torque + r / R * roller[0]) / reduced;  // pure rolling
    worst = std::max(worst, std::abs(wheel - state.train.axle[0].speed));
  }
  CHECK(state.train.speed - r * wheel > 1.0);  // the wheels do slide on the virtual rail
  CHECK(worst < 1e-9);                         // round-off of twenty thousand additions
}

TEST_CASE("while the brake's torque changes evenly the wheel is late by (D17) without a lead, and by nothing with it") {
  RigController controller = controller_of_two_axles(ExactForces{}, 1e9, 1.0);
  Motor const motor{.bandwidth = 2.0 * pi * 50.0};
  double const reduced = J_w + J_r * (r / R) * (r / R), slope = -1.5e4, fine = 1e-5;
  auto const brake = [&](double t) { return -3400.0 * std::min(1.0, t / 0.5) + slope * std::max(0.0, t - 0.6); };
  auto const rail = [&](int, double slip, double speed, double load) {
    return controller.rail.force(slip, speed, load, 0.0, 0.0, 0.0, 0.0);
  };
  // How late the sliding wheel is behind one whose torque is not sampled: from the rate at which it falls behind.
  auto const late_by = [&](double period) {
    Measurements now{.axles = 2, .under_test = 2};
    double wheel = 120 / 3.6 / r, drive = 0.0, begin = 0.0;
    now.axle_speed = {wheel, wheel};
    auto state = controller.start(now, 120 / 3.6, period);
    VirtualTrainState ideal(controller.train, 120 / 3.6);
    int const parts = static_cast<int>(std::lround(period / fine)), last = static_cast<int>(std::lround(0.9 / period));
    for (int k = 0; k < last; ++k) {
      PerAxle<double> command{};
      now.time = k * period;
      now.axle_speed = {wheel, wheel};
      now.true_torque = {brake(now.time), brake(now.time)};
      controller.step(state, now, period, command);
      double const decay = std::exp(-motor.bandwidth * period);
      double const mean = command[0] + (drive - command[0]) * (1.0 - decay) / (motor.bandwidth * period);
      drive = command[0] + (drive - command[0]) * decay;
      wheel += period * (brake(now.time + 0.5 * period) + r / R * mean) / reduced;  // pure rolling
      for (int j = 0; j < parts; ++j) {
        double const torque = brake(now.time + (j + 0.5) * fine);
        ideal.step(controller.train, 2, {torque, torque}, nullptr, 0.0, fine, rail);
      }
      if (k + 1 == std::lround(0.7 / period)) begin = wheel - ideal.axle[0].speed;
    }
    CHECK(ideal.speed - r * ideal.axle[0].speed > 1.0);  // it slides
    return (wheel - ideal.axle[0].speed - begin) / 0.2 * J_w / -slope;
  };
  for (double const period : {2e-3, 1e-3, 0.5e-3}) {
    double const lag = torque_lag(motor, period, 0.0, 0.0);
    controller.drive_command = DirectCommand{};
    CHECK(late_by(period) == doctest::Approx(lag).epsilon(0.03));  // the rail's force changes with the slip
    controller.drive_command = LeadCommand{lag};
    CHECK(std::fabs(late_by(period)) < 0.01 * lag);
    controller.drive_command = LeadCommand{lag + 0.5 * period};  // as shipped, (D22)
    CHECK(late_by(period) == doctest::Approx(-0.5 * period).epsilon(0.05));
  }
}

TEST_CASE("the drives of locked wheels give the rail's force without ringing, whatever the estimator") {
  RigController controller = controller_of_two_axles(ExactForces{}, 2e4, 1.0);
  double const period = 1e-3, reduced = J_w + J_r * (r / R) * (r / R);
  double const brake = 3e4;                              // holds the wheel: viscous [N m s/rad]
  double const drive = 1.0 - std::exp(-314.0 * period);  // of 50 Hz
  double const held = 1.0 - std::exp(-brake / reduced * period);

  struct Motion {
    double ringing;  ///< RMS of the drive's torque about its mean [N m]
    double off;      ///< mean of U + R T_v [N m]
  };
  // Pure rolling; the wheel already stands, the train runs at 20 m/s, and the drive starts from a torque of its own.
  auto const run = [&](AnyEstimator const& estimator, double locked_speed) {
    controller.estimator = estimator;
    controller.locked_speed = locked_speed;
    Measurements now{.axles = 1, .under_test = 1};
    auto state = controller.start(now, 20.0, period);
    state.train.axle[0].locked = true, state.train.axle[0].speed = 0.0;
    double wheel = 0.0, torque = 500.0, mean = 0.0, square = 0.0, off = 0.0;
    int const samples = 3000, late = 2000;
    for (int k = 0; k < samples; ++k) {
      PerAxle<double> command{};
      now.time = k * period;
      now.axle_speed[0] = wheel, now.roller_speed[0] = r / R * wheel, now.roller_torque[0] = torque;
      controller.step(state, now, period, command);
      torque += drive * (command[0] - torque);
      wheel += held * (r / R * torque / brake - wheel);
      if (k < samples - late) continue;
      mean += torque / late, square += torque * torque / late;
      off += (torque + R * state.train.axle[0].force) / late;
    }
    return Motion{std::sqrt(std::fmax(0.0, square - mean * mean)), off};
  };

  double const bandwidth = 2.0 * pi * 20.0;
  KalmanFilter const kalman{.bandwidth = bandwidth, .speed_noise = 1e-3};
  for (AnyEstimator const& estimator : {AnyEstimator{kalman}, AnyEstimator{DisturbanceObserver{bandwidth, 0.8}},
                                        AnyEstimator{FilteredDerivative{bandwidth}}}) {
    Motion const locked = run(estimator, 0.1);
    CHECK(locked.ringing < 10.0);
    CHECK(std::fabs(locked.off) < 10.0);
  }
  CHECK(run(kalman, 0.0).ringing > 1000.0);  // what the reaction of the brake would do through (D3)
}

TEST_CASE("the virtual train stops in the distance of its adhesion") {
  auto train = train_of_two_axles();
  double const v0 = 20.0;
  VirtualTrainState virtual_train(train, v0);
  PerAxle<double> const locked{-30000.0, -30000.0};  // far more than the rail can take: full sliding
  double const mu = 0.1;
  auto const coulomb = [&](int, double slip, double, double load) { return mu * load * std::tanh(slip / 1e-3); };
  double time = 0.0;
  while (virtual_train.speed > 1.0) {
    virtual_train.step(train, 2, locked, nullptr, 0.0, 1e-3, coulomb);
    time += 1e-3;
  }
  double const deceleration = mu * 2 * 109100.0 / 22000.0;
  double const v = virtual_train.speed;
  CHECK(time == doctest::Approx((v0 - v) / deceleration).epsilon(2e-3));  // the first moments build the slip up
  CHECK(virtual_train.distance == doctest::Approx((v0 * v0 - v * v) / (2 * deceleration)).epsilon(2e-3));
}

TEST_CASE("the virtual axle is integrated to second order") {
  auto const train = train_of_two_axles();
  auto const end_speed = [&](double period) {
    VirtualTrainState state(train, 30.0);
    int const steps = static_cast<int>(std::lround(1.0 / period));
    for (int k = 0; k < steps; ++k) state.step(train, 2, {-4000.0, -6000.0}, nullptr, 0.0, period, degraded_force);
    return state.axle[1].speed;
  };
  double const reference = end_speed(1e-5);
  double const coarse = std::abs(end_speed(4e-3) - reference);
  double const fine = std::abs(end_speed(2e-3) - reference);
  CHECK(coarse / fine > 3.0);
  CHECK(coarse < 1e-3);
}

TEST_CASE("the estimates settle on the contact force, as fast as their bandwidth says") {
  AssumedParameters const wheel_and_roller{J_r, R, J_w, r};
  auto const settles = [&](auto const& law) {
    double const period = 1e-3;
    double roller = 40.0, wheel = roller * R / r;
    auto state = law.start(wheel_and_roller, period, {.roller_speed = roller, .wheel_speed = wheel});
    double const force = 5000.0, torque = -2000.0, axle_torque = 3000.0;  // constant from the start
    double reached = 0.0;
    ContactForceEstimate found;
    for (int k = 1; k <= 400; ++k) {
      roller += period * (torque + R * force) / J_r;
      wheel += period * (axle_torque - r * force) / J_w;
      found = law.step(state, wheel_and_roller, {roller, wheel, torque}, period);
      if (reached == 0.0 && found.force > 0.632 * force) reached = k * period;
    }
    CHECK(found.force == doctest::Approx(force).epsilon(1e-6));
    CHECK(found.torque == doctest::Approx(axle_torque).epsilon(1e-6));
    CHECK(reached > 0.5 / law.bandwidth);
    CHECK(reached < 2.5 / law.bandwidth);
  };
  settles(FilteredDerivative{.bandwidth = 2 * pi * 20});
  settles(DisturbanceObserver{.bandwidth = 2 * pi * 20, .damping_ratio = 0.8});
}

TEST_CASE("feedback does not wind up at the limit of the command") {
  ProportionalIntegral const p{.proportional = 100.0, .integral = 1000.0};
  ProportionalIntegral::State state;
  double const limit = 500.0;
  auto const torque = [&](double error) {
    return std::clamp(p.step(state, {J_r, R, J_w, r}, {0.0, error, 1e-2}, limit), -limit, limit);
  };
  for (int k = 0; k < 1000; ++k) CHECK(torque(10.0) == 500.0);
  CHECK(torque(-1.0) < 500.0);
  double after = 500.0;
  for (int k = 0; k < 60; ++k) after = torque(-1.0);
  CHECK(after < 0.0);
}

TEST_CASE("absent gains place the poles of wheel and roller as one inertia where bandwidth and damping say") {
  double const w = 4.0, zeta = 0.7, period = 1e-4;
  ProportionalIntegral const p{.bandwidth = w, .damping_ratio = zeta};
  ProportionalIntegral::State state;
  // Pure rolling: (J_w + J_r (r/R)^2) w' = (r/R) U. Under a constant disturbance the error is that of s^2 + 2 zeta w s + w^2.
  double const inertia = J_w + J_r * (r / R) * (r / R), disturbance = 500.0;
  double speed = 0.0;
  for (int k = 0; k * period < 0.5; ++k) {
    double const drive = p.step(state, {J_r, R, J_w, r}, {0.0, -speed, period}, 1e9);
    speed += period * (disturbance + r / R * drive) / inertia;
  }
  double const damped = w * std::sqrt(1 - zeta * zeta);
  double const exact = disturbance / inertia / damped * std::exp(-zeta * w * 0.5) * std::sin(damped * 0.5);
  CHECK(speed == doctest::Approx(exact).epsilon(2e-3));  // Euler steps of 0.1 ms
  CHECK(p.gains({J_r, R, J_w, r}).proportional == doctest::Approx(2 * zeta * w * inertia * R / r));
  ProportionalIntegral const given{.bandwidth = w, .damping_ratio = zeta, .proportional = 1.0, .integral = 2.0};
  CHECK(given.gains({J_r, R, J_w, r}).proportional == 1.0);
  CHECK(given.gains({J_r, R, J_w, r}).integral == 2.0);
}

TEST_CASE("sliding mode is in proportion within its boundary layer and of constant size outside") {
  SlidingMode const p{.switching = 800.0, .boundary_layer = 0.5};
  SlidingMode::State state;
  CHECK(p.step(state, {J_r, R, J_w, r}, {100.0, 0.25, 1e-3}, 1e9) == doctest::Approx(500.0));
  CHECK(p.step(state, {J_r, R, J_w, r}, {100.0, -3.0, 1e-3}, 1e9) == doctest::Approx(-700.0));
}

TEST_CASE(
    "a virtual axle that grips firmly at low speed rolls with the train: no ringing, no jump to the other branch") {
  VirtualTrain train{.mass = 11e3, .wheelset_inertia = J_w, .wheel_radius = r};
  train.static_load = {109e3};
  train.load_transfer = {0.0};
  VirtualTrainState state(train, 5.0);
  double const torque = -5900.0;
  // Steep at small slip, flat beyond: 22 MN over the creepage, 33 kN at most.
  auto const law = [](int, double slip, double speed, double) {
    return 33e3 * std::tanh(22e6 / 33e3 * slip / std::hypot(speed, 1.0));
  };
  while (state.speed > 0.5) {
    state.step(train, 1, {torque}, nullptr, 0.0, 1e-3, law);
    REQUIRE(std::fabs(train.wheel_radius * state.axle[0].speed - state.speed) < 0.02);
    REQUIRE(state.axle[0].force < 0.0);
  }
}

/// Of two axles that roll at 30 m/s, sampled every millisecond.
ControllerPlant small_motions() {
  double const speed = 30.0;
  ControllerPlant plant({.name = "small",
                         .step = 1e-3,
                         .controller = {.controller = controller_of_two_axles(FilteredDerivative{125.0}, 1e9, 1.0)},
                         .axles = {"axle_1", "axle_2"},
                         .train_speed = speed,
                         .axle_speed = {speed / r, speed / r},
                         .roller_speed = {speed / R, speed / R}});
  plant.start(1.0);
  return plant;
}

int index_of(ControllerPlant const& plant, char const* name) {
  auto const all = plant.variables();
  return static_cast<int>(std::ranges::find(all, name, &Variable::name) - all.begin());
}

TEST_CASE(
    "small motions of the controller alone: torque of a drive, filtered, through (D3) and (D5) on a rail that gives "
    "nothing") {
  double const low_pass = 1.0 - std::exp(-125.0 * 1e-3);
  ControllerPlant plant = small_motions();
  REQUIRE(plant.set_input(index_of(plant, "train.friction_change"), -1.0));
  std::array const moves{std::pair{index_of(plant, "axle_1.roller_torque"), 100.0}};
  auto const [rows, columns, matrix] = plant.jacobian(moves);
  CHECK(rows - 2 == columns - 1);
  double const* command = &matrix[(rows - 2) * columns];
  CHECK(command[columns - 1] == doctest::Approx(-low_pass * J_r * (r / R) * (r / R) / J_w).epsilon(1e-9));
  CHECK(command[2 * columns - 1] == 0.0);  // of the other axle
  CHECK(plant.jacobian(moves).matrix == matrix);
}

TEST_CASE("small motions of the controller are those about the motion of its train, however fast that brakes") {
  auto const found = [](double track_brake_force, double move) {
    ControllerPlant plant = small_motions();
    REQUIRE(plant.set_input(index_of(plant, "train.track_brake_force"), track_brake_force));
    std::array const moves{std::pair{index_of(plant, "axle_1.roller_torque"), move}};
    return plant.jacobian(moves);
  };
  auto const steady = found(0.0, 1.0), braking = found(50e3, 1.0);
  REQUIRE(braking.rows == steady.rows);
  REQUIRE(braking.columns == steady.columns);
  for (std::size_t k = (steady.rows - 2) * steady.columns; k < steady.matrix.size(); ++k)  // the commands
    CHECK(braking.matrix[k] == doctest::Approx(steady.matrix[k]).epsilon(1e-6));
  CHECK(found(0.0, 1e-6).rows < steady.rows);  // of such a torque the train feels some rounding
}
