// contact/adhesion/adhesion_map.hpp - how much friction a degraded rail offers, and how stiffly: over slip velocity, over the
// energy that has been dissipated on it, and where or when.
//
//   arc length or time, slip velocity, dissipated energy density -> [adhesion map] -> surface -> creep law
//
// One implementation for the contact of the 3-D track and for the virtual rail in the rig's controller.
// Source  Polach, Wear 258 (2005): (A1);
//         Meacci, Rindi, Pugi et al., degraded adhesion with recovery by dissipated energy: (A2), (A3). Sand, (A19): ours.
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <vector>

#include "rollerrig/contact/adhesion/friction_laws.hpp"
#include "rollerrig/contact/adhesion/rail_surface.hpp"

namespace rollerrig {

/// What lies on a rail.
struct RailCondition {
  FrictionLaw friction{};
  double k_A{1.0}, k_S{1.0};
  static constexpr auto fields() {
    return members(Member{"friction", &RailCondition::friction},
                   Member{"k_A", &RailCondition::k_A, "1",
                          "stiffness of the creep curve on the area of adhesion; k_A = k_S = 1: clean", fraction},
                   Member{"k_S", &RailCondition::k_S, "1",
                          "stiffness of the creep curve on the area of slip, at most k_A", fraction});
  }

  template <Scalar T>
  RailSurface<T> at(T const& slip) const {
    return {friction_at(friction, slip), T(k_A), T(k_S)};
  }
};

/// A rail surface that recovers by the energy that sliding wheels dissipate on it.
///
///     mu = (1 - lambda) mu_degraded(w) + lambda mu_recovered(w),   lambda = 1 - exp(-tau W)   (A2), (A3)
///
/// and k_A, k_S likewise. W is the energy dissipated per unit of running surface [J/m^2]. Sand lies over both:
///
///     mu_s = (1 - sigma) mu + sigma mu_sanded(w),   sigma = 1 - exp(-q/q_0)                  (A19)
///
/// with q its mass per length of rail [kg/m].
struct RailAdhesion {
  RailCondition degraded{};
  RailCondition recovered{};
  double recovery_constant{0.0};
  RailCondition sanded{};
  double sand_constant{0.0};
  static constexpr auto fields() {
    return members(Member{"degraded", &RailAdhesion::degraded}, Member{"recovered", &RailAdhesion::recovered},
                   Member{"recovery_constant", &RailAdhesion::recovery_constant, "m^2/J",
                          "recovery by dissipated energy per area, tau; 0: none", not_negative},
                   Member{"sanded", &RailAdhesion::sanded},
                   Member{"sand_constant", &RailAdhesion::sand_constant, "m/kg",
                          "effect of sand by mass per length of rail, 1/q_0; 0: none", not_negative});
  }

  /// @param sand  mass per length on the rail [kg/m]
  template <Scalar T>
  RailSurface<T> at(T const& slip, T const& energy_density, double sand = 0.0) const {
    using std::exp;
    auto const bare = blended(recovered.at(slip), degraded.at(slip), exp(-recovery_constant * energy_density));
    if (!(sand > 0.0)) return bare;
    return blended(bare, sanded.at(slip), T(-std::expm1(-sand_constant * sand)));
  }
};

/// Which adhesion a rail has where, or when: pieces along the rail [m], or over time [s].
///
/// From one piece to the next the surface changes smoothly, t^2 (3 - 2 t), over `blend` behind the border.
struct AdhesionMap {
  std::vector<RailAdhesion> pieces{RailAdhesion{}};
  std::vector<double> borders{};
  double blend{0.0};
  bool over_time{false};  ///< borders are times
  static constexpr auto fields() {
    return members(
        Member{"pieces", &AdhesionMap::pieces},
        Member{"borders", &AdhesionMap::borders, "m or s", "begin of piece k + 1, ascending; one less than pieces"},
        Member{"blend", &AdhesionMap::blend, "m or s", "length of the transition behind a border; 0: a step",
               not_negative},
        Member{"over_time", &AdhesionMap::over_time});
  }

  void check() const {
    if (pieces.size() != borders.size() + 1) throw std::invalid_argument("adhesion map: one border less than pieces");
    if (std::adjacent_find(borders.begin(), borders.end(), std::greater_equal<>{}) != borders.end())
      throw std::invalid_argument("adhesion map: borders must increase");
  }

  /// @param at    arc length along the rail [m], or time [s]
  /// @param sand  mass per length on the rail [kg/m]
  template <Scalar T>
  RailSurface<T> operator()(T const& at, T const& slip, T const& energy_density, double sand = 0.0) const {
    auto const after = std::upper_bound(borders.begin(), borders.end(), value_of(at)) - borders.begin();
    auto const k = static_cast<std::size_t>(after);
    auto const here = pieces[k].at(slip, energy_density, sand);
    if (k == 0 || !(blend > 0.0)) return here;
    T const t = (at - borders[k - 1]) / blend;
    if (value_of(t) >= 1.0) return here;
    return blended(pieces[k - 1].at(slip, energy_density, sand), here, t * t * (3.0 - 2.0 * t));
  }
};

}  // namespace rollerrig
