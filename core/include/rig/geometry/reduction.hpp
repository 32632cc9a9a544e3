// geometry/reduction.hpp - the paper's reduction of the contact problem from four unknowns to one.
//
//   profiles and pose -> [reduction: F(y_r) = 0] -> search -> contact points -> forces
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
#include "rig/geometry/pair.hpp"

namespace rig {

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
  T const r = pair.wheel_radius + line.profile.value;
  T const slope = line.profile.slope;  // r'(y_r)
  T const y_r = pair.tape_circle_y + s;
  double const kappa = pair.inverse_radius;

  // Apex of the cone of normals, and the unit vector u from the roller axis to it (in the x-z plane of b).
  Vec3<T> const apex = pose.o + (y_r + r * slope) * pose.R.ey;
  T const ax = kappa * apex.x;
  T const az = kappa * apex.z + 1.0;
  T const inverse_length = 1.0 / sqrt(ax * ax + az * az);
  T const ux = ax * inverse_length;
  T const uz = az * inverse_length;

  // The normal has no component along w = e_y x u:  w.x sin(alpha) - w.z cos(alpha) = r' w.y  in the wheelset frame.
  Vec3<T> const w = pose.R.transposed_times(Vec3<T>{uz, T(0.0), -ux});
  T const c = slope * w.y;
  T const rho2 = w.x * w.x + w.z * w.z;
  T const root = sqrt(rho2 - c * c);
  T const sin_alpha = (c * w.x + w.z * root) / rho2;  // x_r = r sin(alpha)
  T const cos_alpha = (w.x * root - c * w.z) / rho2;

  T const scale = 1.0 / sqrt(1.0 + slope * slope);
  line.radius = r;
  line.n = pose.R * (scale * Vec3<T>{sin_alpha, -slope, -cos_alpha});        // (4), (5)
  line.p = pose.o + pose.R * Vec3<T>{r * sin_alpha, y_r, -(r * cos_alpha)};  // (1), (2)

  // Height over the crown circle without the difference of two large radii: exact for 1/R -> 0.
  Vec3<T> const& p = line.p;
  T const px = kappa * p.x;
  T const pz = kappa * p.z + 1.0;
  line.height = (kappa * (p.x * p.x + p.z * p.z) + 2.0 * p.z) / (sqrt(px * px + pz * pz) + 1.0);
  line.y = p.y - pair.rail_origin_y;
  line.n_radial = line.n.x * ux + line.n.z * uz;
  return line;
}

/// Where the wheel's normal line cuts the generatrix.
template <Scalar T>
struct GeneratrixFoot {
  T y;                 ///< abscissa on the rail profile [m]
  CurvePoint<T> rail;  ///< h, h', h'' there
  bool found{false};   ///< false: the line misses the profile
};

/// Solves (y - y_p) n_radial - (h(y) - height_p) n_y = 0 for y: Newton in double, then one step that carries derivatives.
template <Scalar T>
GeneratrixFoot<T> generatrix_foot(WheelRollerPair const& pair, WheelNormalLine<T> const& line) {
  UniformSpline const& rail = *pair.rail;
  double const y_p = value_of(line.y);
  double const height_p = value_of(line.height);
  double const n_u = value_of(line.n_radial);
  double const n_y = value_of(line.n.y);

  double y = y_p;
  bool converged = false;
  double const resolution = 1e-16;  // of the abscissa [m]; the square of the last but one step
  for (int iteration = 0; iteration < 12 && !converged; ++iteration) {
    auto const h = rail.at(y);
    double const residual = (y - y_p) * n_u - (h.value - height_p) * n_y;
    double const gradient = n_u - h.slope * n_y;
    if (!(gradient < -0.1)) return {};  // the line runs along the profile or away from it
    double const step = residual / gradient;
    y -= step;
    converged = step * step < resolution;
    if (!(y > rail.start - 0.05 && y < rail.end() + 0.05)) return {};
  }
  if (!converged || !rail.contains(y)) return {};

  GeneratrixFoot<T> foot;
  auto const h = rail.at(T(y));
  T const residual = (T(y) - line.y) * line.n_radial - (h.value - line.height) * line.n.y;
  foot.y = T(y) - residual / (line.n_radial - h.slope * line.n.y);
  foot.rail = rail.at(foot.y);
  foot.found = true;
  return foot;
}

/// One evaluation of the reduced equation.
template <Scalar T>
struct Reduced {
  WheelNormalLine<T> line;
  GeneratrixFoot<T> foot;
  T residual;  ///< F(y_r): slope of the generatrix minus slope of the wheel across the line [-]
  T gap;       ///< signed distance wheel - roller along the line [m]; negative: the surfaces overlap
};

template <Scalar T>
Reduced<T> reduce(WheelRollerPair const& pair, RelativePose<T> const& pose, T const& s) {
  Reduced<T> result;
  result.line = wheel_normal_line(pair, pose, s);
  result.foot = generatrix_foot(pair, result.line);
  auto const& line = result.line;
  auto const& foot = result.foot;
  result.residual = foot.rail.slope + line.n.y / line.n_radial;
  result.gap = -((line.y - foot.y) * line.n.y + (line.height - foot.rail.value) * line.n_radial);
  return result;
}

}  // namespace rig
