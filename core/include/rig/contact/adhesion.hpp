// contact/adhesion.hpp - how much friction a rail offers: over slip velocity, over the energy that cleans it, and where.
//
//   place, slip velocity, energy spent per area -> [adhesion] -> friction coefficient -> creep law
//
// One implementation for the contact of the 3-D track and for the virtual rail in the rig's controller.
// Source  Polach, Creep forces in simulations of traction vehicles running on adhesion limit, Wear 258 (2005): (A1);
//         Meacci, Rindi, Pugi et al., degraded adhesion with recovery by dissipated energy: (A2), (A3).
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "rig/scalar.hpp"

namespace rig {

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

/// A rail surface that sliding wheels clean.
///
///     mu = (1 - lambda) mu_degraded(w) + lambda mu_recovered(w),   lambda = 1 - exp(-tau W)   (A2), (A3)
///
/// W is the energy dissipated per unit of running surface [J/m^2].
struct RailAdhesion {
  FallingFriction degraded{};
  FallingFriction recovered{};
  double cleaning{0.0};  ///< tau [m^2/J]; 0: nothing is cleaned

  template <Scalar T>
  T friction(T const& slip_speed, T const& energy_per_area) const {
    using std::exp;
    T const contaminated = exp(-cleaning * energy_per_area);
    return contaminated * degraded.at(slip_speed) + (1.0 - contaminated) * recovered.at(slip_speed);
  }
};

/// Which adhesion a rail has where, or when: pieces along the rail [m], or over time [s].
///
/// From one piece to the next the friction changes smoothly, t^2 (3 - 2 t), over `blend` behind the border.
struct AdhesionMap {
  std::vector<RailAdhesion> piece{RailAdhesion{}};
  std::vector<double> from{};  ///< where piece k + 1 begins, rising; one less than pieces
  double blend{0.0};           ///< [m] or [s]; 0: the friction jumps
  bool over_time{false};       ///< `from` are times

  /// @param place  distance along the rail [m], or time [s]
  template <Scalar T>
  T friction(T const& place, T const& slip_speed, T const& energy_per_area) const {
    auto const after = std::upper_bound(from.begin(), from.end(), value_of(place)) - from.begin();
    auto const k = static_cast<std::size_t>(after);
    T const here = piece[k].friction(slip_speed, energy_per_area);
    if (k == 0 || !(blend > 0.0)) return here;
    T const t = (place - from[k - 1]) / blend;
    if (value_of(t) >= 1.0) return here;
    T const before = piece[k - 1].friction(slip_speed, energy_per_area);
    return before + t * t * (3.0 - 2.0 * t) * (here - before);
  }
};

}  // namespace rig
