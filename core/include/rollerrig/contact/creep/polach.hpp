// contact/creep/polach.hpp - Polach's creep force with spin: a closed form, for dry and for wet or contaminated rails.
//
// The force follows the slip at the leading edge where spin adds to lateral creepage; a second term is the force of spin alone.
// Polach gives no spin moment. Here it is Kalker's, saturated: docs/theory/creep_laws.md, (C10)-(C12).
//
// Source  Polach, A fast wheel-rail forces calculation computer code, Vehicle System Dynamics Supplement 33 (1999);
//         Polach, Creep forces in simulations of traction vehicles running on adhesion limit, Wear 258 (2005).
#pragma once
#include "rollerrig/contact/adhesion/friction.hpp"
#include "rollerrig/contact/creep/creep_query.hpp"
#include "rollerrig/fields.hpp"

namespace rollerrig {

/// @param k_A, k_S  what is left of the stiffness on the areas of adhesion and of slip [-]: numbers, or the rail's
template <Scalar T, class Factor>
CreepForce<T> polach_force(CreepQuery<T> const& query, Factor const& k_A, Factor const& k_S) {
  using regularisation::length;
  using std::atan2;
  using std::exp;
  using std::sqrt;
  auto const& e = query.creepage;
  auto const& f = query.stiffness;
  T const& a = query.a;
  T const spin = query.direction * e.spin;

  // Creepage with spin where it makes the lateral slip larger.
  T const edge = e.lateral + a * spin;
  T const lateral = select(edge * edge > e.lateral * e.lateral, edge, e.lateral);
  T const slip = length(e.longitudinal, lateral, regularisation::creepage);
  T const elastic = length(f.f11 * e.longitudinal, f.f22 * lateral, regularisation::force);
  T const gradient = 0.25 * pi * elastic / query.adhesion;
  T const stick = k_A * gradient;
  T const force = 2.0 / pi * query.adhesion * (stick / (1.0 + stick * stick) + atan2(k_S * gradient, T(1.0)));

  // Force of spin alone.
  T const spread = 1.0 + 6.3 * (1.0 - exp(-(a / query.b)));
  T const coupling = query.direction * f.f23 / a;  // G b sqrt(ab) C23
  T const spin_gradient = 8.0 / 3.0 * k_A * coupling * lateral / (query.adhesion * spread);
  T const g = sqrt(spin_gradient * spin_gradient + square(regularisation::creepage));
  T const delta = (g * g - 1.0) / (g * g + 1.0);
  T const root = 2.0 * g / (g * g + 1.0);  // sqrt(1 - delta^2)
  T const k_m = g * (delta * delta * delta / 3.0 - 0.5 * delta * delta + 1.0 / 6.0) - root * root * root / 3.0;
  T const spin_force = 9.0 / 16.0 * a * query.adhesion * k_m * spread;

  // Without spin term the pull is along the slip (e_x, e_y): s_y, not the creepage at the edge, gives its share.
  T const along = force / slip;
  auto const linear = linear_creep_force(e, f);
  T const tau = demand(linear, query.adhesion);
  T const tx = -(along * e.longitudinal);
  T const ty = -(along * e.lateral) + spin_force * spin / slip;
  T const friction_spin = f.f33 * e.spin / friction_moment(query);
  T const plain = (square(f.f11 * e.longitudinal) + square(f.f22 * e.lateral)) / square(query.adhesion);
  T const epsilon = johnson_vermeulen(sqrt(plain + friction_spin * friction_spin + square(regularisation::creepage)));
  T const moment = epsilon * (epsilon * epsilon * f.f23 * e.lateral - f.f33 * e.spin);
  return never_drives(query, CreepForce<T>{tx, ty, moment, saturation(tx, ty, tau * query.adhesion)});
}

struct Polach {
  static constexpr char const* name = "polach";
  static constexpr bool in_lanes = true;
  double k_A{1.0}, k_S{1.0};
  static constexpr auto fields() {
    return members(
        Member{"k_A", &Polach::k_A, "1", "stiffness on the area of adhesion; k_A = k_S = 1: clean", fraction},
        Member{"k_S", &Polach::k_S, "1", "stiffness on the area of slip, at most k_A", fraction});
  }

  template <Scalar T>
  CreepForce<T> operator()(CreepQuery<T> const& query) const {
    return polach_force(query, k_A, k_S);
  }
  template <Scalar T>
  CreepForce<T> operator()(CreepQuery<T> const& query, RailSurface<T> const& rail) const {
    return polach_force(query, rail.k_A, rail.k_S);
  }
};

}  // namespace rollerrig
