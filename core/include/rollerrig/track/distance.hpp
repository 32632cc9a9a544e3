// track/distance.hpp - how far along the line the vehicle's reference point is, and how fast.
#pragma once
#include "rollerrig/math/piecewise_linear.hpp"

namespace rollerrig {

/// Position and motion of the vehicle's reference point along the line.
template <Scalar T>
struct Travel {
  T s;             ///< arc length [m]
  T speed;         ///< V [m/s]
  T acceleration;  ///< dV/dt [m/s^2]
};

/// Travel with a speed given over time: s = start + integral of V from time 0 on, in closed form. (W1)
template <Scalar T>
Travel<T> travel_at(TimeTable const& speed, double start, T const& t) {
  double const now = value_of(t);
  double const acceleration = speed.rate(now);
  T const v = speed.at(t);
  T const since = t - now;  // zero, but for its derivative
  return {start + speed.integral(now) + value_of(v) * since, v, T(acceleration)};
}

}  // namespace rollerrig
