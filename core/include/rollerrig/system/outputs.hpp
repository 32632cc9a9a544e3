// system/outputs.hpp - what is read off an evaluation beside motion and forces: energies, accelerometers.
#pragma once
#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {

double kinetic_energy(Dynamics const& dynamics);  ///< of bodies and geared rotors [J]
double gravity_energy(Dynamics const& dynamics);  ///< over the design position [J]
double element_energy(Dynamics const& dynamics);  ///< elastic, preload included [J]

/// Specific force at a body's centre of mass, along its own axes: what an accelerometer there measures, 1 g at rest [m/s^2].
Vec3<double> specific_force(Dynamics const& dynamics, int body);

/// Longitudinal slip at nominal radii of the axle of a rolling constraint [m/s].
double rolling_slip(Dynamics const& dynamics, int constraint);

}  // namespace rollerrig
