// mechatronics/pneumatic_brake.hpp - from brake demand and valve state to the torque of a friction brake.
//
//   demand -> [control valve: pressure limited in rate] -> [dump valve: fill, hold, vent] -> cylinder pressure
//          -> clamping force -> friction of pads or blocks -> torque against the axle's turning
//
// Pressures are over the ambient [Pa]. Flow through the valves: choked up to a critical pressure ratio, elliptic beyond.
// Source  ISO 6358 for the flow function; EN 15595 and UIC 541-05 for the arrangement of control and dump valves.
#pragma once
#include <cmath>
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/math/piecewise_linear.hpp"

namespace rollerrig {

enum class DumpValve : int { fill, hold, vent };

/// Mass flow of an orifice over that of choked flow: 1 up to the critical pressure ratio, then down to 0 at equal pressures.
///
/// @param ratio  absolute downstream over absolute upstream pressure, 0..1
template <Scalar T>
T orifice_flow(T const& ratio) {
  using std::sqrt;
  double const critical = 0.4;   // of pneumatic valves, ISO 6358 annex: 0.2 to 0.5
  double const rounding = 0.05;  // of the square root's end: keeps the slope at equal pressures finite
  T const beyond = (ratio - critical) / (1.0 - critical);
  T const part = select(beyond > 0.0, beyond, T(0.0));
  T const left = 1.0 - part * part;
  T const open = select(left < 0.0, T(0.0), left);
  return (sqrt(open + rounding * rounding) - rounding) / (std::sqrt(1.0 + rounding * rounding) - rounding);
}

struct PneumaticBrake {
  double application_rate{};  ///< rise of the control valve's pressure [Pa/s]
  double release_rate{};      ///< its fall [Pa/s]
  double follow_rate{};       ///< of the control valve once within reach [1/s]
  double fill_rate{};         ///< of the cylinder through the open dump valve, choked: p'/p_supply [1/s]
  double vent_rate{};         ///< of the cylinder to the ambient, choked: -p'/p_cylinder [1/s]
  double ambient_pressure{};  ///< of the air around [Pa]
  double volume{};            ///< of the cylinder and its pipe [m^3]

  double piston_area{};        ///< times rigging ratio and efficiency [m^2]
  double spring_force{};       ///< of the retracting spring, at the pads [N]
  PiecewiseLinear friction{};  ///< of pad on disc or block on tread, over sliding speed at the friction radius [m/s]
  double friction_radius{};    ///< [m]; of a tread brake the wheel radius
  double faces{};              ///< friction faces that the force presses on, per axle
  double friction_regularisation_speed{};  ///< below it friction turns into viscous drag, at the friction radius [m/s]

  static constexpr auto fields() {
    using P = PneumaticBrake;
    return std::tuple{Member{"application_rate", &P::application_rate, not_negative},
                      Member{"release_rate", &P::release_rate, not_negative},
                      Member{"follow_rate", &P::follow_rate, not_negative},
                      Member{"fill_rate", &P::fill_rate, not_negative},
                      Member{"vent_rate", &P::vent_rate, not_negative},
                      Member{"ambient_pressure", &P::ambient_pressure, positive},
                      Member{"volume", &P::volume, not_negative},
                      Member{"piston_area", &P::piston_area, not_negative},
                      Member{"spring_force", &P::spring_force},
                      Member{"friction", &P::friction},
                      Member{"friction_radius", &P::friction_radius, not_negative},
                      Member{"faces", &P::faces, not_negative},
                      Member{"friction_regularisation_speed", &P::friction_regularisation_speed, positive}};
  }

  /// Rates of control valve pressure and cylinder pressure.
  ///
  /// @param inflow  rise of the cylinder's pressure by filling, for the air account [Pa/s]
  template <Scalar T>
  void rates(T const* state, T const& demand, DumpValve valve, T* rate, T& inflow) const {
    T const wanted = follow_rate * (demand - state[0]);
    rate[0] = select(wanted > application_rate, T(application_rate),
                     select(wanted < -release_rate, T(-release_rate), wanted));
    T const& supply = state[0];
    T const& cylinder = state[1];
    T const high = select(supply > cylinder, supply, cylinder) + ambient_pressure;
    T const low = select(supply > cylinder, cylinder, supply) + ambient_pressure;
    T const exchange = fill_rate * high * orifice_flow(low / high);
    T const vented =
        vent_rate * (cylinder + ambient_pressure) * orifice_flow(ambient_pressure / (cylinder + ambient_pressure));
    inflow = T(0.0);
    rate[1] = T(0.0);
    if (valve == DumpValve::fill) {
      rate[1] = select(supply > cylinder, exchange, -exchange);
      inflow = select(supply > cylinder, exchange, T(0.0));
    }
    if (valve == DumpValve::vent) rate[1] = -vented;
  }

  /// Volume of air at ambient pressure that a rise of the cylinder's pressure takes [m^3].
  double air(double pressure_rise) const { return volume * pressure_rise / ambient_pressure; }

  /// Torque on the axle, against its turning.
  template <Scalar T>
  T torque(T const& cylinder, T const& axle_speed) const {
    using std::sqrt;
    T const pressed = piston_area * cylinder - spring_force;
    T const force = select(pressed > 0.0, pressed, T(0.0));
    T const sliding = friction_radius * axle_speed;
    T const speed = sqrt(sliding * sliding + friction_regularisation_speed * friction_regularisation_speed);
    T const mu = friction.at(speed);
    return -(faces * friction_radius * mu * force * (sliding / speed));
  }
};

}  // namespace rollerrig
