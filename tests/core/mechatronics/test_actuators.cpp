// Motor, wheel slide protection, wheel-slip control, encoders.
#include <doctest/doctest.h>

#include <cmath>
#include <concepts>
#include <numeric>
#include <vector>

#include "rollerrig/contact/adhesion/friction.hpp"
#include "rollerrig/contact/adhesion/rail_memory.hpp"
#include "rollerrig/math/dual.hpp"
#include "rollerrig/mechatronics/measurements.hpp"
#include "rollerrig/mechatronics/motor.hpp"
#include "rollerrig/mechatronics/sensors.hpp"
#include "rollerrig/mechatronics/wheel_slide_protection.hpp"
#include "rollerrig/mechatronics/wheel_slip_control.hpp"

using namespace rollerrig;

namespace {

WheelSlideProtection protection_by(AnySlideProtection const& law) {
  return {.law = law,
          .wheel_radius = 0.46,
          .reference_deceleration = 1.6,
          .filter_time = 0.04,
          .recovery_acceleration = 0.5,
          .longest_vent = 5.0,
          .least_speed = 5.0 / 3.6,
          .return_speed = 5.0 / 3.6,
          .release_interval = 3.0,
          .shortest_release = 0.3,
          .longest_release = 1.2,
          .least_deceleration = 0.2,
          .regained_after = 2.0};
}

WheelSlideProtection const wsp = protection_by(SlipAndDeceleration{.vent_slip = 0.12,
                                                                   .vent_slip_speed = 1.0,
                                                                   .vent_deceleration = 4.0,
                                                                   .fill_slip = 0.06,
                                                                   .fill_slip_speed = 0.5,
                                                                   .pulse_time = 0.06,
                                                                   .pulse_pause = 0.14});

ThresholdTable const threshold_table{.least_slip_reference = 8.3,
                                     .slip_thresholds = {0.05, 0.1, 0.2},
                                     .acceleration_thresholds = {-4.0, -1.5, 0.5},
                                     .entries = {1, 0, 0, 0, 2, 1, 1, 1, 2, 3, 3, 1, 2, 2, 2, 1},
                                     .pulse_time = 0.06,
                                     .pulse_pause = 0.14};

WheelSlipControl const slip_control{.wheel_radius = 0.46,
                                    .reference_acceleration = 1.5,
                                    .slip = 0.04,
                                    .slip_speed = 0.15,
                                    .acceleration = 3.0,
                                    .filter_time = 0.04,
                                    .reduction_rate = 4.0,
                                    .restoring_rate = 0.35,
                                    .least_factor = 0.05,
                                    .release_interval = 3.0,
                                    .shortest_release = 0.4,
                                    .longest_release = 1.2,
                                    .release_deceleration = 0.5,
                                    .least_acceleration = 0.05,
                                    .regained_after = 3.0};

/// A controller of two axles with the speeds that it sees.
template <class Law>
struct Device {
  Law const& law;
  double period;
  typename Law::State state;
  PerAxle<double> command{};

  Device(Law const& the_law, double speed, double the_period)
      : law{the_law}, period{the_period}, state{law.start({}, speed, period)} {}

  /// @param speeds  at the wheels' circumferences [m/s]
  PerAxle<double> const& step(double first, double second) {
    Measurements now{.axles = 2};
    now.vehicle_axle_speed = {first / law.wheel_radius, second / law.wheel_radius};
    law.step(state, now, period, command);
    return command;
  }
};

DumpValve valve(double command) { return static_cast<DumpValve>(static_cast<int>(command)); }

}  // namespace

TEST_CASE("falling friction starts at mu_0, ends at A mu_0, and recovery leads from one curve to the other") {
  FallingFriction const curve{0.3, 0.4, 0.2};
  CHECK(curve(0.0) == doctest::Approx(0.3).epsilon(1e-14));
  CHECK(curve(1e3) == doctest::Approx(0.12).epsilon(1e-14));
  CHECK(curve(5.0) == doctest::Approx(0.3 * (0.6 * std::exp(-1.0) + 0.4)).epsilon(1e-14));
  RailAdhesion const rail{{FallingFriction{0.06, 0.4, 0.2}}, {FallingFriction{0.28, 0.4, 0.6}}, 1.9e-4};
  CHECK(rail.at(2.0, 0.0).friction == doctest::Approx(rail.degraded.at(2.0).friction).epsilon(1e-14));
  CHECK(rail.at(2.0, 1e6).friction == doctest::Approx(rail.recovered.at(2.0).friction).epsilon(1e-14));
  double const half = std::log(2.0) / rail.recovery_constant;
  CHECK(rail.at(2.0, half).friction ==
        doctest::Approx(0.5 * (rail.degraded.at(2.0).friction + rail.recovered.at(2.0).friction)).epsilon(1e-14));
}

TEST_CASE("the recovery is the integral of its rate: each joule recovers the same part of what is still degraded") {
  RailAdhesion const rail{{FallingFriction{0.06, 0.4, 0.2}}, {FallingFriction{0.28, 0.4, 0.6}}, 1.9e-4};
  double degraded = 1.0, energy = 0.0;  // d(1 - lambda) = -tau (1 - lambda) dW
  int const steps = 200000;
  for (int k = 0; k < steps; ++k) {
    double const dissipated = 3e4 * (1.0 + std::sin(1e-4 * k)) / steps;
    degraded -= rail.recovery_constant * (degraded - 0.5 * rail.recovery_constant * degraded * dissipated) *
                dissipated;  // midpoint
    energy += dissipated;
  }
  double const recovered = rail.recovered.at(3.0).friction, worst = rail.degraded.at(3.0).friction;
  CHECK(degraded < 0.02);  // it has come to something
  CHECK(rail.at(3.0, energy).friction == doctest::Approx(recovered + degraded * (worst - recovered)).epsilon(1e-8));
}

TEST_CASE("reductions of the creep curve of a half recovered rail are blended like the friction") {
  AdhesionMap map;
  RailCondition const recovered{ConstantFriction{0.5}, 1.0, 0.4};
  map.pieces = {{{ConstantFriction{0.3}, 0.3, 0.1}, recovered, 1e-4},
                {{ConstantFriction{0.1}, 0.2, 0.2}, recovered, 1e-4}};
  map.borders = {100.0}, map.blend = 4.0;
  double const half = std::log(2.0) / 1e-4;
  CHECK(map(0.0, 0.0, half).k_A == doctest::Approx(0.65).epsilon(1e-12));
  CHECK(map(0.0, 0.0, half).k_S == doctest::Approx(0.25).epsilon(1e-12));
  CHECK(map(102.0, 0.0, 0.0).k_A == doctest::Approx(0.25).epsilon(1e-12));
  CHECK(map(102.0, 0.0, 0.0).k_S == doctest::Approx(0.15).epsilon(1e-12));
  CHECK(map(102.0, 0.0, 0.0).friction == doctest::Approx(0.2).epsilon(1e-12));
}

TEST_CASE("adhesion changes from piece to piece, smoothly where asked") {
  AdhesionMap map;
  map.pieces.clear();
  for (double mu : {0.3, 0.05, 0.2}) map.pieces.push_back({{ConstantFriction{mu}}, {ConstantFriction{mu}}});
  map.borders = {100.0, 200.0};
  CHECK(map(99.9, 1.0, 0.0).friction == 0.3);
  CHECK(map(100.0, 1.0, 0.0).friction == 0.05);
  CHECK(map(250.0, 1.0, 0.0).friction == 0.2);
  map.blend = 4.0;
  CHECK(map(100.0, 1.0, 0.0).friction == doctest::Approx(0.3).epsilon(1e-12));
  CHECK(map(102.0, 1.0, 0.0).friction == doctest::Approx(0.175).epsilon(1e-12));
  CHECK(map(104.0, 1.0, 0.0).friction == doctest::Approx(0.05).epsilon(1e-12));
  auto const slope = map(Dual<1>::variable(101.0, 0), Dual<1>(1.0), Dual<1>(0.0)).friction.d[0];
  CHECK(slope ==
        doctest::Approx((map(101.001, 1.0, 0.0).friction - map(100.999, 1.0, 0.0).friction) / 0.002).epsilon(1e-6));
}

TEST_CASE("a wheel finds what the wheels ahead have dissipated, and nothing of its own") {
  for (double step : {0.031, 0.004}) {
    RailCells rail;
    rail.reset();
    double const behind = 2.56;  // the next axle
    for (int k = 0; k * step < 20.0; ++k) {
      double const x = k * step;
      CHECK(rail.before(x) == 0.0);
      CHECK(rail.before(x - behind) ==
            doctest::Approx(x < behind + 0.05 ? rail.before(x - behind) : 7.0).epsilon(1e-9));
      rail.add(x, x + step, 7.0);
      rail.add(x - behind, x - behind + step, 3.0);
    }
  }
}

TEST_CASE("a cleaned rail remembers each wheel's energy once, however small the steps") {
  auto const pass = [](double step) {
    RailCells rail;
    rail.reset();
    for (int k = 0; k * step < 20.0 - 1e-9; ++k) rail.add(k * step, (k + 1) * step, 7.0);
    return rail;
  };
  for (double step : {0.5, 0.013}) {
    auto rail = pass(step);
    for (double s : {1.0, 7.3, 19.0}) CHECK(rail.at(s) == doctest::Approx(7.0).epsilon(1e-9));
    CHECK(rail.at(25.0) == 0.0);
    rail.add(3.0, 9.0, 2.0);  // a following wheel
    CHECK(rail.at(5.0) == doctest::Approx(9.0).epsilon(1e-9));
    CHECK(rail.at(12.0) == doctest::Approx(7.0).epsilon(1e-9));
    rail.add(20.0, 200.0, 1.0);  // far ahead: what is forgotten reads as untouched
    CHECK(rail.at(5.0) == 0.0);
  }
}

TEST_CASE("a wheel keeps of its cleaning what its circumference and its memory leave") {
  double const around = 2.0 * pi * 0.46, memory = 30.0, own = 5e3;  // [m], [m], [J/m^2]
  auto const after = [&](double length, double step, double roll, double of_memory) {
    CleanedWheel wheel;
    for (double s = 0.0; s < length - 1e-9; s += step) wheel.run(own, step, roll * step, around, of_memory);
    return wheel;
  };
  // dE/ds = e / (2 pi r) - E / L, whatever the step: to its settled value e L / (2 pi r)
  for (double step : {0.03, 1.0})
    CHECK(after(45.0, step, 1.0, memory).energy ==
          doctest::Approx(own * memory / around * -std::expm1(-45.0 / memory)).epsilon(1e-9));
  CHECK(after(45.0, 0.05, 1.0, 0.0).energy == 0.0);                                                    // switched off
  CHECK(after(45.0, 0.05, 0.0, memory).energy == doctest::Approx(own * 45.0 / around).epsilon(1e-9));  // locked
  CleanedWheel wheel = after(45.0, 0.05, 1.0, memory);
  double const cleaned = wheel.energy;
  for (int k = 0; k < 600; ++k) wheel.run(0.0, 0.1, 0.1, around, memory);  // rolls 60 m without sliding
  CHECK(wheel.energy == doctest::Approx(cleaned * std::exp(-2.0)).epsilon(1e-9));
}

TEST_CASE("a motor stays within its envelope and follows with its bandwidth") {
  Motor const motor{
      .envelope = {{0.0, 100.0, 200.0}, {8000.0, 8000.0, 4000.0}}, .bandwidth = 50.0, .damping_ratio = 0.0};
  CHECK(motor.within_envelope(1e5, 50.0) == 8000.0);
  CHECK(motor.within_envelope(-1e5, -150.0) == -6000.0);
  CHECK(motor.within_envelope(1e5, 400.0) == 0.0);  // beyond the last point the line goes on, never below nothing
  CHECK(motor.within_envelope(10.0, 150.0) == 10.0);
  double torque = 0.0, rate = 0.0;
  double const h = 1e-5;
  for (int k = 0; k < 2000; ++k) {
    motor.rates(&torque, 5000.0, 10.0, &rate);
    torque += h * rate;
  }
  CHECK(torque ==
        doctest::Approx(5000.0 * (1 - std::exp(-1.0))).epsilon(1e-3));  // Euler: half a step of 1e-5 s in 20 ms
}

TEST_CASE("a motor's torque, power and speed have limits, each on its own") {
  Motor const motor{.envelope = {},
                    .bandwidth = 50.0,
                    .damping_ratio = 0.0,
                    .largest_torque = 8000.0,
                    .largest_power = 4e5,
                    .largest_speed = 180.0};
  CHECK(motor.within_envelope(1e5, 0.0) == 8000.0);
  CHECK(motor.within_envelope(-1e5, 50.0) == -8000.0);
  CHECK(motor.within_envelope(1e5, 100.0) == doctest::Approx(4000.0));
  CHECK(motor.within_envelope(-1e5, -160.0) == doctest::Approx(-2500.0));
  CHECK(motor.within_envelope(100.0, 160.0) == 100.0);
  CHECK(motor.within_envelope(100.0, 181.0) == 0.0);
  auto const slope = motor.within_envelope(Dual<1>(1e5), Dual<1>::variable(100.0, 0)).d[0];
  CHECK(slope == doctest::Approx(-4e5 / 1e4));
}

TEST_CASE("a second-order torque loop overshoots as its damping says") {
  Motor const motor{.envelope = {}, .bandwidth = 100.0, .damping_ratio = 0.5};
  double state[2] = {0.0, 0.0}, rate[2];
  double largest = 0.0;
  double const h = 1e-5;
  for (int k = 0; k < 10000; ++k) {
    motor.rates(state, 1000.0, 0.0, rate);
    state[1] += h * rate[1];
    state[0] += h * state[1];
    largest = std::max(largest, state[0]);
  }
  double const overshoot = std::exp(-pi * 0.5 / std::sqrt(1 - 0.25));
  CHECK(largest == doctest::Approx(1000.0 * (1 + overshoot)).epsilon(1e-3));
}

TEST_CASE("wheel slide protection vents a sliding axle, refills it, and lets a gripping one alone") {
  double const period = 5e-3;
  Device device(wsp, 30.0, period);
  double slow = 30.0, train = 30.0;
  int vented = 0;
  for (int k = 0; k < 100; ++k) {  // axle 1 locks up at 10 m/s^2, axle 0 follows the train
    train -= 1.0 * period, slow -= 10.0 * period;
    bool const before = valve(device.command[1]) == DumpValve::vent;
    CHECK(valve(device.step(train, slow)[0]) == DumpValve::fill);
    vented += !before && valve(device.command[1]) == DumpValve::vent;
  }
  CHECK(valve(device.command[1]) == DumpValve::vent);
  CHECK(vented == 1);
  while (slow < train) {  // it regains speed: nothing is filled before it has
    train -= 1.0 * period, slow += 5.0 * period;
    device.step(train, slow);
  }
  int open = 0;
  for (int k = 0; k < 200; ++k) {
    train -= 1.0 * period;
    device.step(train, train);
    open += valve(device.command[1]) == DumpValve::fill;
    CHECK(valve(device.command[1]) != DumpValve::vent);
  }
  CHECK(open > 40);  // filled in steps: 60 ms of every 200 ms
  CHECK(open < 80);
}

TEST_CASE("the watchdog fills after the longest vent, and everything fills near standstill") {
  double const period = 1e-2;
  Device device(wsp, 40.0, period);
  double train = 40.0;
  bool refilled = false;
  for (int k = 0; k < 600; ++k) {
    train -= 1.0 * period;
    device.step(train, 0.0);
    refilled = refilled || (k > 300 && valve(device.command[1]) == DumpValve::fill);
  }
  CHECK(refilled);
  for (int k = 0; k < 3000; ++k) device.step(1.0, 0.0);
  CHECK(valve(device.command[1]) == DumpValve::fill);
}

TEST_CASE("a table of thresholds passes through the phases of an anti-lock cycle") {
  using Entry = ThresholdTable::Entry;
  double const period = 5e-3;
  WheelSlideProtection const protection = protection_by(threshold_table);
  Device device(protection, 30.0, period);
  CHECK(threshold_table.entry(0.0, 0.0) == Entry::fill);
  CHECK(threshold_table.entry(0.0, -9.0) == Entry::hold);
  CHECK(threshold_table.entry(0.08, -9.0) == Entry::vent);
  CHECK(threshold_table.entry(0.15, 0.0) == Entry::vent_in_steps);
  CHECK(threshold_table.entry(0.3, 0.0) == Entry::vent);
  CHECK(threshold_table.entry(0.3, 2.0) == Entry::hold);
  double train = 30.0, slow = 30.0;
  std::vector<DumpValve> phases{DumpValve::fill};
  auto const note = [&](DumpValve now) {
    if (now != phases.back()) phases.push_back(now);
  };
  for (int k = 0; k < 60; ++k) {  // axle 1 locks up at 20 m/s^2, axle 0 follows the train
    train -= 1.0 * period, slow -= 20.0 * period;
    CHECK(valve(device.step(train, slow)[0]) == DumpValve::fill);
    note(valve(device.command[1]));
  }
  while (slow < train - 1e-9) {
    train -= 1.0 * period, slow = std::fmin(train, slow + 20.0 * period);
    note(valve(device.step(train, slow)[1]));
  }
  phases.resize(5);  // then pulses
  CHECK((phases == std::vector{DumpValve::fill, DumpValve::hold, DumpValve::vent, DumpValve::hold, DumpValve::fill}));
  int open = 0;
  for (int k = 0; k < 200; ++k) {
    train -= 1.0 * period;
    open += valve(device.step(train, train)[1]) == DumpValve::fill;
  }
  CHECK(open > 40);  // filled in steps: 60 ms of every 200 ms
  CHECK(open < 80);
  CHECK(device.state.reference_speed() == doctest::Approx(train).epsilon(1e-3));
}

TEST_CASE("wheel-slip control takes torque off the slipping axle and gives it back") {
  Device device(slip_control, 5.0, 5e-3);
  for (int k = 0; k < 40; ++k) device.step(5.0, 5.0 + 0.05 * k);
  CHECK(device.command[0] == 1.0);
  CHECK(device.command[1] < 0.5);
  for (int k = 0; k < 2000; ++k) device.step(5.0, 5.0);
  CHECK(device.command[0] == 1.0);
  CHECK(device.command[1] == 1.0);
}

TEST_CASE("commands act after their delay, in the order in which they were sent") {
  DelayedCommands commands(1.0, 3);
  for (long step = 0; step < 12; ++step) {
    if (step % 4 == 0) commands.send({static_cast<double>(step)}, step);
    commands.advance(step);
    CHECK(commands.acting()[0] == (step < 3 ? 1.0 : step < 7 ? 0.0 : step < 11 ? 4.0 : 8.0));
  }
}

TEST_CASE("noise has mean 0 and deviation 1") {
  double sum = 0.0, squares = 0.0;
  int const n = 100000;
  for (int k = 0; k < n; ++k) {
    double const x = normal_number(42, static_cast<std::uint64_t>(k));
    sum += x, squares += x * x;
  }
  CHECK(std::abs(sum / n) < 4 / std::sqrt(n));  // four standard errors
  CHECK(squares / n == doctest::Approx(1.0).epsilon(4 * std::sqrt(2.0 / n)));
}

TEST_CASE("a protection that is off near standstill comes back above its own threshold alone") {
  auto const switches = [](double return_speed) {
    WheelSlideProtection law = wsp;
    law.return_speed = return_speed;
    Device device(law, 4.0, 5e-3);
    int changes = 0;
    for (int k = 0; k < 4000; ++k) {  // the train hovers about least_speed, 1.39 m/s; axle 1 is locked
      double const train = 1.39 + 0.2 * std::cos(2.0 * pi * 0.5 * 5e-3 * k);
      bool const off = device.state.off;
      device.step(train, 0.0);
      changes += device.state.off != off;
      if (device.state.off) CHECK(valve(device.command[1]) == DumpValve::fill);
    }
    return changes;
  };
  CHECK(switches(wsp.least_speed) > 10);
  CHECK(switches(0.0) == switches(wsp.least_speed));  // never below least_speed
  CHECK(switches(2.0) == 1);
  CHECK(switches(1.5) > 10);  // the train passes it
}

namespace {

/// An axle with a motor under slip control beside one that rolls, on a rail whose adhesion over slip s is 2 x/(1 + x^2) of its
/// largest with x = s/s_p; the train's speed stays.
///
/// @return  mean adhesion of the second half over the largest
double adhesion_under(WheelSlipControl law, double peak_slip, double demand, double sign, double* least_factor) {
  double const speed = 20.0, r = 0.46, inertia = 150.0, largest = 6e3, h = 1e-3;  // [m/s], [m], [kg m^2], [N], [s]
  law.release_interval = 0.0;  // the axle beside it tells the train's speed
  WheelSlipControl::State state = law.start({}, speed, 5e-3);
  Measurements now{.axles = 2};
  PerAxle<double> factor{1.0, 1.0};
  double w = speed / r, motor = 0.0, sum = 0.0;
  int const steps = 200000;
  for (int k = 0; k < steps; ++k) {
    if (k % 5 == 0) {
      now.vehicle_axle_speed = {w, speed / r};
      now.motor_torque = {motor, 0.0};
      law.step(state, now, 5e-3, factor);
      if (least_factor != nullptr) *least_factor = std::fmin(*least_factor, factor[0]);
    }
    motor += h / 0.02 * (sign * factor[0] * demand * r - motor);
    double const x = (r * w - speed) / speed / peak_slip, force = largest * 2.0 * x / (1.0 + x * x);
    w = std::fmax(0.0, w + h * (motor - force * r) / inertia);
    if (2 * k >= steps) sum += sign * force;
  }
  return sum / (steps / 2) / largest;
}

WheelSlipControl searching(WheelSlipControl law) {
  law.search = {.interval = 2.0, .ratio = 1.15, .least = 0.1, .largest = 8.0, .axle_inertia = 150.0};
  return law;
}

}  // namespace

TEST_CASE("a search for the best slip comes near the peak of the adhesion wherever it is, pulling and braking") {
  struct Rail {
    double peak, best;  // slip of the peak; threshold that transmits most there, over that of slip_control, 4 %
  };
  double fixed_least = 1.0, found_least = 1.0, best_least = 1.0;
  for (double sign : {1.0, -1.0})
    for (Rail rail : {Rail{0.012, 0.25}, {0.02, 0.47}, {0.03, 0.74}, {0.06, 1.48}, {0.1, 3.45}, {0.15, 5.47}}) {
      WheelSlipControl best = slip_control;
      best.slip *= rail.best, best.slip_speed *= rail.best;
      double const found = adhesion_under(searching(slip_control), rail.peak, 8e3, sign, nullptr);
      fixed_least = std::fmin(fixed_least, adhesion_under(slip_control, rail.peak, 8e3, sign, nullptr));
      found_least = std::fmin(found_least, found);
      best_least = std::fmin(best_least, adhesion_under(best, rail.peak, 8e3, sign, nullptr));
      INFO(sign, " ", rail.peak, " ", found);
      CHECK(found < 0.95);
    }
  // docs/theory/adhesion.md; no threshold reaches 1: the torque swings about it, as (A8) says
  CHECK(fixed_least == doctest::Approx(0.435).epsilon(0.02));
  CHECK(found_least == doctest::Approx(0.822).epsilon(0.02));
  CHECK(best_least == doctest::Approx(0.920).epsilon(0.02));
}

TEST_CASE("a search does nothing where the rail bears the demand") {
  double least = 1.0;
  double const given = adhesion_under(searching(slip_control), 0.02, 4e3, 1.0, &least);
  CHECK(least == 1.0);
  CHECK(given == doctest::Approx(4.0 / 6.0).epsilon(1e-3));
}

TEST_CASE("an axle that its motor brakes does not lock under wheel-slip control, and gets its torque back") {
  double least = 1.0;
  double const got = adhesion_under(slip_control, 0.03, 12e3, -1.0, &least);
  INFO(got);
  CHECK(got > 0.8);
  CHECK(least < 0.6);
  CHECK(adhesion_under(slip_control, 0.03, 4e3, -1.0, nullptr) == doctest::Approx(4.0 / 6.0).epsilon(1e-3));
}
