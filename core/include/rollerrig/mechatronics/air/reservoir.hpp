// mechatronics/air/reservoir.hpp - an auxiliary reservoir, fed by the main pipe, behind dump valves with dead times.
//
//   main pipe -> [choke, check valve] -> auxiliary reservoir -> [relay valve, inlet] -> cylinders -> [outlet] -> ambient
//                                                     control valve's pressure -^
//
//     V p' = sqrt(T/T_0) p_0 C p_1 phi(p_2/p_1)        (A13), with (A12): isothermal, every part of the air at T
//
// The relay valve opens in proportion to what is missing at the cylinder and lets out what is too much; nothing flows back into
// the reservoir or the main pipe. What one volume loses another gains, to the last bit but one: air is conserved.
// With a `pipe`: reservoir -> [relay valve of several axles] -> pipes -> [tube, inlet] -> cylinders -> [outlet] -> ambient; the
// relay valve then follows the pressure in the pipes, and a cylinder's air flows back into them where they have less.
// Source  ISO 6358-1; docs/theory/adhesion.md. A midpoint step never moves more than makes two pressures equal.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <tuple>

#include "rollerrig/mechatronics/air/control_valve.hpp"
#include "rollerrig/mechatronics/air/cylinder_pipe.hpp"
#include "rollerrig/mechatronics/orifice.hpp"

namespace rollerrig {

struct ReservoirAir {
  static constexpr char const* name = "reservoir";

  double fill_conductance{}, vent_conductance{}, critical_ratio{}, relay_band{}, opening_time{}, closing_time{};
  double least_pulse{}, reservoir_volume{}, reservoir_pressure{}, main_pipe_pressure{}, charging_conductance{};
  double reference_pressure{}, temperature{};
  std::optional<CylinderPipe> pipe{};  ///< absent: a relay valve at each cylinder, in one with the inlet

  static constexpr double reference_temperature = 293.15;  ///< of ISO 8778 [K]

  static constexpr auto fields() {
    using P = ReservoirAir;
    return members(
        Member{"fill_conductance", &P::fill_conductance, "m^3/(s Pa)",
               "sonic conductance from the reservoir, or the pipe, to a cylinder, C", not_negative},
        Member{"vent_conductance", &P::vent_conductance, "m^3/(s Pa)",
               "sonic conductance from a cylinder to the ambient, C", not_negative},
        Member{"critical_ratio", &P::critical_ratio, "1", "critical pressure ratio of all orifices, b",
               Range{0.0, 0.99, "0 to 0.99"}},
        Member{"relay_band", &P::relay_band, "Pa", "missing pressure from which the relay valve is wide open",
               positive},
        Member{"opening_time", &P::opening_time, "s", "dead time of a magnet valve that opens", not_negative},
        Member{"closing_time", &P::closing_time, "s", "dead time of a magnet valve that closes", not_negative},
        Member{"least_pulse", &P::least_pulse, "s", "least duration of a magnet valve's command", not_negative},
        Member{"reservoir_volume", &P::reservoir_volume, "m^3",
               "volume of the reservoir, for all its cylinders together", positive},
        Member{"reservoir_pressure", &P::reservoir_pressure, "Pa",
               "pressure of the reservoir at the start, over the ambient", positive},
        Member{"main_pipe_pressure", &P::main_pipe_pressure, "Pa", "pressure of the main pipe, over the ambient",
               not_negative},
        Member{"charging_conductance", &P::charging_conductance, "m^3/(s Pa)",
               "sonic conductance of the choke between main pipe and reservoir, C", not_negative},
        Member{"reference_pressure", &P::reference_pressure, "Pa",
               "absolute pressure at which conductances are stated, p_0", positive},
        Member{"temperature", &P::temperature, "K", "temperature of all air, T", positive}, Member{"pipe", &P::pipe});
  }

  AirSupply start() const { return {.reservoir = reservoir_pressure, .drawn = 0.0}; }

  void step(ControlValve const& valve, std::span<Cylinder> cylinders, std::span<RelayValve> relays, AirSupply& supply,
            std::span<DumpValve const> command, std::span<double const> demand, double h) const {
    auto const steps = [&](double time) { return static_cast<int>(std::lround(time / h)); };
    SwitchingSteps const switching{steps(opening_time), steps(closing_time), steps(least_pulse)};
    for (std::size_t i = 0; i < cylinders.size(); ++i) {
      DumpUnit& unit = cylinders[i].unit;
      unit.step(command[i], switching);
      cylinders[i].move_valves(unit.inlet_open(), unit.outlet_open());
    }
    int const parts = pipe && !relays.empty() ? pipe_parts(relays.front().cylinders, h) : air_parts;
    for (int k = 0; k < parts; ++k)
      pipe ? advance_pipes(valve, cylinders, relays, supply, demand, h / parts)
           : advance(valve, cylinders, supply, demand, h / parts);
  }

 private:
  static constexpr double endless = std::numeric_limits<double>::infinity();  ///< volume of ambient and main pipe

  /// p V per time that flows through an orifice [Pa m^3/s]; pressures over the ambient.
  double flow(double conductance, double from, double to, double ambient) const {
    return flow(Orifice{conductance, critical_ratio}, from, to, ambient);
  }
  double flow(Orifice const& orifice, double from, double to, double ambient) const {
    double const upstream = from + ambient;
    double const warmth = std::sqrt(temperature / reference_temperature);
    return warmth * reference_pressure * orifice.conductance * upstream *
           orifice_flow((to + ambient) / upstream, orifice.critical_ratio);
  }

  /// p V per time into a cylinder from the reservoir, and out of it to the ambient [Pa m^3/s].
  struct Exchange {
    double in{}, out{};
  };
  Exchange exchange(Cylinder const& own, double control, double pressure, double reservoir, double ambient) const {
    double const relay = own.inlet_open ? std::clamp((control - pressure) / relay_band, -1.0, 1.0) : 0.0;
    Exchange found;
    if (relay > 0.0) found.in = relay * flow(fill_conductance, reservoir, pressure, ambient);
    if (relay < 0.0) found.out = -relay * flow(fill_conductance, pressure, 0.0, ambient);
    if (own.outlet_open) found.out += flow(vent_conductance, pressure, 0.0, ambient);
    return found;
  }

  void advance(ControlValve const& valve, std::span<Cylinder> cylinders, AirSupply& supply,
               std::span<double const> demand, double part) const {
    double const ambient = valve.ambient_pressure, volume = valve.volume;
    double taken = 0.0;
    for (Cylinder const& own : cylinders)
      taken += exchange(own, own.control, own.pressure, supply.reservoir, ambient).in;
    double const charged = flow(charging_conductance, main_pipe_pressure, supply.reservoir, ambient);
    double const reservoir = std::fmax(0.0, supply.reservoir + 0.5 * part * (charged - taken) / reservoir_volume);
    for (std::size_t i = 0; i < cylinders.size(); ++i) {
      Cylinder& own = cylinders[i];
      double const control = own.control + 0.5 * part * valve.rate(own.control, demand[i]);
      auto const first = exchange(own, own.control, own.pressure, supply.reservoir, ambient);
      double const middle = std::fmax(0.0, own.pressure + 0.5 * part * (first.in - first.out) / volume);
      own.control = std::fmax(0.0, own.control + part * valve.rate(control, demand[i]));
      auto const now = exchange(own, control, middle, reservoir, ambient);
      double const between = volume * reservoir_volume / (volume + reservoir_volume);
      double const in = std::min({part * now.in, std::fmax(0.0, supply.reservoir - own.pressure) * between,
                                  std::fmax(0.0, own.control - own.pressure) * volume});
      double const floor = own.outlet_open ? 0.0 : std::fmin(own.control, own.pressure);
      double const out = std::fmin(part * now.out, in + (own.pressure - floor) * volume);
      own.pressure += (in - out) / volume;
      supply.reservoir -= in / reservoir_volume;
      own.air += in / ambient;
      own.exhausted += out / ambient;
    }
    double const missing = std::fmax(0.0, main_pipe_pressure - supply.reservoir) * reservoir_volume;
    double const fed = std::fmin(part * flow(charging_conductance, main_pipe_pressure, reservoir, ambient), missing);
    supply.reservoir += fed / reservoir_volume;
    supply.drawn += fed / ambient;
  }

  /// Of a step: choked flow changes a pipe's pressure by 1 % of that before the orifice in each, if they do not get too many.
  int pipe_parts(std::size_t cylinders, double h) const {
    double const conductance = std::fmax(pipe->relay_conductance / static_cast<double>(cylinders), fill_conductance);
    double const wanted = std::ceil(100.0 * reference_pressure * conductance * h / pipe->volume());
    return static_cast<int>(std::clamp(wanted, double{air_parts}, 64.0));
  }

  struct Volume {
    double& pressure;
    double size;
  };
  /// Moves air within a time and returns its p V [Pa m^3]: a midpoint step, at most until both pressures are equal. Its first half
  /// goes at most half of that way: a flow that is much faster than the step closes in, too.
  static double pass(auto const& rate, Volume from, Volume to, double time, double most = endless) {
    double const equal = (from.pressure - to.pressure) / (1.0 / from.size + 1.0 / to.size);
    most = std::fmax(0.0, std::fmin(most, equal));
    double const begun = 0.5 * std::fmin(time * rate(from.pressure, to.pressure), most);
    double const moved = std::fmin(time * rate(from.pressure - begun / from.size, to.pressure + begun / to.size), most);
    from.pressure = std::fmax(0.0, from.pressure - moved / from.size);
    to.pressure += moved / to.size;
    return moved;
  }

  /// A part of a step, relay valves half before and half after the dump valves: symmetric, and so of second order.
  void advance_pipes(ControlValve const& valve, std::span<Cylinder> cylinders, std::span<RelayValve> relays,
                     AirSupply& supply, std::span<double const> demand, double part) const {
    std::size_t first = 0;
    for (RelayValve& relay : relays) {
      auto const behind = cylinders.subspan(first, relay.cylinders);
      double asked = 0.0;
      for (double one : demand.subspan(first, relay.cylinders)) asked += one / static_cast<double>(relay.cylinders);
      move_relay(valve, relay, behind, supply, 0.5 * part);
      double const control = relay.control + 0.5 * part * valve.rate(relay.control, asked);
      relay.control = std::fmax(0.0, relay.control + part * valve.rate(control, asked));
      move_cylinders(valve, relay, behind, part);
      move_relay(valve, relay, behind, supply, 0.5 * part);
      first += relay.cylinders;
    }
    auto const charge = [&](double from, double to) {
      return flow(charging_conductance, from, to, valve.ambient_pressure);
    };
    double main = main_pipe_pressure;
    double const fed = pass(charge, {main, endless}, {supply.reservoir, reservoir_volume}, part);
    supply.drawn += fed / valve.ambient_pressure;
  }

  /// From the reservoir into the pipes, or out of them: that counts as air that all cylinders behind have taken and let out.
  void move_relay(ControlValve const& valve, RelayValve& relay, std::span<Cylinder> behind, AirSupply& supply,
                  double time) const {
    double const ambient = valve.ambient_pressure, count = static_cast<double>(behind.size());
    Volume const own{relay.pressure, count * pipe->volume()};
    double const missing = (relay.control - relay.pressure) * own.size;
    auto const rate = [&](double from, double to) {
      double const open = std::fabs(relay.control - (missing > 0.0 ? to : from)) / relay_band;
      return std::fmin(1.0, open) * flow(pipe->relay_conductance, from, to, ambient);
    };
    double outside = 0.0;
    if (missing > 0.0) {
      pass(rate, {supply.reservoir, reservoir_volume}, own, time, missing);
    } else {
      double const each = pass(rate, own, {outside, endless}, time, -missing) / (count * ambient);
      for (Cylinder& one : behind) one.air += each, one.exhausted += each;
    }
  }

  /// Between each cylinder and its own pipe, and out of the cylinders.
  void move_cylinders(ControlValve const& valve, RelayValve& relay, std::span<Cylinder> behind, double time) const {
    double const ambient = valve.ambient_pressure, count = static_cast<double>(behind.size());
    Orifice const inlet = in_series(pipe->tube(), {fill_conductance, critical_ratio});
    auto const through = [&](double from, double to) { return flow(inlet, from, to, ambient); };
    auto const vent = [&](double from, double to) { return flow(vent_conductance, from, to, ambient); };
    double const before = relay.pressure;
    for (Cylinder& each : behind) {
      double piped = before, outside = 0.0;
      Volume const own{each.pressure, valve.volume}, tube{piped, pipe->volume()};
      if (each.inlet_open) {
        double const in = piped > each.pressure ? pass(through, tube, own, time) : -pass(through, own, tube, time);
        each.air += in / ambient;
        relay.pressure = std::fmax(0.0, relay.pressure - in / (count * tube.size));
      }
      if (each.outlet_open) each.exhausted += pass(vent, own, {outside, endless}, time) / ambient;
    }
  }
};

}  // namespace rollerrig
