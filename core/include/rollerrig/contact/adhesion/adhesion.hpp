// contact/adhesion/adhesion.hpp - how much friction a rail offers, and how stiffly: over slip velocity, over the energy that cleans it,
// and where.
//
//   place, slip velocity, energy spent per area -> [adhesion] -> friction and reductions of the creep curve -> creep law
//
// One implementation for the contact of the 3-D track and for the virtual rail in the rig's controller.
// Source  Polach, Creep forces in simulations of traction vehicles running on adhesion limit, Wear 258 (2005): (A1);
//         Meacci, Rindi, Pugi et al., degraded adhesion with recovery by dissipated energy: (A2), (A3).
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "rollerrig/scalar.hpp"

namespace rollerrig {

/// Friction that falls with slip velocity: mu(w) = mu0 [(1 - A) exp(-B w) + A]   (A1)
struct FallingFriction {
  double start{0.3};      ///< mu0, at no slip [-]
  double remaining{1.0};  ///< A: friction at large slip over that at none [-]; 1 is Coulomb's law
  double decay{0.0};      ///< B [s/m]

  template <Scalar T>
  T at(T const& slip_speed) const {
    using std::exp;
    return start * ((1.0 - remaining) * exp(-decay * slip_speed) + remaining);
  }
};

/// A surface at one instant, as a creep law sees it.
template <Scalar T>
struct RailSurface {
  T friction;  ///< mu [-]
  T k_A;       ///< k_A: what is left of the creep curve's stiffness where the patch sticks [-] ...
  T k_S;       ///< k_S: ... and where it slides [-], contact/creep/polach.hpp
};

/// A surface of which a part `share` is as `b`, the rest as `a`: forces add up, and so do stiffnesses.
template <Scalar T>
RailSurface<T> mixed(RailSurface<T> const& a, RailSurface<T> const& b, T const& share) {
  auto const between = [&](T const& from, T const& to) { return from + share * (to - from); };
  return {between(a.friction, b.friction), between(a.k_A, b.k_A), between(a.k_S, b.k_S)};
}

/// What lies on a rail.
struct RailCondition {
  FallingFriction friction{};
  double k_A{1.0};  ///< k_A [-]; 1 and 1: as the creep law on a clean surface
  double k_S{1.0};  ///< k_S [-], at most k_A

  template <Scalar T>
  RailSurface<T> at(T const& slip_speed) const {
    return {friction.at(slip_speed), T(k_A), T(k_S)};
  }
};

/// A rail surface that sliding wheels clean.
///
///     mu = (1 - lambda) mu_degraded(w) + lambda mu_recovered(w),   lambda = 1 - exp(-tau W)   (A2), (A3)
///
/// and k_A, k_S likewise. W is the energy dissipated per unit of running surface [J/m^2].
struct RailAdhesion {
  RailCondition degraded{};
  RailCondition recovered{};
  double cleaning{0.0};  ///< tau [m^2/J]; 0: nothing is cleaned

  template <Scalar T>
  RailSurface<T> at(T const& slip_speed, T const& energy_per_area) const {
    using std::exp;
    return mixed(recovered.at(slip_speed), degraded.at(slip_speed), exp(-cleaning * energy_per_area));
  }
};

/// Which adhesion a rail has where, or when: pieces along the rail [m], or over time [s].
///
/// From one piece to the next the surface changes smoothly, t^2 (3 - 2 t), over `blend` behind the border.
struct AdhesionMap {
  std::vector<RailAdhesion> piece{RailAdhesion{}};
  std::vector<double> from{};  ///< where piece k + 1 begins, rising; one less than pieces
  double blend{0.0};           ///< [m] or [s]; 0: it jumps
  bool over_time{false};       ///< `from` are times

  /// @param place  distance along the rail [m], or time [s]
  template <Scalar T>
  RailSurface<T> at(T const& place, T const& slip_speed, T const& energy_per_area) const {
    auto const after = std::upper_bound(from.begin(), from.end(), value_of(place)) - from.begin();
    auto const k = static_cast<std::size_t>(after);
    auto const here = piece[k].at(slip_speed, energy_per_area);
    if (k == 0 || !(blend > 0.0)) return here;
    T const t = (place - from[k - 1]) / blend;
    if (value_of(t) >= 1.0) return here;
    return mixed(piece[k - 1].at(slip_speed, energy_per_area), here, t * t * (3.0 - 2.0 * t));
  }
};

}  // namespace rollerrig
