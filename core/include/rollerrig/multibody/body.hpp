// multibody/body.hpp - a rigid body: constant data, and its motion in one state.
//
// Coordinates  displacement (x, y, z) from the design position [m]; roll phi, pitch theta, yaw psi [rad].
// Orientation  R = Rz(psi) Rx(phi) Ry(theta): turns body components into world components.
// Velocities   the state holds the rates of these coordinates; locks are then exact.
// A wheelset or roller is axisymmetric: its frame does not take part in the spin (R = Rz Rx), theta is cyclic and enters
// only as the rate theta_dot, so hours of running cost no accuracy.
#pragma once
#include <array>

#include "rollerrig/fields.hpp"
#include "rollerrig/math/vector.hpp"

namespace rollerrig {

enum Coordinate : int { coord_x, coord_y, coord_z, coord_roll, coord_pitch, coord_yaw };

struct Body {
  double mass{0.0};
  Vec3<double> inertia{};
  Vec3<double> position{};
  bool axisymmetric{false};      ///< surface of revolution about its y axis
  std::array<bool, 6> locked{};  ///< per Coordinate
  double speed_controlled_radius{0.0};
  bool in_moving_frame{true};  ///< on a track: moves with the vehicle; false: a piece of the track itself
  double loss_constant{0.0}, loss_linear{0.0}, loss_quadratic{0.0};  ///< of an axle that only turns against the ground

  static constexpr auto fields() {
    using P = Body;
    return members(
        Member{"mass", &P::mass, "kg", "mass", positive},
        Member{"inertia", &P::inertia, "kg m^2", "principal moments of inertia Ixx, Iyy, Izz", positive},
        Member{"position", &P::position, "m", "design position of the centre of mass, world"},
        Member{"axisymmetric", &P::axisymmetric}, Member{"locked", &P::locked},
        Member{"speed_controlled_radius", &P::speed_controlled_radius, "m",
               "radius V over pitch rate of a roller whose pitch rate is prescribed; 0: it is free", not_negative},
        Member{"in_moving_frame", &P::in_moving_frame},
        Member{"loss_constant", &P::loss_constant, "N m", "torque against the spin that bearings take at any speed",
               not_negative},
        Member{"loss_linear", &P::loss_linear, "N m s/rad", "torque that grows with it", not_negative},
        Member{"loss_quadratic", &P::loss_quadratic, "N m s^2/rad^2", "torque that grows with its square: ventilation",
               not_negative});
  }

  /// A roller on rigid bearings: its frame coincides with the world's.
  bool only_spins() const {
    return locked[coord_x] && locked[coord_y] && locked[coord_z] && locked[coord_roll] && locked[coord_yaw];
  }
  bool speed_controlled() const { return speed_controlled_radius > 0.0; }
  /// Prescribed pitch acceleration of a speed-controlled roller [rad/s^2].
  ///
  /// @param acceleration  dV/dt [m/s^2]
  double prescribed_pitch(double acceleration) const {
    return speed_controlled() ? -acceleration / speed_controlled_radius : 0.0;
  }
  bool has_losses() const { return loss_constant != 0.0 || loss_linear != 0.0 || loss_quadratic != 0.0; }
  /// Torque of bearings and air against the spin [N m]: M = M_0 w/|w| + M_1 w + M_2 w |w|; below 0.01 rad/s the
  /// constant part is viscous drag, so that a body comes to rest.
  ///
  /// @param rate  w [rad/s]
  template <Scalar T>
  T loss(T const& rate) const {
    using std::sqrt;
    T const size = sqrt(rate * rate + T(1e-4));
    return rate * (T(loss_constant) / size + T(loss_linear) + T(loss_quadratic) * size);
  }
};

template <Scalar T>
struct BodyMotion {
  std::array<T, 6> q{T(0.0), T(0.0), T(0.0), T(0.0), T(0.0), T(0.0)};
  std::array<T, 6> rate{T(0.0), T(0.0), T(0.0), T(0.0), T(0.0), T(0.0)};
  Rotation<T> R;        ///< body frame -> world
  Vec3<T> p;            ///< displacement of the centre of mass [m]
  Vec3<T> v;            ///< its velocity [m/s]
  Vec3<T> omega_body;   ///< angular velocity incl. spin, body components [rad/s]
  Vec3<T> frame_body;   ///< angular velocity of the body frame (without spin if axisymmetric), body components
  Vec3<T> omega;        ///< angular velocity incl. spin, world components
  Vec3<T> frame_omega;  ///< angular velocity of the body frame, world components
  T sin_roll{0.0}, cos_roll{1.0}, sin_pitch{0.0}, cos_pitch{1.0};  ///< pitch: of the body frame
};

/// The same of a body that only spins: its frame is the world's.
template <Scalar T>
void update_spin(BodyMotion<T>& m) {
  T const one(1.0), none(0.0);
  m.p = m.v = m.frame_body = m.frame_omega = {none, none, none};
  m.R = {{one, none, none}, {none, one, none}, {none, none, one}};
  m.omega = m.omega_body = {none, m.rate[coord_pitch], none};
  m.sin_roll = m.sin_pitch = none;
  m.cos_roll = m.cos_pitch = one;
}

/// Fills the derived members of `m` from q and rate.
template <Scalar T>
void update_motion(Body const& body, BodyMotion<T>& m) {
  using std::cos;
  using std::sin;
  if (body.axisymmetric && body.only_spins()) {
    update_spin(m);
    return;
  }
  T const sr = sin(m.q[coord_roll]), cr = cos(m.q[coord_roll]);
  T const sy = sin(m.q[coord_yaw]), cy = cos(m.q[coord_yaw]);
  T const roll_rate = m.rate[coord_roll], pitch_rate = m.rate[coord_pitch], yaw_rate = m.rate[coord_yaw];
  m.p = {m.q[coord_x], m.q[coord_y], m.q[coord_z]};
  m.v = {m.rate[coord_x], m.rate[coord_y], m.rate[coord_z]};
  m.sin_roll = sr;
  m.cos_roll = cr;

  // Frame after yaw and roll; angular velocity in it.
  Rotation<T> const S{{cy, sy, T(0.0)}, {-(sy * cr), cy * cr, sr}, {sy * sr, -(cy * sr), cr}};
  Vec3<T> const frame_s{roll_rate, yaw_rate * sr, yaw_rate * cr};
  Vec3<T> const omega_s{roll_rate, pitch_rate + yaw_rate * sr, yaw_rate * cr};
  m.omega = S * omega_s;
  if (body.axisymmetric) {
    m.R = S;
    m.omega_body = omega_s;
    m.frame_body = frame_s;
    m.frame_omega = S * frame_s;
    m.sin_pitch = T(0.0);
    m.cos_pitch = T(1.0);
    return;
  }
  T const sp = sin(m.q[coord_pitch]), cp = cos(m.q[coord_pitch]);
  m.sin_pitch = sp;
  m.cos_pitch = cp;
  m.R = {cp * S.ex - sp * S.ez, S.ey, sp * S.ex + cp * S.ez};
  m.omega_body = {cp * omega_s.x - sp * omega_s.z, omega_s.y, sp * omega_s.x + cp * omega_s.z};
  m.frame_body = m.omega_body;
  m.frame_omega = m.omega;
}

/// What the angular acceleration of the body has beside E times the second derivatives of its angles: E_d q_d, body
/// components [rad/s^2]. Columns of E: roll (cp, 0, sp), pitch (0, 1, 0), yaw (-sp cr, sr, cp cr); of an axisymmetric body
/// p = 0, since its frame does not take part in the spin.
template <Scalar T>
Vec3<T> turning_bias(Body const& body, BodyMotion<T> const& m) {
  T const sr = m.sin_roll, cr = m.cos_roll, sp = m.sin_pitch, cp = m.cos_pitch;
  T const roll_rate = m.rate[coord_roll], yaw_rate = m.rate[coord_yaw];
  T const pitch_rate = body.axisymmetric ? T(0.0) : m.rate[coord_pitch];
  return {pitch_rate * -(sp * roll_rate) + yaw_rate * (sp * sr * roll_rate - cp * cr * pitch_rate),
          yaw_rate * cr * roll_rate,
          pitch_rate * cp * roll_rate - yaw_rate * (sp * cr * pitch_rate + cp * sr * roll_rate)};
}

/// Angular acceleration of the body's frame, which does not spin if axisymmetric, body components [rad/s^2].
///
/// @param a  second derivatives of the coordinates
template <Scalar T>
Vec3<T> frame_angular_acceleration(Body const& body, BodyMotion<T> const& m, std::array<T, 6> const& a) {
  T const pitching = body.axisymmetric ? T(0.0) : a[coord_pitch];
  Vec3<T> const turning{m.cos_pitch * a[coord_roll] - m.sin_pitch * m.cos_roll * a[coord_yaw],
                        pitching + m.sin_roll * a[coord_yaw],
                        m.sin_pitch * a[coord_roll] + m.cos_pitch * m.cos_roll * a[coord_yaw]};
  return turning + turning_bias(body, m);
}

/// Force and moment about the centre of mass, world components.
template <Scalar T>
struct Wrench {
  Vec3<T> force{};
  Vec3<T> moment{};
};

/// W x (I w): what stands beside the moment in Euler's equation, body components [N m].
template <Scalar T>
Vec3<T> gyroscopic_moment(Body const& body, BodyMotion<T> const& m) {
  auto const& I = body.inertia;
  auto const& w = m.omega_body;
  return cross(m.frame_body, Vec3<T>{I.x * w.x, I.y * w.y, I.z * w.z});
}

/// Accelerations of the six coordinates under a wrench (gravity included by the caller).
///
/// Newton: m p_dd = F. Euler in the body frame: I w_d + W x (I w) = M, where W is the angular velocity of the frame and
/// w = E(phi, theta) (phi_d, theta_d, psi_d). Projected on the coordinates: E^T I E q_dd = E^T (M - I E_d q_d - W x I w).
/// Locked coordinates have zero acceleration, a speed-controlled pitch the prescribed one; both drop out of the system exactly.
///
/// @param gyroscopic         W x (I w), and what the turning of a track frame adds, body components [N m]
/// @param constraint_moment  torque of the drive that makes a speed-controlled body turn as prescribed [N m]
template <Scalar T>
std::array<T, 6> accelerations(Body const& body, BodyMotion<T> const& m, Wrench<T> const& wrench,
                               Vec3<T> const& gyroscopic, T const& prescribed_pitch, T& constraint_moment) {
  std::array<T, 6> a{T(0.0), T(0.0), T(0.0), T(0.0), T(0.0), T(0.0)};
  if (body.axisymmetric && body.only_spins()) {  // Euler's equation about one axis
    bool const given = body.speed_controlled();
    T const moment = wrench.moment.y - gyroscopic.y;
    a[coord_pitch] = given ? prescribed_pitch : body.locked[coord_pitch] ? T(0.0) : moment / body.inertia.y;
    constraint_moment = given ? body.inertia.y * prescribed_pitch - moment : T(0.0);
    return a;
  }
  double const inverse_mass = 1.0 / body.mass;
  if (!body.locked[coord_x]) a[coord_x] = inverse_mass * wrench.force.x;
  if (!body.locked[coord_y]) a[coord_y] = inverse_mass * wrench.force.y;
  if (!body.locked[coord_z]) a[coord_z] = inverse_mass * wrench.force.z;

  auto const& I = body.inertia;
  T const sr = m.sin_roll, cr = m.cos_roll, sp = m.sin_pitch, cp = m.cos_pitch;
  // Columns of E: roll (cp, 0, sp), pitch (0, 1, 0), yaw (-sp cr, sr, cp cr).
  Vec3<T> const yaw_column{-(sp * cr), sr, cp * cr};
  Vec3<T> const bias = turning_bias(body, m);
  Vec3<T> const moment = m.R.transposed_times(wrench.moment);
  Vec3<T> const u{moment.x - I.x * bias.x - gyroscopic.x, moment.y - I.y * bias.y - gyroscopic.y,
                  moment.z - I.z * bias.z - gyroscopic.z};

  T const g_roll = cp * u.x + sp * u.z;
  T const g_pitch = u.y;
  T const g_yaw = dot(yaw_column, u);
  T const a_rr = I.x * cp * cp + I.z * sp * sp;
  T const a_ry = (I.z - I.x) * (sp * cp) * cr;
  T const a_py = I.y * sr;
  T const a_yy = I.x * square(yaw_column.x) + I.y * sr * sr + I.z * square(yaw_column.z);
  bool const roll_free = !body.locked[coord_roll];
  bool const pitch_free = !body.locked[coord_pitch] && !body.speed_controlled();
  bool const yaw_free = !body.locked[coord_yaw];
  T const pitch_given = body.speed_controlled() ? prescribed_pitch : T(0.0);

  // Eliminate roll and pitch (not coupled with each other), then yaw.
  T yaw_mass = a_yy;
  T yaw_load = g_yaw;
  if (roll_free) {
    yaw_mass = yaw_mass - a_ry * a_ry / a_rr;
    yaw_load = yaw_load - a_ry * g_roll / a_rr;
  }
  if (pitch_free) {
    yaw_mass = yaw_mass - a_py * a_py / I.y;
    yaw_load = yaw_load - a_py * g_pitch / I.y;
  } else {
    yaw_load = yaw_load - a_py * pitch_given;
  }
  T const yaw = yaw_free ? yaw_load / yaw_mass : T(0.0);
  a[coord_yaw] = yaw;
  a[coord_roll] = roll_free ? (g_roll - a_ry * yaw) / a_rr : T(0.0);
  a[coord_pitch] = pitch_free ? (g_pitch - a_py * yaw) / I.y : pitch_given;
  constraint_moment = body.speed_controlled() ? I.y * pitch_given + a_py * yaw - g_pitch : T(0.0);
  return a;
}

template <Scalar T>
std::array<T, 6> accelerations(Body const& body, BodyMotion<T> const& m, Wrench<T> const& wrench,
                               T const& prescribed_pitch, T& constraint_moment) {
  return accelerations(body, m, wrench, gyroscopic_moment(body, m), prescribed_pitch, constraint_moment);
}

}  // namespace rollerrig
