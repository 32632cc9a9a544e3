// system/contact_placement.hpp - how a wheel and the rail or roller under it lie and move, before a contact is looked for.
//
//   motion of wheelset and roller, track frame, irregularity -> [placement] -> contact geometry, contact forces
//
// Frame b  of geometry/pair.hpp, fixed to the rail or roller where it really lies: displaced by the irregularity and turned
//          into its direction. The material of a rail stands still in the ground; seen from the wheelset's track frame it
//          runs backwards with -V and turns with -omega, along the rail's own direction. So the rate of the gap, the lateral
//          creepage and the work of the rail need no terms of their own.
// Neglected: the curvature of the rail along its length, within the centimetre by which a contact leads or lags.
// Source: docs/theory/track.md, (W8).
#pragma once
#include "rollerrig/contact/patch.hpp"
#include "rollerrig/multibody/moving_frame.hpp"
#include "rollerrig/system/model.hpp"
#include "rollerrig/track/line.hpp"

namespace rollerrig {

template <Scalar T>
struct ContactPlacement {
  RelativePose<T> pose;      ///< of the wheelset, b components
  ContactMotion<T> motion;   ///< b components
  Rotation<T> R;             ///< b -> axes of the wheelset's frame; not set where `turned` is false: they are parallel
  Vec3<T> prescribed_v;      ///< part of motion.v_roller that no state makes: of rails and of steered rollers
  Vec3<T> prescribed_omega;  ///< the same of motion.omega_roller
  bool turned{false};
  bool prescribed{false};
};

template <Scalar T>
Vec3<T> mirrored(Vec3<T> const& polar) {
  return {polar.x, -polar.y, polar.z};
}
template <Scalar T>
Vec3<T> mirrored_axial(Vec3<T> const& axial) {
  return {-axial.x, axial.y, -axial.z};
}

/// The same, looked at in the mirror of the plane x-z: a right wheel becomes a left one.
template <Scalar T>
void mirror(ContactPlacement<T>& p) {
  p.pose.o = mirrored(p.pose.o);
  p.pose.R = {mirrored(p.pose.R.ex), mirrored_axial(p.pose.R.ey), mirrored(p.pose.R.ez)};
  p.motion = {mirrored(p.motion.v_wheel), mirrored_axial(p.motion.omega_wheel), mirrored(p.motion.v_roller),
              mirrored_axial(p.motion.omega_roller)};
  p.prescribed_v = mirrored(p.prescribed_v);
  p.prescribed_omega = mirrored_axial(p.prescribed_omega);
}

/// What patches do to both bodies: force on the wheel, moment about the wheelset's centre, and the moment that a roller takes
/// the opposite of.
template <Scalar T>
struct ContactWrenches {
  Vec3<T> force{};
  Vec3<T> on_wheelset{};
  Vec3<T>
      on_roller{};  ///< about the crown point; after in_wheelset_frame() about the roller's centre, roller components

  ContactWrenches& operator+=(ContactWrenches const& o) {
    force += o.force, on_wheelset += o.on_wheelset, on_roller += o.on_roller;
    return *this;
  }
};

/// Of a force and a moment at a point, b components, mirrored like it.
template <Scalar T>
ContactWrenches<T> contact_wrenches(RollerEffects const& effects, ContactPlacement<T> const& placed, Vec3<T> const& p,
                                    Vec3<T> const& force, Vec3<T> const& moment) {
  return {force, cross(p - placed.pose.o, force) + moment, moment_about_crown(effects, p, force, moment)};
}

/// Power of what moves the rail or steers the roller, beside what a state does.
template <Scalar T>
T prescribed_power(ContactPlacement<T> const& placed, ContactWrenches<T> const& w) {
  if (!placed.prescribed) return T(0.0);
  return placed.turned ? dot(w.force, placed.prescribed_v) + dot(w.on_roller, placed.prescribed_omega)
                       : w.force.x * placed.prescribed_v.x;
}

/// The mirror removed, force and moment on the wheelset in the axes of its frame.
template <Scalar T>
ContactWrenches<T> in_wheelset_frame(WheelContact const& contact, ContactPlacement<T> const& placed,
                                     ContactWrenches<T> w) {
  if (contact.right) w = {mirrored(w.force), mirrored_axial(w.on_wheelset), mirrored_axial(w.on_roller)};
  w.on_roller += cross(lift<T>(contact.crown_in_roller), w.force);
  if (placed.turned) {
    w.force = placed.R * w.force;
    w.on_wheelset = placed.R * w.on_wheelset;
  }
  return w;
}

/// The axes of a rail along a direction: x there, y level.
template <Scalar T>
Rotation<T> axes_along(Vec3<T> const& direction) {
  using std::sqrt;
  T const plan2 = direction.x * direction.x + direction.y * direction.y;
  T const inverse_plan = 1.0 / sqrt(plan2);
  T const inverse = 1.0 / sqrt(plan2 + direction.z * direction.z);
  Vec3<T> const ex = inverse * direction;
  Vec3<T> const ey{-(direction.y * inverse_plan), direction.x * inverse_plan, T(0.0)};
  return {ex, ey, cross(ex, ey)};
}

/// The head of the undisturbed rail, from the origin of b [m].
inline Vec3<double> head_of(WheelContact const& contact) {
  return {0.0, contact.right ? -contact.pair.rail_origin_y : contact.pair.rail_origin_y, 0.0};
}

/// Wheel on a rail of straight, level and perfect track.
template <Scalar T>
ContactPlacement<T> on_straight_rail(WheelContact const& contact, BodyMotion<T> const& wheelset, T const& speed) {
  ContactPlacement<T> p;
  p.pose = {lift<T>(contact.wheelset_from_crown) + wheelset.p, wheelset.R};
  p.prescribed = true;
  p.prescribed_v = {-speed, T(0.0), T(0.0)};
  p.motion = {wheelset.v, wheelset.omega, p.prescribed_v, {}};
  return p;
}

/// Wheel on a rail anywhere: curved and canted (`frame`; null: straight), irregular, on springs (`rail`; null: rigid). (W8)
template <Scalar T>
ContactPlacement<T> on_rail(WheelContact const& contact, BodyMotion<T> const& wheelset, BodyMotion<T> const* rail,
                            TrackFrame<T> const* frame, RailOffset<T> const& offset, T const& speed) {
  ContactPlacement<T> p;
  Vec3<T> const head = lift<T>(head_of(contact));
  Vec3<T> const irregular{T(0.0), offset.y.value, offset.z.value};
  // Direction of this rail per metre of the line, and velocity of its material at any place X: -V (along + twist x X).
  Vec3<T> direction{T(1.0), offset.y.slope, offset.z.slope};
  if (frame) direction += frame->along - Vec3<T>{T(1.0), T(0.0), T(0.0)} + cross(frame->twist, head + irregular);
  Rotation<T> along = axes_along(direction);
  if (offset.rolled) {
    auto const lean = offset.lean();
    along = {along.ex, along * lean.ey, along * lean.ez};
  }
  p.R = along;
  p.turned = true;
  Vec3<T> displaced = head + irregular;
  if (rail) {  // its head moves with its centre of mass, and on the lever arm from there as it rolls
    Vec3<T> const arm = lift<T>(contact.crown_in_roller) + head;
    p.R = {rail->R * along.ex, rail->R * along.ey, rail->R * along.ez};
    displaced += rail->p + p.R * arm - along * arm;
  }
  auto const to_b = [&](Vec3<T> const& v) { return p.R.transposed_times(v); };
  p.pose = {head + to_b(lift<T>(contact.wheelset_from_crown) + wheelset.p - displaced), relative(p.R, wheelset.R)};
  Vec3<T> material{-speed, T(0.0), T(0.0)};
  if (frame) {
    Vec3<T> const origin = displaced - p.R * head;  // of b, from that of F
    material = -(frame->v + cross(frame->omega, origin));
    p.prescribed_omega = to_b(-frame->omega);
  }
  p.prescribed = true;
  p.prescribed_v = to_b(material);
  if (offset.rolled) {  // a surface that is twisted along x rises and falls under the wheel, away from its head
    Vec3<T> const twist{speed * offset.roll.slope, T(0.0), T(0.0)};
    p.prescribed_omega += twist;
    p.prescribed_v -= cross(twist, head);
  }
  p.motion = {to_b(wheelset.v), to_b(wheelset.omega), p.prescribed_v, p.prescribed_omega};
  if (rail) {
    Vec3<T> const turning = to_b(rail->omega);
    p.motion.v_roller += to_b(rail->v) + cross(turning, lift<T>(contact.crown_in_roller));
    p.motion.omega_roller += turning;
  }
  return p;
}

/// Wheel on a roller that can only spin: its frame coincides with the world's.
template <Scalar T>
ContactPlacement<T> on_fixed_roller(WheelContact const& contact, BodyMotion<T> const& wheelset,
                                    BodyMotion<T> const& roller) {
  ContactPlacement<T> p;
  p.pose = {lift<T>(contact.wheelset_from_crown) + wheelset.p, wheelset.R};
  p.motion = {wheelset.v,
              wheelset.omega,
              {roller.rate[coord_pitch] * contact.crown_in_roller.z, T(0.0), T(0.0)},
              {T(0.0), roller.rate[coord_pitch], T(0.0)}};
  return p;
}

/// Wheel on a roller on springs, or one that is moved like the rail it stands for (`offset`; null: it is not).
template <Scalar T>
ContactPlacement<T> on_roller(WheelContact const& contact, BodyMotion<T> const& wheelset, BodyMotion<T> const& roller,
                              RailOffset<T> const* offset, bool steered, T const& speed) {
  ContactPlacement<T> p;
  Vec3<T> const c = lift<T>(contact.crown_in_roller);
  // The crown point moves by (R - 1) c with the roller's turning; written so that a large radius cancels exactly.
  Vec3<T> const turned = c.x * (roller.R.ex - Vec3<T>{T(1.0), T(0.0), T(0.0)}) +
                         c.y * (roller.R.ey - Vec3<T>{T(0.0), T(1.0), T(0.0)}) +
                         c.z * (roller.R.ez - Vec3<T>{T(0.0), T(0.0), T(1.0)});
  Vec3<T> origin = roller.p + turned;  // of b, from its design position
  p.R = roller.R;
  p.turned = true;
  Vec3<T> given{};  // velocity that the actuators prescribe
  if (offset) {
    p.prescribed = true;
    origin += Vec3<T>{T(0.0), offset->y.value, offset->z.value};
    given = {T(0.0), speed * offset->y.slope, speed * offset->z.slope};
    if (steered) {
      T const slope = offset->y.slope;
      Rotation<T> const steering = axes_along(Vec3<T>{T(1.0), slope, T(0.0)});
      Vec3<T> const head = lift<T>(head_of(contact));
      origin += roller.R * (head - steering * head);  // it turns about its own crown
      p.R = {roller.R * steering.ex, roller.R * steering.ey, roller.R * steering.ez};
      p.prescribed_omega.z = speed * offset->y.second / (1.0 + slope * slope);
      p.prescribed_v = -cross(p.prescribed_omega, head);
    }
  }
  auto const to_b = [&](Vec3<T> const& v) { return p.R.transposed_times(v); };
  p.prescribed_v += to_b(given);
  p.pose = {to_b(lift<T>(contact.wheelset_from_crown) + wheelset.p - origin), relative(p.R, wheelset.R)};
  p.motion = {to_b(wheelset.v), to_b(wheelset.omega), to_b(roller.v) + cross(roller.omega_body, c), roller.omega_body};
  if (offset) {
    p.motion.v_roller += p.prescribed_v;
    p.motion.omega_roller += p.prescribed_omega;
  }
  return p;
}

// An axle that rolls on its roller without slip, r w = R W: the hypothesis of the rig's control law.
// The patches keep normal forces, lateral creep and what differs between left and right (yaw). What they do together along
// the track and about the two axles is taken out, and T keeps the mean longitudinal slip at nominal radii at nothing:
//   delta = v_x - V_x - r Omega - R Omega_r        delta' = -delta / tau        (D13)
// with Omega about the body's own axle (of a roller negative in forward running), V_x of a roller on springs. It is a coupling
// of system/couplings.hpp: alone, T = -(delta'_0 + delta / tau) / (1/m + r^2/I + 1/m_r + R^2/I_r).

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
