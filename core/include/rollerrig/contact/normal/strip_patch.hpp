// contact/normal/strip_patch.hpp - from the strips of a region, or of a part of it, to a patch: force, centre, moment, ellipse.
//
//   line loads and places of the strips, one region per lane -> [sums (S6), (S7)] -> patch
#pragma once
#include "rollerrig/contact/normal/strip_contact.hpp"
#include "rollerrig/contact/normal/strip_layout.hpp"

namespace rollerrig {

namespace strip_detail {

/// Resultant and centre of the pressures. (S6)
template <class T, std::size_t n>
void find_resultant(Strips<T, n> const& s, StripPlaces<T, n> const& places, StripRow<T, n> const& share,
                    StripPatch<T>& out) {
  using std::sqrt;
  Vec3<T> force{}, centre{}, turning{};
  T sum(1e-60), wheel_s(0.0), rail_y(0.0);
  Vec3<T> const& origin = places.point[n / 2];  // sums of small numbers
  for (std::size_t i = 0; i < n; ++i) {
    T const f = share[i] * s.load[i] * s.width[i];
    Vec3<T> const fn = f * places.normal[i];
    Vec3<T> const arm = places.point[i] - origin;
    sum += f;
    force += fn;
    centre += f * arm;
    turning += cross(arm, fn);
    wheel_s += f * places.wheel_s[i];
    rail_y += f * places.rail_y[i];
  }
  T const inverse = 1.0 / sum;
  T const length = sqrt(dot(force, force) + 1e-120);
  Vec3<T> const from_origin = inverse * centre;
  out.force = sum;
  out.normal = length;
  out.direction = T(1.0 / length) * force;
  out.point = origin + from_origin;
  out.moment = turning - cross(from_origin, force);
  out.wheel_s = inverse * wheel_s;
  out.rail_y = inverse * rail_y;
}

/// The equivalent ellipse: of the same area, with the ratio of the pressures' second moments along and across rolling. (S7)
template <class T, std::size_t n>
void find_ellipse(Strips<T, n> const& s, StripPlaces<T, n> const& places, StripRow<T, n> const& share, T const& exact_a,
                  T const& exact_b, StripPatch<T>& out) {
  using std::sqrt;
  T sum(1e-60), area(1e-60), x(0.0), y(0.0), xx(0.0), xy(0.0), yy(0.0);
  T lx(0.0), ly(0.0), lxx(0.0), lxy(0.0), lyy(0.0);
  for (std::size_t i = 0; i < n; ++i) {
    T const w = share[i] * s.load[i] * s.width[i];
    T const a2 = s.half_length[i] * s.half_length[i];
    T const ahead = places.along[i] - places.along[n / 2], aside = s.position[i] - s.middle;
    T const own = s.width[i] * s.width[i] * (1.0 / 12.0);
    sum += w;
    x += w * ahead;
    y += w * aside;
    xx += w * (ahead * ahead + 0.25 * a2);
    xy += w * (ahead * aside);
    yy += w * (aside * aside + own);
    T const l = share[i] * s.width[i] * (a2 - s.shortest2) / s.half_length[i];
    area += l;
    lx += l * ahead;
    ly += l * aside;
    lxx += l * (ahead * ahead + (1.0 / 3.0) * a2);
    lxy += l * (ahead * aside);
    lyy += l * (aside * aside + own);
  }
  T const inverse = 1.0 / sum, of_area = 1.0 / area;
  // In the axes of the strips the ellipse is corrected by what they leave out of Hertz'.
  T const stretch = exact_a / exact_b;
  xx = stretch * (xx - x * x * inverse) + 1e-80;
  xy = xy - x * y * inverse;
  yy = (yy - y * y * inverse) / stretch + 1e-80;
  lxx = stretch * (lxx - lx * lx * of_area) + 1e-80;
  lxy = lxy - lx * ly * of_area;
  lyy = (lyy - ly * ly * of_area) / stretch + 1e-80;
  // From the strips' axes to those of rolling. Of a Hertz pressure the moments are a^2/5 and b^2/5, and pi a b the area.
  T const cos2 = places.turn_cos * places.turn_cos, sin2 = places.turn_sin * places.turn_sin;
  T const twice = 2.0 * places.turn_sin * places.turn_cos;
  auto const squared_ratio = [&](T const& along, T const& mixed, T const& across) {
    return T((cos2 * along + sin2 * across - twice * mixed) / (cos2 * across + sin2 * along + twice * mixed));
  };
  T const ratio = sqrt(sqrt(squared_ratio(xx, xy, yy) * squared_ratio(lxx, lxy, lyy)));  // a/b
  T const product = exact_a * exact_b * (2.0 / pi) * area;
  out.a = sqrt(product * ratio);
  out.b = sqrt(product / ratio);
}

/// Vertex of the parabola through three points at distances from the middle one, where it is the highest: (S16).
template <class N>
N vertex(N const& low, N const& here, N const& high, N const& left, N const& right) {
  N const falls_left = (here - low) * reciprocal(left), falls_right = (here - high) * reciprocal(right);
  N const bend = (falls_left + falls_right) * reciprocal(N(left + right));
  N const lean = (falls_left * right - falls_right * left) * reciprocal(N(left + right));
  auto const top = !(here < low) && !(here < high) && bend > 0.0;
  N const rise = 0.25 * lean * lean * reciprocal(select(top, bend, N(1.0)));
  return here + select(top, rise, N(0.0));
}

/// Largest interpenetration and pressure, and the extent across and along rolling.
template <class T, std::size_t n>
void find_extremes(Strips<T, n> const& s, StripPlaces<T, n> const& places, StripRow<T, n> const& share,
                   StripPatch<T>& out) {
  using N = NumberOf<T>;
  using std::sqrt;
  std::array<N, n + 2> all, load, square_pressure, h;  // with nothing on either side
  all[0] = all[n + 1] = load[0] = load[n + 1] = square_pressure[0] = square_pressure[n + 1] = N(0.0);
  for (std::size_t i = 0; i < n; ++i) {
    h[i + 1] = value_of(s.width[i]);
    all[i + 1] = select(value_of(s.on[i]) > 0.5, value_of(s.load[i]), N(0.0));
    load[i + 1] = value_of(share[i]) * all[i + 1];
    N const p = load[i + 1] * reciprocal(value_of(s.half_length[i]));
    square_pressure[i + 1] = p * p;
  }
  h[0] = h[1], h[n + 1] = h[n];
  N const sine = value_of(places.turn_sin), cosine = value_of(places.turn_cos);
  N const steep = select(sine < 0.0, N(-sine), sine);
  N left(0.0), right(0.0), front(-1e3), rear(1e3);
  out.approach = out.peak_pressure = out.width = N(0.0);
  // The patch's edges lie where the load of its outermost strips runs out, where the region is cut or a turned strip ends.
  auto const to_edge = [&](N const& width, N const& here, N const& inner) {
    auto const falls = here < inner;
    N const reach = width * here / select(falls, N(inner - here), N(1.0));
    return select(falls, select(reach < width, reach, width), N(0.5 * width));
  };
  for (std::size_t i = 0; i < n; ++i) {
    N const &before = load[i], &here = load[i + 1], &after = load[i + 2];
    N const &width = h[i + 1], a = value_of(s.half_length[i]);
    N const depth = value_of(s.interpenetration[i]);
    auto const loaded = here > 0.0;
    auto const present = value_of(share[i]) > 0.0;
    N const highest = vertex(square_pressure[i], square_pressure[i + 1], square_pressure[i + 2],
                             N(0.5 * (h[i] + width)), N(0.5 * (width + h[i + 2])));
    N const pressure = (2.0 / pi) * sqrt(highest);
    out.peak_pressure = select(present && pressure > out.peak_pressure, pressure, out.peak_pressure);
    out.approach = select(present && depth > out.approach, depth, out.approach);
    N const along = value_of(places.along[i]), across = value_of(s.position[i]);
    N const middle = sine * along + cosine * across, reach = a * steep;
    auto const opens = loaded && !(before > 0.0);
    auto const closes = loaded && !(after > 0.0);
    left = select(opens, middle, left);
    right = select(opens, middle, right);
    N const cut = width * (value_of(share[i]) - 0.5);
    N const low = middle - cosine * select(opens, select(all[i] > 0.0, cut, to_edge(width, here, after)), N(0.0));
    N const high =
        middle + cosine * select(closes, select(all[i + 2] > 0.0, cut, to_edge(width, here, before)), N(0.0));
    left = select(loaded && middle - reach < left, N(middle - reach), left);
    left = select(loaded && low < left, low, left);
    right = select(loaded && middle + reach > right, N(middle + reach), right);
    right = select(loaded && high > right, high, right);
    out.width = out.width + select(closes, N(right - left), N(0.0));
    N const ahead = cosine * along - sine * across;
    front = select(loaded && ahead + cosine * a > front, N(ahead + cosine * a), front);
    rear = select(loaded && ahead - cosine * a < rear, N(ahead - cosine * a), rear);
  }
  out.length = select(front > rear, N(front - rear), N(0.0));
}

}  // namespace strip_detail

/// A region, or a part of it, as one patch.
///
/// @param share  of each strip in it, 0 to 1
template <class T, std::size_t n>
StripPatch<T> part_of(StripTables const& tables, Strips<T, n> const& s, StripPlaces<T, n> const& places,
                      StripRow<T, n> const& share) {
  StripPatch<T> out;
  strip_detail::find_resultant(s, places, share, out);
  T const exact_a = tables.at(StartFunction::half_length, s.ellipse.place);
  T const exact_b = tables.at(StartFunction::half_width, s.ellipse.place);
  strip_detail::find_ellipse(s, places, share, exact_a, exact_b, out);
  strip_detail::find_extremes(s, places, share, out);
  out.length = value_of(exact_a) * out.length;
  out.peak_pressure = value_of(tables.at(StartFunction::peak_pressure, s.ellipse.place)) * out.peak_pressure;
  out.width = value_of(tables.at(StartFunction::width, s.ellipse.place)) * out.width;
  return out;
}

}  // namespace rollerrig
