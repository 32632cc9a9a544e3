// geometry/reduction.hpp - the paper's reduction of the contact problem from four unknowns to one.
//
//   profiles and pose -> [reduction: F(y_r) = 0] -> minima of the gap -> contact points -> forces
//
// The normal of a surface of revolution meets its axis. A common normal therefore meets both axes, and:
//   y_r given      the wheel's normals form a cone with apex A on the wheelset axis                      (1), (4)
//   x_r            the normal lies in the plane of A and the roller axis: closed form, two solutions     (7)
//                  of which the lower half of the wheel has one
//   x_b            follows, because the whole problem now lies in that plane (a meridian of the roller)  (3), (6)
//   y_b            where the normal line cuts the roller's generatrix                                    (8)
//   F(y_r) = 0     the generatrix is normal to the line there                                            (7)
// Source: Malvezzi, Meli, Pugi (2010), eqs (1)-(11); derivation in docs/theory/contact_geometry.md.
#pragma once
#include "rollerrig/geometry/wheel_circle.hpp"

namespace rollerrig {

/// The wheel's normal line for one wheel abscissa, in 3-D and in the roller's meridian plane (y, height over crown).
template <Scalar T>
struct WheelNormalLine {
  CurvePoint<T> profile;  ///< z, z', z'' of the wheel profile
  T radius;               ///< r(y_r) [m]
  Vec3<T> p;              ///< p_r^b, point on the wheel [m], eq. (2)
  Vec3<T> n;              ///< n_r^b, outward unit normal of the wheel, eq. (5)
  T y;                    ///< abscissa of p along the rail profile [m]
  T height;               ///< radial height of p over the crown circle [m]
  T n_radial;             ///< component of n along the roller's radius; negative where the wheel faces the roller
};

/// Eqs (1), (2), (4), (5) and the closed-form x_r that makes the normal meet the roller axis.
template <Scalar T>
WheelNormalLine<T> wheel_normal_line(WheelRollerPair const& pair, RelativePose<T> const& pose, T const& s) {
  using std::sqrt;
  WheelNormalLine<T> line;
  line.profile = pair.wheel->at(s);
  line.radius = pair.wheel_radius + line.profile.value;
  T const slope = line.profile.slope;  // r'(y_r)
  WheelCircle<T> const circle{line.radius, slope, 1.0 / sqrt(1.0 + slope * slope),
                              pose.o + (pair.tape_circle_y + s) * pose.R.ey};
  auto const [sin_alpha, cos_alpha] = facing_angle(pair, pose, circle);  // x_r = r sin(alpha)
  Vec3<T> const outwards = sin_alpha * pose.R.ex - cos_alpha * pose.R.ez;
  line.n = circle.cosine * (outwards - slope * pose.R.ey);  // (4), (5)
  line.p = circle.centre + line.radius * outwards;          // (1), (2)

  // Height over the crown circle without the difference of two large radii: exact for 1/R -> 0.
  auto const kappa = pair.geometry_curvature();
  Vec3<T> const& p = line.p;
  T const px = kappa * p.x;
  T const pz = kappa * p.z + 1.0;
  T const length = sqrt(px * px + pz * pz);
  line.height = (kappa * (p.x * p.x + p.z * p.z) + 2.0 * p.z) / (length + 1.0);
  line.y = p.y - pair.rail_origin_y;
  line.n_radial = (line.n.x * px + line.n.z * pz) / length;
  return line;
}

/// Where the wheel's normal line cuts the generatrix.
template <Scalar T>
struct GeneratrixPoint {
  T y;                 ///< abscissa on the rail profile [m]
  CurvePoint<T> rail;  ///< h, h', h'' there
  bool found{false};   ///< false: the line misses the profile
};

constexpr double parallel_line =
    0.1;  ///< least sine between normal line and generatrix: a smaller one does not cut it [-]
constexpr double beyond_profile = 0.05;  ///< farther beyond the ends of the profile Newton does not come back [m]
/// Last Newton step in double [m]: convergence is quadratic, and 1e-13 m is left at a gauge corner.
constexpr double newton_step = 1e-8;
/// The same where one more step follows.
constexpr double newton_step_before_last = 1e-5;

/// Solves (y - y_p) n_radial - (h(y) - height_p) n_y = 0 for y: Newton in double, then one step that carries derivatives.
template <Scalar T>
GeneratrixPoint<T> generatrix_point(WheelRollerPair const& pair, WheelNormalLine<T> const& line) {
  UniformSpline const& rail = *pair.rail;
  double const y_p = value_of(line.y);
  double const height_p = value_of(line.height);
  double const n_u = value_of(line.n_radial);
  double const n_y = value_of(line.n.y);

  double y = y_p;
  bool converged = false;
  // Exact derivatives need the root itself; in double the step below is one more Newton step.
  double const resolution = std::same_as<T, double> ? newton_step_before_last : newton_step;
  for (int iteration = 0; iteration < 12 && !converged; ++iteration) {
    auto const h = rail.at(y);
    double const residual = (y - y_p) * n_u - (h.value - height_p) * n_y;
    double const gradient = n_u - h.slope * n_y;
    if (!(gradient < -parallel_line)) return {};  // the line runs along the profile or away from it
    double const step = residual / gradient;
    y -= step;
    converged = step * step < resolution * resolution;
    if (!(y > rail.start - beyond_profile && y < rail.end() + beyond_profile)) return {};
  }
  if (!converged || !rail.contains(y)) return {};

  GeneratrixPoint<T> point;
  auto const h = rail.at(T(y));
  T const residual = (T(y) - line.y) * line.n_radial - (h.value - line.height) * line.n.y;
  point.y = T(y) - residual / (line.n_radial - h.slope * line.n.y);
  point.rail = rail.at(point.y);
  point.found = true;
  return point;
}

template <Scalar T>
struct Reduced {
  WheelNormalLine<T> line;
  GeneratrixPoint<T> rail_point;
  T residual;  ///< F(y_r): slope of the generatrix minus slope of the wheel across the line [-]
  T gap;       ///< signed distance wheel - roller along the line [m]; negative: the surfaces overlap
};

template <Scalar T>
Reduced<T> reduce(WheelRollerPair const& pair, RelativePose<T> const& pose, T const& s) {
  Reduced<T> result;
  result.line = wheel_normal_line(pair, pose, s);
  result.rail_point = generatrix_point(pair, result.line);
  auto const& line = result.line;
  auto const& rail_point = result.rail_point;
  result.residual = rail_point.rail.slope + line.n.y / line.n_radial;
  result.gap = -((line.y - rail_point.y) * line.n.y + (line.height - rail_point.rail.value) * line.n_radial);
  return result;
}

}  // namespace rollerrig
