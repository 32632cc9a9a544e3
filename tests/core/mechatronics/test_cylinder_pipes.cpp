// Relay valves for several axles, and the pipes from them to the dump valves.
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <vector>

#include "rollerrig/mechatronics/brake_unit.hpp"
#include "rollerrig/plant/state_archive.hpp"

using namespace rollerrig;

namespace {

constexpr double ambient = 101325.0, cylinder_volume = 5e-3, reservoir_volume = 0.1;
ControlValve const control_valve{.application_rate = 1e12,
                                 .release_rate = 1e12,
                                 .follow_rate = 100.0,
                                 .ambient_pressure = ambient,
                                 .volume = cylinder_volume};
CylinderPipe const usual_pipe{.length = 4.0, .diameter = 0.02, .relay_conductance = 5e-7};

ReservoirAir air_of(std::optional<CylinderPipe> const& piping) {
  return {.fill_conductance = 2.5e-7,
          .vent_conductance = 2e-7,
          .critical_ratio = 0.3,
          .relay_band = 1e4,
          .opening_time = 0.0,
          .closing_time = 0.0,
          .least_pulse = 0.0,
          .reservoir_volume = reservoir_volume,
          .reservoir_pressure = 8e5,
          .main_pipe_pressure = 8.5e5,
          .charging_conductance = 2e-8,
          .reference_pressure = 1e5,
          .temperature = 293.15,
          .pipe = piping};
}

constexpr auto fill = DumpValve::fill, hold = DumpValve::hold, vent = DumpValve::vent;

/// A brake unit under one demand.
struct Bench {
  Pneumatics pneumatics;
  std::size_t axles;
  BrakeCylinders unit;
  double step{1e-3};

  Bench(ReservoirAir const& air, std::size_t count, std::vector<int> const& reservoir = {},
        std::vector<int> const& relay_valve = {})
      : pneumatics{control_valve, air}, axles{count}, unit{pneumatics, reservoir, relay_valve, count} {}

  void run(double seconds, std::vector<DumpValve> const& commands, double demand) {
    PerAxle<double> valve{}, asked{};
    for (std::size_t i = 0; i < axles; ++i) valve[i] = static_cast<double>(commands[i]), asked[i] = demand;
    for (long k = std::lround(seconds / step); k > 0; --k) unit.step(pneumatics, valve, asked, step);
  }
  double pressure(std::size_t axle) const { return unit.cylinder(axle).pressure; }
};

/// Sonic conductance of a smooth tube behind a sharp inlet: adiabatic flow with friction, choked at its end (Fanno), 7 bar before it.
double fanno_conductance(double length, double diameter) {
  constexpr double gamma = 1.4, gas = 287.05, temperature = 293.15, viscosity = 1.82e-5, inlet_loss = 0.5, p = 7e5;
  double const area = 0.25 * M_PI * diameter * diameter;
  double friction = 0.02, flow = 0.0;
  for (int k = 0; k < 30; ++k) {
    double low = 1e-4, high = 1.0;
    while (high - low > 1e-12) {
      double const mach = 0.5 * (low + high), square = mach * mach;
      double const passed = (1.0 - square) / (gamma * square) +
                            1.2 / gamma * std::log(2.4 * square / (2.0 + 0.4 * square));  // (gamma + 1)/(2 gamma) ...
      (passed > friction * length / diameter + inlet_loss ? low : high) = mach;
    }
    flow = p * area * low * std::sqrt(gamma / (gas * temperature)) * std::pow(1.0 + 0.2 * low * low, -3.0);
    friction = 0.3164 * std::pow(4.0 * flow / (M_PI * diameter * viscosity), -0.25);  // Blasius
  }
  return flow / (1e5 / (gas * temperature) * p);
}

/// Flow through two orifices in series at a pressure ratio, over the pressure before them.
double flow_through(Orifice const& first, Orifice const& second, double ratio) {
  auto const through = [&](double between) { return first.conductance * orifice_flow(between, first.critical_ratio); };
  double low = ratio, high = 1.0;
  for (int k = 0; k < 60; ++k) {
    double const between = 0.5 * (low + high);
    bool const more =
        through(between) > second.conductance * between * orifice_flow(ratio / between, second.critical_ratio);
    (more ? low : high) = between;
  }
  return through(low);
}

double time_to(double part, CylinderPipe const& own) {
  Bench bench(air_of(own), 1);
  int steps = 0;
  while (bench.pressure(0) < part * 3.8e5 && steps < 20000) bench.run(1e-3, {fill}, 3.8e5), ++steps;
  return 1e-3 * steps;
}

}  // namespace

TEST_CASE("a tube's conductance is that of flow with friction, (A25): the formula is 2 to 12 % below it") {
  for (double diameter : {0.006, 0.012, 0.02, 0.025})
    for (double length : {0.1, 1.0, 5.0, 20.0}) {
      CylinderPipe const tube{length, diameter, 0.0};
      double const ratio = fanno_conductance(length, diameter) / tube.tube().conductance;
      CHECK(ratio > 1.01);
      CHECK(ratio < 1.125);
      CHECK(tube.tube().critical_ratio > 0.05);
      CHECK(tube.tube().critical_ratio < 0.61);
    }
}

TEST_CASE("two orifices in series let through what the pressure between them says, (A26): within 5.5 %") {
  for (double ratio : {0.01, 0.3, 0.5, 0.7, 0.9, 0.97})
    for (double second : {0.3e-7, 0.5e-7, 1e-7, 3e-7, 20e-7}) {
      Orifice const a{1e-7, 0.27}, b{second, 0.3}, both = in_series(a, b);
      double const expected = flow_through(a, b, ratio);
      CHECK(both.conductance * orifice_flow(ratio, both.critical_ratio) == doctest::Approx(expected).epsilon(0.055));
      CHECK(in_series(b, a).conductance == doctest::Approx(both.conductance).epsilon(1e-14));
    }
  CHECK(in_series({0.0, 0.3}, {1e-7, 0.3}).conductance == 0.0);
}

TEST_CASE(
    "the less volume and resistance a pipe has, the more a cylinder fills, releases and takes air as without one") {
  for (double length : {0.01, 0.0025}) {
    double const part = CylinderPipe{length, 0.08, 2.5e-7}.volume() / cylinder_volume;  // that has to be filled, too
    ReservoirAir wide = air_of(CylinderPipe{length, 0.08, 2.5e-7});
    wide.fill_conductance = 2e-5;
    Bench piped(wide, 1), plain(air_of({}), 1);
    for (Bench* one : {&piped, &plain}) one->step = 1e-4;
    auto const both = [&](double seconds, DumpValve command, double demand) {
      for (Bench* one : {&piped, &plain}) one->run(seconds, {command}, demand);
      CHECK(std::fabs(piped.pressure(0) - plain.pressure(0)) < 3.8e5 * part + 600.0);
      CHECK(piped.unit.cylinder(0).air == doctest::Approx(plain.unit.cylinder(0).air).epsilon(0.005 + 2.0 * part));
      CHECK(std::fabs(piped.unit.cylinder(0).exhausted - plain.unit.cylinder(0).exhausted) < 1e-4 + 0.04 * part);
      CHECK(piped.unit.supply(0).reservoir == doctest::Approx(plain.unit.supply(0).reservoir).epsilon(1e-3));
    };
    for (int k = 0; k < 10; ++k) both(0.02, fill, 3.8e5);
    both(1.0, fill, 3.8e5);
    both(0.1, vent, 3.8e5);
    both(0.3, fill, 3.8e5);
    for (int k = 0; k < 10; ++k) both(0.03, fill, 1e5);
  }
}

TEST_CASE("a pipe fills at the choked rate of its relay valve, a cylinder at that of tube and inlet") {
  ReservoirAir air = air_of(usual_pipe);
  air.charging_conductance = 0.0;
  Bench bench(air, 1);
  bench.step = 1e-4;
  bench.run(2e-3, {hold}, 7.9e5);  // the relay valve is wide open
  double const before = bench.unit.pipe_pressure(0);
  bench.run(2e-3, {hold}, 7.9e5);
  double const rate = 1e5 * usual_pipe.relay_conductance * (8e5 + ambient) / usual_pipe.volume();
  CHECK(bench.unit.pipe_pressure(0) + ambient < 0.3 * (8e5 + ambient));
  CHECK((bench.unit.pipe_pressure(0) - before) / 2e-3 == doctest::Approx(rate).epsilon(0.02));  // the reservoir gives
  CHECK(bench.pressure(0) == 0.0);
  CylinderPipe long_pipe{40.0, 0.03, 5e-6};  // stands for a supply of one pressure
  Bench large(air_of(long_pipe), 1);
  large.run(5.0, {hold}, 6e5);
  double const full = large.unit.pipe_pressure(0) + ambient;
  large.run(0.01, {fill}, 6e5);
  double const started = large.pressure(0);
  large.run(0.01, {fill}, 6e5);
  Orifice const both = in_series(long_pipe.tube(), {air.fill_conductance, air.critical_ratio});
  double const expected = 1e5 * both.conductance * full / cylinder_volume;
  CHECK((large.pressure(0) - started) / 0.01 == doctest::Approx(expected).epsilon(0.01));
}

TEST_CASE("with everything shut but the inlets pipes and cylinders come to one pressure, that of Boyle's law") {
  ReservoirAir air = air_of(usual_pipe);
  Bench bench(air, 2);
  bench.run(5.0, {fill, vent}, 3.8e5);
  bench.run(0.02, {hold, hold}, 3.8e5);
  air.pipe->relay_conductance = 0.0;
  bench.pneumatics.air = air;
  double const piped = bench.unit.pipe_pressure(0), first = bench.pressure(0), second = bench.pressure(1);
  CHECK(piped > 3.7e5);
  CHECK(second < 1e3);
  bench.run(20.0, {fill, fill}, 0.0);
  double const total = 2.0 * usual_pipe.volume() + 2.0 * cylinder_volume;
  double const equal = (2.0 * usual_pipe.volume() * piped + cylinder_volume * (first + second)) / total;
  for (double pressure : {bench.unit.pipe_pressure(1), bench.pressure(0), bench.pressure(1)})
    CHECK(pressure == doctest::Approx(equal).epsilon(1e-9));
}

TEST_CASE("air is conserved over random commands and demands, and pressures stay between those that they follow") {
  std::mt19937 random(26);
  std::uniform_int_distribution<int> command(0, 2);
  std::uniform_real_distribution<double> part(0.0, 1.0);
  for (double conductance : {1e-7, 5e-7, 1e-4}) {
    ReservoirAir air = air_of(CylinderPipe{2.0, 0.012, conductance});
    air.opening_time = air.closing_time = 0.01;
    if (conductance > 1e-5) air.fill_conductance = air.vent_conductance = conductance;
    Bench bench(air, 5, {0, 0, 1, 1, 1}, {0, 0, 1, 2, 2});
    double const before = 2.0 * reservoir_volume * 8e5 / ambient;
    for (int k = 0; k < 120; ++k) {
      std::vector<DumpValve> commands(5);
      for (DumpValve& one : commands) one = static_cast<DumpValve>(command(random));
      bench.run(0.2 * part(random), commands, 4e5 * part(random));
      double balance = before + bench.unit.drawn();
      for (std::size_t axle : {0, 2}) balance -= reservoir_volume * bench.unit.supply(axle).reservoir / ambient;
      for (std::size_t axle = 0; axle < 5; ++axle) {
        Cylinder const& own = bench.unit.cylinder(axle);
        CHECK(std::fabs(own.air - own.exhausted - control_valve.air(own.pressure)) < 1e-11 * (1.0 + own.air));
        balance -= own.exhausted + control_valve.air(own.pressure) +
                   air.pipe->volume() * bench.unit.pipe_pressure(axle) / ambient;
        for (double pressure : {own.pressure, bench.unit.pipe_pressure(axle)}) {
          CHECK(pressure >= 0.0);
          CHECK(pressure <= 4e5 * (1 + 1e-12));
        }
      }
      CHECK(std::fabs(balance) < 1e-11 * (before + bench.unit.drawn()));  // round-off of 200 000 parts
    }
    CHECK(bench.unit.drawn() > 0.0);
    CHECK(bench.unit.cylinder(0).exhausted > 0.05);
  }
}

TEST_CASE("a vented cylinder that fills again takes from its neighbour what the pipe gives, and that comes back") {
  auto const lowest = [&](CylinderPipe const& own, std::vector<int> const& relays) {
    Bench bench(air_of(own), 2, {}, relays);
    bench.run(5.0, {fill, fill}, 3.8e5);
    double least = bench.pressure(1);
    bench.run(0.6, {vent, fill}, 3.8e5);
    CHECK(bench.pressure(0) < 1e4);
    CHECK(bench.pressure(1) == doctest::Approx(least).epsilon(1e-3));  // its inlet is shut: it draws nothing
    for (int k = 0; k < 500; ++k) {
      bench.run(1e-3, {fill, fill}, 3.8e5);
      least = std::fmin(least, bench.pressure(1));
    }
    bench.run(3.0, {fill, fill}, 3.8e5);
    CHECK(bench.pressure(1) == doctest::Approx(3.8e5).epsilon(2e-3));
    return least;
  };
  CylinderPipe weak = usual_pipe, strong = usual_pipe;
  weak.relay_conductance = 1e-7, strong.relay_conductance = 1e-5;
  double const shared = cylinder_volume * 3.8e5 / (2.0 * cylinder_volume);
  double const dropped = lowest(weak, {0, 0});
  CHECK(dropped > shared);
  CHECK(dropped < 3.65e5);
  CHECK(lowest(usual_pipe, {0, 0}) > dropped);
  CHECK(lowest(strong, {0, 0}) > 3.75e5);
  CHECK(lowest(weak, {0, 1}) > 3.75e5);  // a relay valve each
}

TEST_CASE("the time to 95 % of the pressure grows with the length and falls with the diameter") {
  double last = 0.0;
  for (double length : {0.5, 2.0, 4.0, 8.0, 16.0}) {
    double const time = time_to(0.95, {length, 0.016, 5e-7});
    CHECK(time > 1.03 * last);
    last = time;
  }
  CHECK(last < 2.0);
  CHECK(time_to(0.95, {4.0, 0.012, 5e-7}) > 1.1 * time_to(0.95, {4.0, 0.02, 5e-7}));
}

TEST_CASE("a relay valve makes the mean of what its axles are asked for") {
  Bench bench(air_of(usual_pipe), 3, {0, 2, 0}, {0, 1, 0});  // in any order, and no axle at the reservoir between
  PerAxle<double> const asked{1e5, 3e5, 2e5};
  for (int k = 0; k < 6000; ++k) bench.unit.step(bench.pneumatics, {}, asked, 1e-3);
  CHECK(bench.pressure(0) == doctest::Approx(1.5e5).epsilon(5e-3));
  CHECK(bench.pressure(2) == bench.pressure(0));
  CHECK(bench.pressure(1) == doctest::Approx(3e5).epsilon(5e-3));
}

TEST_CASE("a result hardly depends on the step: pipes that a step of 1 ms resolves") {
  for (double length : {0.5, 8.0}) {
    Bench coarse(air_of(CylinderPipe{length, 0.012, 5e-7}), 2), fine = coarse;
    fine.step = 1e-4;
    for (DumpValve command : {fill, vent, fill, hold, fill})
      for (int k = 0; k < 5; ++k) {
        for (Bench* one : {&coarse, &fine}) one->run(0.05, {command, fill}, 3.8e5);
        for (std::size_t i : {0, 1}) CHECK(std::fabs(coarse.pressure(i) - fine.pressure(i)) < 400.0);
      }
  }
}

TEST_CASE("a state that is saved and restored goes on as it was") {
  Bench bench(air_of(usual_pipe), 2, {}, {0, 0});
  bench.run(0.3, {fill, vent}, 3.8e5);
  StateWriter writer;
  writer(bench.unit);
  Bench other(air_of(usual_pipe), 2, {}, {0, 0});
  StateReader reader(writer.out.bytes());
  reader(other.unit);
  CHECK(other.unit.pipe_pressure(1) == bench.unit.pipe_pressure(1));
  for (Bench* one : {&bench, &other}) one->run(0.2, {vent, fill}, 2e5);
  for (std::size_t i : {0, 1}) CHECK(other.pressure(i) == bench.pressure(i));
  CHECK(other.unit.pipe_pressure(0) == bench.unit.pipe_pressure(0));
}
