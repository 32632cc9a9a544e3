// system/couplings.hpp - what couples the accelerations of several bodies: geared rotors, and axles that roll without slip.
//
//   wrenches of all bodies -> [couplings] -> one multiplier per coupling -> forces and moments on its bodies
//
// A coupling has a speed  u = sum over its terms (x v_x + z v_z + pitch Omega), Omega the body's turning about its own y axis,
// and acts on each body with the multiplier p times the same coefficients. With u'_0 what all other wrenches make of u',
//
//   geared rotor of inertia J, turning with u:   p = -J u'          =>  (G + 1/J) p = -u'_0
//   rolling constraint:                          u' = -rate u       =>  G p = -(u'_0 + rate u)
//
// and G_ij = sum of c_i c_j / (mass or inertia): constant, so that its inverse is made once. Exact for any attitude: the
// rate of Omega of a free body is (moment - gyroscopic moment)_y / I_y, whatever else it does.
#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "rollerrig/multibody/body.hpp"

namespace rollerrig {

/// A body's term in the speed of a coupling; body -1: none.
struct CouplingTerm {
  int body{-1};
  double x{0.0}, z{0.0};  ///< coefficients of its velocity [1/m of a rotor, 1 of a constraint]
  double pitch{0.0};      ///< coefficient of its turning [1 of a rotor, m of a constraint]
};

struct Coupling {
  std::array<CouplingTerm, 2> term{};
  double inertia{0.0};  ///< J of a geared rotor [kg m^2]; 0: a constraint
  double rate{0.0};     ///< of a constraint [1/s]
};

/// u
template <Scalar T>
T coupling_speed(Coupling const& coupling, std::vector<BodyMotion<T>> const& motion) {
  T u(0.0);
  for (CouplingTerm const& c : coupling.term) {
    if (c.body < 0) continue;
    auto const& m = motion[at(c.body)];
    u = u + c.x * m.v.x + c.z * m.v.z + c.pitch * dot(m.R.ey, m.omega);
  }
  return u;
}

/// A term's part of u' under these wrenches.
///
/// @param prescribed  pitch acceleration of a speed-controlled body [rad/s^2]
template <Scalar T>
T coupling_acceleration(CouplingTerm const& c, Body const& body, BodyMotion<T> const& m, Wrench<T> const& wrench,
                        Vec3<T> const& gyroscopic, T const& prescribed) {
  T rate(0.0);
  if (!body.locked[coord_x]) rate = rate + (c.x / body.mass) * wrench.force.x;
  if (!body.locked[coord_z]) rate = rate + (c.z / body.mass) * wrench.force.z;
  if (body.speed_controlled()) return rate + c.pitch * prescribed;
  if (!body.locked[coord_pitch]) rate = rate + (c.pitch / body.inertia.y) * (dot(m.R.ey, wrench.moment) - gyroscopic.y);
  return rate;
}

/// Puts `multiplier` of the coupling on one of its bodies.
template <Scalar T>
void apply_coupling(CouplingTerm const& c, BodyMotion<T> const& m, T const& multiplier, Wrench<T>& wrench) {
  wrench.force.x += c.x * multiplier;
  wrench.force.z += c.z * multiplier;
  wrench.moment += (c.pitch * multiplier) * m.R.ey;
}

}  // namespace rollerrig
