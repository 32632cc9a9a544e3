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
#include "rollerrig/geometry/pair.hpp"

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
///
/// @tparam Pair  WheelRollerPair, or as many of them side by side as T has lanes: geometry/lane_pair.hpp
template <Scalar T, class Pair>
WheelNormalLine<T> wheel_normal_line(Pair const& pair, RelativePose<T> const& pose, T const& s) {
  using std::sqrt;
  WheelNormalLine<T> line;
  line.profile = pair.wheel->at(s);
  T const r = pair.wheel_radius + line.profile.value;
  T const slope = line.profile.slope;  // r'(y_r)
  T const y_r = pair.tape_circle_y + s;
  auto const kappa = pair.geometry_curvature();

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

/// One evaluation of the reduced equation.
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

/// F and its derivative for the search, in double: the same equations as reduce() with the chain rule written out,
/// which is faster than a dual number. A test holds the two together.
struct ReducedSlope {
  double residual{0.0};    ///< F [-]
  double gradient{0.0};    ///< dF/ds at a fixed pose [1/m]
  double gap{0.0};         ///< [m]
  double gap_slope{0.0};   ///< dgap/ds at a fixed pose [-]
  double y{0.0};           ///< abscissa of the wheel's point along the generatrix [m]
  double rail_y{0.0};      ///< abscissa of the contact point on the generatrix [m]
  double slope{0.0};       ///< of the wheel across the normal line, F minus the generatrix' slope [-]
  double shift_rate{0.0};  ///< dF over a lateral shift of the wheel [1/m]
  bool found{false};
};

/// The meridian plane of the roller that holds the apex of the wheel's normals: u = (ux, 0, uz).
struct MeridianPlane {
  double ux{0.0}, uz{1.0};
  double turn_rate{0.0};  ///< du/ds = turn_rate (uz, 0, -ux): u turns as the apex moves along the axle [1/m]
};

/// @tparam round  a roller; false: a straight rail, for which much is constant
/// @param r, y_r  point of the wheel's profile about and along the wheelset axis [m], with its slope and curvature
template <bool round>
[[gnu::always_inline]] inline MeridianPlane meridian_plane(RelativePose<double> const& pose, double kappa, double r,
                                                           double y_r, double slope, double second) {
  if constexpr (!round) return {};
  auto const& R = pose.R;
  double const apex = y_r + r * slope;
  double const apex_rate = 1.0 + slope * slope + r * second;
  double const ax = kappa * (pose.o.x + apex * R.ey.x);
  double const az = kappa * (pose.o.z + apex * R.ey.z) + 1.0;
  double const inverse_length = 1.0 / std::sqrt(ax * ax + az * az);
  double const ux = ax * inverse_length;
  double const uz = az * inverse_length;
  return {ux, uz, kappa * apex_rate * (uz * R.ey.x - ux * R.ey.z) * inverse_length};
}

/// alpha of x_r = r sin(alpha), eq. (7), and its derivatives over s.
struct NormalAngle {
  double sin, cos, sin_rate, cos_rate;
};

template <bool round>
[[gnu::always_inline]] inline NormalAngle normal_angle(Rotation<double> const& R, MeridianPlane const& plane,
                                                       double slope, double second) {
  auto const& [ux, uz, q] = plane;
  Vec3<double> const w = R.transposed_times({uz, 0.0, -ux});
  double const c = slope * w.y;
  double const inverse_rho2 = 1.0 / (1.0 - w.y * w.y);
  double const root = std::sqrt(1.0 - w.y * w.y - c * c);
  double const sin_alpha = (c * w.x + w.z * root) * inverse_rho2;
  double const cos_alpha = (w.x * root - c * w.z) * inverse_rho2;
  double c_rate = second * w.y;
  if constexpr (round) {
    Vec3<double> const v = R.transposed_times({ux, 0.0, uz});  // w turns towards -v
    c_rate -= slope * q * v.y;
    double const root_rate = (w.y * q * v.y - c * c_rate) / root;
    double const rho2_rate = 2.0 * w.y * q * v.y;
    return {sin_alpha, cos_alpha,
            (c_rate * w.x - c * q * v.x - q * v.z * root + w.z * root_rate - sin_alpha * rho2_rate) * inverse_rho2,
            (w.x * root_rate - q * v.x * root - c_rate * w.z + c * q * v.z - cos_alpha * rho2_rate) * inverse_rho2};
  }
  double const root_rate = -c * c_rate / root;
  return {sin_alpha, cos_alpha, (c_rate * w.x + w.z * root_rate) * inverse_rho2,
          (w.x * root_rate - c_rate * w.z) * inverse_rho2};
}

/// The wheel's normal line in the meridian plane, as WheelNormalLine has it, and its derivatives over s.
struct MeridianLine {
  double y, height;            ///< of the wheel's point on the rail profile's abscissa and over the crown [m]
  double y_rate, height_rate;  ///< [-]
  double m_y, m_u;             ///< normal along the axis and along the roller's radius, not scaled to one
  double slope, slope_rate;    ///< of the wheel across the line, m_y/m_u [-], [1/m]
};

template <bool round>
[[gnu::always_inline]] inline MeridianLine meridian_line(WheelRollerPair const& pair, RelativePose<double> const& pose,
                                                         double s, CurvePoint<double> const& profile) {
  auto const& R = pose.R;
  double const kappa = pair.geometry_curvature();
  auto const [z, slope, second] = profile;
  double const r = pair.wheel_radius + z;
  double const y_r = pair.tape_circle_y + s;
  auto const plane = meridian_plane<round>(pose, kappa, r, y_r, slope, second);
  auto const& [ux, uz, q] = plane;
  auto const alpha = normal_angle<round>(R, plane, slope, second);

  Vec3<double> const m = R * Vec3<double>{alpha.sin, -slope, -alpha.cos};
  Vec3<double> const m_rate = R * Vec3<double>{alpha.sin_rate, -second, -alpha.cos_rate};
  Vec3<double> const p = pose.o + R * Vec3<double>{r * alpha.sin, y_r, -r * alpha.cos};
  Vec3<double> const p_rate =
      R * Vec3<double>{slope * alpha.sin + r * alpha.sin_rate, 1.0, -slope * alpha.cos - r * alpha.cos_rate};
  double m_u = m.z, m_u_rate = m_rate.z, height = p.z, height_rate = p_rate.z;
  if constexpr (round) {
    m_u = m.x * ux + m.z * uz;
    m_u_rate = m_rate.x * ux + m_rate.z * uz + q * (m.x * uz - m.z * ux);
    double const px = kappa * p.x;
    double const pz = kappa * p.z + 1.0;
    double const length = std::sqrt(px * px + pz * pz);
    height = (kappa * (p.x * p.x + p.z * p.z) + 2.0 * p.z) / (length + 1.0);
    height_rate = (px * p_rate.x + pz * p_rate.z) / length;
  }
  double const inverse_m_u = 1.0 / m_u;
  double const sigma = m.y * inverse_m_u;
  double const sigma_rate = (m_rate.y - sigma * m_u_rate) * inverse_m_u;
  return {p.y - pair.rail_origin_y, height, p_rate.y, height_rate, m.y, m_u, sigma, sigma_rate};
}

/// Solves y - y_p = (h(y) - height) sigma for y by Newton, as generatrix_point() does.
///
/// @param facing  component of the wheel's unit normal towards the roller [-]
[[gnu::always_inline]] inline GeneratrixPoint<double> generatrix_point(UniformSpline const& rail,
                                                                       MeridianLine const& line, double facing) {
  GeneratrixPoint<double> point{line.y, rail.at(line.y)};
  for (int iteration = 0; iteration < 12; ++iteration) {
    double const gradient = 1.0 - point.rail.slope * line.slope;
    if (!(gradient * facing > parallel_line)) return {};
    double const inverse_gradient = 1.0 / gradient;
    double const step = (point.y - line.y - (point.rail.value - line.height) * line.slope) * inverse_gradient;
    point.y -= step;
    if (!(point.y > rail.start - beyond_profile && point.y < rail.end() + beyond_profile)) return {};
    point.rail = rail.at(point.y);
    if (step * step < newton_step * newton_step) {
      point.found = rail.contains(point.y);
      break;
    }
  }
  return point;
}

/// @tparam round  as in meridian_plane()
template <bool round>
ReducedSlope reduce_with_slope(WheelRollerPair const& pair, RelativePose<double> const& pose, double s) {
  auto const profile = pair.wheel->at(s);
  double const inverse_normal = 1.0 / std::sqrt(1.0 + profile.slope * profile.slope);
  auto const line = meridian_line<round>(pair, pose, s, profile);
  ReducedSlope out;
  out.y = line.y;
  auto const point = generatrix_point(*pair.rail, line, -line.m_u * inverse_normal);
  if (!point.found) return out;
  auto const& h = point.rail;
  double const inverse_gradient = 1.0 / (1.0 - h.slope * line.slope);
  double const y_rate =
      (line.y_rate - line.slope * line.height_rate + (h.value - line.height) * line.slope_rate) * inverse_gradient;
  out.found = true;
  out.rail_y = point.y;
  out.slope = line.slope;
  out.shift_rate = h.second * inverse_gradient;
  out.residual = h.slope + line.slope;
  out.gradient = h.second * y_rate + line.slope_rate;
  out.gap = -((line.y - point.y) * line.m_y + (line.height - h.value) * line.m_u) * inverse_normal;
  // Along the wheel's normal the gap changes by the travel of the roller's point alone: at yaw not the wheel's.
  out.gap_slope = line.m_u * inverse_normal * out.residual * y_rate;
  return out;
}

inline ReducedSlope reduce_with_slope(WheelRollerPair const& pair, RelativePose<double> const& pose, double s) {
  return pair.geometry_curvature() != 0.0 ? reduce_with_slope<true>(pair, pose, s)
                                          : reduce_with_slope<false>(pair, pose, s);
}

}  // namespace rollerrig
