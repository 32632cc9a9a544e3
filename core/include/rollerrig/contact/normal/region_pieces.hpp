// contact/normal/region_pieces.hpp - interpenetration regions with several minima: where they are divided, and how far.
//
//   regions, minima and rises of the gap -> [find_divisions] -> weights of one solution and of one patch (S17), (S8)
//     -> [find_pieces] -> what is solved by itself
//
// Places of minima and rises are found to round-off and carry derivatives: the scan only estimates them.
#pragma once
#include "rollerrig/contact/normal/normal_patch.hpp"
#include "rollerrig/contact/normal/strip_layout.hpp"
#include "rollerrig/geometry/gap_nodes.hpp"
#include "rollerrig/math/dual.hpp"

namespace rollerrig {
namespace strip_detail {

/// The lowest point of the circle at a place along the arc.
template <Scalar T>
CirclePoint<T> point_at(NormalSetting const& wheel, RelativePose<T> const& pose, T const& position) {
  LanePair<double> pair;
  pair.set(0, wheel.pair, wheel.nodes->arc().abscissae());
  std::array<CirclePoint<T>, 1> point;
  lowest_points(pair, pose, std::array<T, 1>{pair.arc_to_abscissa.value(position)}, point);
  return point[0];
}

template <Scalar T>
struct Extreme {
  T position;  ///< along the arc [m]
  CirclePoint<T> point;
};

/// The extreme of the gap near the scan's estimate, by Newton on its slope; the place has derivatives, too.
template <Scalar T>
Extreme<T> extreme_at(NormalSetting const& wheel, RelativePose<T> const& pose, double position) {
  using Along = Dual<1>;
  constexpr int most_steps = 8;
  constexpr double farthest_step = 1e-4;  // [m]
  constexpr double level = 1e-9;          // of slope
  auto const fixed = [](Vec3<double> const& v) { return lift<Along>(v); };
  auto const at_rest = numbers_of(pose);
  RelativePose<Along> const rest{fixed(at_rest.o), {fixed(at_rest.R.ex), fixed(at_rest.R.ey), fixed(at_rest.R.ez)}};
  double bend = 0.0;
  for (int i = 0; i < most_steps; ++i) {
    Along const slope = point_at(wheel, rest, Along::variable(position, 0)).slope;
    bend = slope.d[0];
    if (std::abs(slope.value) < level || bend == 0.0) break;
    position -= std::clamp(slope.value / bend, -farthest_step, farthest_step);
  }
  T place(position);
  if constexpr (!std::same_as<T, double>) {
    T const slope = point_at(wheel, pose, place).slope;
    if (bend != 0.0) place -= (slope - slope.value) / bend;
  }
  return {place, point_at(wheel, pose, place)};
}

/// What lies between two neighbouring minima.
template <Scalar T>
struct Saddle {
  T rise;      ///< its gap over the depth of the shallower minimum: negative in the material [-]
  T skew;      ///< distance of the minima along the wheel's circles over that across them, not negative [-]
  T position;  ///< of the rise, along the arc [m]
};

template <Scalar T>
Saddle<T> saddle(NormalSetting const& wheel, RelativePose<T> const& pose, GapScan const& scan, int i) {
  auto const at_estimate = [&](GapExtreme const& e) { return extreme_at(wheel, pose, e.position); };
  auto const left = at_estimate(scan.minimum[at(i)]), right = at_estimate(scan.minimum[at(i + 1)]);
  auto const top = at_estimate(scan.rise[at(i)]);
  auto const &g = left.point, &h = right.point;
  T const shallower = select(g.gap < h.gap, h.gap, g.gap);  // both negative
  T const along = 0.5 * dot(h.p - g.p, g.u + h.u);
  return {-(top.point.gap / shallower), select(along < 0.0, -along, along) / (right.position - left.position),
          top.position};
}

}  // namespace strip_detail

/// Rises of regions whose minima may be patches of their own, and how far they are.
template <Scalar T>
struct Division {
  bool possible{false};
  T place{0.0};   ///< of the rise, along the arc [m]
  T joined{1.0};  ///< weight of one solution for both sides (S17)
  T merged{1.0};  ///< weight of one patch with that solution (S8)
};
template <Scalar T>
using Divisions = std::array<Division<T>, GapScan::most_minima>;

/// Rises that do not lie deep in the material make two patches of a region (S8). They are solved as one, and the less so the
/// higher the rise and the farther one lies ahead of the other: else as two that push each other as single forces do. In between
/// both solutions count. (S17)
template <Scalar T>
Division<T> divide(strip_detail::Saddle<T> const& between) {
  using strip_detail::smooth_step;
  T const ahead = smooth_step(T((between.skew - 0.2) / 0.3));
  T const joined = 1.0 - smooth_step(T((between.rise + 0.4 * ahead) / (0.2 + 0.3 * ahead) + 1.0));
  return {true, between.position, joined, smooth_step(T((-between.rise - 0.7) / 0.2))};
}

template <Scalar T>
void find_divisions(NormalSetting const& wheel, RelativePose<T> const& pose, GapScan const& scan,
                    Divisions<T>& divisions) {
  for (int k = 0; k < scan.regions; ++k)
    for (int i = scan.region[at(k)].first; i < scan.region[at(k)].last; ++i) {
      auto const &left = scan.minimum[at(i)], &right = scan.minimum[at(i + 1)], &top = scan.rise[at(i)];
      constexpr double sure = 0.03;  // the nodes' estimate is closer
      if (top.gap / std::max(left.gap, right.gap) > 0.9 + sure)
        divisions[at(i)].possible = false;
      else
        divisions[at(i)] = divide(strip_detail::saddle(wheel, pose, scan, i));
    }
}

/// A region, or what lies between two rises of one.
template <Scalar T>
struct Piece {
  RegionEnd left, right;
  std::array<T, 2> end;
  int first, last;  ///< of its minima
  T joined{0.0};    ///< with the next one
};
template <Scalar T>
using Pieces = std::array<Piece<T>, GapScan::most_minima>;

/// The regions of a wheel, divided at rises where they may be solved as two.
template <Scalar T>
int find_pieces(GapScan const& scan, Divisions<T> const& divisions, Pieces<T>& piece) {
  int count = 0;
  for (int k = 0; k < scan.regions; ++k, ++count) {
    auto const& region = scan.region[at(k)];
    piece[at(count)] = {region.left,  region.right, {T(region.left.position), T(region.right.position)},
                        region.first, region.last,  T(0.0)};
    for (int i = region.first; i < region.last; ++i) {
      auto const& here = divisions[at(i)];
      if (!here.possible || !(here.joined < 1.0)) continue;
      auto &one = piece[at(count)], &next = piece[at(++count)];
      next = one;
      double const cut = value_of(here.place);
      one.right = next.left = {cut, cut, cut, false};
      one.end[1] = next.end[0] = here.place;
      one.last = i, next.first = i + 1;
      one.joined = here.joined;
    }
  }
  return count;
}

}  // namespace rollerrig
