// contact/patch.hpp - one contact patch: from the contact point and the motion of both bodies to the force on the wheel.
//
//   contact point -> Hertz (12)-(19) -> creepages (21) -> Kalker and saturation (20)-(24) -> force and moment on the wheel
//
// Frame b, left side (see geometry/pair.hpp). i: rolling direction in the contact plane, t = n x i: to the left, n: out of
// the roller. Forces act on the wheel at the contact point on the roller; the roller takes the opposite.
#pragma once
#include "rollerrig/contact/adhesion/friction.hpp"
#include "rollerrig/contact/creep/creep_law.hpp"
#include "rollerrig/contact/normal/hertz.hpp"
#include "rollerrig/contact/normal/normal_force.hpp"
#include "rollerrig/geometry/contact_point.hpp"

namespace rollerrig {

class ArcLength;
class StripKernel;

/// How the surfaces carry normal load.
enum class NormalContactKind : int {
  hertz,  ///< one ellipse per indented minimum of the gap: the paper's
  strips  ///< elastic strips over everything that overlaps, contact/normal/strip_contact.hpp
};

/// What a contact is made of.
struct ContactLaws {
  Material material{};
  NormalContactKind normal{NormalContactKind::hertz};
  HertzTable const* hertz{nullptr};
  StripKernel const* strip_kernel{nullptr};  ///< both for NormalContactKind::strips
  ArcLength const* wheel_arc{nullptr};
  KalkerTable const* kalker{nullptr};
  NormalDamping damping{};
  CreepLaw creep{};
  Friction friction{};
  double creepage_regularisation_speed{
      0.1};  ///< V_s [m/s]: rolling speed below which creepage turns into viscous friction
  double merging_criterion{
      0.01};               ///< see contact/normal/blending_weight.hpp [-]; 0: patches appear and vanish at full force
  RollerEffects roller{};  ///< which of the roller's peculiarities count
};

/// Motion of wheel and roller, all in b components.
template <Scalar T>
struct ContactMotion {
  Vec3<T> v_wheel;       ///< velocity of the wheelset's centre [m/s]
  Vec3<T> omega_wheel;   ///< its angular velocity incl. spin [rad/s]
  Vec3<T> v_roller;      ///< velocity of the roller's material point at the origin of b [m/s]
  Vec3<T> omega_roller;  ///< its angular velocity incl. spin [rad/s]
  T place{0.0};          ///< of the contact along the rail [m]
  double spent{0.0};     ///< energy per area that wheels have spent there [J/m^2]
};

template <Scalar T>
struct Patch {
  ContactPoint<T> point;
  HertzContact<T> hertz;
  T a, b;                 ///< semi-axes along and across the rolling direction [m], eq. (18)
  NormalForce<T> normal;  ///< eq. (12)
  T gap_rate;             ///< v_n [m/s]
  T slip_longitudinal;    ///< velocity of the wheel's point relative to the roller's along i [m/s]
  T slip_lateral;         ///< along t [m/s]
  T spin_rate;            ///< relative angular velocity along n [rad/s]
  T rolling_speed;        ///< signed, positive for forward running [m/s]
  Creepage<T> creepage;   ///< eq. (21)
  CreepForce<T> creep;    ///< eqs (20)-(24)
  T share{1.0};           ///< of the force that counts, contact/normal/blending_weight.hpp
  Vec3<T> force;          ///< on the wheel, b components [N]
  Vec3<T> moment;   ///< on the wheel about the point, b components [N m]: spin moment, and of the pressures' normals
  T elastic_power;  ///< of the elastic pressures on the relative motion [W]
  T peak_pressure;  ///< [Pa]

  T creep_dissipation() const {
    return -(creep.longitudinal * slip_longitudinal + creep.lateral * slip_lateral + creep.spin_moment * spin_rate);
  }

  /// Scales every force of the patch.
  void scale(T const& factor) {
    share = factor;
    normal = {factor * normal.elastic, factor * normal.damping};
    creep = {factor * creep.longitudinal, factor * creep.lateral, factor * creep.spin_moment, creep.saturation};
    force = factor * force;
    moment = factor * moment;
    elastic_power = factor * elastic_power;
  }
};

/// Velocity of the roller's surface at p: of the turning, without the parts that are switched off.
template <Scalar T>
Vec3<T> roller_surface_velocity(RollerEffects const& effects, ContactMotion<T> const& motion, Vec3<T> const& p) {
  Vec3<T> v = motion.v_roller + cross(motion.omega_roller, p);
  if (!effects.conicity) v.x = v.x - motion.omega_roller.y * p.z;
  if (!effects.yaw) v.z = v.z + motion.omega_roller.y * p.x;
  return v;
}

/// Angular velocity of wheel against roller that spins the patch.
template <Scalar T>
Vec3<T> relative_turning(RollerEffects const& effects, ContactMotion<T> const& motion) {
  Vec3<T> omega = motion.omega_wheel - motion.omega_roller;
  if (!effects.spin) omega.y = motion.omega_wheel.y;
  return omega;
}

/// Moment of the force on the wheel about the origin of b: the roller takes its opposite. Dual to the two velocities above,
/// so that the power on the roller is what they say it is.
template <Scalar T>
Vec3<T> moment_about_crown(RollerEffects const& effects, Patch<T> const& patch) {
  Vec3<T> const& p = patch.point.p;
  Vec3<T> moment = cross(p, patch.force) + patch.moment;
  if (!effects.conicity) moment.y = moment.y - p.z * patch.force.x;
  if (!effects.yaw) moment.y = moment.y + p.x * patch.force.z;
  if (!effects.spin) moment.y = moment.y - patch.moment.y;
  return moment;
}

/// Creepages and forces of a patch whose normal contact is filled in by `carry`.
///
/// @param time   [s], handed to the friction law
/// @param carry  gets the patch with point and gap rate; sets hertz, a, b, normal, peak_pressure
template <Scalar T, class Carry>
Patch<T> patch_carried(ContactLaws const& laws, ContactPoint<T> const& point, RelativePose<T> const& pose,
                       ContactMotion<T> const& motion, T const& time, Carry const& carry) {
  using std::sqrt;
  Patch<T> patch;
  patch.point = point;
  Vec3<T> const& n = point.n;
  T const across = 1.0 / sqrt(n.y * n.y + n.z * n.z);
  Vec3<T> const t{T(0.0), n.z * across, -(n.y * across)};  // n x i_b, normalised
  Vec3<T> const i = cross(t, n);

  Vec3<T> const v_on_wheel = motion.v_wheel + cross(motion.omega_wheel, point.p - pose.o);
  Vec3<T> const v_on_roller = roller_surface_velocity(laws.roller, motion, point.p);
  Vec3<T> const v = v_on_wheel - v_on_roller;  // errata to (12), (21): relative to the roller's point
  patch.gap_rate = dot(v, n);
  patch.slip_longitudinal = dot(v, i);
  patch.slip_lateral = dot(v, t);
  patch.spin_rate = dot(relative_turning(laws.roller, motion), n);

  carry(patch);
  T const load = patch.normal.total();

  // Rolling speed: mean of wheel and roller surface speed past the contact point, which travels with the wheelset.
  patch.rolling_speed = dot(motion.v_wheel - T(0.5) * (v_on_wheel + v_on_roller), i);
  double const v_s = laws.creepage_regularisation_speed;
  T const inverse_speed = 1.0 / sqrt(patch.rolling_speed * patch.rolling_speed + v_s * v_s);
  patch.creepage = {patch.slip_longitudinal * inverse_speed, patch.slip_lateral * inverse_speed,
                    patch.spin_rate * inverse_speed};  // (21)

  T const slip = sqrt(square(patch.slip_longitudinal) + square(patch.slip_lateral) + 1e-20);
  auto const surface = laws.friction(time, motion.place, slip, motion.spent);
  T const adhesion = surface.friction * load + 1e-9;
  T const direction = patch.rolling_speed * inverse_speed;
  auto const stiffness = kalker_stiffness(laws.kalker->at(patch.hertz.log_aspect), laws.material.shear_modulus, patch.a,
                                          patch.b, direction);  // (22)
  CreepQuery<T> const query{patch.creepage, stiffness, adhesion, patch.a, patch.b, patch.hertz.log_aspect, direction};
  patch.creep = laws.friction.map != nullptr ? creep_force(laws.creep, query, surface)
                                             : creep_force(laws.creep, query);  // (20), (23), (24)
  patch.force = load * n + patch.creep.longitudinal * i + patch.creep.lateral * t;
  patch.moment = patch.creep.spin_moment * n;
  patch.elastic_power = patch.normal.elastic * patch.gap_rate;
  return patch;
}

/// A patch of the paper: Hertz' ellipse at one contact point.
///
/// @param time  [s], handed to the friction law
template <Scalar T>
Patch<T> patch_force(ContactLaws const& laws, ContactPoint<T> const& point, RelativePose<T> const& pose,
                     ContactMotion<T> const& motion, T const& time) {
  return patch_carried(laws, point, pose, motion, time, [&](Patch<T>& patch) {
    using std::sqrt;
    T const d1 = 0.5 * (point.wheel_curvature_along + point.rail_curvature_along);    // (14)
    T const d2 = 0.5 * (point.wheel_curvature_across + point.rail_curvature_across);  // (14)
    patch.hertz = hertz_contact(*laws.hertz, laws.material, d1, d2);                  // (13), (16)
    T const root_depth = sqrt(select(point.gap < 0.0, -point.gap, T(1e-30)));
    patch.a = patch.hertz.a_per_root * root_depth;  // (17), (18)
    patch.b = patch.hertz.b_per_root * root_depth;
    patch.normal = normal_force(laws.damping, patch.hertz.stiffness, point.gap, patch.gap_rate);  // (12)
    patch.peak_pressure = 1.5 / pi * patch.normal.elastic / (patch.a * patch.b);
  });
}

}  // namespace rollerrig
