// geometry/interpenetration.hpp - the stretches of a wheel profile along which the undeformed surfaces overlap.
//
//   indented minima of the search -> [regions: where the gap along the wheel's normals is negative] -> strips
//
// The gap is that of the reduction: along the wheel's normal, in the plane of that normal and the roller's axis. So yaw and
// longitudinal offset are in it, and curved (conformal) stretches are followed along the profile.
#pragma once
#include <array>

#include "rollerrig/geometry/contact_point.hpp"
#include "rollerrig/geometry/search.hpp"

namespace rollerrig {

/// A stretch with negative gap; minima `first` to `last` of the search lie in it.
struct InterpenetrationRegion {
  double left{0.0}, right{0.0};                  ///< wheel abscissa of its ends [m]
  bool left_is_root{true}, right_is_root{true};  ///< false: a profile ends there
  int first{0}, last{0};
};

inline constexpr int max_regions = 3;

/// The regions in order of the abscissa. With more than max_regions, those with the lowest rise between them are joined.
int find_regions(WheelRollerPair const& pair, RelativePose<double> const& pose, ContactSearch const& search,
                 std::array<InterpenetrationRegion, max_regions>& regions);

/// An region's end as a function of the pose: the root of the gap, by the implicit function theorem.
template <Scalar T>
T region_end(WheelRollerPair const& pair, RelativePose<T> const& pose, double s, double gap_slope) {
  if constexpr (std::same_as<T, double>)
    return s;
  else
    return T(s) - reduce(pair, pose, T(s)).gap / gap_slope;
}

/// Arc length along a wheel profile and back.
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

 private:
  UniformSpline length_, abscissa_;
};

}  // namespace rollerrig
