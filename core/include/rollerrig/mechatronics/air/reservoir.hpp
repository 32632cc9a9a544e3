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
#include <optional>
#include <span>
#include <tuple>

#include "rollerrig/mechatronics/air/control_valve.hpp"
#include "rollerrig/mechatronics/air/cylinder_pipe.hpp"

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
            std::span<DumpValve const> command, std::span<double const> demand, double h) const;
};

}  // namespace rollerrig
