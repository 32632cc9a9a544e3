// Orifices, dump valves with dead times, the reservoir and the cylinders behind it, the friction brake.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <vector>

#include "explicit_real.hpp"
#include "rollerrig/math/dual.hpp"
#include "rollerrig/mechatronics/brakes.hpp"
#include "rollerrig/mechatronics/pneumatics.hpp"

using namespace rollerrig;

namespace {

ControlValve const control_valve{.application_rate = 1.2e5,
                                 .release_rate = 1.2e5,
                                 .follow_rate = 20.0,
                                 .ambient_pressure = 101325.0,
                                 .volume = 5e-3};
UnlimitedAir const unlimited{.fill_rate = 6.0, .vent_rate = 5.0};
FrictionBrake const friction_brake{.piston_area = 0.085,
                                   .spring_force = 500.0,
                                   .friction = {{0.0, 50.0}, {0.35, 0.35}},
                                   .friction_radius = 0.247,
                                   .faces = 2.0,
                                   .friction_regularisation_speed = 0.05};
ReservoirAir const unit{.fill_conductance = 2.5e-7,
                        .vent_conductance = 2e-7,
                        .critical_ratio = 0.3,
                        .relay_band = 1e4,
                        .opening_time = 0.02,
                        .closing_time = 0.015,
                        .least_pulse = 0.01,
                        .reservoir_volume = 0.1,
                        .reservoir_pressure = 8e5,
                        .main_pipe_pressure = 8.5e5,
                        .charging_conductance = 2e-8,
                        .reference_pressure = 1e5,
                        .temperature = 293.15,
                        .pipe = {}};

/// Cylinders under one demand and one command, step by step.
template <class Air>
struct Bench {
  ControlValve valve;
  Air air;
  std::vector<Cylinder> cylinder;
  AirSupply supply;
  double step{1e-3};

  Bench(ControlValve const& the_valve, Air const& the_air, std::size_t axles)
      : valve{the_valve}, air{the_air}, cylinder(axles), supply{the_air.start()} {}

  void run(double seconds, DumpValve command, double demand) {
    std::vector<DumpValve> const commands(cylinder.size(), command);
    std::vector<double> const demands(cylinder.size(), demand);
    for (long k = std::lround(seconds / step); k > 0; --k)
      air.step(valve, cylinder, {}, supply, commands, demands, step);
  }
};

/// Time of (A13) in which a cylinder vents from one absolute pressure to another: choked, then subsonic, with k = p_0 C / V.
/// With u = (p_a/p - b)/(1 - b) subsonic venting is du/dt = k (u + c) sqrt(1 - u^2), c = b/(1 - b) < 1.
double vent_time(double k, double from, double to, double ambient, double b) {
  double const choked_end = ambient / b;
  double const choked = std::log(from / std::fmax(to, choked_end)) / k;
  if (to >= choked_end) return choked;
  double const c = b / (1.0 - b), s = std::sqrt(1.0 - c * c);
  auto const integral = [&](double u) {
    double const t = std::tan(0.5 * std::asin(u));
    return std::log(std::fabs((c * t + 1.0 - s) / (c * t + 1.0 + s))) / s;
  };
  return choked + (integral((ambient / to - b) / (1.0 - b)) - integral(0.0)) / k;
}

/// Time in which a cylinder fills from a supply of constant absolute pressure.
double fill_time(double k, double from, double to, double supply, double b) {
  double const choked_end = std::fmax(from, b * supply);
  double const choked = std::fmax(0.0, std::fmin(to, choked_end) - from) / (k * supply);
  auto const u = [&](double p) { return (p / supply - b) / (1.0 - b); };
  return to <= choked_end ? choked : choked + (1.0 - b) / k * (std::asin(u(to)) - std::asin(u(choked_end)));
}

ReservoirAir prompt(ReservoirAir air) {
  air.opening_time = air.closing_time = air.least_pulse = 0.0;
  return air;
}

}  // namespace

TEST_CASE("orifice flow is choked, falls on an ellipse, and ends at equal pressures with a finite slope") {
  double const b = 0.4;
  CHECK(orifice_flow(0.1, b) == 1.0);
  CHECK(orifice_flow(b, b) == 1.0);
  CHECK(orifice_flow(0.7, b) == doctest::Approx(std::sqrt(0.75)).epsilon(1e-14));
  CHECK(orifice_flow(1.0, b) == 0.0);
  CHECK(orifice_flow(1.7, b) == 0.0);
  for (double at : {0.2, 0.4001, 0.8, 0.9985, 0.9995}) {
    double const slope = orifice_flow(Dual<1>::variable(at, 0), b).d[0];
    double const h = 1e-6;
    CHECK(slope == doctest::Approx((orifice_flow(at + h, b) - orifice_flow(at - h, b)) / (2 * h)).epsilon(1e-4));
  }
  CHECK(orifice_flow(test::ExplicitReal(0.7), b).x == orifice_flow(0.7, b));
}

TEST_CASE("a cylinder vents in the time of the closed form, choked and subsonic") {
  for (double b : {0.2, 0.3, 0.45}) {
    ReservoirAir air = prompt(unit);
    air.critical_ratio = b;
    for (double to : {2.5e5, 1.0e5, 2e4}) {  // over the ambient
      Bench bench(control_valve, air, 1);
      bench.cylinder[0].pressure = bench.cylinder[0].control = 3.8e5;
      double const k = air.reference_pressure * air.vent_conductance / control_valve.volume, p = 101325.0;
      bench.run(std::round(1e3 * vent_time(k, 3.8e5 + p, to + p, p, b)) / 1e3, DumpValve::vent, 3.8e5);
      double const rounding = k * (to + p) * 0.6e-3;  // of the time, to whole steps
      CHECK(std::fabs(bench.cylinder[0].pressure - to) < 0.002 * to + rounding);
    }
  }
}

TEST_CASE("a cylinder fills from a large reservoir in the time of the closed form, which goes with 1/sqrt(T)") {
  ReservoirAir air = prompt(unit);
  air.reservoir_volume = 1e6;
  air.relay_band = 1.0;
  ControlValve quick = control_valve;
  quick.application_rate = 1e12, quick.follow_rate = 1e4;
  for (double temperature : {243.15, 293.15, 323.15})
    for (double to : {1e5, 3.8e5, 7.5e5}) {
      air.temperature = temperature;
      Bench bench(quick, air, 1);
      double const p = 101325.0, supply = air.reservoir_pressure + p;
      double const k = air.reference_pressure * air.fill_conductance / quick.volume;  // at 293.15 K
      double const time = fill_time(k, p, to + p, supply, air.critical_ratio) * std::sqrt(293.15 / temperature);
      bench.step = time / 200.0;
      bench.run(time, DumpValve::fill, 2e6);                                   // the relay valve stays wide open
      CHECK(bench.cylinder[0].pressure == doctest::Approx(to).epsilon(3e-3));  // the control valve's own rise
    }
}

TEST_CASE("air is conserved: what the main pipe gives stands in the volumes or went out") {
  for (double volume : {0.1, 0.01}) {
    ReservoirAir air = unit;
    air.reservoir_volume = volume;
    Bench bench(control_valve, air, 3);
    double const ambient = control_valve.ambient_pressure;
    double const before = volume * air.reservoir_pressure / ambient;
    for (int k = 0; k < 30; ++k) {
      bench.run(0.31, DumpValve::fill, 3.8e5);
      bench.run(0.17, DumpValve::hold, 3.8e5);
      bench.run(0.23, DumpValve::vent, 3.8e5);
      bench.run(0.05, DumpValve::fill, k % 5 == 4 ? 0.0 : 3.8e5);  // the relay valve lets air out, too
      double balance = before + bench.supply.drawn - volume * bench.supply.reservoir / ambient;
      for (Cylinder const& own : bench.cylinder) {
        balance -= own.exhausted + control_valve.air(own.pressure);
        CHECK(own.air - own.exhausted == doctest::Approx(control_valve.air(own.pressure)).epsilon(1e-10));
      }
      CHECK(std::fabs(balance) < 1e-10 * (before + bench.supply.drawn));  // round-off of 30 000 parts
    }
    CHECK(bench.supply.drawn > 0.0);
  }
}

TEST_CASE("air runs out: a reservoir that is not fed brakes less after each venting") {
  ReservoirAir air = prompt(unit);
  air.charging_conductance = 0.0;
  air.reservoir_volume = 0.02;
  Bench bench(control_valve, air, 2);
  double last = 1e9;
  for (int k = 0; k < 12; ++k) {
    bench.run(5.0, DumpValve::fill, 3.8e5);
    CHECK(bench.cylinder[0].pressure <= last);
    last = bench.cylinder[0].pressure;
    bench.run(3.0, DumpValve::vent, 3.8e5);
  }
  CHECK(last < 1e5);
  CHECK(bench.supply.drawn == 0.0);
}

TEST_CASE("valves move after their dead times, hold keeps the pressure, and a short command is prolonged") {
  SwitchingSteps const steps{.opening = 20, .closing = 15, .least_pulse = 10};
  auto const open_at = [&](int from, int until, int step) {  // the outlet, commanded to open from .. until
    DumpUnit own;
    for (int k = 0; k <= step; ++k) own.step(k >= from && k < until ? DumpValve::vent : DumpValve::hold, steps);
    return own.outlet_open();
  };
  CHECK(!open_at(5, 60, 24));
  CHECK(open_at(5, 60, 25));
  CHECK(open_at(5, 60, 74));
  CHECK(!open_at(5, 60, 75));
  CHECK(!open_at(5, 20, 25));  // shorter than the dead time: it never opens
  SwitchingSteps const long_pulse{.opening = 20, .closing = 15, .least_pulse = 30};
  DumpUnit own;
  int open = 0;
  for (int k = 0; k < 200; ++k) {
    own.step(k == 5 ? DumpValve::vent : DumpValve::hold, long_pulse);
    open += own.outlet_open();
    CHECK(!(k > 40 && own.inlet_open()));
  }
  CHECK(open == 30 - 20 + 15);  // as a command of 30 steps
  Bench bench(control_valve, prompt(unit), 1);
  bench.run(6.0, DumpValve::fill, 3.8e5);
  CHECK(bench.cylinder[0].pressure == doctest::Approx(3.8e5).epsilon(1e-3));
  double const held = bench.cylinder[0].pressure;
  bench.run(1.0, DumpValve::hold, 0.0);
  CHECK(bench.cylinder[0].pressure == held);
}

TEST_CASE("no step is too long: pressures stay between those that they follow") {
  for (double conductance : {1e-7, 1e-4}) {
    ReservoirAir air = prompt(unit);
    air.fill_conductance = air.vent_conductance = air.charging_conductance = conductance;
    Bench bench(control_valve, air, 2);
    for (int k = 0; k < 20; ++k) {
      bench.run(0.3, k % 3 == 2 ? DumpValve::vent : DumpValve::fill, 3.8e5);
      CHECK(bench.cylinder[0].pressure >= 0.0);
      CHECK(bench.cylinder[0].pressure <= 3.8e5 * (1 + 1e-12));
      CHECK(bench.supply.reservoir <= air.main_pipe_pressure * (1 + 1e-12));
    }
  }
}

TEST_CASE("with an unlimited supply a cylinder fills to the demand, holds, vents to nothing") {
  Bench bench(control_valve, unlimited, 1);
  Cylinder& own = bench.cylinder[0];
  bench.run(6.0, DumpValve::fill, 3.8e5);
  CHECK(own.pressure == doctest::Approx(3.8e5).epsilon(1e-3));
  CHECK(own.air == doctest::Approx(control_valve.air(own.pressure)).epsilon(1e-9));
  double const held = own.pressure;
  bench.run(1.0, DumpValve::hold, 3.8e5);
  CHECK(own.pressure == held);
  bench.run(3.0, DumpValve::vent, 3.8e5);
  CHECK(own.pressure < 1.0);
  CHECK(own.exhausted == doctest::Approx(own.air).epsilon(1e-4));
  CHECK(own.dump_cycles == 1);
}

TEST_CASE("a brake's torque opposes the turning and begins where the pads touch") {
  CHECK(friction_brake.torque(3.8e5, 50.0) < -5000.0);
  CHECK(friction_brake.torque(3.8e5, -50.0) == doctest::Approx(-friction_brake.torque(3.8e5, 50.0)).epsilon(1e-12));
  CHECK(friction_brake.torque(3.8e5, 0.0) == 0.0);
  CHECK(friction_brake.torque(0.0, 50.0) == 0.0);
  CHECK(friction_brake.torque(500.0 / 0.085, 50.0) == doctest::Approx(0.0));
}
