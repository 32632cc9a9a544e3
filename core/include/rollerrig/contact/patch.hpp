// contact/patch.hpp - one contact patch: from its normal contact and the motion of both bodies to the force on the wheel.
//
//   normal patch (12)-(19) -> creepages (21) -> Kalker and saturation (20)-(24) -> force and moment on the wheel
//
// Frame b, left side (see geometry/pair.hpp). i: rolling direction in the contact plane, t = n x i: to the left, n: out of
// the roller. Forces act on the wheel at the contact point on the roller; the roller takes the opposite.
#pragma once
#include <memory>
#include <span>

#include "rollerrig/contact/adhesion/friction.hpp"
#include "rollerrig/contact/creep/creep_law.hpp"
#include "rollerrig/contact/normal/normal_law.hpp"

namespace rollerrig {

/// Of all contacts of a model; friction is that of each.
struct ContactLaws {
  Material material{};
  NormalLaw normal{};
  NormalDamping damping{};
  CreepLaw creep{};
  double kalker_factor{1.0};
  double creepage_regularisation_speed{0.1};
  RollerEffects roller{};  ///< which of the roller's differences from a rail count
  static constexpr auto fields() {
    return members(Member{"material", &ContactLaws::material}, Member{"normal", &ContactLaws::normal},
                   Member{"damping", &ContactLaws::damping, not_negative}, Member{"creep", &ContactLaws::creep},
                   Member{"kalker_factor", &ContactLaws::kalker_factor, "1",
                          "what is left of Kalker's coefficients, those of creep laws without their own", positive},
                   Member{"creepage_regularisation_speed", &ContactLaws::creepage_regularisation_speed, "m/s",
                          "rolling speed below which creepage turns into viscous friction, V_s", not_negative},
                   Member{"roller", &ContactLaws::roller});
  }

  std::shared_ptr<KalkerTable const> kalker{};  ///< follows from the material
};

/// Motion of wheel and roller, all in b components.
template <Scalar T>
struct ContactMotion {
  Vec3<T> v_wheel;                ///< velocity of the wheelset's centre [m/s]
  Vec3<T> omega_wheel;            ///< its angular velocity incl. spin [rad/s]
  Vec3<T> v_roller;               ///< velocity of the roller's material point at the origin of b [m/s]
  Vec3<T> omega_roller;           ///< its angular velocity incl. spin [rad/s]
  T arc_length{0.0};              ///< of the contact along the rail [m]
  double dissipated_energy{0.0};  ///< per area, by the wheels that ran there [J/m^2]
  double sand{0.0};               ///< mass per length of rail [kg/m]
  double friction_factor{1.0};    ///< over what the law says
};

/// What the motion of both bodies makes of a patch under load; forces act on the wheel, times the patch's blending weight.
template <Scalar T>
struct PatchForces {
  NormalForce<T> normal;  ///< eq. (12)
  T gap_rate;             ///< v_n [m/s]
  T slip_longitudinal;    ///< velocity of the wheel's point relative to the roller's along i [m/s]
  T slip_lateral;         ///< along t [m/s]
  T spin_rate;            ///< relative angular velocity along n [rad/s]
  T rolling_speed;        ///< signed, positive for forward running [m/s]
  Creepage<T> creepage;   ///< eq. (21)
  CreepForce<T> creep;    ///< eqs (20)-(24)
  Vec3<T> force;          ///< on the wheel, b components [N]
  Vec3<T> moment;   ///< on the wheel about the point, b components [N m]: spin moment, and of the pressures' normals
  T elastic_power;  ///< of the elastic pressures on the relative motion [W]
  T bending_power;  ///< of creep forces along n and moments along the patch, where its strips are turned [W] ...
  T bending_work;   ///< ... and per metre [N]

  T creep_dissipation() const {
    return -(creep.longitudinal * slip_longitudinal + creep.lateral * slip_lateral + creep.spin_moment * spin_rate +
             bending_power);
  }

  /// T gamma: heat of creep per metre [N]. docs/theory/wheel_rail_forces.md, (R3)
  T wear_number() const {
    return -(creep.longitudinal * creepage.longitudinal + creep.lateral * creepage.lateral +
             creep.spin_moment * creepage.spin + bending_work);
  }
};

template <Scalar T>
struct Patch : NormalPatch<T>, PatchForces<T> {};

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

/// Moment of a force on the wheel at p about the origin of b: the roller takes its opposite. Dual to the two velocities above,
/// so that the power on the roller is what they say it is.
///
/// @param own  moment about p
template <Scalar T>
Vec3<T> moment_about_crown(RollerEffects const& effects, Vec3<T> const& p, Vec3<T> const& force, Vec3<T> const& own) {
  Vec3<T> moment = cross(p, force) + own;
  if (!effects.conicity) moment.y = moment.y - p.z * force.x;
  if (!effects.yaw) moment.y = moment.y + p.x * force.z;
  if (!effects.spin) moment.y = moment.y - own.y;
  return moment;
}

/// i and t of a patch or a strip with the normal n.
template <class T>
struct ContactAxes {
  Vec3<T> i, t;
};
template <class T>
ContactAxes<T> contact_axes(Vec3<T> const& n) {
  using std::sqrt;
  T const across = 1.0 / sqrt(n.y * n.y + n.z * n.z);
  Vec3<T> const t{T(0.0), n.z * across, -(n.y * across)};  // n x i_b, normalised
  return {cross(t, n), t};
}

/// One over the rolling speed that creepages refer to [s/m].
template <Scalar T>
T inverse_rolling_speed(ContactLaws const& laws, T const& rolling_speed) {
  using std::sqrt;
  return 1.0 / sqrt(rolling_speed * rolling_speed + square(laws.creepage_regularisation_speed));
}

/// Eq. (22) of an ellipse between the surfaces of these laws.
template <Scalar T>
KalkerStiffness<T> kalker_stiffness(ContactLaws const& laws, T const& log_aspect, T const& a, T const& b,
                                    T const& direction) {
  return kalker_stiffness(laws.kalker->at(log_aspect), laws.kalker_factor * laws.material.shear_modulus, a, b,
                          direction);
}

/// What the creep law is asked.
///
/// @param adhesion  mu N [N]
template <Scalar T>
CreepQuery<T> creep_query(ContactLaws const& laws, NormalPatch<T> const& patch, Creepage<T> const& creepage,
                          T const& adhesion, T const& direction) {
  auto const stiffness = kalker_stiffness(laws, patch.log_aspect, patch.a, patch.b, direction);  // (22)
  return {creepage, stiffness, adhesion, patch.a, patch.b, patch.log_aspect, direction};
}

/// Creepages and forces of a patch of which the normal contact is known. T: any scalar, lanes of several patches among them.
///
/// @param friction  the surface at a slip velocity [m/s], RailSurface<T>
/// @param on_map    the surface reduces the creep curve's stiffness
template <Scalar T, class Surface>
PatchForces<T> patch_forces(ContactLaws const& laws, NormalPatch<T> const& patch, Vec3<T> const& wheelset,
                            ContactMotion<T> const& motion, Surface const& friction, bool on_map) {
  PatchForces<T> out;
  Vec3<T> const& p = patch.point.p;
  Vec3<T> const& n = patch.point.n;
  auto const [i, t] = contact_axes(n);

  Vec3<T> const v_on_wheel = motion.v_wheel + cross(motion.omega_wheel, p - wheelset);
  Vec3<T> const v_on_roller = roller_surface_velocity(laws.roller, motion, p);
  Vec3<T> const v = v_on_wheel - v_on_roller;  // errata to (12), (21): relative to the roller's point
  Vec3<T> const omega = relative_turning(laws.roller, motion);
  out.gap_rate = dot(v, n);
  out.slip_longitudinal = dot(v, i);
  out.slip_lateral = dot(v, t);
  out.spin_rate = dot(omega, n);
  T const damping = patch.damper * laws.damping.force(out.gap_rate);
  NormalForce<T> const normal = normal_force(patch.elastic, damping);  // (12)
  T const load = normal.total();

  // Rolling speed: mean of wheel and roller surface speed past the contact point, which moves with the wheelset.
  out.rolling_speed = dot(motion.v_wheel - T(0.5) * (v_on_wheel + v_on_roller), i);
  T const inverse_speed = inverse_rolling_speed(laws, out.rolling_speed);
  out.creepage = {out.slip_longitudinal * inverse_speed, out.slip_lateral * inverse_speed,
                  out.spin_rate * inverse_speed};  // (21)

  T const slip = regularisation::length(out.slip_longitudinal, out.slip_lateral, regularisation::slip);
  RailSurface<T> const surface = friction(slip);
  T const adhesion = surface.friction * load + regularisation::adhesion;
  auto const query = creep_query(laws, patch, out.creepage, adhesion, T(out.rolling_speed * inverse_speed));
  auto const creep =
      on_map ? creep_force(laws.creep, query, surface) : creep_force(laws.creep, query);  // (20), (23), (24)

  T const& w = patch.weight;
  out.normal = {w * normal.elastic, w * normal.damping};
  out.creep = {w * creep.longitudinal, w * creep.lateral, w * creep.spin_moment, creep.saturation};
  out.force = w * (load * n + creep.longitudinal * i + creep.lateral * t);
  out.moment = w * (creep.spin_moment * n + patch.pressure_moment);
  out.elastic_power = w * (normal.elastic * out.gap_rate + dot(patch.pressure_moment, omega));
  out.bending_power = out.bending_work = T(0.0);
  return out;
}

/// A patch under load, and what its forces depend on beside the laws that all patches have in common.
template <Scalar T>
struct MovingPatch {
  Patch<T>* patch;
  Vec3<T> const* wheelset;  ///< its centre, b components [m]
  ContactMotion<T> const* motion;
  Friction const* friction;
  PatchStrips<T> const* strips{nullptr};  ///< if the creep law follows them: contact/patch_lanes.cpp

  /// @param slip  velocity [m/s]
  RailSurface<T> surface(T const& time, T const& slip) const {
    auto rail = (*friction)(time, motion->arc_length, slip, motion->dissipated_energy, motion->sand);
    rail.friction = motion->friction_factor * friction->where(rail.friction, patch->point.n);
    return rail;
  }
};

template <Scalar T>
void add_creep_force(ContactLaws const& laws, T const& time, MovingPatch<T> const& m) {
  PatchForces<T>& out = *m.patch;
  out = patch_forces<T>(
      laws, *m.patch, *m.wheelset, *m.motion, [&](T const& slip) { return m.surface(time, slip); },
      m.friction->map != nullptr);
}

template <Scalar T>
using WheelPatches = PatchList<Patch<T>>;

/// Creep forces of the patches of several wheels at once, side by side in lanes.
///
///   patches of all wheels under load -> [lanes of patches] -> contact/patch.hpp, once for as many patches as there are lanes
/// At most W patches, W not below 2. Lanes behind the last one repeat it.
template <int W>
void add_creep_forces_in_lanes(ContactLaws const& laws, double time, std::span<MovingPatch<double> const> patches);

/// Creepages and forces of patches, each with its own friction: by plain numbers or dual ones one after the other, in
/// lanes as many at once as a register holds.
template <Scalar T>
void add_creep_forces(ContactLaws const& laws, T const& time, std::span<MovingPatch<T> const> patches);

}  // namespace rollerrig
