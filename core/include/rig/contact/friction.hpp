// contact/friction.hpp - the friction coefficient of one contact.
#pragma once
#include "rig/scalar.hpp"

namespace rig {

/// Coulomb friction. The arguments are what later laws may depend on: time, place along the rail, and slip.
struct Friction {
  double coefficient{0.3};  ///< mu [-]

  template <Scalar T>
  T operator()(T const& /*time*/, T const& /*position*/, T const& /*slip_speed*/) const {
    return T(coefficient);
  }
};

}  // namespace rig
