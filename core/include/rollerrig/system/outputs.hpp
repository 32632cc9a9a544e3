// system/outputs.hpp - what is read off an evaluation beside motion and forces: energies, accelerometers.
#pragma once
#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {

double kinetic_energy(Dynamics const& dynamics);  ///< of bodies and geared rotors [J]
double gravity_energy(Dynamics const& dynamics);  ///< over the design position [J]
double element_energy(Dynamics const& dynamics);  ///< elastic, preload included [J]

/// Specific force at a body's centre of mass, along its own axes: what an accelerometer there measures, 1 g at rest [m/s^2].
Vec3<double> specific_force(Dynamics const& dynamics, int body);

/// Turning of a body's frame against the ground, along its own axes: what gyroscopes fixed to it measure; in curves and cant
/// with the turning of the track under it. The spin of an axisymmetric body is not in it.
struct InertialTurning {
  Vec3<double> rate;          ///< [rad/s]
  Vec3<double> acceleration;  ///< [rad/s^2]
};
InertialTurning inertial_turning(Dynamics const& dynamics, int body);

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
