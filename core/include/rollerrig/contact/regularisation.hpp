// contact/regularisation.hpp - the small numbers that keep the contact's formulas differentiable and finite at rest, without
// load and without slip. Each is far below what it stands beside and far above the round-off of its square.
#pragma once
#include <cmath>

#include "rollerrig/scalar.hpp"

namespace rollerrig::regularisation {

constexpr double slip = 1e-10;      ///< [m/s]: 1e-8 of the slowest sliding that a contact resolves
constexpr double force = 1e-10;     ///< [N]: 1e-14 of a wheel load
constexpr double creepage = 1e-15;  ///< [-]: round-off of a creepage of 1
constexpr double demand = 1e-10;    ///< [-]: of a creepage in the unit that demands mu N
constexpr double spin = 1e-10;      ///< [1/m]: slower spin dissipates nothing that could be corrected
constexpr double adhesion = 1e-9;   ///< [N]: least mu N, of a patch without load or on a rail without friction
constexpr double approach = 1e-30;  ///< [m]: depth of a patch that is about to open, and its root is finite

/// Length of (x, y), with a slope of zero at the origin instead of none: sqrt(x^2 + y^2 + least^2).
template <Scalar T>
T length(T const& x, T const& y, double least) {
  using std::sqrt;
  return sqrt(x * x + y * y + least * least);
}

}  // namespace rollerrig::regularisation
