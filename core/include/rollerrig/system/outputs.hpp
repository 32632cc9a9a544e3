// system/outputs.hpp - what is read off an evaluation beside motion and forces: energies, accelerometers.
//
// What is a template on T is also read off the sweeps of the Jacobian.
#pragma once
#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {

double kinetic_energy(Dynamics const& dynamics);  ///< of bodies and geared rotors [J]
double gravity_energy(Dynamics const& dynamics);  ///< over the design position [J]
double element_energy(Dynamics const& dynamics);  ///< elastic, preload included [J]

/// Specific force at a body's centre of mass, along its own axes: what an accelerometer there measures, 1 g at rest [m/s^2].
template <Scalar T>
Vec3<T> specific_force(Model const& model, Workspace<T> const& work, int body) {
  auto const b = at(body);
  auto const& a = work.acceleration[b];
  bool const moving = model.bodies[b].in_moving_frame && model.on_rails;
  Vec3<T> f{a[coord_x], a[coord_y], a[coord_z]};
  if (moving && work.curved) {
    f += transport_acceleration(model.bodies[b], work.frame[b], work.motion[b]) + T(model.gravity) * work.frame[b].up;
  } else {
    f.z += T(model.gravity);
    if (moving) f.x += work.travel.acceleration;
  }
  return work.motion[b].R.transposed_times(f);
}

/// Turning of a body's frame against the ground, along its own axes: what gyroscopes fixed to it measure; in curves and cant
/// with the turning of the track under it. The spin of an axisymmetric body is not in it.
template <Scalar T>
struct InertialTurning {
  Vec3<T> rate;          ///< [rad/s]
  Vec3<T> acceleration;  ///< [rad/s^2]
};

template <Scalar T>
InertialTurning<T> inertial_turning(Model const& model, Workspace<T> const& work, int body) {
  auto const b = at(body);
  Body const& data = model.bodies[b];
  auto const& m = work.motion[b];
  InertialTurning<T> turning{m.frame_body, frame_angular_acceleration(data, m, work.acceleration[b])};
  if (data.in_moving_frame && model.on_rails && work.curved) {  // (W11)
    turning.rate += m.R.transposed_times(work.frame[b].omega);
    turning.acceleration += transport_turning(work.frame[b], m);
  }
  return turning;
}

/// Speed of the rollers' crowns under the wheels, mean over the wheels [m/s].
double crown_speed(Dynamics const& dynamics);

/// How far and how fast the vehicle runs: on track its moving frame; on a rig what of the rollers' crowns passes under the
/// wheels, mean over the wheels: s = mean of R times the angle that the roller has turned forward, and its rates.
///
/// @param z  quadratures: the angles turned since the start
Travel<double> running_motion(Dynamics const& dynamics, double t, double const* z, Inputs const& inputs);

/// Longitudinal slip at nominal radii of the axle of a rolling constraint [m/s].
double rolling_slip(Dynamics const& dynamics, int constraint);

}  // namespace rollerrig
