#include "rollerrig/geometry/gap_minima.hpp"

#include "rollerrig/math/dual.hpp"

namespace rollerrig {
namespace {

using Along = Dual<1>;

/// Newton on F near the scan's place, halving where it leaves the bracket. That is the scan's, and as much wider as the surfaces are
/// apart: so far off may the scan have taken the foot on the other one.
///
/// @param falling  +1: F falls through its root, a minimum of the gap; -1: it rises, a maximum
/// @return         whether there is such a root
bool polish(WheelRollerPair const& pair, ArcLength const& arc, RelativePose<Along> const& pose, GapExtreme const& near,
            double falling, GapRoot& root) {
  constexpr int most_steps = 40;
  constexpr double last_step = 1e-9;  // from here on a step of Newton leaves round-off [m]
  if (!(near.low < near.high)) return false;
  double const margin = std::abs(near.gap);
  double low = arc.abscissa(near.low) - margin, high = arc.abscissa(near.high) + margin;
  double s = arc.abscissa(near.position);
  for (int i = 0; i < most_steps; ++i) {
    auto const at = reduce(pair, pose, Along::variable(s, 0));
    if (!at.rail_point.found) return false;
    double const residual = at.residual.value, gradient = at.residual.d[0];
    root = {s, gradient, at.gap.value};
    (falling * residual > 0.0 ? low : high) = s;
    double const next = s - residual / gradient;
    bool const regular = falling * gradient < 0.0;
    if (regular && std::abs(next - s) < last_step) {
      root.s = next;  // the gap is stationary there
      return true;
    }
    if (high - low < last_step) return false;
    s = regular && next >= low && next <= high ? next : 0.5 * (low + high);
  }
  return false;
}

}  // namespace

GapMinima find_minima(WheelRollerPair const& pair, GapNodes const& nodes, RelativePose<double> const& pose,
                      double reach) {
  GapScan const scan = scan_minima(pair, nodes, pose, reach);
  auto const at_rest = lift<Along>(pose);
  GapMinima out;
  GapRoot top{0.0, 1.0, -1.0};  // the highest since the minimum before
  for (int i = 0; i < scan.minima; ++i) {
    GapRoot root;
    if (polish(pair, nodes.arc(), at_rest, scan.minimum[at(i)], 1.0, root) && root.gap < reach) {
      if (out.count > 0) out.barrier[out.count - 1] = top;
      out.minimum[out.count++] = root;
      top.gap = -1.0;
    }
    if (i + 1 == scan.minima) break;
    GapExtreme const& rise = scan.rise[at(i)];
    GapRoot maximum;
    if (!polish(pair, nodes.arc(), at_rest, rise, -1.0, maximum))
      maximum = {nodes.arc().abscissa(rise.position), 1.0, 1.0};
    if (maximum.gap > top.gap) top = maximum;
  }
  return out;
}

}  // namespace rollerrig
