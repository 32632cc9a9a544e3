// system/rolling_constraint.hpp - an axle that rolls on its roller without slip, r w = R W: the hypothesis of the rig's control law.
//
//   wrenches of wheelset and roller, creep forces along the track -> [constraint] -> one force T at the crown instead of them
//
// The patches keep normal forces, lateral creep and what differs between left and right (yaw). What they do together along
// the track and about the two axles is taken out, and T keeps the mean longitudinal slip at nominal radii at nothing:
//
//   delta = v_x - V_x - r Omega - R Omega_r        delta' = -delta / tau        (D13)
//
// with Omega about the body's own axle (of a roller negative in forward running), V_x of a roller on springs. It is a coupling
// of system/couplings.hpp: alone, T = -(delta'_0 + delta / tau) / (1/m + r^2/I + 1/m_r + R^2/I_r).
#pragma once
#include "rollerrig/system/contact_placement.hpp"

namespace rollerrig {

/// Creep force of both wheels on the wheelset along the track [N], and their moments on wheelset and roller about the axles.
template <Scalar T>
struct AxleCreep {
  T force{0.0}, on_wheelset{0.0}, on_roller{0.0};

  AxleCreep& operator+=(AxleCreep const& o) {
    force = force + o.force, on_wheelset = on_wheelset + o.on_wheelset, on_roller = on_roller + o.on_roller;
    return *this;
  }
};

/// The part of one patch.
///
/// @param axle  of the wheelset, unit vector
template <Scalar T>
AxleCreep<T> axle_creep(WheelContact const& contact, ContactPlacement<T> const& placed, Vec3<T> const& axle,
                        Patch<T> const& patch) {
  Vec3<T> const& n = patch.point.n;
  auto const w =
      in_wheelset_frame(contact, placed,
                        contact_wrenches(contact.laws.roller, placed, patch.point.p,
                                         patch.force - patch.normal.total() * n, patch.creep.spin_moment * n));
  return {w.force.x, dot(w.on_wheelset, axle), -w.on_roller.y};
}

/// Takes the mean creep out of the wrenches; returns the power it did, which no longer dissipates [W].
template <Scalar T>
T remove_mean_creep(AxleCreep<T> const& creep, BodyMotion<T> const& wheelset, BodyMotion<T> const& roller,
                    Wrench<T>& on_wheelset, Wrench<T>& on_roller) {
  on_wheelset.force.x -= creep.force;
  on_roller.force.x += creep.force;
  on_wheelset.moment -= creep.on_wheelset * wheelset.R.ey;
  on_roller.moment -= creep.on_roller * roller.R.ey;
  return creep.force * (wheelset.v.x - roller.v.x) + creep.on_wheelset * dot(wheelset.R.ey, wheelset.omega) +
         creep.on_roller * dot(roller.R.ey, roller.omega);
}

}  // namespace rollerrig
