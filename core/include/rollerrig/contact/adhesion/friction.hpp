// contact/adhesion/friction.hpp - the friction of one contact, and what its surface leaves of the creep curve's stiffness.
#pragma once
#include "rollerrig/contact/adhesion/adhesion.hpp"

namespace rollerrig {

/// Friction that may fall with the slip velocity w, one for the whole run:
///
///     mu(w) = mu_0 ((1 - A) exp(-B w) + A)
///
/// or what a map says of the place, the time, the slip and the energy spent there.
/// Source: Polach, Wear 258 (2005). A = 1: Coulomb.
struct Friction {
  double coefficient{0.3};          ///< mu_0, the largest [-]
  double ratio{1.0};                ///< A, what is left at high slip velocity over mu_0 [-]
  double decay{0.0};                ///< B [s/m]
  AdhesionMap const* map{nullptr};  ///< in place of them, contact/adhesion/adhesion.hpp

  /// @param place            distance along the rail [m]
  /// @param energy_per_area  spent on this piece of rail, by the wheels ahead and by this one [J/m^2]
  template <Scalar T>
  RailSurface<T> operator()(T const& time, T const& place, T const& slip_speed, double energy_per_area) const {
    if (map != nullptr) return map->at(map->over_time ? time : place, slip_speed, T(energy_per_area));
    T const mu = ratio == 1.0 ? T(coefficient) : FallingFriction{coefficient, ratio, decay}.at(slip_speed);
    return {mu, T(1.0), T(1.0)};
  }
};

}  // namespace rollerrig
