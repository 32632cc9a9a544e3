// contact/normal/strip_layout.hpp - where the strips of a wheel lie: places, interpenetration, curvature and normals.
//
//   interpenetration regions -> samples along the profile -> [direction and places of the strips] -> strip problem
//
// In a region the wheel profile is sampled at equal distances along its arc. Every sample is a point of the gap's valley: the
// lowest gap on the wheel's circle. At yaw the valley runs obliquely across the rail, x and y move together, and the ellipse of
// equal gap is turned; the strips of a region lie along its mean principal direction, at equal distances eta across it. The
// interpenetration of a strip is the largest on its line, from the local quadratic of the gap at its sample; its curvature is
// that along the line. Without yaw a strip lies along rolling, at its sample. (S10)-(S13) of docs/theory/non_elliptic_contact.md.
#pragma once
#include <array>

#include "rollerrig/contact/normal/normal_patch.hpp"
#include "rollerrig/contact/normal/strip_problem.hpp"
#include "rollerrig/geometry/interpenetration.hpp"

namespace rollerrig {

/// What each strip is besides the elastic problem. Of strips that miss the generatrix only wheel_s is known.
template <Scalar T>
struct StripPlaces {
  template <class V>
  using Each = std::array<V, Strips<T>::capacity>;
  template <class V>
  using Region = std::array<V, max_regions>;

  Each<T> wheel_s, rail_y;      ///< abscissae of its middle [m]
  Each<Vec3<T>> point, normal;  ///< its middle on the roller [m]; the wheel's normal there, out of the roller: frame b
  Each<T> along, across;        ///< its middle in the axes of the region's strips [m]
  Region<Twist<T>> turn;        ///< direction of the strips: from the roller's circumference towards its left side
};

/// Lays the strips of one wheel. T: double or StripDual.
template <Scalar T>
void lay_strips(NormalSetting const& wheel, RelativePose<T> const& pose,
                std::array<InterpenetrationRegion, max_regions> const& regions, int count, Strips<T>& strips,
                StripPlaces<T>& places);

}  // namespace rollerrig
