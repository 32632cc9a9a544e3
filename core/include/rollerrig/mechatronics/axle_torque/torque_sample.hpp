// mechatronics/axle_torque/torque_sample.hpp - what the controller knows of one axle's torque at a sample.
#pragma once

namespace rollerrig {

struct TorqueSample {
  double estimate{};   ///< of the estimator, late by its lag [N m]
  double bandwidth{};  ///< of the estimator [rad/s]; 0: no lag
  double motor{};      ///< of the traction motor, as its drive reports it [N m]
  double brake{};      ///< of the friction brake, from the pressure in its cylinder and the friction of its pads [N m]
};

}  // namespace rollerrig
