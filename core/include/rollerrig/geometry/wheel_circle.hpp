// geometry/wheel_circle.hpp - the lowest point of each circle of a wheel over its roller or rail, and the gap there.
//
//   circle of the wheel (one abscissa of its profile), pose -> [lowest point] -> gap, its slope along the profile, normal
//
// Two surfaces overlap on a circle exactly where its lowest point is below the other surface: the set of such circles is the
// set of all overlaps, whatever the profiles and the yaw. Along a circle both surfaces are convex, so that there is one lowest
// point; Newton finds it from where the wheel's normal meets the roller's axis, (7), which it is without yaw.
// Frame b, left wheel. One wheel per lane, or one place of a wheel per lane.
#pragma once
#include "rollerrig/geometry/pair.hpp"
#include "rollerrig/math/dual.hpp"
#include "rollerrig/math/lane.hpp"
#include "rollerrig/math/lane_spline.hpp"

namespace rollerrig {

/// WheelRollerPair, one per lane.
template <class N>
struct LanePair {
  LaneSpline<N> wheel_profile, rail_profile, arc_to_abscissa;
  LaneSpline<N> const* wheel{&wheel_profile};
  LaneSpline<N> const* rail{&rail_profile};
  N wheel_radius{}, tape_circle_y{}, rail_origin_y{}, curvature{}, hertz_curvature{};

  LanePair() = default;
  LanePair(LanePair const&) = delete;
  LanePair& operator=(LanePair const&) = delete;

  N const& geometry_curvature() const { return curvature; }
  N const& curvature_for_hertz() const { return hertz_curvature; }

  void set(int i, WheelRollerPair const& pair, UniformSpline const& abscissa_over_arc) {
    wheel_profile.set(i, *pair.wheel);
    rail_profile.set(i, *pair.rail);
    arc_to_abscissa.set(i, abscissa_over_arc);
    set_lane(wheel_radius, i, pair.wheel_radius);
    set_lane(tape_circle_y, i, pair.tape_circle_y);
    set_lane(rail_origin_y, i, pair.rail_origin_y);
    set_lane(curvature, i, pair.geometry_curvature());
    set_lane(hertz_curvature, i, pair.curvature_for_hertz());
  }

  void set_all(WheelRollerPair const& pair, UniformSpline const& abscissa_over_arc) {
    wheel_profile.set_all(*pair.wheel);
    rail_profile.set_all(*pair.rail);
    arc_to_abscissa.set_all(abscissa_over_arc);
    wheel_radius = N(pair.wheel_radius), tape_circle_y = N(pair.tape_circle_y), rail_origin_y = N(pair.rail_origin_y);
    curvature = N(pair.geometry_curvature()), hertz_curvature = N(pair.curvature_for_hertz());
  }
};

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

template <class T>
RelativePose<NumberOf<T>> numbers_of(RelativePose<T> const& pose) {
  using N = NumberOf<T>;
  auto const plain = [](Vec3<T> const& v) { return Vec3<N>{value_of(v.x), value_of(v.y), value_of(v.z)}; };
  return {plain(pose.o), {plain(pose.R.ex), plain(pose.R.ey), plain(pose.R.ez)}};
}

template <class N>
using MaskOf = decltype(std::declval<N>() < std::declval<N>());

template <class T>
struct WheelCircle {
  T radius;         ///< [m]
  T slope, cosine;  ///< z' of the profile [-], 1/sqrt(1 + z'^2)
  Vec3<T> centre;   ///< on the wheelset's axis [m]
};

/// A point of a circle over the other surface.
template <class T>
struct CirclePoint {
  T gap;                      ///< along the other surface's normal [m]; negative: the surfaces overlap
  T slope;                    ///< of the gap along the profile's arc [-]
  T tilt;                     ///< of the gap along the circle; zero at the lowest point [-]
  T curvature;                ///< half the second derivative of the gap along the circle [1/m]
  Vec3<T> p, n;               ///< point of the other surface [m] and its normal, out of the roller
  Vec3<T> u;                  ///< direction of the circle
  T rail_y;                   ///< abscissa of p on the generatrix [m]
  MaskOf<NumberOf<T>> found;  ///< whether there is a generatrix under it and at p
};

/// Least curvature along a circle over that of the wheel alone, for hollow rails [-].
inline constexpr double least_circle_curvature = 0.2;
/// Farthest step of the search along the circle, over its radius [-].
inline constexpr double farthest_turn = 0.06;

template <class T>
WheelCircle<T> wheel_circle(LanePair<NumberOf<T>> const& pair, RelativePose<T> const& pose, T const& s) {
  auto const profile = pair.wheel->at(s);
  return {pair.wheel_radius + profile.value, profile.slope, inverse_root(T(1.0 + profile.slope * profile.slope)),
          pose.o + T(pair.tape_circle_y + s) * pose.R.ey};
}

/// Where the wheel's normal meets the roller's axis: sine and cosine of the angle of eq. (7), (G1).
template <class N, class Pair>
[[gnu::always_inline]] inline std::array<N, 2> facing_angle(Pair const& pair, RelativePose<N> const& pose,
                                                            WheelCircle<N> const& c) {
  auto const kappa = pair.geometry_curvature();
  N const reach = c.radius * c.slope;
  N const ax = kappa * (c.centre.x + reach * pose.R.ey.x);
  N const az = 1.0 + kappa * (c.centre.z + reach * pose.R.ey.z);
  N const inverse = inverse_root(N(ax * ax + az * az));
  Vec3<N> const w = pose.R.transposed_times(Vec3<N>{az * inverse, N(0.0), -(ax * inverse)});
  N const lean = c.slope * w.y;
  N const rho2 = w.x * w.x + w.z * w.z;
  N const left = rho2 - lean * lean;
  N const root = left * inverse_root(select(left > 1e-6, left, N(1e-6)));
  N const scale = reciprocal(rho2);
  return {(lean * w.x + w.z * root) * scale, (w.x * root - lean * w.z) * scale};
}

/// The generatrix, and beyond its ends the tangent: a search that starts or passes there comes back, none ends there.
template <class N, class T>
[[gnu::always_inline]] inline CurvePoint<T> generatrix_at(LaneSpline<N> const& rail, T const& y) {
  auto const before = y<rail.start, behind = y> rail.end();
  T const nearest = select(before, T(rail.start), select(behind, T(rail.end()), y));
  auto out = rail.at(nearest);
  out.value += out.slope * (y - nearest);
  out.second = select(before || behind, T(0.0), out.second);
  return out;
}

/// Gap, slopes and curvature at an angle of the circle. The foot on the generatrix by its osculating circle at the height of
/// the wheel's point: exact to the third order of the gap.
template <class T, class Pair>
[[gnu::always_inline]] inline CirclePoint<T> circle_point(Pair const& pair, RelativePose<T> const& pose,
                                                          WheelCircle<T> const& c, T const& sine, T const& cosine) {
  auto const kappa = pair.geometry_curvature();
  CirclePoint<T> out;
  Vec3<T> const outwards = sine * pose.R.ex - cosine * pose.R.ez;
  Vec3<T> const place = c.centre + c.radius * outwards;
  out.u = cosine * pose.R.ex + sine * pose.R.ez;

  // The meridian plane of the roller through that point: height over the crown, radial direction (ux, 0, uz).
  T const px = kappa * place.x, pz = 1.0 + kappa * place.z;
  T const inverse_radius = inverse_root(T(px * px + pz * pz));
  T const ux = px * inverse_radius, uz = pz * inverse_radius;
  T const length = (px * px + pz * pz) * inverse_radius;
  T const height = (kappa * (place.x * place.x + place.z * place.z) + 2.0 * place.z) * reciprocal(T(length + 1.0));

  T const y = place.y - pair.rail_origin_y;
  auto const rail = generatrix_at(*pair.rail, y);
  T const rail_cosine = inverse_root(T(1.0 + rail.slope * rail.slope));
  T const rail_sine = rail.slope * rail_cosine;
  T const across = -(rail.second * rail_cosine * rail_cosine * rail_cosine);  // (15)
  T const above = height - rail.value;
  T const rise = above * rail_cosine, aside = above * rail_sine;
  T const shrink = 1.0 + across * rise;
  T const inverse_shrink = reciprocal(select(shrink > 0.5, shrink, T(0.5)));
  T const foot = aside * inverse_shrink, turn = across * foot;
  out.gap = rise + 0.5 * turn * aside;
  out.rail_y = y + rail_cosine * foot;
  T const straight = 1.0 - 0.5 * turn * turn;
  T const axial = turn * rail_cosine - straight * rail_sine, radial = turn * rail_sine + straight * rail_cosine;
  out.n = {radial * ux, axial, radial * uz};
  out.p = place - out.gap * out.n;
  out.found = pair.rail->contains(value_of(y)) && pair.rail->contains(value_of(out.rail_y));

  out.tilt = dot(out.n, out.u);
  out.slope = (dot(out.n, pose.R.ey) + c.slope * dot(out.n, outwards)) * c.cosine;
  // Along the circle the wheel rises towards its axis; the other surface falls by its curvatures (15) in that direction.
  T const wheel = -(dot(out.n, outwards) * reciprocal(c.radius));
  T const u_along = out.u.x * uz - out.u.z * ux;
  T const u_across = out.u.y * radial - (out.u.x * ux + out.u.z * uz) * axial;
  auto const& bent = pair.curvature_for_hertz();
  T const rail_along = bent * rail_cosine * reciprocal(T(1.0 + bent * rail.value));
  T const both = 0.5 * (wheel + rail_along * u_along * u_along + across * inverse_shrink * u_across * u_across);
  T const least = 0.5 * least_circle_curvature * wheel;
  out.curvature = select(both > least, both, least);
  return out;
}

/// Turns the angle by a step along the circle over its radius.
template <class T>
[[gnu::always_inline]] inline void turn_by(T const& step, T& sine, T& cosine) {
  T const square = step * step;
  T const s = step * (1.0 - square * (1.0 / 6.0) * (1.0 - 0.05 * square));
  T const c = 1.0 - 0.5 * square * (1.0 - square * (1.0 / 12.0) * (1.0 - square * (1.0 / 30.0)));
  T const old = sine;
  sine = old * c + cosine * s;
  cosine = cosine * c - old * s;
}

/// One step of Newton towards the lowest point.
template <class T>
[[gnu::always_inline]] inline T towards_lowest(CirclePoint<T> const& at, WheelCircle<T> const& c) {
  T const step = -0.5 * (at.tilt * reciprocal(T(at.curvature * c.radius)));
  T const short_of = select(step > -farthest_turn, step, T(-farthest_turn));
  return select(short_of < farthest_turn, short_of, T(farthest_turn));
}

/// The lowest points of several circles. Step by step for all of them: one place is a long chain of operations that wait for
/// each other, several fill the time.
template <class T, class Pair, std::size_t count>
void lowest_points(Pair const& pair, RelativePose<T> const& pose, std::array<WheelCircle<T>, count> const& circles,
                   std::array<CirclePoint<T>, count>& points) {
  using N = NumberOf<T>;
  auto const numbers = numbers_of(pose);
  std::array<WheelCircle<N>, count> circle;
  std::array<CirclePoint<N>, count> point;
  std::array<std::array<N, 2>, count> angle;  // sine and cosine
  for (std::size_t k = 0; k < count; ++k) {
    auto const& c = circles[k];
    circle[k] = {value_of(c.radius),
                 value_of(c.slope),
                 value_of(c.cosine),
                 {value_of(c.centre.x), value_of(c.centre.y), value_of(c.centre.z)}};
    angle[k] = facing_angle(pair, numbers, circle[k]);
  }
  constexpr int most_steps = 7;
  constexpr double level = 1e-12;  // of tilt
  auto const tilt_of = [&](std::size_t k) { return select(point[k].tilt < 0.0, N(-point[k].tilt), point[k].tilt); };
  for (int step = 0; step < most_steps; ++step) {
    N steepest(0.0);
    for (std::size_t k = 0; k < count; ++k) {
      if (step > 0) {  // a wheel that is level stays, whatever the others do
        N const turn = towards_lowest(point[k], circle[k]);
        turn_by(select(tilt_of(k) > level, turn, N(0.0)), angle[k][0], angle[k][1]);
      }
      point[k] = circle_point(pair, numbers, circle[k], angle[k][0], angle[k][1]);
      // A circle whose first point is beyond the profile's end may have its lowest one on it.
      steepest = select(tilt_of(k) > steepest, tilt_of(k), steepest);
    }
    if (!any(steepest > level)) break;
  }
  for (std::size_t k = 0; k < count; ++k) {
    if constexpr (std::same_as<T, N>) {
      points[k] = point[k];
    } else {  // derivatives of the angle, by the implicit function theorem
      T sine(angle[k][0]), cosine(angle[k][1]);
      using Turn = Dual<1>;
      Turn turned_sine(angle[k][0]), turned_cosine(angle[k][1]);
      turn_by(Turn::variable(0.0, 0), turned_sine, turned_cosine);
      double const rate = circle_point<Turn>(pair, lift<Turn>(numbers),
                                             {Turn(circle[k].radius), Turn(circle[k].slope), Turn(circle[k].cosine),
                                              lift<Turn>(circle[k].centre)},
                                             turned_sine, turned_cosine)
                              .tilt.d[0];
      T const tilt = circle_point(pair, pose, circles[k], sine, cosine).tilt;
      turn_by(T((value_of(tilt) - tilt) / rate), sine, cosine);
      points[k] = circle_point(pair, pose, circles[k], sine, cosine);
    }
  }
}

/// The same at abscissae of the wheels [m].
template <class T, std::size_t count>
void lowest_points(LanePair<NumberOf<T>> const& pair, RelativePose<T> const& pose, std::array<T, count> const& s,
                   std::array<CirclePoint<T>, count>& points) {
  std::array<WheelCircle<T>, count> circles;
  for (std::size_t k = 0; k < count; ++k) circles[k] = wheel_circle(pair, pose, s[k]);
  lowest_points(pair, pose, circles, points);
}

}  // namespace rollerrig
