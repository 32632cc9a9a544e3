// contact/adhesion/friction.hpp - the friction of one contact, and what its surface leaves of the creep curve's stiffness.
//
// Source  friction over the inclination of the surface: as in CONTACT (E. A. H. Vollebregt, User guide for CONTACT, variable
//         friction), here with a continuous slope. docs/theory/contact_forces.md, (F6).
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <stdexcept>
#include <vector>

#include "rollerrig/fields.hpp"
#include "rollerrig/math/vector.hpp"
#include "rollerrig/scalar.hpp"

namespace rollerrig {

/// A rail's surface at one instant, as a creep law sees it.
template <Scalar T>
struct RailSurface {
  T friction;  ///< mu [-]
  T k_A;       ///< what is left of the creep curve's stiffness on the area of adhesion [-] ...
  T k_S;       ///< ... and on the area of slip [-], contact/creep/polach.hpp
};

/// What is left of the slope of the creep curve at the origin, (A4).
template <Scalar T>
T mean_reduction(RailSurface<T> const& rail) {
  return 0.5 * (rail.k_A + rail.k_S);
}

/// A surface of which a part `weight` is as `b`, the rest as `a`: forces add up, and so do stiffnesses.
template <Scalar T>
RailSurface<T> blended(RailSurface<T> const& a, RailSurface<T> const& b, T const& weight) {
  auto const between = [&](T const& from, T const& to) { return from + weight * (to - from); };
  return {between(a.friction, b.friction), between(a.k_A, b.k_A), between(a.k_S, b.k_S)};
}

/// The friction laws a configuration can name: friction over slip velocity.
///
/// To add a law: a struct with its name, its fields and `T operator()(T const& slip) const`, and its line in FrictionLaw.
///
/// Source  Polach, Creep forces in simulations of traction vehicles running on adhesion limit, Wear 258 (2005): (A1).
/// Coulomb's.
struct ConstantFriction {
  static constexpr char const* name = "constant";
  double mu_0{0.3};
  static constexpr auto fields() {
    return members(Member{"mu_0", &ConstantFriction::mu_0, "1", "friction coefficient", not_negative});
  }

  template <Scalar T>
  T operator()(T const& /*slip*/) const {
    return T(mu_0);
  }
};

/// Polach's, that falls with slip velocity w: mu(w) = mu_0 [(1 - A) exp(-B w) + A]   (A1)
struct FallingFriction {
  static constexpr char const* name = "falling";
  double mu_0{0.3}, A{1.0}, B{0.0};
  static constexpr auto fields() {
    return members(Member{"mu_0", &FallingFriction::mu_0, "1", "friction coefficient at no slip", not_negative},
                   Member{"A", &FallingFriction::A, "1", "friction at large slip over mu_0"},
                   Member{"B", &FallingFriction::B, "s/m", "rate at which friction falls with slip velocity"});
  }

  /// @param slip  slip velocity, not negative [m/s]
  template <Scalar T>
  T operator()(T const& slip) const {
    using std::exp;
    return mu_0 * ((1.0 - A) * exp(-B * slip) + A);
  }
};

using FrictionLaw = OneOf<ConstantFriction, FallingFriction>;

/// Friction coefficient at a slip velocity [m/s].
template <Scalar T>
T friction_at(FrictionLaw const& law, T const& slip) {
  return std::visit([&](auto const& chosen) { return chosen(slip); }, law);
}

/// How much friction a degraded rail offers, and how stiffly: over slip velocity, over the
/// energy that has been dissipated on it, and where or when.
///
///   arc length or time, slip velocity, dissipated energy density -> [adhesion map] -> surface -> creep law
///
/// One implementation for the contact of the 3-D track and for the virtual rail in the rig's controller.
/// Source  Polach, Wear 258 (2005): (A1);
///         Meacci, Rindi, Pugi et al., degraded adhesion with recovery by dissipated energy: (A2), (A3). Sand, (A19): ours.
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

/// How far a contact lies on the gauge face: 0 up to an angle of 20 degrees, 1 from 40 degrees on, smooth between, (F6).
///
/// @param n  outward normal of rail or roller, b components of the left side
template <Scalar T>
T share_of_gauge_face(Vec3<T> const& n) {
  using std::sqrt;
  constexpr double top = 0.3420201433256687, face = 0.6427876096865394;  // sin 20°, sin 40°
  T const x = (-n.y / sqrt(n.y * n.y + n.z * n.z) - top) * (1.0 / (face - top));
  T const within = select(x < T(0.0), T(0.0), select(x > T(1.0), T(1.0), x));
  return within * within * (3.0 - 2.0 * within);
}

/// One law for the whole run, or what a map says of arc length, time, slip and dissipated energy; another on the gauge face.
struct Friction {
  FrictionLaw law{};
  std::shared_ptr<AdhesionMap const> map{};  ///< in place of the law
  double gauge_face{-1.0};
  static constexpr auto fields() {
    return members(Member{"law", &Friction::law}, OptionalMember{"map", &Friction::map},
                   Member{"gauge_face", &Friction::gauge_face, "1",
                          "friction coefficient on the gauge face; -1: as on top of the rail"});
  }

  /// @param top  friction on top of the rail
  /// @param n    see share_of_gauge_face
  template <Scalar T>
  T where(T const& top, Vec3<T> const& n) const {
    return gauge_face < 0.0 ? top : top + share_of_gauge_face(n) * (gauge_face - top);
  }

  /// @param arc_length      along the rail [m]
  /// @param slip            slip velocity [m/s]
  /// @param energy_density  dissipated on this piece of rail, by the wheels ahead and by this one [J/m^2]
  /// @param sand            mass per length on it [kg/m]
  template <Scalar T>
  RailSurface<T> operator()(T const& time, T const& arc_length, T const& slip, double energy_density,
                            double sand) const {
    if (map) return (*map)(map->over_time ? time : arc_length, slip, T(energy_density), sand);
    return {friction_at(law, slip), T(1.0), T(1.0)};
  }
};

}  // namespace rollerrig
