// contact/adhesion/rail_surface.hpp - a rail's surface at one instant, as a creep law sees it.
#pragma once
#include "rollerrig/scalar.hpp"

namespace rollerrig {

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

}  // namespace rollerrig
