// contact/normal/strip_layout.hpp - where the strips of a region lie: places, interpenetration, curvature and normals.
//
//   interpenetration region -> samples along the profile -> [direction and places of the strips] -> strip problem
//
// In a region the wheel profile is sampled at equal distances along its arc. Every sample is a point of the gap's valley: the
// lowest gap on the wheel's circle. At yaw the valley runs obliquely across the rail, x and y move together, and the ellipse of
// equal gap is turned; the strips of a region lie along its mean principal direction, at equal distances eta across it. The
// interpenetration of a strip is the largest on its line, from the local quadratic of the gap at its sample; its curvature is
// that along the line. Without yaw a strip lies along rolling, at its sample. (S10)-(S13) of docs/theory/non_elliptic_contact.md.
// Strips cover what Hertz' solution for a parabola of the region's width and mean depth would load, and a little more. (S15)
// One region per lane, without a branch on a value.
#pragma once
#include "rollerrig/contact/normal/strip_problem.hpp"
#include "rollerrig/geometry/combined_curvature.hpp"
#include "rollerrig/geometry/lane_pair.hpp"

namespace rollerrig {

/// Regions side by side: what is known of them before they are solved.
template <class T>
struct RegionPack {
  using N = NumberOf<T>;
  LanePair<N> pair;
  RelativePose<T> pose;
  N compliance{1.0};  ///< Q/pi [1/Pa]
  struct End {
    N place{0.0}, low{0.0}, high{0.0};  ///< along the arc, its bracket [m]
    N is_root{1.0};                     ///< 1 or 0
  };
  std::array<End, 2> end;  ///< left, right
};

/// What each strip is besides the elastic problem.
template <class T>
struct StripPlaces {
  StripRow<T> wheel_s, rail_y;  ///< abscissae of its middle [m]
  StripRow<Vec3<T>> point,
      normal;                 ///< its middle on the roller [m]; the wheel's normal there, out of the roller: frame b
  StripRow<T> along, across;  ///< its middle in the axes of the region's strips [m]
  Twist<T> turn;              ///< direction of the strips: from the roller's circumference towards its left side
};

namespace strip_detail {

/// Within this part of the mean curvature a patch is so round that its principal directions say little [-].
inline constexpr double round_patch = 0.1;
/// Least curvature along a strip over that without twist: at large yaw a concave flange root may face the rail [-].
inline constexpr double least_curvature = 0.1;
/// Square of a strip's loaded length over that of its interpenetration: 1/2 in a round patch, up to 3/4 in a long one [-].
inline constexpr double loaded_rise = 0.6;
/// Part of the region's mean interpenetration below which no strip carries load [-].
inline constexpr double never_loaded = 0.1;

/// A point of the gap's valley. Axes c, m of geometry/combined_curvature.hpp.
template <class T>
struct Sample {
  T gap, slope;              ///< [m]; of the gap over the distance across [-]
  CurvatureTensor<T> wheel;  ///< [1/m]
  CurvatureTensor<T> both;   ///< D, half the sum of both bodies' [1/m]
  T abscissa, wheel_across;  ///< of the wheel's profile [m]; its k_2r [1/m]
  CurvePoint<T> profile;     ///< of the wheel there
  T straight;                ///< D along rolling without the twist [1/m]
  T x, y;                    ///< along and across from the wheel's first sample [m]
  T eta;                     ///< across the strips of its region [m]
  T rail_y;
  Twist<T> twist;
  T wheel_cosine, rail_cosine;  ///< 1 / sqrt(1 + r'^2), 1 / sqrt(1 + h'^2)
  Vec3<T> p, n, c, m;           ///< on the roller; axes; frame b
};

/// Place, gap and curvatures of the valley at one abscissa of the wheel, (S10).
template <class T>
void take_sample(RegionPack<T> const& r, LaneGap<T> const& here, Sample<T>& s) {
  auto const& line = here.line;
  auto const& rail = here.rail;
  auto const& kappa = r.pair.hertz_curvature();
  s.gap = select(here.found, here.gap, T(1e-3));
  s.rail_y = here.rail_y;
  T const norm2 = 1.0 + line.profile.slope * line.profile.slope;
  s.wheel_cosine = inverse_root(norm2);
  T const wheel_norm = norm2 * s.wheel_cosine;
  s.rail_cosine = inverse_root(T(1.0 + rail.slope * rail.slope));
  s.n = -line.n;
  T const lean = -line.n_radial;
  T const inverse_lean = -here.inverse_radial;
  s.slope = -(here.residual * lean * s.rail_cosine);
  s.twist = twist_of(s.n, r.pose.R.ey, wheel_norm, inverse_lean);
  T const wheel_along = s.wheel_cosine * reciprocal(line.radius);                              // (15)
  s.wheel_across = -(line.profile.second * s.wheel_cosine * s.wheel_cosine * s.wheel_cosine);  // (15)
  T const rail_along = kappa * s.rail_cosine * reciprocal(T(1.0 + kappa * rail.value));        // (15)
  T const rail_across = -(rail.second * s.rail_cosine * s.rail_cosine * s.rail_cosine);        // (15)
  s.profile = line.profile;
  s.wheel = curvature_tensor(wheel_along, s.wheel_across, s.twist);
  s.both = {0.5 * (s.wheel.along + rail_along), 0.5 * s.wheel.mixed, 0.5 * (s.wheel.across + rail_across)};
  s.straight = 0.5 * (wheel_along + rail_along);
  s.c = {s.n.z * inverse_lean, T(0.0), -(s.n.x * inverse_lean)};
  s.m = cross(s.n, s.c);
  s.p = line.p + here.gap * line.n;
}

/// Samples at equal distances along the arc, with their places: dy = (dl + sin(chi) dx) / cos(chi), (S10).
template <class T, std::size_t count>
void sample_row(RegionPack<T> const& r, T const& first, T const& step, std::array<Sample<T>, count>& samples) {
  std::array<T, count> abscissa;
  for (std::size_t k = 0; k < count; ++k)
    abscissa[k] = r.pair.arc_to_abscissa.value(T(first + static_cast<double>(k) * step));
  std::array<LaneGap<T>, count> gaps;
  gaps_along_normal(r.pair, r.pose, abscissa, gaps);
  for (std::size_t k = 0; k < count; ++k) {
    samples[k].abscissa = abscissa[k];
    take_sample(r, gaps[k], samples[k]);
  }
  samples[0].x = samples[0].y = T(0.0);
  for (std::size_t k = 1; k < count; ++k) {
    Sample<T>& s = samples[k];
    Sample<T> const& before = samples[k - 1];
    Twist<T> const chi{0.5 * (before.twist.sin + s.twist.sin), 0.5 * (before.twist.cos + s.twist.cos)};
    T const travel = dot(s.p - before.p, s.c);
    s.x = before.x + travel;
    s.y = before.y + (step + chi.sin * travel) * reciprocal(chi.cos);
  }
}

/// Of a region: direction of its strips, its mean depth and curvature along the strips.
template <class T>
struct MeanOverlap {
  Twist<T> direction;  ///< from the roller's circumference
  T depth;             ///< [m]
  T along;             ///< [1/m]
};

/// The strips lie along the principal direction of the mean curvature that is nearer to rolling, (S11).
template <class T, std::size_t count>
MeanOverlap<T> mean_overlap(std::array<Sample<T>, count> const& samples) {
  using std::sqrt;
  CurvatureTensor<T> mean{T(0.0), T(0.0), T(0.0)};
  T depth(0.0);
  for (std::size_t k = 0; k < count; ++k) {
    auto const& s = samples[k];
    T const d = (1.0 / count) * select(s.gap < 0.0, -s.gap, T(0.0));
    depth += d;
    mean = mean + d * s.both;
  }
  T const half = 0.5 * (mean.along - mean.across);
  T const round2 = square(T((0.5 * round_patch) * (mean.along + mean.across)));
  T const half2 = half * half;
  T const tan2 = mean.mixed * half * half2 / (half2 * half2 + round2 * round2 + 1e-60);
  T const cos2 = 1.0 / sqrt(1.0 + tan2 * tan2);
  T const cosine = sqrt(0.5 + 0.5 * cos2);
  Twist<T> const theta{0.5 * tan2 * cos2 / cosine, cosine};
  return {theta, depth, mean.on(theta.cos, theta.sin, theta.cos, theta.sin) / (depth + 1e-30)};
}

template <class T>
T curvature_along(Sample<T> const& s, Twist<T> const& theta) {
  T const along = s.both.on(theta.cos, theta.sin, theta.cos, theta.sin);
  T const least = least_curvature * s.straight;
  return select(along > least, along, least);
}

/// How far the ellipse of equal gap, which is turned, reaches across the strips beyond a point of the valley. (S12)
///
/// @param outward  slope of the gap towards the end [-]
template <class T>
T beyond(Sample<T> const& s, Twist<T> const& theta, T const& outward) {
  using std::sqrt;
  T const along = curvature_along(s, theta);
  T const across = s.both.on(-theta.sin, theta.cos, -theta.sin, theta.cos);
  T const sin2 = theta.sin * theta.sin;
  T const stretch2 = theta.cos * theta.cos + sin2 * select(across > 0.0, across, T(0.0)) / along;
  return select(outward > 0.0, outward, T(0.0)) * sin2 / (2.0 * along * (sqrt(stretch2) + theta.cos));
}

/// The samples' places across the strips; returned: where the row ends, half a step outside its first and last sample, and how
/// far the overlap reaches beyond that: left end, beyond it, right end, beyond it [m].
template <class T, std::size_t count>
std::array<T, 4> spread(std::array<Sample<T>, count>& samples, Twist<T> const& along) {
  for (auto& s : samples) s.eta = along.cos * s.y - along.sin * s.x;
  Sample<T> const &first = samples[0], &last = samples[count - 1];
  return {T(first.eta - 0.5 * (samples[1].eta - first.eta)), beyond(first, along, T(-first.slope)),
          T(last.eta + 0.5 * (last.eta - samples[count - 2].eta)), beyond(last, along, last.slope)};
}

/// The gap on the line of one strip, from a sample beside or on it: quadratic but for the wheel's profile, which is the true one,
/// because a long strip at large yaw crosses stretches of different curvature. (S13)
template <class T>
struct StripLine {
  T level, slope,
      curvature;  ///< gap [m], its slope [-] and half its second derivative [1/m], without the profile's bend
  T from_wheel, wheel_slope;  ///< wheel's arc at the line's start [m] and its rate along the line [-]

  /// @param s  its sample
  T at(LaneSpline<NumberOf<T>> const& profile, Sample<T> const& s, T const& along) const {
    T const ds = (from_wheel + wheel_slope * along) * s.wheel_cosine;
    T const bend = s.profile.value + s.profile.slope * ds - profile.value(T(s.abscissa + ds));
    return level + (slope + curvature * along) * along + bend * s.wheel_cosine;
  }
};

template <class T>
StripLine<T> strip_line(Sample<T> const& s, Twist<T> const& theta, T const& aside) {
  T const& sine = theta.sin;
  T const& cosine = theta.cos;
  // The wheel's meridian in the axes of the strip, and what is left of D without the bend of its profile.
  T const on_line = sine * s.twist.cos - cosine * s.twist.sin;
  T const beside = cosine * s.twist.cos + sine * s.twist.sin;
  T const bend = 0.5 * s.wheel_across;
  T const along = s.both.on(cosine, sine, cosine, sine) - bend * on_line * on_line;
  T const mixed = s.both.on(cosine, sine, -sine, cosine) - bend * on_line * beside;
  T const across = s.both.on(-sine, cosine, -sine, cosine) - bend * beside * beside;
  return {s.gap + (s.slope * cosine + across * aside) * aside, s.slope * sine + 2.0 * mixed * aside, along,
          beside * aside, on_line};
}

/// How far from `lowest` the gap on the line has risen by `rise`, about `step` away: as if it rose with the square.
template <class T>
T distance_to_rise(LaneSpline<NumberOf<T>> const& profile, Sample<T> const& s, StripLine<T> const& line,
                   T const& lowest, T const& depth, T const& rise, T const& step) {
  T const risen = line.at(profile, s, T(lowest + step)) + depth;
  T const least = 0.25 * rise;  // where the wheel bends away from a parabola by more, the strip is twice as long
  return step * rise * inverse_root(T(rise * select(risen > least, risen, least)));
}

/// The strips at equal distances eta across: of each, the parabola of its interpenetration through the places where a strip under
/// load ends. Step by step for all of them, as gaps_along_normal().
///
/// @param low      where the first strip begins [m]
/// @param shallow  interpenetration below which a strip never carries load [m]
template <class T>
void lay_row(RegionPack<T> const& r, std::array<Sample<T>, strip_count> const& samples, Twist<T> const& theta,
             T const& low, T const& shallow, Strips<T>& strips, StripPlaces<T>& places) {
  T const& sine = theta.sin;
  T const& cosine = theta.cos;
  auto const eta = [&](std::size_t i) { return T(low + (static_cast<double>(i) + 0.5) * strips.width); };
  StripRow<StripLine<T>> line;
  StripRow<T> lowest, depth, rise, half, front, back;
  for (std::size_t i = 0; i < strip_count; ++i) {
    auto const& s = samples[i];
    line[i] = strip_line(s, theta, T(eta(i) - s.eta));
    T const along = curvature_along(s, theta);
    lowest[i] = -(0.5 * line[i].slope * reciprocal(along));
    half[i] = along;
  }
  auto const& profile = *r.pair.wheel;
  for (std::size_t i = 0; i < strip_count; ++i) depth[i] = -line[i].at(profile, samples[i], lowest[i]);
  for (std::size_t i = 0; i < strip_count; ++i) {
    rise[i] = loaded_rise * select(depth[i] > shallow, depth[i], shallow);
    half[i] = rise[i] * inverse_root(T(rise[i] * half[i]));
    front[i] = distance_to_rise(profile, samples[i], line[i], lowest[i], depth[i], rise[i], half[i]);
    back[i] = distance_to_rise(profile, samples[i], line[i], lowest[i], depth[i], rise[i], T(-half[i]));
  }
  for (std::size_t i = 0; i < strip_count; ++i) {
    auto const& s = samples[i];
    T const ahead = lowest[i] + 0.5 * (front[i] + back[i]), aside = eta(i) - s.eta;
    T const length = 0.5 * (front[i] - back[i]);
    strips.interpenetration[i] = depth[i];
    strips.curvature[i] = rise[i] * reciprocal(T(length * length));
    places.along[i] = cosine * s.x + sine * s.y + ahead;
    places.across[i] = eta(i);
    T const u = cosine * ahead - sine * aside;
    T const v = sine * ahead + cosine * aside;
    places.wheel_s[i] = s.abscissa + (v * s.twist.cos - u * s.twist.sin) * s.wheel_cosine;
    places.rail_y[i] = s.rail_y + v * s.rail_cosine;
    places.point[i] = s.p + u * s.c + v * s.m;
    places.normal[i] =
        s.n - (s.wheel.along * u + s.wheel.mixed * v) * s.c - (s.wheel.mixed * u + s.wheel.across * v) * s.m;
  }
}

/// Slope of the gap outwards, from a point a little further inside [-].
template <class N>
N outward_rate(N const& gap, N const& inside, double probe) {
  N const rate = (gap - inside) * (1.0 / probe);
  return select(rate > 1e-6, rate, N(1e-6));
}

/// The ends of the regions as functions of the pose: Newton on the gap within the brackets, the last step in T.
template <class T>
std::array<T, 2> ends_of(RegionPack<T> const& r) {
  using N = NumberOf<T>;
  auto const pose = numbers_of(r.pose);
  constexpr double probe =
      1e-8;  // [m]: the slope's error from the gap's curvature and from its last digits are below 1e-4
  constexpr double outwards[] = {-1.0, 1.0};
  auto const abscissa = [&](auto const& place) { return r.pair.arc_to_abscissa.value(place); };
  std::array<N, 2> place, rate;
  std::array<N, 4> s;  // of both ends, then a little further inside
  std::array<LaneGap<N>, 4> gap;
  auto const look = [&] {
    for (std::size_t k = 0; k < 2; ++k) {
      s[k] = abscissa(place[k]);
      s[k + 2] = abscissa(N(place[k] - outwards[k] * probe));
    }
    gaps_along_normal(r.pair, pose, s, gap);
    for (std::size_t k = 0; k < 2; ++k) rate[k] = outward_rate(gap[k].gap, gap[k + 2].gap, probe);
  };
  for (std::size_t k = 0; k < 2; ++k) place[k] = r.end[k].place;
  look();
  for (std::size_t k = 0; k < 2; ++k) {
    auto const& end = r.end[k];
    N const next = clamped(N(place[k] - outwards[k] * gap[k].gap / rate[k]), end.low, end.high);
    place[k] = select(end.is_root > 0.5 && gap[k].found, next, place[k]);
  }
  // The last step moves by a nanometre with the slope that there is; derivatives need the one of the place itself.
  if constexpr (!std::same_as<T, N>) look();
  std::array<T, 2> ends, last_s;
  std::array<LaneGap<T>, 2> last;
  for (std::size_t k = 0; k < 2; ++k) last_s[k] = abscissa(T(place[k]));
  gaps_along_normal(r.pair, r.pose, last_s, last);
  for (std::size_t k = 0; k < 2; ++k) {
    auto const& end = r.end[k];
    T const next = place[k] - outwards[k] * last[k].gap / rate[k];
    auto const within = value_of(next) > end.low && value_of(next) < end.high;
    ends[k] = select(end.is_root > 0.5 && last[k].found && within, next, T(place[k]));
  }
  return ends;
}

}  // namespace strip_detail

/// Lays the strips of every region.
template <class T>
void lay_strips(StripTables const& tables, RegionPack<T> const& r, Strips<T>& strips, StripPlaces<T>& places) {
  using namespace strip_detail;
  using std::log;
  auto const [left, right] = ends_of(r);

  // A first row over the whole region: how the strips lie, and what of it carries load.
  std::array<Sample<T>, n> samples;
  T const first_step = (right - left) / static_cast<double>(n);
  sample_row(r, T(left + 0.5 * first_step), first_step, samples);
  auto const theta = mean_overlap(samples).direction;
  auto const whole = spread(samples, theta);
  strips.compliance = r.compliance;
  strips.width = (whole[2] - whole[0]) / static_cast<double>(n);
  T const stretch = 1.0 + (whole[1] + whole[3]) / (whole[2] - whole[0]);
  for (std::size_t k = 0; k < n; ++k) {
    strips.interpenetration[k] = -samples[k].gap;
    strips.curvature[k] = curvature_along(samples[k], theta);
  }
  auto const loaded = range_of_load(tables, stretch, strips);

  T const step = (1.0 / n) * (loaded.to - loaded.from) * first_step;
  sample_row(r, T(left + loaded.from * first_step + 0.5 * step), step, samples);
  auto const mean = mean_overlap(samples);
  auto const& turn = mean.direction;
  T const shallow = never_loaded * mean.depth;
  auto const ends = spread(samples, turn);
  T const low = ends[0] - ends[1];
  strips.width = (ends[2] + ends[3] - low) / static_cast<double>(n);
  places.turn = turn;
  lay_row(r, samples, turn, low, shallow, strips, places);
}

}  // namespace rollerrig
