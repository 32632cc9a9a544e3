// geometry/lane_pair.hpp - wheels on their rollers or rails side by side, one pair per lane.
//
//   pairs and poses, one per lane -> [LanePair] -> geometry/wheel_circle.hpp
#pragma once
#include "rollerrig/geometry/pair.hpp"
#include "rollerrig/math/lane.hpp"
#include "rollerrig/math/lane_spline.hpp"

namespace rollerrig {

/// WheelRollerPair, one per lane.
template <class N>
struct LanePair {
  LaneSpline<N> wheel_profile, rail_profile, arc_to_abscissa;
  LaneSpline<N> const* wheel{&wheel_profile};
  LaneSpline<N> const* rail{&rail_profile};
  N wheel_radius{}, tape_circle_y{}, rail_origin_y{}, curvature{}, seen_by_hertz{};

  LanePair() = default;
  LanePair(LanePair const&) = delete;
  LanePair& operator=(LanePair const&) = delete;

  N const& geometry_curvature() const { return curvature; }
  N const& hertz_curvature() const { return seen_by_hertz; }

  void set(int i, WheelRollerPair const& pair, UniformSpline const& abscissa_over_arc) {
    wheel_profile.set(i, *pair.wheel);
    rail_profile.set(i, *pair.rail);
    arc_to_abscissa.set(i, abscissa_over_arc);
    set_lane(wheel_radius, i, pair.wheel_radius);
    set_lane(tape_circle_y, i, pair.tape_circle_y);
    set_lane(rail_origin_y, i, pair.rail_origin_y);
    set_lane(curvature, i, pair.geometry_curvature());
    set_lane(seen_by_hertz, i, pair.hertz_curvature());
  }

  /// The same pair in all lanes.
  void set_all(WheelRollerPair const& pair, UniformSpline const& abscissa_over_arc) {
    wheel_profile.set_all(*pair.wheel);
    rail_profile.set_all(*pair.rail);
    arc_to_abscissa.set_all(abscissa_over_arc);
    wheel_radius = N(pair.wheel_radius), tape_circle_y = N(pair.tape_circle_y), rail_origin_y = N(pair.rail_origin_y);
    curvature = N(pair.geometry_curvature()), seen_by_hertz = N(pair.hertz_curvature());
  }
};

/// A pose into one lane.
template <class T, class One>
void set_lane(RelativePose<T>& pose, int i, RelativePose<One> const& one) {
  auto const put = [i](Vec3<T>& to, Vec3<One> const& from) {
    if constexpr (std::same_as<T, One>) {
      to = from;
    } else {
      set_lane(to.x, i, from.x);
      set_lane(to.y, i, from.y);
      set_lane(to.z, i, from.z);
    }
  };
  put(pose.o, one.o);
  put(pose.R.ex, one.R.ex);
  put(pose.R.ey, one.R.ey);
  put(pose.R.ez, one.R.ez);
}

/// The pose without derivatives.
template <class T>
RelativePose<NumberOf<T>> numbers_of(RelativePose<T> const& pose) {
  using N = NumberOf<T>;
  auto const plain = [](Vec3<T> const& v) { return Vec3<N>{value_of(v.x), value_of(v.y), value_of(v.z)}; };
  return {plain(pose.o), {plain(pose.R.ex), plain(pose.R.ey), plain(pose.R.ez)}};
}

template <class N>
using MaskOf = decltype(std::declval<N>() < std::declval<N>());

}  // namespace rollerrig
