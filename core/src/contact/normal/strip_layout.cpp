#include "rollerrig/contact/normal/strip_layout.hpp"

#include "rollerrig/contact/normal/strip_contact.hpp"

namespace rollerrig {
namespace {

constexpr int per_region = Strips<double>::per_region;
/// Within this part of the mean curvature a patch is so round that its principal directions say little [-].
constexpr double round_patch = 0.1;
/// Least curvature along a strip over that without twist: at large yaw a concave flange root may face the rail [-].
constexpr double least_curvature = 0.1;
/// Loaded half-width over that of the interpenetration, at most, of patches long enough for their turn to count [-].
constexpr double covered = 0.75;
/// Square of a strip's loaded length over that of its interpenetration: 1/2 in a round patch, up to 3/4 in a long one [-].
constexpr double loaded_rise = 0.6;
/// Part of the region's mean interpenetration below which no strip carries load [-].
constexpr double never_loaded = 0.1;

constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// A point of the gap's valley. Axes c, m of geometry/combined_curvature.hpp.
template <Scalar T>
struct Sample {
  bool found{false};
  T gap{1.0}, slope{0.0};                           ///< [m]; of the gap over the distance across [-]
  CurvatureTensor<T> wheel{};                       ///< [1/m]
  CurvatureTensor<T> both{T(1.0), T(0.0), T(1.0)};  ///< D, half the sum of both bodies' [1/m]
  T abscissa{0.0}, wheel_across{0.0};               ///< of the wheel's profile [m]; its k_2r [1/m]
  CurvePoint<T> profile{};                          ///< of the wheel there
  T straight{1.0};                                  ///< D along rolling without the twist [1/m]
  T x{0.0}, y{0.0};                                 ///< along and across from the wheel's first sample [m]
  T eta{0.0};                                       ///< across the strips of its region [m]
  Twist<T> twist{};
  T wheel_cosine{1.0}, rail_cosine{1.0};  ///< 1 / sqrt(1 + r'^2), 1 / sqrt(1 + h'^2)
  Vec3<T> p, n, c, m;                     ///< on the roller; axes; frame b
};

template <Scalar T>
using Samples = std::array<Sample<T>, at(per_region)>;

/// Place, gap and curvatures of the valley at one abscissa of the wheel, (S10).
template <Scalar T>
Sample<T> sample_at(WheelRollerPair const& pair, RelativePose<T> const& pose, Reduced<T> const& here) {
  using std::sqrt;
  auto const& line = here.line;
  auto const& rail = here.rail_point.rail;
  double const kappa = pair.hertz_curvature();
  Sample<T> s;
  s.found = true;
  s.gap = here.gap;
  T const wheel_norm = sqrt(1.0 + line.profile.slope * line.profile.slope);
  s.wheel_cosine = 1.0 / wheel_norm;
  s.rail_cosine = 1.0 / sqrt(1.0 + rail.slope * rail.slope);
  s.n = -line.n;
  T const lean = -line.n_radial;
  T const inverse_lean = 1.0 / lean;
  s.slope = -(here.residual * lean * s.rail_cosine);
  s.twist = twist_of(s.n, pose.R.ey, wheel_norm, inverse_lean);
  T const wheel_along = s.wheel_cosine / line.radius;                                               // (15)
  s.wheel_across = -(line.profile.second * s.wheel_cosine * s.wheel_cosine * s.wheel_cosine);       // (15)
  T const rail_along = kappa == 0.0 ? T(0.0) : kappa * s.rail_cosine / (1.0 + kappa * rail.value);  // (15)
  T const rail_across = -(rail.second * s.rail_cosine * s.rail_cosine * s.rail_cosine);             // (15)
  s.profile = line.profile;
  s.wheel = curvature_tensor(wheel_along, s.wheel_across, s.twist);
  s.both = {0.5 * (s.wheel.along + rail_along), 0.5 * s.wheel.mixed, 0.5 * (s.wheel.across + rail_across)};
  s.straight = 0.5 * (wheel_along + rail_along);
  s.c = {s.n.z * inverse_lean, T(0.0), -(s.n.x * inverse_lean)};
  s.m = cross(s.n, s.c);
  s.p = line.p + here.gap * line.n;
  return s;
}

/// Travel of the contact point from one sample to the next, along and across: dy = (dl + sin(chi) dx) / cos(chi), (S10).
template <Scalar T>
void place_after(Sample<T> const& before, T const& arc, Sample<T>& s) {
  s.x = before.x;
  s.y = before.y + arc;
  if (!s.found || !before.found) return;
  Twist<T> const chi{0.5 * (before.twist.sin + s.twist.sin), 0.5 * (before.twist.cos + s.twist.cos)};
  T const travel = dot(s.p - before.p, s.c);
  s.x += travel;
  s.y = before.y + (arc + chi.sin * travel) / chi.cos;
}

/// Of a region: direction of its strips and its mean depth.
template <Scalar T>
struct MeanOverlap {
  Twist<T> direction;  ///< from the roller's circumference
  T depth;             ///< [m]
};

/// The strips lie along the principal direction of the mean curvature that is nearer to rolling, (S11).
template <Scalar T>
MeanOverlap<T> mean_overlap(Samples<T> const& samples) {
  using std::sqrt;
  CurvatureTensor<T> mean{T(0.0), T(0.0), T(0.0)};
  T depth(0.0);
  for (auto const& s : samples) {
    T const d = select(s.gap < 0.0, -s.gap, T(0.0));
    depth += d;
    mean = mean + d * s.both;
  }
  T const half = 0.5 * (mean.along - mean.across);
  T const round2 = square((0.5 * round_patch) * (mean.along + mean.across));
  T const half2 = half * half;
  T const tan2 = mean.mixed * half * half2 / (half2 * half2 + round2 * round2);
  T const cos2 = 1.0 / sqrt(1.0 + tan2 * tan2);
  T const cosine = sqrt(0.5 + 0.5 * cos2);
  return {{0.5 * tan2 * cos2 / cosine, cosine}, (1.0 / per_region) * depth};
}

template <Scalar T>
T curvature_along(Sample<T> const& s, Twist<T> const& theta) {
  T const along = s.both.on(theta.cos, theta.sin, theta.cos, theta.sin);
  T const least = least_curvature * s.straight;
  return select(along > least, along, least);
}

/// How far the ellipse of equal gap, which is turned, reaches across the strips beyond the valley's end. (S12)
///
/// @param outward  slope of the gap towards the end [-]
template <Scalar T>
T beyond_end(Sample<T> const& s, Twist<T> const& theta, T const& outward) {
  using std::sqrt;
  T const along = curvature_along(s, theta);
  T const across = s.both.on(-theta.sin, theta.cos, -theta.sin, theta.cos);
  T const sin2 = theta.sin * theta.sin;
  T const stretch2 = theta.cos * theta.cos + sin2 * select(across > 0.0, across, T(0.0)) / along;
  return select(outward > 0.0, outward, T(0.0)) * sin2 / (2.0 * along * (sqrt(stretch2) + theta.cos));
}

/// The part of it that may carry load: strips without load are wasted.
///
/// @param half  half the distance of the valley's ends across the strips [m]
template <Scalar T>
T loaded_beyond(T const& beyond, T const& half) {
  T const missing = covered * (half + beyond) - half;
  return select(missing > 0.0, missing, T(0.0));
}

/// The gap on the line of one strip, from a sample beside or on it: quadratic but for the wheel's profile, which is the true one,
/// because a long strip at large yaw crosses stretches of different curvature. (S13)
template <Scalar T>
struct StripLine {
  UniformSpline const& profile;
  T abscissa;                 ///< of the sample on the wheel [m]
  CurvePoint<T> const& here;  ///< the profile there
  T level, slope,
      curvature;  ///< gap [m], its slope [-] and half its second derivative [1/m], without the profile's bend
  T from_wheel, wheel_slope;  ///< wheel's arc at the line's start [m] and its rate along the line [-]
  T wheel_cosine;             ///< 1 / sqrt(1 + r'^2)

  T at(T const& along) const {
    T const ds = (from_wheel + wheel_slope * along) * wheel_cosine;
    T const bend = here.value + here.slope * ds - profile.at(abscissa + ds).value;
    return level + (slope + curvature * along) * along + bend * wheel_cosine;
  }
};

template <Scalar T>
StripLine<T> strip_line(UniformSpline const& profile, Sample<T> const& s, Twist<T> const& theta, T const& aside) {
  T const& sine = theta.sin;
  T const& cosine = theta.cos;
  // The wheel's meridian in the axes of the strip, and what is left of D without the bend of its profile.
  T const on_line = sine * s.twist.cos - cosine * s.twist.sin;
  T const beside = cosine * s.twist.cos + sine * s.twist.sin;
  T const bend = 0.5 * s.wheel_across;
  T const along = s.both.on(cosine, sine, cosine, sine) - bend * on_line * on_line;
  T const mixed = s.both.on(cosine, sine, -sine, cosine) - bend * on_line * beside;
  T const across = s.both.on(-sine, cosine, -sine, cosine) - bend * beside * beside;
  return {profile,
          s.abscissa,
          s.profile,
          s.gap + (s.slope * cosine + across * aside) * aside,
          s.slope * sine + 2.0 * mixed * aside,
          along,
          beside * aside,
          on_line,
          s.wheel_cosine};
}

/// How far from `lowest` the gap on the line has risen by `rise`, about `step` away: as if it rose with the square.
template <Scalar T>
T distance_to_rise(StripLine<T> const& line, T const& lowest, T const& depth, T const& rise, T const& step) {
  using std::sqrt;
  T const risen = line.at(lowest + step) + depth;
  T const least = 0.25 * rise;  // where the wheel bends away from a parabola by more, the strip is twice as long
  return step * sqrt(rise / select(risen > least, risen, least));
}

/// One strip at eta across: the parabola of its interpenetration through the places where a strip under load ends.
///
/// @param shallow  interpenetration below which a strip never carries load [m]
template <Scalar T>
void lay_strip(UniformSpline const& profile, Sample<T> const& s, Twist<T> const& theta, T const& eta, T const& shallow,
               std::size_t i, Strips<T>& strips, StripPlaces<T>& places) {
  using std::sqrt;
  T const& sine = theta.sin;
  T const& cosine = theta.cos;
  T const aside = eta - s.eta;
  auto const line = strip_line(profile, s, theta, aside);
  T const along = curvature_along(s, theta);
  T const lowest = -(0.5 * line.slope / along);
  T const depth = -line.at(lowest);
  T const rise = loaded_rise * select(depth > shallow, depth, shallow);
  T const half = sqrt(rise / along);
  T const front = distance_to_rise(line, lowest, depth, rise, half);
  T const back = distance_to_rise(line, lowest, depth, rise, -half);
  T const ahead = lowest + 0.5 * (front + back);
  T const length = 0.5 * (front - back);
  strips.interpenetration[i] = depth;
  strips.curvature[i] = rise / (length * length);
  places.along[i] = cosine * s.x + sine * s.y + ahead;
  places.across[i] = eta;
  T const u = cosine * ahead - sine * aside;
  T const v = sine * ahead + cosine * aside;
  strips.position[i] = s.y + v;
  strips.offset[i] = s.x + u;
  places.wheel_s[i] = s.abscissa + (v * s.twist.cos - u * s.twist.sin) * s.wheel_cosine;
  places.rail_y[i] = places.rail_y[i] + v * s.rail_cosine;
  places.point[i] = s.p + u * s.c + v * s.m;
  places.normal[i] =
      s.n - (s.wheel.along * u + s.wheel.mixed * v) * s.c - (s.wheel.mixed * u + s.wheel.across * v) * s.m;
}

/// The end of a region's arc, with the derivatives it has as a root of the gap.
template <Scalar T>
T end_of(WheelRollerPair const& pair, RelativePose<T> const& pose, double s, bool is_root) {
  if constexpr (std::same_as<T, double>) return s;
  if (!is_root) return T(s);
  auto const constant = [](Vec3<T> const& v) { return lift<Dual<1>>({value_of(v.x), value_of(v.y), value_of(v.z)}); };
  RelativePose<Dual<1>> const fixed{constant(pose.o), {constant(pose.R.ex), constant(pose.R.ey), constant(pose.R.ez)}};
  return region_end(pair, pose, s, reduce(pair, fixed, Dual<1>::variable(s, 0)).gap.d[0]);
}

}  // namespace

template <Scalar T>
void lay_strips(NormalSetting const& wheel, RelativePose<T> const& pose,
                std::array<InterpenetrationRegion, max_regions> const& regions, int count, Strips<T>& strips,
                StripPlaces<T>& places) {
  strips.regions = count;
  ArcLength const& arc = *wheel.wheel_arc;
  Samples<T> samples;
  Sample<T> last;
  T last_length(0.0);
  for (int region = 0; region < count; ++region) {
    auto const& ends = regions[at(region)];
    T const left = arc.length(end_of(wheel.pair, pose, ends.left, ends.left_is_root));
    T const right = arc.length(end_of(wheel.pair, pose, ends.right, ends.right_is_root));
    T const step = (right - left) / static_cast<double>(per_region);
    for (int k = 0; k < per_region; ++k) {
      std::size_t const i = at(region * per_region + k);
      T const length = left + (k + 0.5) * step;
      places.wheel_s[i] = arc.abscissa(length);
      auto const here = reduce(wheel.pair, pose, places.wheel_s[i]);
      Sample<T>& s = samples[at(k)];
      s = here.rail_point.found ? sample_at(wheel.pair, pose, here) : Sample<T>{};
      places.rail_y[i] = here.rail_point.y;
      s.abscissa = places.wheel_s[i];
      if (i > 0) place_after(last, length - last_length, s);
      last = s;
      last_length = length;
    }
    auto const [theta, depth] = mean_overlap(samples);
    T const shallow = never_loaded * depth;
    for (auto& s : samples) s.eta = theta.cos * s.y - theta.sin * s.x;
    // Outermost samples lie half a step inside the region's ends.
    T low = samples[0].eta - 0.5 * (samples[1].eta - samples[0].eta);
    T high = samples[per_region - 1].eta + 0.5 * (samples[per_region - 1].eta - samples[per_region - 2].eta);
    T const half = 0.5 * (high - low);
    auto const no_more = [&](T const& x) { return select(x < half, x, half); };
    T const beyond_low = no_more(beyond_end(samples[0], theta, -samples[0].slope));
    T const beyond_high = no_more(beyond_end(samples[per_region - 1], theta, samples[per_region - 1].slope));
    T const overlap = high - low + beyond_low + beyond_high;
    low -= loaded_beyond(beyond_low, half);
    high += loaded_beyond(beyond_high, half);
    T const width = (high - low) / static_cast<double>(per_region);
    strips.reach[at(region)] = overlap / (high - low);
    strips.width[at(region)] = width;
    places.turn[at(region)] = theta;
    for (int k = 0; k < per_region; ++k)
      lay_strip(*wheel.pair.wheel, samples[at(k)], theta, low + (k + 0.5) * width, shallow, at(region * per_region + k),
                strips, places);
  }
}

template void lay_strips(NormalSetting const&, RelativePose<double> const&,
                         std::array<InterpenetrationRegion, max_regions> const&, int, Strips<double>&,
                         StripPlaces<double>&);
template void lay_strips(NormalSetting const&, RelativePose<StripDual> const&,
                         std::array<InterpenetrationRegion, max_regions> const&, int, Strips<StripDual>&,
                         StripPlaces<StripDual>&);

}  // namespace rollerrig
