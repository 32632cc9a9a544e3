// system/links.hpp - what ties the accelerations of several bodies to each other: geared rotors, axles that roll ideally.
//
//   wrenches of all bodies -> [links] -> one multiplier per link -> forces and moments on its bodies
//
// A link has a speed  u = sum over its arms (along v_x + up v_z + turn Omega), Omega the body's turning about its own y axis, and
// acts on the arms with the multiplier p times the same numbers. With u'_0 what all other wrenches make of u',
//
//   geared rotor of inertia J, turning with u:   p = -J u'          =>  (G + 1/J) p = -u'_0
//   tie:                                         u' = -rate u       =>  G p = -(u'_0 + rate u)
//
// and G_ij = sum of arm_i arm_j / (mass or inertia): constant, so that its inverse is made once. Exact for any attitude: the
// rate of Omega of a free body is (moment - gyroscopic moment)_y / I_y, whatever else it does.
#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "rollerrig/multibody/body.hpp"

namespace rollerrig {

/// A body's part in a link; body -1: none.
struct LinkArm {
  int body{-1};
  double along{0.0}, up{0.0}, turn{0.0};
};

struct Link {
  std::array<LinkArm, 2> arm{};
  double inertia{0.0};  ///< J [kg m^2]; 0: a tie
  double rate{0.0};     ///< of a tie [1/s]
};

/// u
template <Scalar T>
T link_speed(Link const& link, std::vector<BodyMotion<T>> const& motion) {
  T u(0.0);
  for (LinkArm const& a : link.arm) {
    if (a.body < 0) continue;
    auto const& m = motion[static_cast<std::size_t>(a.body)];
    u = u + a.along * m.v.x + a.up * m.v.z + a.turn * dot(m.R.ey, m.omega);
  }
  return u;
}

/// An arm's part of u' under these wrenches.
///
/// @param driven  pitch acceleration of a body whose turning is given [rad/s^2]
template <Scalar T>
T link_acceleration(LinkArm const& a, Body const& body, BodyMotion<T> const& m, Wrench<T> const& wrench,
                    Vec3<T> const& gyroscopic, T const& driven) {
  T rate(0.0);
  if (!body.locked[coord_x]) rate = rate + (a.along / body.mass) * wrench.force.x;
  if (!body.locked[coord_z]) rate = rate + (a.up / body.mass) * wrench.force.z;
  if (body.driven) return rate + a.turn * driven;
  if (!body.locked[coord_pitch]) rate = rate + (a.turn / body.inertia.y) * (dot(m.R.ey, wrench.moment) - gyroscopic.y);
  return rate;
}

/// Puts `multiplier` of the link on one of its bodies.
template <Scalar T>
void apply_link(LinkArm const& a, BodyMotion<T> const& m, T const& multiplier, Wrench<T>& wrench) {
  wrench.force.x += a.along * multiplier;
  wrench.force.z += a.up * multiplier;
  wrench.moment += (a.turn * multiplier) * m.R.ey;
}

/// The inverse of G, with 1/J on the diagonal of rotors.
Eigen::MatrixXd link_matrix(std::vector<Link> const& links, std::vector<Body> const& bodies);

}  // namespace rollerrig
