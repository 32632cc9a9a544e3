// contact/normal/region_pieces.hpp - interpenetration regions with several minima: where they are divided, and how far.
//
//   regions, minima and rises of the gap -> [find_divisions] -> weights of one solution and of one patch (S17), (S8)
//     -> [find_pieces] -> what is solved by itself
//
// Places of minima and rises are found to round-off and carry derivatives: the scan only estimates them.
#pragma once
#include "rollerrig/contact/normal/normal_patch.hpp"
#include "rollerrig/contact/normal/strip_layout.hpp"
#include "rollerrig/contact/patch_strips.hpp"
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
  auto const rest = lift<Along>(numbers_of(pose));
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

// The strips of a region handed on to a creep law that follows a bent patch.
// Only where the creep law asks for them: contact/creep/strip_theory.hpp.

/// Of a region, which may be divided.
template <Scalar T>
struct RegionStrips : PatchStrips<T> {
  typename PatchStrips<T>::Row position, width;  ///< along the wheel's arc [m]
  typename PatchStrips<T>::Row ahead, aside;  ///< of the strip's middle from the circle's lowest point, along i, t [m]
};

/// Strips lie along the wheel's circles, those of a creep law along rolling: from the chords of the region's ellipse along one to
/// those along the other, middles on x = skew y. (S18)
template <class T>
struct TurnedChords {
  T skew, wider;  ///< wider: distances across over those before, half-lengths the other way round

  TurnedChords(ObliqueEllipse<T> const& e, T const& sine, T const& cosine) {
    using std::sqrt;
    T const across = e.half_width * e.half_width, mixed = e.skew * across;
    T const along = e.half_length * e.half_length + e.skew * mixed;
    T const turned = sine * sine * along + 2.0 * sine * cosine * mixed + cosine * cosine * across;
    skew = (sine * cosine * (along - across) + (cosine * cosine - sine * sine) * mixed) / turned;
    wider = sqrt(turned / across);
  }
};

template <class L, std::size_t n, Scalar T>
void take_strips(StripTables const& tables, Strips<L, n> const& strips, StripPlaces<L, n> const& places, int i,
                 RegionStrips<T>& to) {
  auto const get = [i](L const& x) {
    if constexpr (std::same_as<L, T>)
      return x;
    else
      return lane(x, i);
  };
  TurnedChords<L> const chords(strips.ellipse, places.turn_sin, places.turn_cos);
  T const sine = get(places.turn_sin), cosine = get(places.turn_cos), skew = get(strips.ellipse.skew);
  T const wider = get(chords.wider), middle = get(strips.middle);
  T const stretch = get(tables.at(StartFunction::half_length, strips.ellipse.place)) / wider;
  T const ahead = wider * get(chords.skew) + sine - cosine * skew, aside = wider - cosine - sine * skew;
  for (std::size_t k = 0; k < n; ++k) {
    auto const at = static_cast<std::size_t>(to.count++);
    auto const &p = places.point[k], &normal = places.normal[k];
    to.point[0][at] = get(p.x), to.point[1][at] = get(p.y), to.point[2][at] = get(p.z);
    to.normal[0][at] = get(normal.x), to.normal[1][at] = get(normal.y), to.normal[2][at] = get(normal.z);
    T const half = get(strips.half_length[k]), width = get(strips.width[k]);
    to.force[at] = get(strips.load[k]) * width;
    to.half_length[at] = stretch * half;
    // Strips beside the patch keep a little load and length, (S5), which would take stiffness away from those in it.
    to.area[at] = get(strips.on[k]) * width * half;
    to.position[at] = get(strips.position[k]), to.width[at] = width;
    T const shift = get(places.shift[k]), across = get(places.inside[k]) * (to.position[at] - middle);
    to.ahead[at] = across * ahead + cosine * shift;
    to.aside[at] = across * aside + sine * shift;
  }
}

/// Lets the strips from `first` on count with a weight.
template <Scalar T>
void weigh(RegionStrips<T>& strips, int first, int last, T const& weight) {
  for (auto i = static_cast<std::size_t>(first); i < static_cast<std::size_t>(last); ++i) {
    strips.force[i] = weight * strips.force[i];
    strips.area[i] = weight * strips.area[i];
  }
}

/// The strips between two places along the arc, of cut ones a share.
///
/// @param whole  their area together [m^2]
/// @param factor, size  what other regions leave of forces and of lengths
template <Scalar T>
void strips_of_part(RegionStrips<T> const& region, T const& from, T const& to, T const& factor, T const& size,
                    T const& whole, PatchStrips<T>& part) {
  using std::sqrt;
  part.count = region.count;
  auto const n = static_cast<std::size_t>(region.count);
  T sum(1e-60), moved_ahead(0.0), moved_aside(0.0), area(1e-60);
  for (std::size_t i = 0; i < n; ++i) {
    T const share = strip_detail::share_between(region.position[i], region.width[i], from, to);
    part.force[i] = factor * share * region.force[i];
    part.area[i] = share * region.area[i];
    part.half_length[i] = size * region.half_length[i];
    sum += part.force[i];
    area += part.area[i];
    moved_ahead += part.force[i] * region.ahead[i];
    moved_aside += part.force[i] * region.aside[i];
  }
  // The centre of the pressures stays that of the lowest points.
  T const mean_ahead = moved_ahead / sum, mean_aside = moved_aside / sum, scale = whole / area;
  part.normal = region.normal;
  for (std::size_t i = 0; i < n; ++i) {
    // Along i and t of contact/patch.hpp.
    T const nx = region.normal[0][i], ny = region.normal[1][i], nz = region.normal[2][i];
    T const across = sqrt(ny * ny + nz * nz), inverse = 1.0 / across;
    T const ahead = region.ahead[i] - mean_ahead, aside = (region.aside[i] - mean_aside) * inverse;
    T const sideways = ahead * nx * inverse;
    part.area[i] = scale * part.area[i];
    part.point[0][i] = region.point[0][i] + ahead * across;
    part.point[1][i] = region.point[1][i] - sideways * ny + aside * nz;
    part.point[2][i] = region.point[2][i] - sideways * nz - aside * ny;
  }
}

}  // namespace rollerrig
