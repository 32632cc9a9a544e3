#include "rollerrig/contact/normal/strip_contact.hpp"

#include <limits>

#include "rollerrig/contact/normal/strip_layout.hpp"

namespace rollerrig {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr int per_region = Strips<double>::per_region;

/// How far the middle of a loaded strip at the end of a run is from where the load vanishes [m].
double to_edge(double width, double load, double inner_load) {
  return load < inner_load ? std::min(width * load / (inner_load - load), width) : 0.5 * width;
}

/// Strips first .. last-1 of one region, which lie along (turn.cos, turn.sin).
struct Run {
  int first, last;
  int region() const { return first / per_region; }
};

/// Resultant and centre of the pressures; false if no strip carries load. (S6)
template <Scalar T>
bool find_resultant(Strips<T> const& strips, StripPlaces<T> const& places, Run const& run, StripPatch<T>& patch) {
  using std::sqrt;
  Vec3<T> force{}, centre{};
  T sum(0.0), s(0.0), y(0.0);
  T const width = strips.width[at(run.region())];
  for (int i = run.first; i < run.last; ++i) {
    if (!(strips.load[at(i)] > 0.0)) continue;
    T const f = strips.load[at(i)] * width;
    sum += f;
    force += f * places.normal[at(i)];
    centre += f * places.point[at(i)];
    s += f * places.wheel_s[at(i)];
    y += f * places.rail_y[at(i)];
  }
  if (!(sum > 0.0)) return false;
  T const inverse = 1.0 / sum;
  patch.normal = sqrt(dot(force, force));
  patch.direction = (1.0 / patch.normal) * force;
  patch.point = inverse * centre;
  patch.wheel_s = inverse * s;
  patch.rail_y = inverse * y;
  patch.moment = {};
  for (int i = run.first; i < run.last; ++i)
    if (strips.load[at(i)] > 0.0)
      patch.moment += cross(places.point[at(i)] - patch.point, (strips.load[at(i)] * width) * places.normal[at(i)]);
  return true;
}

/// The equivalent ellipse: of the same area, with the ratio of the pressures' second moments along and across rolling. (S7)
template <Scalar T>
void find_ellipse(Strips<T> const& strips, StripPlaces<T> const& places, Run const& run, StripPatch<T>& patch) {
  using std::sqrt;
  T const width = strips.width[at(run.region())];
  T sum(0.0), area(0.0), x(0.0), y(0.0);
  for (int i = run.first; i < run.last; ++i) {
    T const& w = strips.load[at(i)];
    if (!(w > 0.0)) continue;
    sum += w;
    x += w * places.along[at(i)];
    y += w * places.across[at(i)];
    area += 2.0 * strips.half_length[at(i)] * width;
  }
  x = x / sum;
  y = y / sum;
  T xx(0.0), xy(0.0), yy(0.0);
  for (int i = run.first; i < run.last; ++i) {
    T const& w = strips.load[at(i)];
    if (!(w > 0.0)) continue;
    T const ahead = places.along[at(i)] - x;
    T const aside = places.across[at(i)] - y;
    xx += w * (ahead * ahead + 0.25 * strips.half_length[at(i)] * strips.half_length[at(i)]);
    xy += w * ahead * aside;
    yy += w * (aside * aside + width * width / 12.0);
  }
  // From the strips' axes to those of rolling. Of a Hertz pressure the moments are a^2/5 and b^2/5, and pi a b the area.
  Twist<T> const& turn = places.turn[at(run.region())];
  T const cos2 = turn.cos * turn.cos;
  T const sin2 = turn.sin * turn.sin;
  T const exchanged = 2.0 * turn.sin * turn.cos * xy;
  T const along = cos2 * xx + sin2 * yy - exchanged;
  T const across = cos2 * yy + sin2 * xx + exchanged;
  T const ratio = sqrt(along / across);  // a/b
  T const product = area / pi;
  patch.a = sqrt(product * ratio);
  patch.b = sqrt(product / ratio);
}

/// Largest interpenetration and pressure, the length along rolling and the width across it.
template <Scalar T>
void find_extremes(Strips<T> const& strips, StripPlaces<T> const& places, Run const& run, StripPatch<T>& patch) {
  patch.approach = patch.peak_pressure = patch.width = 0.0;
  double const h = value_of(strips.width[at(run.region())]);
  double const sine = value_of(places.turn[at(run.region())].sin);
  double const cosine = value_of(places.turn[at(run.region())].cos);
  auto const load_of = [&](int j) { return j >= run.first && j < run.last ? value_of(strips.load[at(j)]) : 0.0; };
  double left = 0.0;
  double right = 0.0;
  double front = -std::numeric_limits<double>::infinity();
  double back = -front;
  for (int i = run.first; i < run.last; ++i) {
    patch.approach = std::max(patch.approach, value_of(strips.interpenetration[at(i)]));
    double const load = load_of(i);
    if (!(load > 0.0)) continue;
    double const a = value_of(strips.half_length[at(i)]);
    patch.peak_pressure = std::max(patch.peak_pressure, 2.0 * load / (pi * a));
    // The patch's edges lie where the load of its outermost strips runs out, or where a turned strip ends.
    double const ahead = sine * value_of(places.along[at(i)]);
    double const across = value_of(places.across[at(i)]);
    double const centre = cosine * value_of(places.along[at(i)]) - sine * across;
    front = std::max(front, centre + a * cosine);
    back = std::min(back, centre - a * cosine);
    double const middle = ahead + cosine * across;
    double const reach = a * std::abs(sine);
    bool const opens = !(load_of(i - 1) > 0.0);
    bool const closes = !(load_of(i + 1) > 0.0);
    if (opens) left = right = middle;
    left = std::min(left, middle - reach);
    right = std::max(right, middle + reach);
    if (opens) left = std::min(left, ahead + cosine * (across - to_edge(h, load, load_of(i + 1))));
    if (!closes) continue;
    right = std::max(right, ahead + cosine * (across + to_edge(h, load, load_of(i - 1))));
    patch.width += right - left;
  }
  patch.length = front - back;
}

/// Sums the strips of a run to one patch; false if none of them carries load.
template <Scalar T>
bool gather(Strips<T> const& strips, StripPlaces<T> const& places, Run const& run, StripPatch<T>& patch) {
  if (!find_resultant(strips, places, run, patch)) return false;
  find_ellipse(strips, places, run, patch);
  find_extremes(strips, places, run, patch);
  return true;
}

/// Weight of the reading that two minima are one patch; from how deep the rise between them lies in the material (S8).
template <Scalar T>
T merged_weight(T const& rise, T const& left_gap, T const& right_gap) {
  T const shallower = select(left_gap < right_gap, right_gap, left_gap);  // both negative
  T const t = (rise / shallower - 0.3) / 0.4;
  T const clipped = select(t < 0.0, T(0.0), select(t > 1.0, T(1.0), t));
  return clipped * clipped * (3.0 - 2.0 * clipped);
}

}  // namespace

template <Scalar T>
StripSolution<T> strip_contact(NormalSetting const& wheel, RelativePose<T> const& pose, ContactSearch const& search) {
  auto const constant = [](Vec3<T> const& v) { return Vec3<double>{value_of(v.x), value_of(v.y), value_of(v.z)}; };
  RelativePose<double> const here{constant(pose.o), {constant(pose.R.ex), constant(pose.R.ey), constant(pose.R.ez)}};
  std::array<InterpenetrationRegion, max_regions> regions;
  Strips<T> strips;
  StripPlaces<T> places;
  lay_strips(wheel, pose, regions, find_regions(wheel.pair, here, search, regions), strips, places);
  solve_strips(wheel.material, strips);

  StripSolution<T> out;
  auto const add = [&](int first, int last, T const& weight) {
    if (out.count == StripSolution<T>::capacity || !(weight > 0.0)) return;
    auto& patch = out.patch[at(out.count)];
    if (!gather(strips, places, {first, last}, patch)) return;
    patch.weight = weight;
    ++out.count;
  };
  for (int k = 0; k < strips.regions; ++k) {
    InterpenetrationRegion const& region = regions[at(k)];
    int const first = k * per_region;
    int const last = first + per_region;
    T one(1.0);
    std::array<int, ContactSearch::max_minima + 1> cut{first};
    int cuts = 1;
    for (int i = region.first; i < region.last; ++i) {
      auto const gap = [&](GapMinimum const& g) {
        if constexpr (std::same_as<T, double>) return g.gap;
        return contact_point(wheel.pair, pose, g.s, g.gradient).gap;
      };
      GapMinimum const& top = search.barrier(i);
      T const m = merged_weight(gap(top), gap(search[i]), gap(search[i + 1]));
      if (!(m < 1.0)) continue;
      one = select(m < one, m, one);
      int next = cut[at(cuts - 1)];
      while (next < last && value_of(places.wheel_s[at(next)]) < top.s) ++next;
      cut[at(cuts++)] = next;
    }
    cut[at(cuts)] = last;
    add(first, last, one);
    if (one < 1.0)
      for (int i = 0; i < cuts; ++i) add(cut[at(i)], cut[at(i + 1)], 1.0 - one);
  }
  return out;
}

template StripSolution<double> strip_contact(NormalSetting const&, RelativePose<double> const&, ContactSearch const&);
template StripSolution<StripDual> strip_contact(NormalSetting const&, RelativePose<StripDual> const&,
                                                ContactSearch const&);

}  // namespace rollerrig
