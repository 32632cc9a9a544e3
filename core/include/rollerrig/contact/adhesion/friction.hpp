// contact/adhesion/friction.hpp - the friction of one contact, and what its surface leaves of the creep curve's stiffness.
//
// Source  friction over the inclination of the surface: as in CONTACT (E. A. H. Vollebregt, User guide for CONTACT, variable
//         friction), here with a continuous slope. docs/theory/contact_forces.md, (F6).
#pragma once
#include <memory>

#include "rollerrig/contact/adhesion/adhesion_map.hpp"
#include "rollerrig/math/vector.hpp"

namespace rollerrig {

/// How far a contact lies on the gauge face: 0 up to an angle of 20 degrees, 1 from 40 degrees on, smooth between, (F6).
///
/// @param n  outward normal of rail or roller, b components of the left side
template <Scalar T>
T share_of_gauge_face(Vec3<T> const& n) {
  using std::sqrt;
  constexpr double top = 0.3420201433256687, face = 0.6427876096865394;  // sin 20°, sin 40°
  T const x = (-n.y / sqrt(n.y * n.y + n.z * n.z) - top) * (1.0 / (face - top));
  T const within = select(x < T(0.0), T(0.0), select(x > T(1.0), T(1.0), x));
  return within * within * (3.0 - 2.0 * within);
}

/// One law for the whole run, or what a map says of arc length, time, slip and dissipated energy; another on the gauge face.
struct Friction {
  FrictionLaw law{};
  std::shared_ptr<AdhesionMap const> map{};  ///< in place of the law
  double gauge_face{-1.0};
  static constexpr auto fields() {
    return members(Member{"law", &Friction::law}, OptionalMember{"map", &Friction::map},
                   Member{"gauge_face", &Friction::gauge_face, "1",
                          "friction coefficient on the gauge face; -1: as on top of the rail"});
  }

  /// @param top  friction on top of the rail
  /// @param n    see share_of_gauge_face
  template <Scalar T>
  T where(T const& top, Vec3<T> const& n) const {
    return gauge_face < 0.0 ? top : top + share_of_gauge_face(n) * (gauge_face - top);
  }

  /// @param arc_length      along the rail [m]
  /// @param slip            slip velocity [m/s]
  /// @param energy_density  dissipated on this piece of rail, by the wheels ahead and by this one [J/m^2]
  /// @param sand            mass per length on it [kg/m]
  template <Scalar T>
  RailSurface<T> operator()(T const& time, T const& arc_length, T const& slip, double energy_density,
                            double sand) const {
    if (map) return (*map)(map->over_time ? time : arc_length, slip, T(energy_density), sand);
    return {friction_at(law, slip), T(1.0), T(1.0)};
  }
};

}  // namespace rollerrig
