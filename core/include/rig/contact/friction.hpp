// contact/friction.hpp - the friction coefficient of one contact.
#pragma once
#include "rig/scalar.hpp"

namespace rig {

/// Coulomb friction with one coefficient. The arguments are there for laws that depend on time, place along the rail or slip.
struct Friction {
  double coefficient{0.3};  ///< mu [-]

  template <Scalar T>
  T operator()(T const& /*time*/, T const& /*position*/, T const& /*slip_speed*/) const {
    return T(coefficient);
  }
};

}  // namespace rig
