// mechatronics/air/control_valve.hpp - the pressure that a brake's control valve asks for, and the cylinders behind it.
//
//   demand -> [control valve: limited in rate] -> pressure asked for -> unlimited.hpp or reservoir.hpp -> cylinder pressure
//
// Pressures are over the ambient [Pa], but for ratios. Air is counted as a volume at the ambient pressure [m^3].
#pragma once
#include <algorithm>
#include <cstddef>
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/dump_valve.hpp"

namespace rollerrig {

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

/// What feeds all cylinders.
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

}  // namespace rollerrig
