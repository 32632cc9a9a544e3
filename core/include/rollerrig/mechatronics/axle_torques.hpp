// mechatronics/axle_torques.hpp - where the controller takes the torque on an axle from: the laws that a case can name.
//
//   estimate, pressure in the cylinder, torque of the motor -> [axle torque] -> C of the virtual train, (D3)
//
// To add one: a header in axle_torque/, its line in AnyAxleTorque, its parameters in python/rollerrig/config/schema/rig_control.py.
#pragma once
#include <variant>

#include "rollerrig/mechatronics/axle_torque/estimated.hpp"
#include "rollerrig/mechatronics/axle_torque/extrapolated.hpp"
#include "rollerrig/mechatronics/axle_torque/known.hpp"

namespace rollerrig {

using AnyAxleTorque = std::variant<EstimatedTorque, KnownTorque, ExtrapolatedTorque>;

}  // namespace rollerrig
