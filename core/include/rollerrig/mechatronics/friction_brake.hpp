// mechatronics/friction_brake.hpp - from cylinder pressure to the torque of a disc or tread brake.
//
//   cylinder pressure over the ambient -> clamping force -> friction of pads or blocks -> torque against the axle's turning
#pragma once
#include <cmath>
#include <tuple>

#include "rollerrig/fields.hpp"
#include "rollerrig/math/piecewise_linear.hpp"

namespace rollerrig {

struct FrictionBrake {
  double piston_area{}, spring_force{};
  PiecewiseLinear friction{};
  double friction_radius{}, faces{}, friction_regularisation_speed{};

  static constexpr auto fields() {
    using P = FrictionBrake;
    return members(
        Member{"piston_area", &P::piston_area, "m^2",
               "piston area of an axle, times ratio and efficiency of the rigging", not_negative},
        Member{"spring_force", &P::spring_force, "N", "force of the retracting spring, at the pads"},
        Member{"friction", &P::friction, "1",
               "friction of pad on disc or block on tread, over sliding speed at the friction radius [m/s]"},
        Member{"friction_radius", &P::friction_radius, "m",
               "effective radius of the disc; of a tread brake the wheel radius", not_negative},
        Member{"faces", &P::faces, "1", "number of friction faces of an axle that the force presses on", not_negative},
        Member{"friction_regularisation_speed", &P::friction_regularisation_speed, "m/s",
               "sliding speed below which friction turns into viscous drag", positive});
  }

  /// Torque on the axle [N m], against its turning.
  template <Scalar T>
  T torque(T const& cylinder, T const& axle_speed) const {
    T const speed = rubbing_speed(axle_speed);
    return -(sliding_torque(cylinder, axle_speed) * (friction_radius * axle_speed / speed));
  }

  /// The same of pads that slide in full, whichever way: its magnitude, also of an axle at rest [N m].
  template <Scalar T>
  T sliding_torque(T const& cylinder, T const& axle_speed) const {
    T const pressed = piston_area * cylinder - spring_force;
    T const force = select(pressed > 0.0, pressed, T(0.0));
    return faces * friction_radius * friction.at(rubbing_speed(axle_speed)) * force;
  }

  /// Cylinder pressure over the ambient at which sliding_torque() is this [Pa]; of no torque that at which the pads touch.
  double pressure(double torque, double axle_speed) const {
    double const per_force = faces * friction_radius * friction.at(rubbing_speed(axle_speed));
    return per_force > 0.0 && piston_area > 0.0 ? (torque / per_force + spring_force) / piston_area : 0.0;
  }

 private:
  /// At the friction radius, never zero [m/s].
  template <Scalar T>
  T rubbing_speed(T const& axle_speed) const {
    using std::sqrt;
    T const sliding = friction_radius * axle_speed;
    return sqrt(sliding * sliding + friction_regularisation_speed * friction_regularisation_speed);
  }
};

}  // namespace rollerrig
