// Exact solution: a free symmetric top, inertia A about two axes and C about its axis of symmetry.
//
// Its angular momentum H is fixed in space. The axis of symmetry goes round H at the rate |H| / A, at a constant angle beta:
// cos(beta) = C w_s / |H|, where w_s is the spin about the axis, which does not change.
// Source: Goldstein, Classical Mechanics, ch. 5.6.
#pragma once
#include <cmath>

#include "rollerrig/math/vector.hpp"

namespace rollerrig::exact {

struct SymmetricTop {
  double across, along;  // A, C [kg m^2]
  Vec3<double> axis;     // unit vector of symmetry at t = 0, world
  Vec3<double> omega;    // angular velocity at t = 0, world [rad/s]

  double spin() const { return dot(omega, axis); }
  Vec3<double> momentum() const {  // [kg m^2/s]
    Vec3<double> const along_axis = spin() * axis;
    return across * (omega - along_axis) + along * along_axis;
  }
  /// The axis of symmetry at time t: turned about H by |H| t / A (Rodrigues).
  Vec3<double> axis_at(double t) const {
    Vec3<double> const h = momentum();
    double const length = std::sqrt(dot(h, h));
    Vec3<double> const e = (1.0 / length) * h;
    double const angle = length * t / across;
    return std::cos(angle) * axis + std::sin(angle) * cross(e, axis) + (dot(e, axis) * (1.0 - std::cos(angle))) * e;
  }
};

}  // namespace rollerrig::exact
