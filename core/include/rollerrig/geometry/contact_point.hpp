// geometry/contact_point.hpp - one solution of (7)-(8) with everything the contact forces need, with derivatives.
#pragma once
#include "rollerrig/geometry/combined_curvature.hpp"
#include "rollerrig/geometry/reduction.hpp"

namespace rollerrig {

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
  double const kappa = pair.hertz_curvature();
  point.wheel_curvature_along = 1.0 / (line.radius * wheel_norm);                            // (15)
  point.wheel_curvature_across = -(line.profile.second / (wheel_norm2 * wheel_norm));        // (15), r > 0
  point.rail_curvature_along = kappa / ((1.0 + kappa * rail_point.rail.value) * rail_norm);  // (15), roller
  point.rail_curvature_across = -(rail_point.rail.second / (rail_norm2 * rail_norm));        // (15)
  point.twist = twist_of(point.n, pose.R.ey, wheel_norm, rail_norm);
  return point;
}

}  // namespace rollerrig
