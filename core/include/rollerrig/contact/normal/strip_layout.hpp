// contact/normal/strip_layout.hpp - where the strips of a region lie: places, interpenetration, curvature and normals.
//
//   interpenetration region -> lowest points of the wheel's circles -> [strips, where the gap bends] -> strip problem
//
// A strip lies along a circle of the wheel, with its middle at the circle's lowest point over the other surface: its
// interpenetration, curvature, place and normals are those of the surfaces there, at any yaw, and nothing is extrapolated.
// Strips are as narrow as the gap is bent and as it is deep: a first row of circles at equal distances gives both. (S13)
// What turns the patch against the circles is the line of the lowest points: (S11), contact/normal/oblique_ellipse.hpp.
// One region per lane, without a branch on a value.
#pragma once
#include "rollerrig/contact/normal/strip_problem.hpp"
#include "rollerrig/geometry/wheel_circle.hpp"

namespace rollerrig {

/// Regions side by side: what is known of them before they are solved.
template <class T>
struct RegionPack {
  using N = NumberOf<T>;
  LanePair<N> pair;
  RelativePose<T> pose;
  N compliance{1.0};  ///< Q/pi [1/Pa]
  struct End {
    T place{0.0};           ///< along the arc [m] ...
    N low{0.0}, high{0.0};  ///< ... and, where it is a root of the gap, its bracket
    N is_root{1.0};         ///< 1 or 0
  };
  std::array<End, 2> end;  ///< left, right
};

/// What each strip is besides the elastic problem.
template <class T, std::size_t n = strip_count>
struct StripPlaces {
  StripRow<T, n> wheel_s, rail_y;  ///< abscissae of its middle [m]
  StripRow<Vec3<T>, n> point,
      normal;             ///< its middle on the roller [m]; the normal there, out of the roller: frame b
  StripRow<T, n> along;   ///< its middle along the wheel's circumference [m] ...
  StripRow<T, n> shift;   ///< ... and of that what (S12) moved it from the lowest point [m]
  StripRow<T, n> inside;  ///< how far the region's ellipse speaks for it, 0 to 1
  T turn_sin, turn_cos;   ///< direction of the strips: from the roller's circumference towards its left side
};

namespace strip_detail {

/// What a place of no interpenetration adds to the density of strips, as a share of the mean interpenetration [-].
inline constexpr double shallow_share = 0.05;
/// What a gap that does not bend adds to it, as a share of the mean bend [-].
inline constexpr double straight_share = 0.1;

/// Edges of strips from depths and slopes of the gap at equal distances over the region, as parts of it, 0 to 1: each strip
/// takes the same share of a density that is linear between those places.
template <class T, std::size_t m, std::size_t n>
void grade(StripRow<T, m> const& gap, StripRow<T, m> const& slope, std::array<T, n + 1>& edge) {
  using std::sqrt;
  // Bend of the gap between two places, and its mean; depth over the deepest.
  std::array<T, m + 1> bend;
  T sum(1e-30), depth2(1e-60), depth1(1e-30);
  for (std::size_t k = 1; k < m; ++k) {
    T const change = slope[k] - slope[k - 1];
    bend[k] = change * change;
    sum += bend[k];
  }
  bend[0] = bend[1], bend[m] = bend[m - 1];
  std::array<T, m> depth, density;
  for (std::size_t k = 0; k < m; ++k) {
    depth[k] = select(gap[k] < 0.0, -gap[k], T(0.0));
    depth1 += depth[k];
    depth2 += depth[k] * depth[k];
  }
  T const inverse_bend = (m - 1.0) / sum, inverse_depth = depth1 / depth2;
  for (std::size_t k = 0; k < m; ++k) {
    T const local = 0.5 * (bend[k] + bend[k + 1]) * inverse_bend;
    density[k] =
        sqrt(T(shallow_share + depth[k] * inverse_depth)) * sqrt(sqrt(straight_share * straight_share + local));
  }
  // Its integral to the middle of every place, in places.
  std::array<T, m + 1> before;
  before[0] = 0.5 * density[0];
  for (std::size_t k = 1; k < m; ++k) before[k] = before[k - 1] + 0.5 * (density[k - 1] + density[k]);
  T const total = before[m - 1] + 0.5 * density[m - 1];
  edge[0] = T(0.0), edge[n] = T(1.0);
  for (std::size_t i = 1; i < n; ++i) {
    T const share = (static_cast<double>(i) / n) * total;
    // The piece that it falls into: constant before the first place and behind the last.
    T begin(0.0), from = density[0], to = density[0], taken(0.0);
    for (std::size_t k = 0; k < m; ++k) {
      auto const behind = share > before[k];
      begin = select(behind, T(static_cast<double>(k) + 0.5), begin);
      from = select(behind, density[k], from);
      to = select(behind, density[std::min(k + 1, m - 1)], to);
      taken = select(behind, before[k], taken);
    }
    T const left = share - taken;
    T const root2 = from * from + 2.0 * (to - from) * left;
    T const root = sqrt(select(root2 > 1e-30, root2, T(1e-30)));
    edge[i] = (1.0 / m) * (begin + 2.0 * left / (from + root));
  }
}

/// The ends of the regions as functions of the pose: Newton on the gap within the brackets, the last step in T.
template <class T>
std::array<T, 2> ends_of(RegionPack<T> const& r) {
  using N = NumberOf<T>;
  constexpr double outwards[] = {-1.0, 1.0};
  auto const step = [&]<class P>(RelativePose<P> const& pose, std::array<P, 2>& place) {
    std::array<P, 2> s;
    for (std::size_t k = 0; k < 2; ++k) s[k] = r.pair.arc_to_abscissa.value(place[k]);
    std::array<CirclePoint<P>, 2> at;
    lowest_points(r.pair, pose, s, at);
    for (std::size_t k = 0; k < 2; ++k) {
      auto const& end = r.end[k];
      N const rate = outwards[k] * value_of(at[k].slope);
      P const next = place[k] - outwards[k] * at[k].gap / select(rate > 1e-6, rate, N(1e-6));
      auto const within = value_of(next) > end.low && value_of(next) < end.high;
      place[k] = select(end.is_root > 0.5 && at[k].found && within, next, place[k]);
    }
  };
  std::array<N, 2> place{value_of(r.end[0].place), value_of(r.end[1].place)};
  for (int i = 0; i < 2; ++i) step(numbers_of(r.pose), place);
  std::array<T, 2> ends;
  for (std::size_t k = 0; k < 2; ++k) ends[k] = select(r.end[k].is_root > 0.5, T(place[k]), r.end[k].place);
  step(r.pose, ends);
  return ends;
}

/// Share of a strip that lies between two places along the arc.
template <class T>
T share_between(T const& position, T const& width, T const& from, T const& to) {
  auto const before = [&](T const& place) {
    T const t = (place - position) / width + 0.5;
    return select(t < 0.0, T(0.0), select(t > 1.0, T(1.0), t));
  };
  return before(to) - before(from);
}

/// The paraboloid that stands for a region, from its strips: middle, depth, and its ellipse. (S15)
/// Depth and width are those of the parabola with the same area, decided by the deep part; its lowest points lie on the line
/// that fits those of the strips.
/// Then middles and interpenetration of the strips are those of the chords of that ellipse, (S12).
template <class T, std::size_t n>
void cut_ellipse(StripTables const& tables, Strips<T, n>& s, StripPlaces<T, n>& places) {
  T area(1e-30), squares(1e-60), cubes(1e-90), curvature(0.0), middle(0.0), ahead(0.0);
  StripRow<T, n> weight;
  for (std::size_t i = 0; i < n; ++i) {
    T const d = select(s.interpenetration[i] > 0.0, s.interpenetration[i], T(0.0));
    T const part = d * s.width[i];
    weight[i] = part * d;
    area += part;
    squares += weight[i];
    cubes += weight[i] * d;
    curvature += part * s.curvature[i];
    middle += weight[i] * s.position[i];
    ahead += weight[i] * places.along[i];
  }
  T const inverse = 1.0 / squares;
  s.middle = inverse * middle;
  ahead = inverse * ahead;
  s.depth = (7.0 / 6.0) * inverse * cubes;
  T spread(1e-60), obliquity(0.0);
  for (std::size_t i = 0; i < n; ++i) {
    T const y = s.position[i] - s.middle;
    spread += weight[i] * y * y;
    obliquity += weight[i] * y * (places.along[i] - ahead);
  }
  T const half = 0.75 * area / s.depth, skew = obliquity / spread;
  s.across = s.depth / (half * half);
  s.ellipse = oblique_ellipse(tables, T(curvature / area), skew, s.across);
  T const inverse_reach2 = reciprocal(T(s.ellipse.half_width * s.ellipse.half_width * s.depth));
  for (std::size_t i = 0; i < n; ++i) {
    T const y = s.position[i] - s.middle;
    T const inside =
        1.0 - smooth_step(T((y * y * inverse_reach2 - 1.5) / 2.5));  // far from the ellipse it says nothing
    // Points stay: the centre of the pressures is that of the lowest points, which are exact.
    places.inside[i] = inside;
    places.shift[i] = inside * (s.ellipse.skew - skew) * y;
    places.along[i] += places.shift[i];
    s.interpenetration[i] -= inside * s.ellipse.taken * y * y;
  }
}

}  // namespace strip_detail

/// Strips over a paraboloid: what is known exactly. Its lowest points lie on the line x = skew y.
///
/// @param along, across  half the second derivatives of the gap along the strips and along that line [1/m]
template <class T, std::size_t n>
void lay_over_paraboloid(StripTables const& tables, T const& along, T const& skew, T const& across, T const& depth,
                         Strips<T, n>& s, StripPlaces<T, n>& places) {
  using std::sqrt;
  constexpr std::size_t m = strip_count;
  T const half = sqrt(depth / across);
  StripRow<T, m> gap, slope;
  for (std::size_t k = 0; k < m; ++k) {
    T const y = ((2.0 * static_cast<double>(k) + 1.0) / m - 1.0) * half;
    gap[k] = across * y * y - depth;
    slope[k] = 2.0 * across * y;
  }
  std::array<T, n + 1> edge;
  strip_detail::grade<T, m, n>(gap, slope, edge);
  for (std::size_t i = 0; i < n; ++i) {
    T const y = s.position[i] = half * (edge[i] + edge[i + 1] - 1.0);
    s.width[i] = 2.0 * half * (edge[i + 1] - edge[i]);
    s.curvature[i] = along;
    s.interpenetration[i] = depth - across * y * y;
    places.along[i] = skew * y;
    places.point[i] = {places.along[i], y, T(0.0)};
    places.normal[i] = {T(0.0), T(0.0), T(1.0)};
    places.wheel_s[i] = places.rail_y[i] = T(0.0);
  }
  places.turn_sin = T(0.0), places.turn_cos = T(1.0);
  strip_detail::cut_ellipse(tables, s, places);
}

template <class T, std::size_t n>
void lay_strips(StripTables const& tables, RegionPack<T> const& r, Strips<T, n>& strips, StripPlaces<T, n>& places) {
  using namespace strip_detail;
  auto const [left, right] = ends_of(r);
  T const length = right - left;

  constexpr std::size_t m = strip_count;
  std::array<T, m> s;
  for (std::size_t k = 0; k < m; ++k)
    s[k] = r.pair.arc_to_abscissa.value(T(left + ((static_cast<double>(k) + 0.5) / m) * length));
  std::array<CirclePoint<T>, m> row;
  lowest_points(r.pair, r.pose, s, row);
  StripRow<T, m> gap, slope;
  for (std::size_t k = 0; k < m; ++k) gap[k] = select(row[k].found, row[k].gap, T(1e-3)), slope[k] = row[k].slope;
  std::array<T, n + 1> edge;
  grade<T, m, n>(gap, slope, edge);

  std::array<CirclePoint<T>, n> at;
  for (std::size_t i = 0; i < n; ++i) {
    strips.width[i] = (edge[i + 1] - edge[i]) * length;
    strips.position[i] = left + (0.5 * (edge[i] + edge[i + 1])) * length;
    places.wheel_s[i] = r.pair.arc_to_abscissa.value(strips.position[i]);
  }
  lowest_points(r.pair, r.pose, places.wheel_s, at);
  strips.compliance = r.compliance;
  T turn_sin(0.0), turn_cos(1e-30);
  for (std::size_t i = 0; i < n; ++i) {
    auto const& p = at[i];
    strips.interpenetration[i] = select(p.found, -p.gap, T(-1e-3));
    strips.curvature[i] = p.curvature;
    places.rail_y[i] = p.rail_y;
    places.point[i] = p.p;
    places.normal[i] = p.n;
    if (i == 0)
      places.along[i] = T(0.0);
    else
      places.along[i] = places.along[i - 1] + 0.5 * dot(p.p - at[i - 1].p, p.u + at[i - 1].u);
    // The circle in the axes of the roller: c along its circumference, m = n x c across.
    T const inverse_lean = inverse_root(T(p.n.x * p.n.x + p.n.z * p.n.z));
    Vec3<T> const c{p.n.z * inverse_lean, T(0.0), -(p.n.x * inverse_lean)};
    T const deep = select(p.gap < 0.0, -p.gap, T(0.0)) * strips.width[i];
    turn_sin += deep * dot(p.u, cross(p.n, c));
    turn_cos += deep * dot(p.u, c);
  }
  T const inverse = inverse_root(T(turn_sin * turn_sin + turn_cos * turn_cos));
  places.turn_sin = inverse * turn_sin;
  places.turn_cos = inverse * turn_cos;
  cut_ellipse(tables, strips, places);
}

}  // namespace rollerrig
