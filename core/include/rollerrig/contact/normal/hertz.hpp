// contact/normal/hertz.hpp - Hertz contact of two bodies with principal curvatures along and across the rolling direction.
//
//   contact point -> [Hertz: ellipse and stiffness] -> normal force, creep forces
//
// Exact elliptic integrals (19) by the arithmetic-geometric mean, the axis ratio (16) by bisection, at model set-up;
// in the step loop smooth functions of one variable, x = ln(D1/D2), read from a fine cubic table (relative error < 1e-9).
// Source: Malvezzi, Meli, Pugi (2010), eqs (13)-(19); Johnson, Contact Mechanics (1985), ch. 4.
#pragma once
#include "rollerrig/contact/material.hpp"
#include "rollerrig/math/spline.hpp"

namespace rollerrig {

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
/// The table, built once for all.
HertzTable const& hertz_table();

/// The ellipse per unit of sqrt(approach), and the stiffness.
template <Scalar T>
struct HertzContact {
  T stiffness;   ///< k_h [N/m^1.5]
  T a_per_root;  ///< a / sqrt(approach) [m^0.5], a along the rolling direction
  T b_per_root;  ///< b / sqrt(approach) [m^0.5]
  T log_aspect;  ///< ln(a/b)
  bool limited;  ///< the curvatures were outside the theory (conformal or saddle) and were limited
};

/// @param d1  (k_1r + k_1b)/2 [1/m], eq. (14): along the rolling direction, always positive
/// @param d2  (k_2r + k_2b)/2 [1/m]: across it; not positive where the surfaces conform. Rule: a d2 below d1/200 is
///            raised to it (a patch about 27 times as wide as long); the caller counts how often.
template <Scalar T>
HertzContact<T> hertz_contact(Material const& material, T const& d1, T const& d2) {
  HertzTable const& table = hertz_table();
  using std::log;
  using std::sqrt;
  T const low = d1 / HertzTable::limit;
  T const high = d1 * HertzTable::limit;
  bool const too_low = !(d2 > low);
  bool const too_high = !(d2 < high);
  T const across = select(too_low, low, select(too_high, high, d2));
  T const sum = d1 + across;
  T const root_sum = sqrt(sum);
  T const x = log(d1 / across);

  HertzContact<T> contact;
  contact.stiffness = table.stiffness.at(x).value / (material.compliance() * root_sum);  // (13)
  contact.a_per_root = table.semi_axis.at(x).value / root_sum;                           // (17), (18)
  contact.b_per_root = table.semi_axis.at(-x).value / root_sum;
  contact.log_aspect = table.log_aspect.at(x).value;
  contact.limited = too_low || too_high;
  return contact;
}

}  // namespace rollerrig
