// multibody/force_laws/direction_force.hpp - what a force law is asked, and what it answers; shared by all of them.
#pragma once
#include "rollerrig/scalar.hpp"

namespace rollerrig {

/// State of one direction of an element, as a law sees it.
template <Scalar T>
struct DirectionState {
  T const& d;     ///< deflection [m or rad]
  T const& rate;  ///< [m/s or rad/s]
  T const& s;     ///< of the law's inner node, where it has one
};

/// What acts in one direction of an element; every law adds its share.
template <Scalar T>
struct DirectionForce {
  T force;       ///< on b along +axis [N or N m]
  T dissipated;  ///< power turned into heat [W]
};

/// A law's inner node s: c s_dot is a force that moves s towards its place with about the stiffness k.
struct InnerNode {
  double damping;    ///< c [N s/m]
  double stiffness;  ///< k [N/m]

  double relaxation_rate() const { return stiffness / damping; }  ///< [1/s]
};

}  // namespace rollerrig
