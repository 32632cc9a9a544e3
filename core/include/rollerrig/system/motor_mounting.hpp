// system/motor_mounting.hpp - how a traction motor is held, and what its rotor adds.
//
//   suspension, gear ratio, inertia of the rotor -> [mounting] -> reaction of the axle torque, link of the rotor
//
// The rotor turns with  Omega_m = n Omega_axle + (1 - n) Omega_casing  (n < 0: against the axle, as with one pair of gears).
// Casing: the bogie frame; the ground; or, axle-hung, a body between the axle and a link at distance d on the frame, with
// Omega_casing = -(z'_link - z'_axle) / d. Source: docs/theory/adhesion.md, (A9)-(A11).
#pragma once
#include "rollerrig/system/model.hpp"

namespace rollerrig {

/// @param link  d, along x from the axle to the link [m]; 0: the motor is held by the reaction body itself, or the ground
inline void mount_motor(Model& model, int axle_torque, double link, double gear_ratio, double rotor_inertia) {
  AxleTorque& torque = model.axle_torques.at(static_cast<std::size_t>(axle_torque));
  LinkArm axle{torque.wheelset, 0.0, 0.0, gear_ratio}, casing{torque.reaction, 0.0, 0.0, 1.0 - gear_ratio};
  if (link != 0.0 && torque.reaction != ground) {
    auto const x = [&](int body) { return model.bodies[static_cast<std::size_t>(body)].position.x; };
    torque.link = link;
    torque.link_on_reaction = x(torque.wheelset) + link - x(torque.reaction);
    axle.up = (1.0 - gear_ratio) / link;
    casing.up = -axle.up;
    casing.turn = axle.up * torque.link_on_reaction;
  }
  if (rotor_inertia > 0.0) model.rotors.push_back({{{axle, casing}}, rotor_inertia, 0.0});
}

}  // namespace rollerrig
