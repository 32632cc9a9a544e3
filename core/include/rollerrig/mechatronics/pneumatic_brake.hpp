// mechatronics/pneumatic_brake.hpp - from brake demand and valve state to the torque of a friction brake.
//
//   demand -> [control valve: pressure limited in rate] -> [dump valve: fill, hold, vent] -> cylinder pressure
//          -> clamping force -> friction of pads or blocks -> torque against the axle's turning
//
// Pressures are over the ambient [Pa]. Flow through the valves: choked up to a critical pressure ratio, elliptic beyond.
// Source  ISO 6358 for the flow function; EN 15595 and UIC 541-05 for the arrangement of control and dump valves.
#pragma once
#include <cmath>

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
  static constexpr int states = 2;  ///< control valve pressure, cylinder pressure

  double application_rate{1.2e5};  ///< rise of the control valve's pressure [Pa/s]
  double release_rate{1.2e5};      ///< its fall [Pa/s]
  double follow_rate{20.0};        ///< of the control valve once within reach [1/s]
  double fill_rate{6.0};           ///< of the cylinder through the open dump valve, choked: p'/p_supply [1/s]
  double vent_rate{5.0};           ///< of the cylinder to the ambient, choked: -p'/p_cylinder [1/s]
  double volume{5e-3};             ///< of the cylinder and its pipe [m^3]
  double ambient{101325.0};        ///< pressure of the air around [Pa]

  double piston_area{0.085};      ///< times rigging ratio and efficiency [m^2]
  double spring_force{500.0};     ///< of the retracting spring, at the pads [N]
  PiecewiseLinear friction{};     ///< of pad on disc or block on tread, over sliding speed at the friction radius [m/s]
  double friction_radius{0.247};  ///< [m]; of a tread brake the wheel radius
  double faces{2.0};              ///< friction faces that the force presses on, per axle
  double friction_regularisation_speed{
      0.05};  ///< below it friction turns into viscous drag, at the friction radius [m/s]

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
    T const high = select(supply > cylinder, supply, cylinder) + ambient;
    T const low = select(supply > cylinder, cylinder, supply) + ambient;
    T const exchange = fill_rate * high * orifice_flow(low / high);
    T const vented = vent_rate * (cylinder + ambient) * orifice_flow(ambient / (cylinder + ambient));
    inflow = T(0.0);
    rate[1] = T(0.0);
    if (valve == DumpValve::fill) {
      rate[1] = select(supply > cylinder, exchange, -exchange);
      inflow = select(supply > cylinder, exchange, T(0.0));
    }
    if (valve == DumpValve::vent) rate[1] = -vented;
  }

  /// Volume of air at ambient pressure that a rise of the cylinder's pressure takes [m^3].
  double air(double pressure_rise) const { return volume * pressure_rise / ambient; }

  /// Torque on the axle, against its turning.
  template <Scalar T>
  T torque(T const& cylinder, T const& axle_speed) const {
    using std::sqrt;
    T const pressed = piston_area * cylinder - spring_force;
    T const force = select(pressed > 0.0, pressed, T(0.0));
    T const sliding = friction_radius * axle_speed;
    T const speed = sqrt(sliding * sliding + friction_regularisation_speed * friction_regularisation_speed);
    T const mu = friction.empty() ? T(0.35) : friction.at(speed);
    return -(faces * friction_radius * mu * force * (sliding / speed));
  }
};

}  // namespace rollerrig
