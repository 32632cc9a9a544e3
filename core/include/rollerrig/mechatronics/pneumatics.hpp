// mechatronics/pneumatics.hpp - from brake demand and dump valves' commands to the pressures of all cylinders.
//
//   demand -> [control valve] -> [law of the air] -> cylinder pressures -> brakes.hpp
//
// To add a law of the air: a struct here, its line in AnyAir, its parameters in python/rollerrig/config/schema/actuators.py.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <variant>

#include "rollerrig/fields.hpp"
#include "rollerrig/scalar.hpp"

namespace rollerrig {

/// What slide protection switches at a brake cylinder, an inlet and an outlet valve. Without current the inlet is open and the outlet
/// closed: an axle brakes when its slide protection fails.
enum class DumpValve : int { fill, hold, vent };

/// Commands go through controllers and files as numbers.
constexpr DumpValve valve_of(double command) { return static_cast<DumpValve>(static_cast<int>(command)); }

/// Of a magnet valve, in steps.
struct SwitchingSteps {
  int opening{}, closing{};  ///< from a changed command to the valve's moving
  int least_pulse{};         ///< that a command stays at least; a shorter one is prolonged
};

/// A valve that moves some time after its command; a command shorter than that does not move it.
class MagnetValve {
 public:
  explicit MagnetValve(bool open) : open_{open}, commanded_{open} {}

  void step(bool command, SwitchingSteps const& steps) {
    if (command != commanded_ && age_ >= steps.least_pulse) {
      commanded_ = command;
      age_ = 0;
    }
    if (open_ != commanded_ && age_ >= (commanded_ ? steps.opening : steps.closing)) open_ = commanded_;
    if (age_ < settled) ++age_;
  }
  bool open() const { return open_; }
  void state(auto& archive) {
    archive(open_, commanded_);
    archive.within(age_, 0, settled);
  }

 private:
  static constexpr int settled = 1 << 30;
  bool open_, commanded_;
  int age_{settled};  ///< of the command [steps]
};

class DumpUnit {
 public:
  void step(DumpValve command, SwitchingSteps const& steps) {
    inlet_.step(command == DumpValve::fill, steps);
    outlet_.step(command == DumpValve::vent, steps);
  }
  bool inlet_open() const { return inlet_.open(); }
  bool outlet_open() const { return outlet_.open(); }
  void state(auto& archive) { archive(inlet_, outlet_); }

 private:
  MagnetValve inlet_{true}, outlet_{false};
};

// Air through an orifice: choked up to a critical pressure ratio, subsonic beyond.
//     q = C p_1 phi(p_2/p_1),   phi = 1 up to b,   sqrt(1 - ((p_2/p_1 - b)/(1 - b))^2) beyond        (A12)
// q is a volume per time of air at the reference state (100 kPa, 20 degrees C), to which the air always returns: isothermal.
// Source  ISO 6358-1: sonic conductance C, critical pressure ratio b, and the straight line near equal pressures.

/// Sonic conductance C [m^3/(s Pa)] and b.
struct Orifice {
  double conductance{}, critical_ratio{};
};

/// Two orifices one behind the other as one, (A26).
inline Orifice in_series(Orifice const& one, Orifice const& other) {
  double const a = one.conductance, b = other.conductance, least = std::fmin(a, b);
  if (!(least > 0.0)) return {0.0, one.critical_ratio};
  double const both = least / std::cbrt(std::pow(least / a, 3.0) + std::pow(least / b, 3.0));
  auto const lost = [&](Orifice const& own) {
    return (1.0 - own.critical_ratio) * std::pow(both / own.conductance, 2.0);
  };
  return {both, std::fmax(0.0, 1.0 - lost(one) - lost(other))};
}

/// phi of (A12): flow over that of choked flow, 1 to 0.
///
/// @param ratio     absolute downstream over absolute upstream pressure; beyond 1 nothing flows
/// @param critical  b, of pneumatic valves 0.2 to 0.5
template <Scalar T>
T orifice_flow(T const& ratio, double critical) {
  using std::sqrt;
  constexpr double laminar = 0.999;  // from here on a straight line to 0: keeps the slope at equal pressures finite
  auto const subsonic = [&](T const& at) {
    T const part = (at - critical) / (1.0 - critical);
    return sqrt(1.0 - part * part);
  };
  T const begun = select(ratio > critical, ratio, T(critical));
  T const inside = subsonic(select(begun > laminar, T(laminar), begun));
  T const left = select(ratio < 1.0, 1.0 - ratio, T(0.0));
  return select(ratio > laminar, subsonic(T(laminar)) * left / (1.0 - laminar), inside);
}

//   demand -> [control valve: limited in rate] -> pressure asked for -> law of the air -> cylinder pressure
// Pressures are over the ambient [Pa], but for ratios. Air is counted as a volume at the ambient pressure [m^3].

/// Of one axle.
struct Cylinder {
  double control{};       ///< pressure asked for [Pa]
  double pressure{};      ///< [Pa]
  double air{};           ///< taken since the start [m^3]
  double exhausted{};     ///< let out since the start [m^3]
  bool inlet_open{true};  ///< of the dump valve
  bool outlet_open{false};
  int dump_cycles{};  ///< times that the outlet has opened
  DumpUnit unit{};    ///< of a law whose valves take time

  void state(auto& archive) { archive(control, pressure, air, exhausted, inlet_open, outlet_open, dump_cycles, unit); }

  void move_valves(bool inlet, bool outlet) {
    dump_cycles += outlet && !outlet_open;
    inlet_open = inlet;
    outlet_open = outlet;
  }
};

/// What feeds the cylinders of one reservoir.
struct AirSupply {
  double reservoir{};  ///< its pressure [Pa]
  double drawn{};      ///< from the main pipe since the start [m^3]
  void state(auto& archive) { archive(reservoir, drawn); }
};

/// A relay valve of several axles, and the air in the pipes behind it, which has one pressure.
struct RelayValve {
  double control{};         ///< pressure asked for: the mean of what its axles are asked for [Pa]
  double pressure{};        ///< in the pipes [Pa]
  std::size_t cylinders{};  ///< behind it
  void state(auto& archive) { archive(control, pressure); }
};

struct ControlValve {
  double application_rate{}, release_rate{}, follow_rate{}, ambient_pressure{}, volume{};

  static constexpr auto fields() {
    using P = ControlValve;
    return members(
        Member{"application_rate", &P::application_rate, "Pa/s", "largest rise of the control valve's pressure",
               not_negative},
        Member{"release_rate", &P::release_rate, "Pa/s", "largest fall of the control valve's pressure", not_negative},
        Member{"follow_rate", &P::follow_rate, "1/s", "rate at which the control valve closes in on the demand",
               not_negative},
        Member{"ambient_pressure", &P::ambient_pressure, "Pa", "absolute pressure of the ambient air", positive},
        Member{"volume", &P::volume, "m^3", "volume of an axle's cylinder and its pipe", positive});
  }

  double rate(double control, double demand) const {
    return std::clamp(follow_rate * (demand - control), -release_rate, application_rate);
  }
  /// Volume at ambient pressure of the air that changes a cylinder's pressure by so much.
  double air(double pressure) const { return volume * pressure / ambient_pressure; }
};

constexpr int air_parts = 8;  ///< of a sampling step: the flow near equal pressures changes fast

/// The pipes from a relay valve to the dump valves of its axles.
///
///   length, diameter -> [tube] -> C = 0.029 d^2/sqrt(L/d^1.25 + 510), b = 474 C/d^2 in m, s, Pa       (A25)
///
/// Source  P. Beater, Pneumatic Drives, Springer (2007), after J. Eckersten, from memory; a test compares it with Fanno's flow.
/// Of one cylinder; all cylinders behind a relay valve have their own, of the same size.
struct CylinderPipe {
  double length{}, diameter{}, relay_conductance{};

  static constexpr auto fields() {
    using P = CylinderPipe;
    return members(
        Member{"length", &P::length, "m", "length of the pipe from the relay valve to a dump valve, L", positive},
        Member{"diameter", &P::diameter, "m", "inner diameter of that pipe, d", positive},
        Member{"relay_conductance", &P::relay_conductance, "m^3/(s Pa)",
               "sonic conductance of a relay valve that is wide open, C", not_negative});
  }

  double volume() const { return 0.25 * pi * diameter * diameter * length; }
  Orifice tube() const {
    double const square = diameter * diameter;
    double const conductance = 0.029 * square / std::sqrt(length / std::pow(diameter, 1.25) + 510.0);
    return {conductance, 474.0 * conductance / square};
  }
};

/// An auxiliary reservoir, fed by the main pipe, behind dump valves with dead times.
///
///   main pipe -> [choke, check valve] -> auxiliary reservoir -> [relay valve, inlet] -> cylinders -> [outlet] -> ambient
///                                                     control valve's pressure -^
///
///     V p' = sqrt(T/T_0) p_0 C p_1 phi(p_2/p_1)        (A13), with (A12): isothermal, every part of the air at T
///
/// The relay valve opens in proportion to what is missing at the cylinder and lets out what is too much; nothing flows back into
/// the reservoir or the main pipe. What one volume loses another gains, to the last bit but one: air is conserved.
/// With a `pipe`: reservoir -> [relay valve of several axles] -> pipes -> [tube, inlet] -> cylinders -> [outlet] -> ambient; the
/// relay valve then follows the pressure in the pipes, and a cylinder's air flows back into them where they have less.
/// Source  ISO 6358-1; docs/theory/adhesion.md. A midpoint step never moves more than makes two pressures equal.
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

/// A supply that never runs out, behind dump valves that switch at once.
///
///   control valve's pressure -> [inlet] -> cylinder -> [outlet] -> ambient
///
/// The control valve holds its pressure whatever flows; dead times, where they matter, are in the controller's `delay`.
struct UnlimitedAir {
  static constexpr char const* name = "unlimited";
  static constexpr double critical_ratio = 0.4;  ///< b of (A12), of pneumatic valves 0.2 to 0.5

  double fill_rate{}, vent_rate{};

  static constexpr auto fields() {
    return members(Member{"fill_rate", &UnlimitedAir::fill_rate, "1/s",
                          "filling rate of the cylinder through the choked inlet, p'/p_supply", not_negative},
                   Member{"vent_rate", &UnlimitedAir::vent_rate, "1/s",
                          "venting rate of the cylinder through the choked outlet, -p'/p_cylinder", not_negative});
  }

  AirSupply start() const { return {}; }

  void step(ControlValve const& valve, std::span<Cylinder> cylinders, std::span<RelayValve> /*relays*/,
            AirSupply& /*supply*/, std::span<DumpValve const> command, std::span<double const> demand, double h) const {
    double const part = h / air_parts;
    for (std::size_t i = 0; i < cylinders.size(); ++i) {
      Cylinder& own = cylinders[i];
      own.move_valves(command[i] == DumpValve::fill, command[i] == DumpValve::vent);
      for (int k = 0; k < air_parts; ++k) advance(valve, own, demand[i], part);
    }
  }

 private:
  /// A midpoint step; no pressure passes the one that it follows.
  void advance(ControlValve const& valve, Cylinder& own, double demand, double part) const {
    double const control = own.control + 0.5 * part * valve.rate(own.control, demand);
    double const middle = own.pressure + 0.5 * part * rate(own, own.control, own.pressure, valve.ambient_pressure);
    own.control = std::fmax(0.0, own.control + part * valve.rate(control, demand));
    double const target = own.inlet_open ? own.control : own.outlet_open ? 0.0 : own.pressure;
    double const change = part * rate(own, control, middle, valve.ambient_pressure);
    double const left = target - own.pressure;
    double const rise = change * left > 0.0 ? std::copysign(std::fmin(std::fabs(change), std::fabs(left)), left) : 0.0;
    own.pressure += rise;
    (rise > 0.0 ? own.air : own.exhausted) += valve.air(std::fabs(rise));
  }

  double rate(Cylinder const& own, double control, double pressure, double ambient) const {
    double const cylinder = pressure + ambient, supply = control + ambient;
    if (own.inlet_open)
      return supply > cylinder ? fill_rate * supply * orifice_flow(cylinder / supply, critical_ratio)
                               : -fill_rate * cylinder * orifice_flow(supply / cylinder, critical_ratio);
    return own.outlet_open ? -vent_rate * cylinder * orifice_flow(ambient / cylinder, critical_ratio) : 0.0;
  }
};

using AnyAir = OneOf<UnlimitedAir, ReservoirAir>;

struct Pneumatics {
  ControlValve control_valve{};
  AnyAir air{};

  static constexpr auto fields() {
    return members(Member{"control_valve", &Pneumatics::control_valve}, Member{"air", &Pneumatics::air});
  }
};

}  // namespace rollerrig
