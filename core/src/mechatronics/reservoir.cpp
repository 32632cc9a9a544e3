#include "rollerrig/mechatronics/pneumatics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rollerrig {
namespace {

constexpr double endless = std::numeric_limits<double>::infinity();  ///< volume of ambient and main pipe
constexpr double most_parts = 64.0;                                  ///< of a step, for the pipes

struct Volume {
  double& pressure;
  double size;
};

/// Moves air within a time and returns its p V [Pa m^3]: a midpoint step, at most until both pressures are equal. Its first half
/// goes at most half of that way: a flow that is much faster than the step closes in, too.
double pass(auto const& rate, Volume from, Volume to, double time, double most = endless) {
  double const equal = (from.pressure - to.pressure) / (1.0 / from.size + 1.0 / to.size);
  most = std::fmax(0.0, std::fmin(most, equal));
  double const begun = 0.5 * std::fmin(time * rate(from.pressure, to.pressure), most);
  double const moved = std::fmin(time * rate(from.pressure - begun / from.size, to.pressure + begun / to.size), most);
  from.pressure = std::fmax(0.0, from.pressure - moved / from.size);
  to.pressure += moved / to.size;
  return moved;
}

/// One reservoir and what it feeds, over a sampling step.
struct Reservoir {
  ReservoirAir const& air;
  ControlValve const& valve;
  std::span<Cylinder> cylinders;
  std::span<RelayValve> relays;
  AirSupply& supply;
  std::span<double const> demand;

  /// p V per time that flows through an orifice [Pa m^3/s]; pressures over the ambient.
  double flow(Orifice const& orifice, double from, double to) const {
    double const upstream = from + valve.ambient_pressure;
    double const warmth = std::sqrt(air.temperature / ReservoirAir::reference_temperature);
    return warmth * air.reference_pressure * orifice.conductance * upstream *
           orifice_flow((to + valve.ambient_pressure) / upstream, orifice.critical_ratio);
  }
  double flow(double conductance, double from, double to) const {
    return flow(Orifice{conductance, air.critical_ratio}, from, to);
  }

  /// p V per time into a cylinder from the reservoir, and out of it to the ambient [Pa m^3/s].
  struct Exchange {
    double in{}, out{};
  };
  Exchange exchange(Cylinder const& own, double control, double pressure, double reservoir) const {
    double const relay = own.inlet_open ? std::clamp((control - pressure) / air.relay_band, -1.0, 1.0) : 0.0;
    Exchange found;
    if (relay > 0.0) found.in = relay * flow(air.fill_conductance, reservoir, pressure);
    if (relay < 0.0) found.out = -relay * flow(air.fill_conductance, pressure, 0.0);
    if (own.outlet_open) found.out += flow(air.vent_conductance, pressure, 0.0);
    return found;
  }

  /// A part of a step, a relay valve at each cylinder.
  void advance(double part) const {
    double const ambient = valve.ambient_pressure, volume = valve.volume;
    double taken = 0.0;
    for (Cylinder const& own : cylinders) taken += exchange(own, own.control, own.pressure, supply.reservoir).in;
    double const charged = flow(air.charging_conductance, air.main_pipe_pressure, supply.reservoir);
    double const reservoir = std::fmax(0.0, supply.reservoir + 0.5 * part * (charged - taken) / air.reservoir_volume);
    for (std::size_t i = 0; i < cylinders.size(); ++i) {
      Cylinder& own = cylinders[i];
      double const control = own.control + 0.5 * part * valve.rate(own.control, demand[i]);
      auto const first = exchange(own, own.control, own.pressure, supply.reservoir);
      double const middle = std::fmax(0.0, own.pressure + 0.5 * part * (first.in - first.out) / volume);
      own.control = std::fmax(0.0, own.control + part * valve.rate(control, demand[i]));
      auto const now = exchange(own, control, middle, reservoir);
      double const between = volume * air.reservoir_volume / (volume + air.reservoir_volume);
      double const in = std::min({part * now.in, std::fmax(0.0, supply.reservoir - own.pressure) * between,
                                  std::fmax(0.0, own.control - own.pressure) * volume});
      double const floor = own.outlet_open ? 0.0 : std::fmin(own.control, own.pressure);
      double const out = std::fmin(part * now.out, in + (own.pressure - floor) * volume);
      own.pressure += (in - out) / volume;
      supply.reservoir -= in / air.reservoir_volume;
      own.air += in / ambient;
      own.exhausted += out / ambient;
    }
    double const missing = std::fmax(0.0, air.main_pipe_pressure - supply.reservoir) * air.reservoir_volume;
    double const fed = std::fmin(part * flow(air.charging_conductance, air.main_pipe_pressure, reservoir), missing);
    supply.reservoir += fed / air.reservoir_volume;
    supply.drawn += fed / ambient;
  }

  /// Of a step: choked flow changes a pipe's pressure by 1 % of that before the orifice in each, if they do not get too many.
  int pipe_parts(double h) const {
    double const behind = static_cast<double>(relays.front().cylinders);
    double const conductance = std::fmax(air.pipe->relay_conductance / behind, air.fill_conductance);
    double const wanted = std::ceil(100.0 * air.reference_pressure * conductance * h / air.pipe->volume());
    return static_cast<int>(std::clamp(wanted, double{air_parts}, most_parts));
  }

  /// A part of a step, relay valves half before and half after the dump valves: symmetric, and so of second order.
  void advance_pipes(double part) const {
    std::size_t first = 0;
    for (RelayValve& relay : relays) {
      auto const behind = cylinders.subspan(first, relay.cylinders);
      double asked = 0.0;
      for (double one : demand.subspan(first, relay.cylinders)) asked += one / static_cast<double>(relay.cylinders);
      move_relay(relay, behind, 0.5 * part);
      double const control = relay.control + 0.5 * part * valve.rate(relay.control, asked);
      relay.control = std::fmax(0.0, relay.control + part * valve.rate(control, asked));
      move_cylinders(relay, behind, part);
      move_relay(relay, behind, 0.5 * part);
      first += relay.cylinders;
    }
    auto const charge = [&](double from, double to) { return flow(air.charging_conductance, from, to); };
    double main = air.main_pipe_pressure;
    double const fed = pass(charge, {main, endless}, {supply.reservoir, air.reservoir_volume}, part);
    supply.drawn += fed / valve.ambient_pressure;
  }

  /// From the reservoir into the pipes, or out of them: that counts as air that all cylinders behind have taken and let out.
  void move_relay(RelayValve& relay, std::span<Cylinder> behind, double time) const {
    double const count = static_cast<double>(behind.size());
    Volume const own{relay.pressure, count * air.pipe->volume()};
    double const missing = (relay.control - relay.pressure) * own.size;
    auto const rate = [&](double from, double to) {
      double const open = std::fabs(relay.control - (missing > 0.0 ? to : from)) / air.relay_band;
      return std::fmin(1.0, open) * flow(air.pipe->relay_conductance, from, to);
    };
    double outside = 0.0;
    if (missing > 0.0) {
      pass(rate, {supply.reservoir, air.reservoir_volume}, own, time, missing);
    } else {
      double const each = pass(rate, own, {outside, endless}, time, -missing) / (count * valve.ambient_pressure);
      for (Cylinder& one : behind) one.air += each, one.exhausted += each;
    }
  }

  /// Between each cylinder and its own pipe, and out of the cylinders.
  void move_cylinders(RelayValve& relay, std::span<Cylinder> behind, double time) const {
    double const ambient = valve.ambient_pressure, count = static_cast<double>(behind.size());
    Orifice const inlet = in_series(air.pipe->tube(), {air.fill_conductance, air.critical_ratio});
    auto const through = [&](double from, double to) { return flow(inlet, from, to); };
    auto const vent = [&](double from, double to) { return flow(air.vent_conductance, from, to); };
    double const before = relay.pressure;
    for (Cylinder& each : behind) {
      double piped = before, outside = 0.0;
      Volume const own{each.pressure, valve.volume}, tube{piped, air.pipe->volume()};
      if (each.inlet_open) {
        double const in = piped > each.pressure ? pass(through, tube, own, time) : -pass(through, own, tube, time);
        each.air += in / ambient;
        relay.pressure = std::fmax(0.0, relay.pressure - in / (count * tube.size));
      }
      if (each.outlet_open) each.exhausted += pass(vent, own, {outside, endless}, time) / ambient;
    }
  }
};

}  // namespace

void ReservoirAir::step(ControlValve const& valve, std::span<Cylinder> cylinders, std::span<RelayValve> relays,
                        AirSupply& supply, std::span<DumpValve const> command, std::span<double const> demand,
                        double h) const {
  auto const steps = [&](double time) { return static_cast<int>(std::lround(time / h)); };
  SwitchingSteps const switching{steps(opening_time), steps(closing_time), steps(least_pulse)};
  for (std::size_t i = 0; i < cylinders.size(); ++i) {
    DumpUnit& unit = cylinders[i].unit;
    unit.step(command[i], switching);
    cylinders[i].move_valves(unit.inlet_open(), unit.outlet_open());
  }
  Reservoir const own{*this, valve, cylinders, relays, supply, demand};
  int const parts = pipe && !relays.empty() ? own.pipe_parts(h) : air_parts;
  for (int k = 0; k < parts; ++k) pipe ? own.advance_pipes(h / parts) : own.advance(h / parts);
}

}  // namespace rollerrig
