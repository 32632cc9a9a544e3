// system/ideal_rolling.hpp - wheel and roller of an axle tied by r w = R W: the hypothesis of the rig's control law.
//
//   wrenches of wheelset and roller, creep forces along the track -> [tie] -> one force T at the crown instead of them
//
// The patches keep normal forces, lateral creep and what differs between left and right (yaw). What they do together along
// the track and about the two axles is taken out, and T keeps the mean longitudinal slip at nominal radii at nothing:
//
//   s = v_x - V_x - r Omega - R Omega_r        s' = -s / tau        (C9)
//
// with Omega about the body's own axle (of a roller negative in forward running), V_x of a roller on springs. All wrenches
// but T are known, and s' is linear in it: T = -(s'_0 + s / tau) / (1/m + r^2/I + 1/m_r + R^2/I_r).
#pragma once
#include <array>

#include "rig/system/contact_placement.hpp"

namespace rig {

/// One axle on its rollers.
struct IdealRolling {
  int wheelset{0}, roller{0};  ///< bodies
  double wheel_radius{0.46};   ///< r, nominal [m]
  double roller_radius{1.0};   ///< R [m]
  std::array<int, 2> contact{-1, -1};
  double rate{20.0};  ///< 1/tau [1/s]: against what rounding adds up to
};

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
                        Patch<T> patch) {
  patch.force -= patch.normal.total() * patch.point.n;
  patch.moment = patch.creep.spin_moment * patch.point.n;
  Vec3<T> on_wheelset = cross(patch.point.p - placed.pose.o, patch.force) + patch.moment;
  Vec3<T> on_crown = moment_about_crown(contact.laws.roller, patch);
  Vec3<T> force = patch.force;
  if (contact.right) {
    force = mirrored(force);
    on_wheelset = mirrored_axial(on_wheelset);
    on_crown = mirrored_axial(on_crown);
  }
  T const on_roller = -(on_crown + cross(lift<T>(contact.crown_in_roller), force)).y;
  if (placed.turned) {
    force = placed.R * force;
    on_wheelset = placed.R * on_wheelset;
  }
  return {force.x, dot(on_wheelset, axle), on_roller};
}

template <Scalar T>
T turning(BodyMotion<T> const& m) {
  return dot(m.R.ey, m.omega);
}

/// s [m/s]
template <Scalar T>
T mean_slip(IdealRolling const& tie, BodyMotion<T> const& wheelset, BodyMotion<T> const& roller) {
  return wheelset.v.x - roller.v.x - tie.wheel_radius * turning(wheelset) - tie.roller_radius * turning(roller);
}

/// A force along x at the centre and a moment about the axle.
template <Scalar T>
void push(Wrench<T>& wrench, BodyMotion<T> const& m, T const& force, T const& moment) {
  wrench.force.x += force;
  wrench.moment += moment * m.R.ey;
}

/// Acceleration of a surface point at `arm` under the axle; and what a force there adds to it per newton.
template <Scalar T>
T surface_acceleration(Body const& body, BodyMotion<T> const& m, Wrench<T> const& wrench, double arm, T const& driven,
                       double& compliance) {
  T a(0.0);
  if (!body.locked[coord_x]) {
    a = wrench.force.x / body.mass;
    compliance += 1.0 / body.mass;
  }
  if (body.driven) return a - arm * driven;
  compliance += arm * arm / body.inertia.y;
  return a - arm * (dot(m.R.ey, wrench.moment) - gyroscopic_moment(body, m).y) / body.inertia.y;
}

/// Puts the tie in place of the mean creep; returns T [N] on the wheelset, forward.
///
/// @param driven  pitch acceleration of a roller whose speed is given [rad/s^2]
/// @param power   to be added to the heat of creep: what is taken out no longer dissipates [W]
template <Scalar T>
T tie_axle(IdealRolling const& tie, Body const& wheelset, Body const& roller, BodyMotion<T> const& m_w,
           BodyMotion<T> const& m_r, AxleCreep<T> const& creep, T const& driven, Wrench<T>& on_wheelset,
           Wrench<T>& on_roller, T& power) {
  push<T>(on_wheelset, m_w, -creep.force, -creep.on_wheelset);
  push<T>(on_roller, m_r, creep.force, -creep.on_roller);
  double compliance = 0.0;
  T const a_wheel = surface_acceleration(wheelset, m_w, on_wheelset, tie.wheel_radius, T(0.0), compliance);
  T const a_roller = surface_acceleration(roller, m_r, on_roller, -tie.roller_radius, driven, compliance);
  T const slip = mean_slip(tie, m_w, m_r);
  T const force = -(a_wheel - a_roller + tie.rate * slip) / compliance;
  push<T>(on_wheelset, m_w, force, -tie.wheel_radius * force);
  push<T>(on_roller, m_r, -force, -tie.roller_radius * force);
  power = creep.force * (m_w.v.x - m_r.v.x) + creep.on_wheelset * turning(m_w) + creep.on_roller * turning(m_r) -
          force * slip;
  return force;
}

}  // namespace rig
