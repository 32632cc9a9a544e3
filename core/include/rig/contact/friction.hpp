// contact/friction.hpp - the friction coefficient of one contact.
#pragma once
#include "rig/scalar.hpp"

namespace rig {

/// Friction that may fall with the slip velocity w:
///
///     mu(w) = mu_0 ((1 - A) exp(-B w) + A)
///
/// Source: Polach, Wear 258 (2005). A = 1: Coulomb. Time and place along the rail are there for laws that depend on them.
struct Friction {
  double coefficient{0.3};  ///< mu_0, the largest [-]
  double ratio{1.0};        ///< A, what is left at high slip velocity over mu_0 [-]
  double decay{0.0};        ///< B [s/m]

  template <Scalar T>
  T operator()(T const& /*time*/, T const& /*position*/, T const& slip_speed) const {
    using std::exp;
    if (ratio == 1.0) return T(coefficient);
    return coefficient * ((1.0 - ratio) * exp(-(decay * slip_speed)) + ratio);
  }
};

}  // namespace rig
