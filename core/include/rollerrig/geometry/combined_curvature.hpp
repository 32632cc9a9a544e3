// geometry/combined_curvature.hpp - the curvatures of two touching surfaces together, where their principal directions differ.
//
//   contact point: normal, principal curvatures (15) -> [twist, combined curvature] -> Hertz, strips
//
// Axes    in the common tangent plane, n out of the roller: c along the roller's circumference (along a rail), m = n x c across.
// Twist   the wheel's circumference lies at the angle chi from c towards m: about yaw / cos(contact angle), 8 degrees for 50 mrad
//         at the flange. Both surfaces' curvatures are symmetric tensors; only in common axes may they be added.
// Source  Johnson, Contact Mechanics (1985), section 4.1; docs/theory/contact_geometry.md, (G5), (G6).
#pragma once
#include "rollerrig/math/vector.hpp"

namespace rollerrig {

/// The angle chi from the roller's circumference to the wheel's.
template <Scalar T>
struct Twist {
  T sin{0.0}, cos{1.0};
};

/// @param n             normal out of the roller; in the plane of the roller's axis if it is the wheel's normal line
/// @param axle          direction of the wheelset's axis, R.ey
/// @param wheel_norm    sqrt(1 + r'^2)
/// @param inverse_lean  1 / |e_y x n|
template <Scalar T>
Twist<T> twist_of(Vec3<T> const& n, Vec3<T> const& axle, T const& wheel_norm, T const& inverse_lean) {
  using std::sqrt;
  T const s = (n.x * axle.z - n.z * axle.x) * (wheel_norm * inverse_lean);  // (G5)
  return {s, sqrt(1.0 - s * s)};
}

/// A symmetric tensor of curvatures in the axes c, m [1/m].
template <Scalar T>
struct CurvatureTensor {
  T along, mixed, across;

  friend CurvatureTensor operator+(CurvatureTensor const& a, CurvatureTensor const& b) {
    return {a.along + b.along, a.mixed + b.mixed, a.across + b.across};
  }
  friend CurvatureTensor operator*(T const& s, CurvatureTensor const& a) {
    return {s * a.along, s * a.mixed, s * a.across};
  }
  /// Value of the quadratic form on two directions (along, across).
  T on(T const& u_along, T const& u_across, T const& v_along, T const& v_across) const {
    return u_along * (along * v_along + mixed * v_across) + u_across * (mixed * v_along + across * v_across);
  }
};

/// Of a surface with principal curvatures k_1 along its circumference and k_2 along its meridian.
template <Scalar T>
CurvatureTensor<T> curvature_tensor(T const& k1, T const& k2, Twist<T> const& chi) {
  T const sin2 = chi.sin * chi.sin;
  T const cos2 = chi.cos * chi.cos;
  return {k1 * cos2 + k2 * sin2, (k1 - k2) * (chi.sin * chi.cos), k2 * cos2 + k1 * sin2};  // (G6)
}

}  // namespace rollerrig
