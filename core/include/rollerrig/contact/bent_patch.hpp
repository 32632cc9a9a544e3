// contact/bent_patch.hpp - what the strips of a patch do beyond those of its equivalent ellipse.
//
//   strips, motion of both bodies, forces by the ellipse -> [follow_strips] -> force and moment on the wheel, in place
//
// Frame b as in contact/patch.hpp. The friction of strips that are turned against the patch has a part along its normal, and
// moments along the patch: their power and work are booked with creep. (C17), (C22) of docs/theory/creep_laws.md.
#pragma once
#include "rollerrig/contact/patch.hpp"

namespace rollerrig {

template <Scalar T>
void follow_strips(ContactLaws const& laws, T const& time, MovingPatch<T> const& m) {
  using std::sqrt;
  using L = std::conditional_t<std::same_as<T, double>, Lanes<native_lanes>, T>;
  NormalPatch<T> const& patch = *m.patch;
  PatchForces<T>& out = *m.patch;
  Vec3<T> const& n = patch.point.n;
  auto const [i, t] = contact_axes(n);
  Vec3<T> const omega = relative_turning(laws.roller, *m.motion);
  T const inverse_speed = inverse_rolling_speed(laws, out.rolling_speed);

  T const damping = patch.damper * laws.damping.force(out.gap_rate);
  RailSurface<T> const surface =
      m.surface(time, regularisation::length(out.slip_longitudinal, out.slip_lateral, regularisation::slip));
  T const adhesion = surface.friction * normal_force(patch.elastic, damping).total() + regularisation::adhesion;
  auto query = creep_query(laws, patch, out.creepage, adhesion, T(out.rolling_speed * inverse_speed));
  if (m.friction->map != nullptr) query = with_reduced_stiffness(query, mean_reduction(surface));

  Vec3<T> const slip = out.slip_longitudinal * i + out.slip_lateral * t + out.gap_rate * n;
  auto const strips = strip_wrench<L>(query, *m.strips, patch.point.p, inverse_speed * slip, inverse_speed * omega,
                                      T(adhesion / patch.elastic));
  auto const ellipse = ellipse_force<L>(query);
  Vec3<T> const force = patch.weight * (strips.force - ellipse.longitudinal * i - ellipse.lateral * t);
  Vec3<T> moment = patch.weight * (strips.moment - ellipse.spin_moment * n);

  out.creep.longitudinal += dot(force, i);
  out.creep.lateral += dot(force, t);
  T const about_normal = dot(moment, n);
  out.creep.spin_moment += about_normal;
  out.bending_power = dot(force, n) * out.gap_rate + dot(moment, omega) - about_normal * out.spin_rate;
  // Both together are approximations: the moment gives way where they would drive, (C16).
  T const power = -out.creep_dissipation();
  auto const drives = power > 0.0 && !(out.spin_rate * out.spin_rate < square(regularisation::spin));
  T const less = select(drives, power, T(0.0)) / select(drives, out.spin_rate, T(1.0));
  out.creep.spin_moment -= less;
  out.bending_work = inverse_speed * out.bending_power;
  auto const linear = linear_creep_force(query.creepage, query.stiffness);
  out.creep.saturation =
      saturation(out.creep.longitudinal, out.creep.lateral,
                 T(patch.weight * regularisation::length(linear.longitudinal, linear.lateral, regularisation::force)));
  out.force += force;
  out.moment += moment - less * n;
}

}  // namespace rollerrig
