// geometry/gap_nodes.hpp - the gap at all nodes of a wheel at once, and from it every stretch where the surfaces overlap.
//
//   pose -> [gap of the wheel's circles at nodes along its arc, in lanes] -> interpenetration regions, extremes of the gap
//
// Nothing is searched for and nothing remembered: every node is looked at in every call, so that no patch can be missed and the
// result is a function of the pose alone. Gap and slope are exact at the nodes; where they allow the gap to vanish between two
// of them, a finer row is laid there, and again in that. Ends and extremes are good to some micrometres: strips polish them.
#pragma once
#include <array>
#include <vector>

#include "rollerrig/geometry/contact_point.hpp"
#include "rollerrig/geometry/pair.hpp"
#include "rollerrig/math/curves.hpp"

namespace rollerrig {

/// Both functions as cubic pieces with exact slopes, 0.1 mm each.
class ArcLength {
 public:
  explicit ArcLength(UniformSpline const& profile);
  template <Scalar T>
  T length(T const& abscissa) const {
    return length_.at(abscissa).value;
  }
  template <Scalar T>
  T abscissa(T const& length) const {
    return abscissa_.at(length).value;
  }
  UniformSpline const& abscissae() const { return abscissa_; }

 private:
  UniformSpline length_, abscissa_;
};

/// What nodes need of a wheel profile, whichever rail it stands on.
class GapNodes {
 public:
  static constexpr double node_distance = 1e-3;  ///< along the arc, of a full-scale wheel [m]
  static constexpr int capacity = 512;

  /// @param size  of the pair over full scale [-]
  GapNodes(UniformSpline const& wheel, double size);

  ArcLength const& arc() const { return arc_; }
  double step() const { return step_; }
  int count() const { return count_; }
  int first_from(double abscissa) const;

  /// Per node, filled up to a multiple of the lanes.
  std::vector<double> abscissa, height, slope, cosine;  ///< S [m], z(S) [m], z'(S), 1/sqrt(1 + z'^2)

 private:
  ArcLength arc_;
  double step_;
  int count_;
};

struct GapExtreme {
  double position{0.0};         ///< along the arc [m]
  double gap{0.0};              ///< [m]
  double low{0.0}, high{-1.0};  ///< it lies between [m]; low > high: it is no extreme, the gap ends there
};

/// Where the gap's sign changes, within a bracket, or where a profile ends.
struct RegionEnd {
  double position{0.0};              ///< along the arc [m]
  double inside{0.0}, outside{0.0};  ///< bracket [m]
  bool is_root{true};                ///< false: a profile ends there
};

struct InterpenetrationRegion {
  RegionEnd left, right;
  int first{0}, last{0};    ///< its minima, of GapScan::minimum
  double rise_before{1e9};  ///< highest gap between the region before it and this one [m]
};

inline constexpr int max_regions = 4;

struct GapScan {
  static constexpr int most_minima = 8;
  int regions{0}, minima{0};
  std::array<InterpenetrationRegion, max_regions> region;  ///< in order of the arc
  std::array<GapExtreme, most_minima> minimum;             ///< in all regions, in order of the arc
  std::array<GapExtreme, most_minima> rise;                ///< the highest point between minimum i and i + 1
};

/// All regions of a wheel; with more than max_regions those at the end are left out.
GapScan scan_gap(WheelRollerPair const& pair, GapNodes const& nodes, RelativePose<double> const& pose);

/// The same for all stretches where the gap is below `reach`, with every minimum in them, however near they are to each other.
GapScan scan_minima(WheelRollerPair const& pair, GapNodes const& nodes, RelativePose<double> const& pose, double reach);

/// Every minimum of the gap to round-off, the candidates for the paper's contact points: Newton on F of reduction.hpp. Where F falls
/// the gap has a minimum (the paper's curvature check), where it rises a maximum; a minimum with gap < 0 is a patch (indentation check).
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
