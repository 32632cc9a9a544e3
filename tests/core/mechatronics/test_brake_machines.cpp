// Electrodynamic brake and its blending with the friction brake; brakes that act on the rail; limits of a drive.
#include <doctest/doctest.h>

#include <cmath>

#include "explicit_real.hpp"
#include "rollerrig/math/dual.hpp"
#include "rollerrig/mechatronics/brakes.hpp"
#include "rollerrig/mechatronics/motor.hpp"
#include "rollerrig/mechatronics/virtual_train.hpp"

using namespace rollerrig;
using test::ExplicitReal;

namespace {

ConstantPowerBrake const constant_power{
    .largest_force = 15e3, .largest_power = 300e3, .fade_from = 3.0, .fade_to = 1.0};
ForceTableBrake const force_table{.forces = {{{1.0, 3.0, 20.0, 60.0}, {0.0, 15e3, 15e3, 5e3}}}};
ElectrodynamicBrake const machine{.characteristic = constant_power,
                                  .wheel_radius = 0.5,
                                  .share = 1.0,
                                  .time_constant = 0.1,
                                  .blending_delay = 0.0,
                                  .on_slide = static_cast<int>(OnSlide::reduce),
                                  .reduction_rate = 5.0,
                                  .restoring_rate = 1.0};
FrictionBrake const friction_brake{.piston_area = 0.085,
                                   .spring_force = 500.0,
                                   .friction = {{0.0, 50.0}, {0.38, 0.30}},
                                   .friction_radius = 0.247,
                                   .faces = 2.0,
                                   .friction_regularisation_speed = 0.05};
MagneticTrackBrake const magnetic{
    .attraction = 160e3, .friction = FallingFriction{0.2, 0.35, 0.1}, .regularisation_speed = 0.05};
EddyCurrentTrackBrake const eddy_current{.largest_force = 15e3, .critical_speed = 25.0};

/// Slope by automatic differentiation against a central difference: the step of 1e-5 leaves 1e-9 of the curvature.
template <class Function>
void check_slope(Function const& f, double at) {
  using D = Dual<1>;
  double const h = 1e-5 * (1.0 + std::fabs(at));
  double const difference = (f(at + h) - f(at - h)) / (2.0 * h);
  CHECK(f(D::variable(at, 0)).d[0] == doctest::Approx(difference).epsilon(1e-6));
}

}  // namespace

TEST_CASE("a motor that brakes has constant force, then constant power, and fades at low speed") {
  CHECK(constant_power.force(10.0) == 15e3);
  CHECK(constant_power.force(20.0) == 15e3);
  CHECK(constant_power.force(40.0) == doctest::Approx(7.5e3).epsilon(1e-15));
  CHECK(constant_power.force(2.0) == doctest::Approx(7.5e3).epsilon(1e-15));
  CHECK(constant_power.force(1.0) == 0.0);
  CHECK(constant_power.force(0.0) == 0.0);
  CHECK(force_table.force(0.5) == 0.0);
  CHECK(force_table.force(40.0) == doctest::Approx(10e3).epsilon(1e-15));
  CHECK(force_table.force(90.0) == 5e3);
  for (double v : {0.5, 2.0, 10.0, 30.0}) {
    check_slope([](auto const& u) { return constant_power.force(u); }, v);
    check_slope([](auto const& u) { return force_table.force(u); }, v);
    CHECK(constant_power.force(ExplicitReal(v)).x == constant_power.force(v));
  }
  for (double w : {-30.0, -4.0, 4.0, 30.0}) check_slope([](auto const& u) { return machine.largest(u); }, w);
  CHECK(machine.largest(-30.0) == machine.largest(30.0));
}

TEST_CASE("a train that a motor brakes with constant power needs M (v0^3 - v1^3)/(3 P)") {
  ElectrodynamicBrake quick = machine;
  quick.time_constant = 1e-5;
  double const mass = 12e3, v0 = 60.0, v1 = 25.0, h = 1e-3;  // above 20 m/s all of it is constant power
  ElectrodynamicBrake::State state;
  double v = v0, way = 0.0;
  while (v > v1) {
    quick.step(state, 1e6, v / quick.wheel_radius, DumpValve::fill, 1.0, h);
    double const before = v;
    v += h * state.torque / quick.wheel_radius / mass;
    way += 0.5 * h * (before + v);
  }
  // Euler's step of 1 ms at 1 m/s^2: 1e-5.
  CHECK(way == doctest::Approx(mass * (v0 * v0 * v0 - v * v * v) / (3.0 * 300e3)).epsilon(5e-5));
}

TEST_CASE("the motor's torque comes with its time constant, against the turning, and never beyond the characteristic") {
  ElectrodynamicBrake::State state;
  double const w = 20.0, asked = 4e3;
  for (int k = 0; k < 100; ++k) machine.step(state, asked, w, DumpValve::fill, 1.0, 1e-3);
  CHECK(state.torque == doctest::Approx(-asked * (1.0 - std::exp(-1.0))).epsilon(1e-12));
  ElectrodynamicBrake::State backwards;
  machine.step(backwards, asked, -w, DumpValve::fill, 1.0, 1e-3);
  CHECK(backwards.torque > 0.0);
  machine.step(state, asked, 1.0, DumpValve::fill, 1.0, 1e-3);  // the wheel has locked: 0.5 m/s is below the fading
  CHECK(state.torque == 0.0);
  for (double speed : {-80.0, -3.0, 0.0, 3.0, 80.0}) {
    machine.step(state, 1e5, speed, DumpValve::fill, 1.0, 1e-3);
    CHECK(state.torque * speed <= 0.0);
    CHECK(std::fabs(state.torque) <= machine.largest(speed));
  }
}

TEST_CASE("motor and friction brake together give what is asked, at every speed") {
  double const demand = 3.8e5, r = machine.wheel_radius;
  ElectrodynamicBrake::State state;
  for (double v = 50.0; v > 0.0; v -= 0.25) {
    double const w = v / r, asked = friction_brake.sliding_torque(demand, w);
    for (int k = 0; k < 3000; ++k) machine.step(state, asked, w, DumpValve::fill, 1.0, 1e-3);
    double const rest = std::fmax(0.0, asked - state.counted), pressure = friction_brake.pressure(rest, w);
    CHECK(friction_brake.sliding_torque(pressure, w) - state.torque == doctest::Approx(asked).epsilon(1e-10));
    if (v < 1.0) CHECK(pressure == doctest::Approx(demand).epsilon(1e-10));
  }
}

TEST_CASE("pressure is the inverse of the torque, and an idle brake keeps its pads at the disc") {
  for (double w : {0.0, 3.0, 60.0})
    for (double p : {1e5, 3.8e5}) {
      CHECK(friction_brake.pressure(friction_brake.sliding_torque(p, w), w) == doctest::Approx(p).epsilon(1e-12));
      CHECK(friction_brake.pressure(0.0, w) == doctest::Approx(500.0 / 0.085).epsilon(1e-14));
    }
  CHECK(-friction_brake.torque(3.8e5, 60.0) ==
        doctest::Approx(friction_brake.sliding_torque(3.8e5, 60.0)).epsilon(1e-5));
}

TEST_CASE("on a slide the motor keeps its torque, or gives way and comes back, or stays off until the release") {
  auto const after = [](OnSlide reaction, double vent, double fill, double asked_then) {
    ElectrodynamicBrake brake = machine;
    brake.on_slide = static_cast<int>(reaction);
    ElectrodynamicBrake::State state;
    auto const run = [&](double seconds, DumpValve valve, double asked) {
      for (long k = std::lround(seconds * 1e3); k > 0; --k) brake.step(state, asked, 20.0, valve, 1.0, 1e-3);
    };
    run(2.0, DumpValve::fill, 4e3);
    run(vent, DumpValve::vent, 4e3);
    run(fill, DumpValve::fill, asked_then);
    if (asked_then == 0.0) run(2.0, DumpValve::fill, 4e3);
    return state;
  };
  CHECK(after(OnSlide::keep, 1.0, 0.0, 4e3).torque == doctest::Approx(-4e3));
  auto const reduced = after(OnSlide::reduce, 0.1, 0.0, 4e3);
  CHECK(reduced.torque == doctest::Approx(-2e3).epsilon(1e-6));
  CHECK(reduced.counted == doctest::Approx(4e3).epsilon(1e-6));  // friction does not fill the gap
  CHECK(after(OnSlide::reduce, 0.3, 0.25, 4e3).torque == doctest::Approx(-1e3).epsilon(1e-6));
  auto const off = after(OnSlide::switch_off, 0.1, 2.0, 4e3);
  CHECK(off.torque == 0.0);
  CHECK(off.counted == 0.0);  // friction takes over
  CHECK(after(OnSlide::switch_off, 0.3, 0.5, 0.0).torque == doctest::Approx(-4e3).epsilon(1e-6));
}

TEST_CASE("track brakes: the curves of force over speed, odd, and against running") {
  CHECK(magnetic.force(0.0) == 0.0);
  CHECK(magnetic.force(20.0) == doctest::Approx(160e3 * 0.2 * (0.65 * std::exp(-2.0) + 0.35)).epsilon(1e-5));
  CHECK(eddy_current.force(25.0) == doctest::Approx(15e3).epsilon(1e-15));
  CHECK(eddy_current.force(50.0) == doctest::Approx(12e3).epsilon(1e-15));
  CHECK(eddy_current.force(12.5) == doctest::Approx(12e3).epsilon(1e-15));
  for (double v : {-40.0, -0.03, 0.02, 1.0, 33.0}) {
    CHECK(magnetic.force(v) == -magnetic.force(-v));
    CHECK(eddy_current.force(v) == -eddy_current.force(-v));
    CHECK(magnetic.force(v) * v > 0.0);
    CHECK(eddy_current.force(v) * v > 0.0);
    check_slope([](auto const& u) { return magnetic.force(u); }, v);
    check_slope([](auto const& u) { return eddy_current.force(u); }, v);
    CHECK(eddy_current.force(ExplicitReal(v)).x == eddy_current.force(v));
  }
}

TEST_CASE("a track brake is lowered, rises on a straight line, and is lifted from a slow train") {
  TrackBrake const brake{.law = magnetic,
                         .bogies = 1.0,
                         .demand = {{{1.0, 1.001}, {0.0, 1.0}}},
                         .delay = 0.5,
                         .rise_time = 0.2,
                         .release_speed = 5.0};
  double excitation = 0.0;
  auto const run = [&](double from, double to, double speed) {
    for (long k = std::lround(from * 1e3); k < std::lround(to * 1e3); ++k)
      excitation = brake.next(excitation, 1e-3 * static_cast<double>(k), speed, 1e-3);
  };
  run(0.0, 1.5, 30.0);
  CHECK(excitation == 0.0);
  run(1.5, 1.601, 30.0);
  CHECK(excitation == doctest::Approx(0.5).epsilon(0.01));
  run(1.601, 2.0, 30.0);
  CHECK(excitation == 1.0);
  run(2.0, 2.5, 4.0);
  CHECK(excitation == 0.0);
}

TEST_CASE("a virtual train that an eddy-current brake alone slows obeys v' = -F(v)/M") {
  // M v dv/ds = -2 F v v_k/(v^2 + v_k^2):   s = M [(v0^3 - v1^3)/3 + v_k^2 (v0 - v1)]/(2 F v_k)
  VirtualTrain train{.mass = 20e3, .wheelset_inertia = 100.0, .wheel_radius = 0.46};
  train.static_load = {98e3};
  train.load_transfer = {0.0};
  VirtualTrainState state(train, 40.0);
  while (state.speed > 10.0)
    state.step(train, 1, {}, nullptr, eddy_current.force(state.speed), 1e-3,
               [](int, double slip, double, double) { return 1e5 * slip; });
  double const v0 = 40.0, v1 = state.speed, k = eddy_current.critical_speed;
  double const with_spin = train.mass + 100.0 / (0.46 * 0.46);  // the axle is dragged along, with a small slip
  double const way = with_spin * ((v0 * v0 * v0 - v1 * v1 * v1) / 3.0 + k * k * (v0 - v1)) / (2.0 * 15e3 * k);
  CHECK(state.distance == doctest::Approx(way).epsilon(1e-3));
}

TEST_CASE("a drive tells which of its limits a command meets, and gives just what that leaves") {
  Motor const drive{.envelope = {},
                    .bandwidth = 300.0,
                    .damping_ratio = 0.0,
                    .largest_torque = 20e3,
                    .largest_power = 1e6,
                    .largest_speed = 134.0};
  CHECK(drive.limit_met(15e3, 10.0) == DriveLimit::none);
  CHECK(drive.limit_met(-25e3, 10.0) == DriveLimit::torque);
  CHECK(drive.limit_met(25e3, 60.0) == DriveLimit::power);
  CHECK(drive.limit_met(15e3, -70.0) == DriveLimit::power);
  CHECK(drive.limit_met(1.0, 135.0) == DriveLimit::speed);
  CHECK(drive.limit_met(0.0, 135.0) == DriveLimit::none);
  for (double command : {-40e3, -12e3, 0.0, 5e3, 21e3})
    for (double speed : {-140.0, -80.0, 0.0, 40.0, 60.0, 133.0}) {
      bool const held = drive.within_envelope(command, speed) != command;
      CHECK(held == (drive.limit_met(command, speed) != DriveLimit::none));
    }
}
