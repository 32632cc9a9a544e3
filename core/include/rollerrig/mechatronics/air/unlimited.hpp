// mechatronics/air/unlimited.hpp - a supply that never runs out, behind dump valves that switch at once.
//
//   control valve's pressure -> [inlet] -> cylinder -> [outlet] -> ambient
//
// The control valve holds its pressure whatever flows; dead times, where they matter, are in the controller's `delay`.
#pragma once
#include <cmath>
#include <span>
#include <tuple>

#include "rollerrig/mechatronics/air/control_valve.hpp"
#include "rollerrig/mechatronics/orifice.hpp"

namespace rollerrig {

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

}  // namespace rollerrig
