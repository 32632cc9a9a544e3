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
  double piston_area{};        ///< times rigging ratio and efficiency [m^2]
  double spring_force{};       ///< of the retracting spring, at the pads [N]
  PiecewiseLinear friction{};  ///< of pad on disc or block on tread, over sliding speed at the friction radius [m/s]
  double friction_radius{};    ///< [m]; of a tread brake the wheel radius
  double faces{};              ///< friction faces that the force presses on, per axle
  double friction_regularisation_speed{};  ///< below it friction turns into viscous drag, at the friction radius [m/s]

  static constexpr auto fields() {
    using P = FrictionBrake;
    return std::tuple{Member{"piston_area", &P::piston_area, not_negative},
                      Member{"spring_force", &P::spring_force},
                      Member{"friction", &P::friction},
                      Member{"friction_radius", &P::friction_radius, not_negative},
                      Member{"faces", &P::faces, not_negative},
                      Member{"friction_regularisation_speed", &P::friction_regularisation_speed, positive}};
  }

  /// Torque on the axle [N m], against its turning.
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
