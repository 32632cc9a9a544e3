// geometry/contact_point.hpp - one solution of (7)-(8) with everything the contact forces need, with derivatives.
#pragma once

#include "rollerrig/geometry/reduction.hpp"
#include "rollerrig/math/vector.hpp"

namespace rollerrig {

/// The curvatures of two touching surfaces together, where their principal directions differ.
///
///   contact point: normal, principal curvatures (15) -> [twist, combined curvature] -> Hertz, strips
///
/// Axes    in the common tangent plane, n out of the roller: c along the roller's circumference (along a rail), m = n x c across.
/// Twist   the wheel's circumference lies at the angle chi from c towards m: about yaw / cos(contact angle), 8 degrees for 50 mrad
///         at the flange. Both surfaces' curvatures are symmetric tensors; only in common axes may they be added.
/// Source  Johnson, Contact Mechanics (1985), section 4.1; docs/theory/contact_geometry.md, (G5), (G6).
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
};

/// Of a surface with principal curvatures k_1 along its circumference and k_2 along its meridian.
template <Scalar T>
CurvatureTensor<T> curvature_tensor(T const& k1, T const& k2, Twist<T> const& chi) {
  T const sin2 = chi.sin * chi.sin;
  T const cos2 = chi.cos * chi.cos;
  return {k1 * cos2 + k2 * sin2, (k1 - k2) * (chi.sin * chi.cos), k2 * cos2 + k1 * sin2};  // (G6)
}

/// A point where wheel and roller share a normal. All vectors in b.
template <Scalar T>
struct ContactPoint {
  T wheel_s;                 ///< EN abscissa on the wheel profile [m]
  T rail_y;                  ///< abscissa on the generatrix [m]
  T gap;                     ///< [m]; negative: the surfaces overlap by -gap, eq. (9)
  Vec3<T> p;                 ///< p_b^{b,C}: point on the roller [m], eq. (11)
  Vec3<T> n;                 ///< n_b^b: outward normal of the roller, eq. (6)
  T wheel_curvature_along;   ///< k_1r [1/m], eq. (15); positive: convex towards the other body
  T wheel_curvature_across;  ///< k_2r [1/m]
  T rail_curvature_along;    ///< k_1b [1/m]
  T rail_curvature_across;   ///< k_2b [1/m]
  Twist<T> twist{};          ///< of the wheel's principal directions against the roller's

  /// D: half the sum of both bodies' curvatures in the roller's axes, eqs (14), (G6) [1/m].
  CurvatureTensor<T> combined_curvature() const {
    auto const wheel = curvature_tensor(wheel_curvature_along, wheel_curvature_across, twist);
    return {0.5 * (wheel.along + rail_curvature_along), 0.5 * wheel.mixed,
            0.5 * (wheel.across + rail_curvature_across)};
  }
};

/// A stationary point of the gap in one pose: root of F, with gradient < 0 a minimum, else a maximum.
struct GapRoot {
  double s{0.0};         ///< wheel abscissa [m]
  double gradient{0.0};  ///< dF/ds [1/m]
  double gap{0.0};       ///< [m]
};

/// The contact point at a root of F, as a function of the pose: by the implicit function theorem, ds = -dF / gradient.
template <Scalar T>
ContactPoint<T> contact_point(WheelRollerPair const& pair, RelativePose<T> const& pose, GapRoot const& found) {
  using std::sqrt;
  T root(found.s);
  if constexpr (!std::same_as<T, double>) root = root - reduce(pair, pose, root).residual / found.gradient;
  auto const at_root = reduce(pair, pose, root);
  auto const& line = at_root.line;
  auto const& rail_point = at_root.rail_point;

  ContactPoint<T> point;
  point.wheel_s = root;
  point.rail_y = rail_point.y;
  point.gap = at_root.gap;
  point.n = -line.n;                         // (7)
  point.p = line.p - at_root.gap * point.n;  // (8)
  T const wheel_norm2 = 1.0 + line.profile.slope * line.profile.slope;
  T const wheel_norm = sqrt(wheel_norm2);
  T const rail_norm2 = 1.0 + rail_point.rail.slope * rail_point.rail.slope;
  T const rail_norm = sqrt(rail_norm2);
  double const kappa = pair.curvature_for_hertz();
  point.wheel_curvature_along = 1.0 / (line.radius * wheel_norm);                            // (15)
  point.wheel_curvature_across = -(line.profile.second / (wheel_norm2 * wheel_norm));        // (15), r > 0
  point.rail_curvature_along = kappa / ((1.0 + kappa * rail_point.rail.value) * rail_norm);  // (15), roller
  point.rail_curvature_across = -(rail_point.rail.second / (rail_norm2 * rail_norm));        // (15)
  point.twist = twist_of(point.n, pose.R.ey, wheel_norm, rail_norm);
  return point;
}

}  // namespace rollerrig
