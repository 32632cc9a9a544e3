// contact/normal/hertz.hpp - Hertz contact of two bodies whose combined curvature is known in the axes of rolling.
//
//   contact point -> [Hertz: ellipse and stiffness] -> normal force, creep forces
//
// Exact elliptic integrals (19) by the arithmetic-geometric mean, the axis ratio (16) by bisection, at model set-up;
// in the step loop smooth functions of one variable, x = ln(D1/D2), read from a fine cubic table (relative error < 1e-9).
// Source: Malvezzi, Meli, Pugi (2010), eqs (13)-(19); Johnson, Contact Mechanics (1985), ch. 4.
#pragma once

#include "rollerrig/fields.hpp"
#include "rollerrig/geometry/contact_point.hpp"
#include "rollerrig/math/curves.hpp"

namespace rollerrig {

/// Elastic constants shared by wheel and roller.
struct Material {
  double shear_modulus{82.03125e9}, poisson_ratio{0.28};
  static constexpr auto fields() {
    return members(Member{"shear_modulus", &Material::shear_modulus, "Pa", "shear modulus, G", positive},
                   Member{"poisson_ratio", &Material::poisson_ratio, "1", "Poisson's ratio, nu", poissons_ratio});
  }

  /// Q = (1 - nu)/G [1/Pa], eq. (13): twice the plane-strain compliance (1 - nu^2)/E of one body.
  double compliance() const { return (1.0 - poisson_ratio) / shear_modulus; }
};

/// E(g) and K(g) of (19), complete integrals with complementary modulus g in (0, 1].
struct EllipticIntegrals {
  double e, k;
};
EllipticIntegrals elliptic_integrals(double g);

/// Axis ratio g = minor/major of the contact ellipse for the ratio smaller/larger of D1, D2, eq. (16).
double axis_ratio(double curvature_ratio);

/// Functions of x = ln(D1/D2), even or odd, tabulated for |x| <= ln(limit).
struct HertzTable {
  static constexpr double limit = 200.0;  ///< largest ratio of D1 and D2; beyond it the smaller one is raised
  UniformSpline semi_axis;                ///< a / sqrt(p / (D1+D2)); b is its mirror image in x, eqs (17), (18)
  UniformSpline stiffness;                ///< k_h Q sqrt(D1+D2), eq. (13)
  UniformSpline log_aspect;               ///< ln(a/b)
  HertzTable();
};
HertzTable const& hertz_table();

/// The ellipse per unit of sqrt(approach), and the stiffness.
template <Scalar T>
struct HertzContact {
  T stiffness;            ///< k_h [N/m^1.5]
  T a_per_root;           ///< a / sqrt(approach) [m^0.5], a along the rolling direction
  T b_per_root;           ///< b / sqrt(approach) [m^0.5]
  T log_aspect;           ///< ln(a/b)
  double ahead_per_root;  ///< how far the ellipse reaches along the rolling direction, / sqrt(approach) [m^0.5]
  double reach_per_root;  ///< how far it reaches across [m^0.5]
  bool limited;           ///< the curvatures were outside the theory (conformal or saddle) and were limited
};

/// The ellipse's axes along and across the rolling direction.
///
/// @param d1  (k_1r + k_1b)/2 [1/m], eq. (14): along the rolling direction
/// @param d2  (k_2r + k_2b)/2 [1/m]: across it; not positive where the surfaces conform. Rule: the smaller of both is raised
///            to 1/200 of the larger (a patch about 27 times as wide as long); the caller counts how often.
template <Scalar T>
HertzContact<T> hertz_contact(Material const& material, T const& d1, T const& d2) {
  HertzTable const& table = hertz_table();
  using std::log;
  using std::sqrt;
  T const least_along = d2 / HertzTable::limit;
  T const least_across = d1 / HertzTable::limit;
  bool const too_long = !(d1 > least_along);
  bool const too_wide = !(d2 > least_across);
  T const along = select(too_long, least_along, d1);
  T const across = select(too_wide, least_across, d2);
  T const sum = along + across;
  T const root_sum = sqrt(sum);
  T const x = log(along / across);

  HertzContact<T> contact;
  contact.stiffness = table.stiffness.at(x).value / (material.compliance() * root_sum);  // (13)
  contact.a_per_root = table.semi_axis.at(x).value / root_sum;                           // (17), (18)
  contact.b_per_root = table.semi_axis.at(-x).value / root_sum;
  contact.log_aspect = table.log_aspect.at(x).value;
  contact.ahead_per_root = value_of(contact.a_per_root);
  contact.reach_per_root = value_of(contact.b_per_root);
  contact.limited = too_long || too_wide;
  return contact;
}

/// The principal axes of a combined curvature: that nearer to the rolling direction, turned from it by at most 45 degrees.
template <Scalar T>
struct PrincipalCurvatures {
  T along, across;  ///< [1/m]
  T sin2;           ///< square of the sine of the angle [-]
};

/// Smooth through a circular contact, where the axes are undefined: what is built from them there is not.
template <Scalar T>
PrincipalCurvatures<T> principal_curvatures(CurvatureTensor<T> const& d) {
  using std::sqrt;
  constexpr double circular =
      1e-9;  // of the mean: keeps the root's slope finite, far above the square of its round-off
  T const mean = 0.5 * (d.along + d.across);
  T const half = 0.5 * (d.along - d.across);
  T const size = select(half < 0.0, -half, half);
  T const radius = sqrt(half * half + d.mixed * d.mixed + square(circular * mean));
  T const signed_radius = select(half < 0.0, -radius, radius);
  return {mean + signed_radius, mean - signed_radius, 0.5 * d.mixed * d.mixed / (radius * (radius + size))};
}

/// Hertz' ellipse with its own axes turned from the rolling direction, as the creep laws see it: they know ellipses with an
/// axis along rolling, so they get the one of the same area whose pressures have the same ratio of second moments along and
/// across (for no turn: itself). Stiffness, area and peak pressure are exact. docs/theory/contact_forces.md, (F5).
template <Scalar T>
HertzContact<T> hertz_contact(Material const& material, CurvatureTensor<T> const& d) {
  using std::log;
  using std::sqrt;
  auto const principal = principal_curvatures(d);
  HertzContact<T> contact = hertz_contact(material, principal.along, principal.across);
  T const a2 = contact.a_per_root * contact.a_per_root;
  T const b2 = contact.b_per_root * contact.b_per_root;
  T const exchanged = principal.sin2 * (b2 - a2);
  T const reach2 = b2 - exchanged;
  T const turned =
      (1.0 + exchanged / a2) * (b2 / reach2);  // squared ratio of the moments over that of the ellipse's axes
  T const stretch = sqrt(sqrt(turned));
  contact.a_per_root = contact.a_per_root * stretch;
  contact.b_per_root = contact.b_per_root / stretch;
  contact.log_aspect = contact.log_aspect + 0.5 * log(turned);
  contact.ahead_per_root = sqrt(value_of(a2 + exchanged));
  contact.reach_per_root = sqrt(value_of(reach2));
  return contact;
}

}  // namespace rollerrig
