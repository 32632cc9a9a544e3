// mechatronics/orifice.hpp - air through an orifice: choked up to a critical pressure ratio, subsonic beyond.
//
//   conductance, absolute pressures on both sides -> [orifice] -> flow
//
//     q = C p_1 phi(p_2/p_1),   phi = 1 up to b,   sqrt(1 - ((p_2/p_1 - b)/(1 - b))^2) beyond        (A12)
//
// q is a volume per time of air at the reference state (100 kPa, 20 degrees C), to which the air always returns: isothermal.
// Source  ISO 6358-1: sonic conductance C, critical pressure ratio b, and the straight line near equal pressures.
#pragma once
#include <cmath>

#include "rollerrig/scalar.hpp"

namespace rollerrig {

/// Sonic conductance C [m^3/(s Pa)] and b.
struct Orifice {
  double conductance{}, critical_ratio{};
};

/// Two orifices one behind the other as one, (A26).
inline Orifice in_series(Orifice const& one, Orifice const& other) {
  double const a = one.conductance, b = other.conductance, least = std::fmin(a, b);
  if (!(least > 0.0)) return {0.0, one.critical_ratio};
  double const both = least / std::cbrt(std::pow(least / a, 3.0) + std::pow(least / b, 3.0));
  auto const lost = [&](Orifice const& own) {
    return (1.0 - own.critical_ratio) * std::pow(both / own.conductance, 2.0);
  };
  return {both, std::fmax(0.0, 1.0 - lost(one) - lost(other))};
}

/// phi of (A12): flow over that of choked flow, 1 to 0.
///
/// @param ratio     absolute downstream over absolute upstream pressure; beyond 1 nothing flows
/// @param critical  b, of pneumatic valves 0.2 to 0.5
template <Scalar T>
T orifice_flow(T const& ratio, double critical) {
  using std::sqrt;
  constexpr double laminar = 0.999;  // from here on a straight line to 0: keeps the slope at equal pressures finite
  auto const subsonic = [&](T const& at) {
    T const part = (at - critical) / (1.0 - critical);
    return sqrt(1.0 - part * part);
  };
  T const begun = select(ratio > critical, ratio, T(critical));
  T const inside = subsonic(select(begun > laminar, T(laminar), begun));
  T const left = select(ratio < 1.0, 1.0 - ratio, T(0.0));
  return select(ratio > laminar, subsonic(T(laminar)) * left / (1.0 - laminar), inside);
}

}  // namespace rollerrig
