// geometry/gap_minima.hpp - every minimum of the gap of one wheel, to round-off: the candidates for the paper's contact points.
//
//   pose -> [gap at the nodes along the wheel's arc: gap_nodes] -> [Newton on F of reduction.hpp] -> minima, and maxima between them
//
// Where F falls the gap has a minimum (the paper's curvature check), where it rises a maximum; a minimum with gap < 0 is a patch
// (indentation check). Nothing is kept from call to call.
#pragma once
#include "rollerrig/geometry/contact_point.hpp"
#include "rollerrig/geometry/gap_nodes.hpp"

namespace rollerrig {

struct GapMinima {
  static constexpr std::size_t capacity = GapScan::most_minima;
  std::size_t count{0};
  std::array<GapRoot, capacity> minimum;  ///< in order of s
  std::array<GapRoot, capacity> barrier;  ///< the maximum between minimum i and i + 1; between two regions an open gap
};

/// All minima with gap < reach [m]; with more than the capacity those at the end are left out.
GapMinima find_minima(WheelRollerPair const& pair, GapNodes const& nodes, RelativePose<double> const& pose,
                      double reach = 0.0);

}  // namespace rollerrig
