// multibody/moving_frame.hpp - a body in the track frame F that moves with it: inertial forces, and its motion as others see it.
//
//   track frame, motion in F -> [moving frame] -> motion in the common frame H (for elements), inertial force and moment in F
//
// P is the centre of mass from the origin of F, v and w its velocity and angular velocity relative to F.
// Source: docs/theory/track.md, (W4)-(W9).
#pragma once
#include "rollerrig/multibody/body.hpp"
#include "rollerrig/track/line.hpp"

namespace rollerrig {

/// P [m].
template <Scalar T>
Vec3<T> place_in_frame(Body const& body, BodyMotion<T> const& m) {
  return {m.p.x, body.position.y + m.p.y, body.position.z + m.p.z};
}

/// The motion seen from H: what of BodyMotion the elements read. Velocities are the absolute ones less V along x of H,
/// angular velocities are absolute. (W7)
template <Scalar T>
void see_from_common_frame(Body const& body, TrackFrame<T> const& frame, T const& speed, BodyMotion<T> const& m,
                           BodyMotion<T>& out) {
  Vec3<T> const place = place_in_frame(body, m);
  out.R = {frame.R * m.R.ex, frame.R * m.R.ey, frame.R * m.R.ez};
  out.p = frame.origin + frame.R * place - lift<T>(body.position);
  out.v = frame.R * (frame.v + m.v + cross(frame.omega, place)) - Vec3<T>{speed, T(0.0), T(0.0)};
  out.omega = frame.R * (frame.omega + m.omega);
  out.frame_omega = frame.R * (frame.omega + m.frame_omega);
}

/// Acceleration of the centre of mass but for that relative to F: of the frame, Euler, centripetal and Coriolis. (W4)
template <Scalar T>
Vec3<T> transport_acceleration(Body const& body, TrackFrame<T> const& frame, BodyMotion<T> const& m) {
  Vec3<T> const place = place_in_frame(body, m);
  return frame.a + cross(frame.alpha, place) + cross(frame.omega, cross(frame.omega, place) + T(2.0) * m.v);
}

/// Rate of the angular velocity of F as it appears along the body's axes, which turn in F, body components [rad/s^2]. (W5)
template <Scalar T>
Vec3<T> transport_turning(TrackFrame<T> const& frame, BodyMotion<T> const& m) {
  return m.R.transposed_times(frame.alpha) - cross(m.frame_body, m.R.transposed_times(frame.omega));
}

/// W x (I w) and I times the turning of F, with absolute W and w, body components [N m]. (W5)
template <Scalar T>
Vec3<T> gyroscopic_moment(Body const& body, TrackFrame<T> const& frame, BodyMotion<T> const& m) {
  auto const& I = body.inertia;
  Vec3<T> const transport = m.R.transposed_times(frame.omega);
  Vec3<T> const turning = transport_turning(frame, m);
  Vec3<T> const w = m.omega_body + transport;
  return cross(m.frame_body + transport, Vec3<T>{I.x * w.x, I.y * w.y, I.z * w.z}) +
         Vec3<T>{I.x * turning.x, I.y * turning.y, I.z * turning.z};
}

/// Power by which the motion of F feeds the motion relative to it. (W9)
///
/// @param common    force and moment of elements and torques, components in F
/// @param inertial  m times minus the transport acceleration [N]
/// @param gyroscopic  (W5) [N m], body components
template <Scalar T>
T transport_power(Body const& body, TrackFrame<T> const& frame, T const& speed, double gravity, BodyMotion<T> const& m,
                  Wrench<T> const& common, Vec3<T> const& inertial, Vec3<T> const& gyroscopic) {
  Vec3<T> const place = place_in_frame(body, m);
  Vec3<T> const ahead = frame.R.transposed_times(Vec3<T>{speed, T(0.0), T(0.0)});  // forces within the vehicle cancel
  T const of_elements =
      dot(common.force, frame.v - ahead + cross(frame.omega, place)) + dot(common.moment, frame.omega);
  T const of_weight = body.mass * gravity * dot(frame.up_rate, place);
  return dot(inertial, m.v) - dot(gyroscopic, m.omega_body) - of_elements + of_weight;
}

}  // namespace rollerrig
