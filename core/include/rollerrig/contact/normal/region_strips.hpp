// contact/normal/region_strips.hpp - the strips of a region handed on to a creep law that follows a bent patch.
//
//   strips as solved, one region per lane -> [take_strips] -> those of the region -> [strips_of_part] -> those of one patch
//
// Only where the creep law asks for them: contact/creep/strip_theory.hpp.
#pragma once
#include "rollerrig/contact/normal/strip_layout.hpp"
#include "rollerrig/contact/patch_strips.hpp"

namespace rollerrig {

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

/// Appends the strips of one lane.
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
