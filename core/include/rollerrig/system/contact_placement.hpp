// system/contact_placement.hpp - how a wheel and the rail or roller under it lie and move, before a contact is looked for.
//
//   motion of wheelset and roller, track frame, irregularity -> [placement] -> contact geometry, contact forces
//
// Frames   b  of geometry/pair.hpp, fixed to the rail or roller where it really lies: displaced by the irregularity and turned
//             into its direction
//          F  where b would be without displacement, in which the motion of all bodies is known: the wheelset's track frame,
//             on a rig the world
//          k  of the roller or elastic rail, at its centre of mass;  r  of the wheelset;  H  the head of the rail, a point
//          p_AB_C from A to B in components of C, R_AC from C to A; v_C, force_C in components of C
//          The material of a rail stands still in the ground; seen from F it runs backwards with -V and turns with -omega,
//          along the rail's own direction. So the rate of the gap, the lateral creepage and the work of the rail need no
//          terms of their own.
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
  RelativePose<T> pose;        ///< p_br_b, R_br
  ContactMotion<T> motion;     ///< b components
  Rotation<T> R_Fb;            ///< not set where `turned` is false: they are parallel
  Vec3<T> prescribed_v_b;      ///< part of motion.v_roller that no state makes: of rails and of steered rollers
  Vec3<T> prescribed_omega_b;  ///< the same of motion.omega_roller
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
  p.prescribed_v_b = mirrored(p.prescribed_v_b);
  p.prescribed_omega_b = mirrored_axial(p.prescribed_omega_b);
}

/// What patches do to both bodies: force on the wheel, moment about the wheelset's centre, and the moment about the origin of b
/// that a roller takes the opposite of.
template <Scalar T>
struct ContactWrenches {
  Vec3<T> force_b{}, on_wheelset_b{}, on_roller_b{};

  ContactWrenches& operator+=(ContactWrenches const& o) {
    force_b += o.force_b, on_wheelset_b += o.on_wheelset_b, on_roller_b += o.on_roller_b;
    return *this;
  }
};

/// The same without the mirror; the roller's moment about its own centre of mass.
template <Scalar T>
struct BodyWrenches {
  Vec3<T> force_F, on_wheelset_F, on_roller_b;
};

/// Of a force and a moment at a point, b components, mirrored like it.
template <Scalar T>
ContactWrenches<T> contact_wrenches(RollerEffects const& effects, ContactPlacement<T> const& placed, Vec3<T> const& p_b,
                                    Vec3<T> const& force_b, Vec3<T> const& moment_b) {
  return {force_b, cross(p_b - placed.pose.o, force_b) + moment_b, moment_about_crown(effects, p_b, force_b, moment_b)};
}

/// Power of what moves the rail or steers the roller, beside what a state does.
template <Scalar T>
T prescribed_power(ContactPlacement<T> const& placed, ContactWrenches<T> const& w) {
  if (!placed.prescribed) return T(0.0);
  return placed.turned ? dot(w.force_b, placed.prescribed_v_b) + dot(w.on_roller_b, placed.prescribed_omega_b)
                       : w.force_b.x * placed.prescribed_v_b.x;
}

template <Scalar T>
BodyWrenches<T> body_wrenches(WheelContact const& contact, ContactPlacement<T> const& placed, ContactWrenches<T> w) {
  if (contact.right) w = {mirrored(w.force_b), mirrored_axial(w.on_wheelset_b), mirrored_axial(w.on_roller_b)};
  Vec3<T> const on_roller_b = w.on_roller_b + cross(lift<T>(contact.crown_in_roller), w.force_b);
  if (!placed.turned) return {w.force_b, w.on_wheelset_b, on_roller_b};
  return {placed.R_Fb * w.force_b, placed.R_Fb * w.on_wheelset_b, on_roller_b};
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

/// p_bH_b: the head is fixed in b [m].
inline Vec3<double> head_of(WheelContact const& contact) {
  return {0.0, contact.right ? -contact.pair.rail_origin_y : contact.pair.rail_origin_y, 0.0};
}

/// Wheel on a rail of straight, level and perfect track.
template <Scalar T>
ContactPlacement<T> on_straight_rail(WheelContact const& contact, BodyMotion<T> const& wheelset, T const& speed) {
  ContactPlacement<T> p;
  p.pose = {lift<T>(contact.wheelset_from_crown) + wheelset.p, wheelset.R};
  p.prescribed = true;
  p.prescribed_v_b = {-speed, T(0.0), T(0.0)};
  p.motion = {wheelset.v, wheelset.omega, p.prescribed_v_b, {}};
  return p;
}

/// Wheel on a rail anywhere: curved and canted (`frame`; null: straight), irregular, on springs (`rail`; null: rigid). (W8)
template <Scalar T>
ContactPlacement<T> on_rail(WheelContact const& contact, BodyMotion<T> const& wheelset, BodyMotion<T> const* rail,
                            TrackFrame<T> const* frame, RailOffset<T> const& offset, T const& speed) {
  ContactPlacement<T> p;
  Vec3<T> const p_bH = lift<T>(head_of(contact)), p_kb_k = lift<T>(contact.crown_in_roller);
  Vec3<T> p_FH_F = p_bH + Vec3<T>{T(0.0), offset.y.value, offset.z.value};
  // Direction of this rail per metre of the line, and velocity of its material at any place X: -V (along + twist x X).
  Vec3<T> direction_F{T(1.0), offset.y.slope, offset.z.slope};
  if (frame) direction_F += frame->along - Vec3<T>{T(1.0), T(0.0), T(0.0)} + cross(frame->twist, p_FH_F);
  Rotation<T> R_kb = axes_along(direction_F);  // the axes of k are those of F until the rail turns on its springs
  if (offset.rolled) {
    auto const lean = offset.lean();
    R_kb = {R_kb.ex, R_kb * lean.ey, R_kb * lean.ez};
  }
  p.R_Fb = R_kb;
  p.turned = true;
  if (rail) {  // its head moves with its centre of mass, and on the lever arm from there as it rolls
    Vec3<T> const p_kH_b = p_kb_k + p_bH;
    p.R_Fb = {rail->R * R_kb.ex, rail->R * R_kb.ey, rail->R * R_kb.ez};
    p_FH_F += rail->p + p.R_Fb * p_kH_b - R_kb * p_kH_b;
  }
  auto const to_b = [&](Vec3<T> const& v_F) { return p.R_Fb.transposed_times(v_F); };
  Vec3<T> const p_Fr_F = lift<T>(contact.wheelset_from_crown) + wheelset.p;
  p.pose = {p_bH + to_b(p_Fr_F - p_FH_F), relative(p.R_Fb, wheelset.R)};
  Vec3<T> material_v_F{-speed, T(0.0), T(0.0)};
  if (frame) {
    Vec3<T> const p_Fb_F = p_FH_F - p.R_Fb * p_bH;
    material_v_F = -(frame->v + cross(frame->omega, p_Fb_F));
    p.prescribed_omega_b = to_b(-frame->omega);
  }
  p.prescribed = true;
  p.prescribed_v_b = to_b(material_v_F);
  if (offset.rolled) {  // a surface that is twisted along x rises and falls under the wheel, away from its head
    Vec3<T> const twist_b{speed * offset.roll.slope, T(0.0), T(0.0)};
    p.prescribed_omega_b += twist_b;
    p.prescribed_v_b -= cross(twist_b, p_bH);
  }
  p.motion = {to_b(wheelset.v), to_b(wheelset.omega), p.prescribed_v_b, p.prescribed_omega_b};
  if (rail) {
    Vec3<T> const omega_b = to_b(rail->omega);
    p.motion.v_roller += to_b(rail->v) + cross(omega_b, p_kb_k);
    p.motion.omega_roller += omega_b;
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
  Vec3<T> const p_kb_k = lift<T>(contact.crown_in_roller);
  // b moves by (R_Fk - 1) p_kb with the roller's turning; written so that a large radius cancels exactly.
  Vec3<T> const turned_F = p_kb_k.x * (roller.R.ex - Vec3<T>{T(1.0), T(0.0), T(0.0)}) +
                           p_kb_k.y * (roller.R.ey - Vec3<T>{T(0.0), T(1.0), T(0.0)}) +
                           p_kb_k.z * (roller.R.ez - Vec3<T>{T(0.0), T(0.0), T(1.0)});
  Vec3<T> p_Fb_F = roller.p + turned_F;
  p.R_Fb = roller.R;
  p.turned = true;
  Vec3<T> actuated_v_F{};  // that the actuators prescribe
  if (offset) {
    p.prescribed = true;
    p_Fb_F += Vec3<T>{T(0.0), offset->y.value, offset->z.value};
    actuated_v_F = {T(0.0), speed * offset->y.slope, speed * offset->z.slope};
    if (steered) {
      T const slope = offset->y.slope;
      Rotation<T> const R_kb = axes_along(Vec3<T>{T(1.0), slope, T(0.0)});
      Vec3<T> const p_bH = lift<T>(head_of(contact));
      p_Fb_F += roller.R * (p_bH - R_kb * p_bH);  // it turns about its own crown
      p.R_Fb = {roller.R * R_kb.ex, roller.R * R_kb.ey, roller.R * R_kb.ez};
      p.prescribed_omega_b.z = speed * offset->y.second / (1.0 + slope * slope);
      p.prescribed_v_b = -cross(p.prescribed_omega_b, p_bH);
    }
  }
  auto const to_b = [&](Vec3<T> const& v_F) { return p.R_Fb.transposed_times(v_F); };
  p.prescribed_v_b += to_b(actuated_v_F);
  Vec3<T> const p_Fr_F = lift<T>(contact.wheelset_from_crown) + wheelset.p;
  p.pose = {to_b(p_Fr_F - p_Fb_F), relative(p.R_Fb, wheelset.R)};
  p.motion = {to_b(wheelset.v), to_b(wheelset.omega), to_b(roller.v) + cross(roller.omega_body, p_kb_k),
              roller.omega_body};
  if (offset) {
    p.motion.v_roller += p.prescribed_v_b;
    p.motion.omega_roller += p.prescribed_omega_b;
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
/// @param axle_F  of the wheelset, unit vector
template <Scalar T>
AxleCreep<T> axle_creep(Model const& model, WheelContact const& contact, ContactPlacement<T> const& placed,
                        Vec3<T> const& axle_F, Patch<T> const& patch) {
  Vec3<T> const& n = patch.point.n;
  auto const w = body_wrenches(contact, placed,
                               contact_wrenches(model.laws.roller, placed, patch.point.p,
                                                patch.force - patch.normal.total() * n, patch.creep.spin_moment * n));
  return {w.force_F.x, dot(w.on_wheelset_F, axle_F), -w.on_roller_b.y};
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
