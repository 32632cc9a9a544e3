// multibody/force_element.hpp - a three-dimensional elastic-viscous element between two bodies: springs, dampers with series
// stiffness, bumpstops, anti-roll bars, traction rods.
//
// Axes     fixed to body a. Deflection d = R_a^T (P_b - P_a) minus its design value: where P_b, a point of b, has moved
//          to in the axes of a. Rotations: the relative z-x-y angles of R_a^T R_b (yaw, roll, pitch).
// Signs    positive d: end b lies further along +axis. The law gives the force that resists it.
// Action and reaction are both applied at P_b, so that the power on the two bodies is exactly -f d_dot.
// Clamped  a loaded spring between two seats is symmetric: it is two halves, one as above, the other with axes fixed to b and
//          acting at P_a. docs/theory/bodies_and_elements.md, (B11)-(B12).
#pragma once
#include <array>

#include "rollerrig/multibody/body.hpp"
#include "rollerrig/multibody/force_laws.hpp"

namespace rollerrig {

inline constexpr Range lever_arm{0.0, 1e5, "within 1e5 m", false, false, true};

struct ForceElement {
  int body_a{-1};  ///< -1: ground
  int body_b{-1};
  Vec3<double> r_b{};
  std::array<DirectionLaw, 6> law{};  ///< per Coordinate
  std::array<int, 7> node{};  ///< first inner node of each direction among all elements' and behind the last ...
  bool rotational{false};     ///< ... and whether there is a law of rotation: both set by system/model.hpp
  bool clamped{false};        ///< half of the force acts in the axes of b, at P_a

  static constexpr auto fields() {
    using P = ForceElement;
    return members(Member{"body_a", &P::body_a, index_or_none}, Member{"body_b", &P::body_b, index_or_none},
                   Member{"point_on_b", &P::r_b, "m",
                          "point of action P_b from b's centre of mass, body frame at design", lever_arm},
                   Member{"law", &P::law}, Member{"clamped", &P::clamped});
  }

  int first_node() const { return node.front(); }
  int end_node() const { return node.back(); }
};

/// Deflections and rates of one element in one state, and the axes its forces act along.
template <Scalar T>
struct ElementMotion {
  std::array<T, 6> d{T(0.0), T(0.0), T(0.0), T(0.0), T(0.0), T(0.0)};
  std::array<T, 6> rate{T(0.0), T(0.0), T(0.0), T(0.0), T(0.0), T(0.0)};
  Vec3<T> arm_a;                            ///< from the centre of mass of a to P_b, world [m]
  Vec3<T> arm_b;                            ///< from the centre of mass of b to P_b, world [m]
  Vec3<T> stretch;                          ///< P_b - P_a, world [m]; of clamped elements
  Vec3<T> roll_axis, pitch_axis, yaw_axis;  ///< dual to the angles: torque on b = sum of moment * axis (a's axes)
};

/// @param a, b        motion of the bodies
/// @param offset      design position of b's centre of mass from a's, world [m]
template <Scalar T>
ElementMotion<T> element_motion(ForceElement const& element, BodyMotion<T> const& a, BodyMotion<T> const& b,
                                Vec3<double> const& offset) {
  using std::asin;
  using std::atan2;
  using std::sqrt;
  ElementMotion<T> m;
  m.arm_b = b.R * lift<T>(element.r_b);
  m.arm_a = lift<T>(offset) + (b.p - a.p) + m.arm_b;
  Vec3<T> d = a.R.transposed_times(m.arm_a) - lift<T>(offset + element.r_b);  // P_a is fixed in a's axes
  Vec3<T> const v_b = b.v + cross(b.frame_omega, m.arm_b);
  Vec3<T> const v_a = a.v + cross(a.frame_omega, m.arm_a);
  Vec3<T> rate = a.R.transposed_times(v_b - v_a);
  if (element.clamped) {
    m.stretch = a.R * d;
    Vec3<T> const slip = v_b - v_a - cross(b.frame_omega - a.frame_omega, m.stretch);  // at P_a
    d = T(0.5) * (d + b.R.transposed_times(m.stretch));
    rate = T(0.5) * (rate + b.R.transposed_times(slip));
  }
  m.d[coord_x] = d.x, m.d[coord_y] = d.y, m.d[coord_z] = d.z;
  m.rate[coord_x] = rate.x, m.rate[coord_y] = rate.y, m.rate[coord_z] = rate.z;
  if (!element.rotational) return m;

  Rotation<T> const R = relative(a.R, b.R);  // Rz(yaw) Rx(roll) Ry(pitch)
  Vec3<T> const w = a.R.transposed_times(b.frame_omega - a.frame_omega);
  T const cos_roll = sqrt(1.0 - R.ey.z * R.ey.z);
  T const sin_yaw = -(R.ey.x / cos_roll);
  T const cos_yaw = R.ey.y / cos_roll;
  m.d[coord_roll] = asin(R.ey.z);
  m.d[coord_yaw] = atan2(-R.ey.x, R.ey.y);
  m.d[coord_pitch] = atan2(-R.ex.z, R.ez.z);
  T const tan_roll = R.ey.z / cos_roll;
  m.roll_axis = {cos_yaw, sin_yaw, T(0.0)};
  m.pitch_axis = {-(sin_yaw / cos_roll), cos_yaw / cos_roll, T(0.0)};
  m.yaw_axis = {sin_yaw * tan_roll, -(cos_yaw * tan_roll), T(1.0)};
  m.rate[coord_roll] = dot(m.roll_axis, w);
  m.rate[coord_pitch] = dot(m.pitch_axis, w);
  m.rate[coord_yaw] = dot(m.yaw_axis, w);
  return m;
}

/// Force at P_b and moment on b, axes of the frame that the motion of a is given in; a takes the opposite.
///
/// @param f  per direction, as direction_force() gives them [N, N m]
template <Scalar T>
Wrench<T> element_wrench(ForceElement const& element, ElementMotion<T> const& m, BodyMotion<T> const& a,
                         BodyMotion<T> const& b, std::array<T, 6> const& f) {
  Vec3<T> const local{f[coord_x], f[coord_y], f[coord_z]};
  Wrench<T> w{a.R * local, {}};
  if (element.rotational)
    w.moment = a.R * (f[coord_roll] * m.roll_axis + f[coord_pitch] * m.pitch_axis + f[coord_yaw] * m.yaw_axis);
  if (element.clamped) {
    Vec3<T> const half = T(0.5) * (b.R * local);
    w.force = T(0.5) * w.force + half;
    w.moment -= cross(m.stretch, half);
  }
  return w;
}

}  // namespace rollerrig
