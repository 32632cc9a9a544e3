// geometry/lane_pair.hpp - wheels on their rollers or rails side by side, one pair per lane: the gap along their normals.
//
//   pairs and poses, one per lane -> [gap at an abscissa of each wheel] -> interpenetration regions, strips
//
// The formulas are those of geometry/reduction.hpp. Where reduce() iterates until it has converged, the lanes take two Newton
// steps: enough where the surfaces overlap or nearly so, which is where strips lie; a test holds the two together.
#pragma once
#include "rollerrig/geometry/reduction.hpp"
#include "rollerrig/math/estimates.hpp"
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

/// What lies along the wheel's normal at one abscissa of each wheel.
template <class T>
struct LaneGap {
  WheelNormalLine<T> line;
  T gap;                      ///< [m]; negative: the surfaces overlap
  T residual;                 ///< F [-]
  T rail_y;                   ///< abscissa of the point on the generatrix [m]
  CurvePoint<T> rail;         ///< h, h', h'' there
  T inverse_radial;           ///< 1 / n_radial
  MaskOf<NumberOf<T>> found;  ///< whether the normal meets the generatrix
};

/// A row of places on each wheel. Step by step for all of them: one place is a long chain of operations that wait for each other,
/// several fill the time.
///
/// @param s  abscissae on each wheel [m]
template <class T, std::size_t count>
void gaps_along_normal(LanePair<NumberOf<T>> const& pair, RelativePose<T> const& pose, std::array<T, count> const& s,
                       std::array<LaneGap<T>, count>& gaps) {
  using N = NumberOf<T>;
  for (std::size_t k = 0; k < count; ++k) gaps[k].line = wheel_normal_line(pair, pose, s[k]);
  // Newton as in generatrix_point(). From the abscissa of the wheel's point: the first step leaves micrometres at most.
  std::array<N, count> y_1;
  for (std::size_t k = 0; k < count; ++k) {
    LaneGap<T>& out = gaps[k];
    auto const& line = out.line;
    N const n_u = value_of(line.n_radial), n_y = value_of(line.n.y), y_p = value_of(line.y);
    auto const first = pair.rail->piece(y_p).at(y_p);
    N const gradient = n_u - first.slope * n_y;
    out.found = gradient < -parallel_line;
    N const safe = select(out.found, gradient, N(-1.0));
    y_1[k] = y_p + (first.value - value_of(line.height)) * n_y * reciprocal(safe);
  }
  for (std::size_t k = 0; k < count; ++k) {
    LaneGap<T>& out = gaps[k];
    auto const& line = out.line;
    auto const piece = pair.rail->piece(y_1[k]);
    auto const h_1 = piece.at(T(y_1[k]));
    T const last_gradient = line.n_radial - h_1.slope * line.n.y;
    out.found = out.found && (value_of(last_gradient) < -parallel_line);
    T const inverse = reciprocal(select(out.found, last_gradient, T(-1.0)));
    T const step = ((y_1[k] - line.y) * line.n_radial - (h_1.value - line.height) * line.n.y) * inverse;
    out.rail_y = y_1[k] - step;
    out.rail = piece.at(out.rail_y);
    out.found = out.found && pair.rail->contains(value_of(out.rail_y));
    out.gap = -((line.y - out.rail_y) * line.n.y + (line.height - out.rail.value) * line.n_radial);
    out.inverse_radial = reciprocal(line.n_radial);
    out.residual = out.rail.slope + line.n.y * out.inverse_radial;
  }
}

/// @param s  abscissa on each wheel [m]
template <class T>
LaneGap<T> gap_along_normal(LanePair<NumberOf<T>> const& pair, RelativePose<T> const& pose, T const& s) {
  std::array<LaneGap<T>, 1> out;
  gaps_along_normal(pair, pose, std::array<T, 1>{s}, out);
  return out[0];
}

}  // namespace rollerrig
