#include "rollerrig/contact/normal/strip_contact.hpp"

namespace rollerrig {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr int per_region = Strips<double>::per_region;

/// What each strip is besides the elastic problem.
template <Scalar T>
struct StripPlaces {
  std::array<T, Strips<T>::capacity> wheel_s, rail_y;
  std::array<Vec3<T>, Strips<T>::capacity> point, normal;
};

/// Lays the strips of one region, equally wide along the profile's arc.
template <Scalar T>
void lay_strips(WheelRollerPair const& pair, ArcLength const& arc, RelativePose<T> const& pose,
                InterpenetrationRegion const& region, int index, Strips<T>& strips, StripPlaces<T>& places) {
  using std::sqrt;
  auto const end = [&](double s, bool is_root) {
    if constexpr (std::same_as<T, double>) return s;
    if (!is_root) return T(s);
    RelativePose<Dual<1>> fixed;
    auto const constant = [](Vec3<T> const& v) { return lift<Dual<1>>({value_of(v.x), value_of(v.y), value_of(v.z)}); };
    fixed = {constant(pose.o), {constant(pose.R.ex), constant(pose.R.ey), constant(pose.R.ez)}};
    return region_end(pair, pose, s, reduce(pair, fixed, Dual<1>::variable(s, 0)).gap.d[0]);
  };
  T const left = arc.length(end(region.left, region.left_is_root));
  T const right = arc.length(end(region.right, region.right_is_root));
  T const width = (right - left) / static_cast<double>(per_region);
  strips.width[at(index)] = width;
  double const kappa = pair.hertz_curvature();
  for (int k = 0; k < per_region; ++k) {
    std::size_t const i = at(index * per_region + k);
    T const length = left + (k + 0.5) * width;
    T const s = arc.abscissa(length);
    auto const here = reduce(pair, pose, s);
    strips.position[i] = length;
    if (!here.rail_point.found) {
      strips.interpenetration[i] = T(-1.0);
      strips.curvature[i] = T(1.0);
      continue;
    }
    auto const& line = here.line;
    auto const& rail = here.rail_point.rail;
    strips.interpenetration[i] = -here.gap;
    strips.curvature[i] =
        0.5 / (line.radius * sqrt(1.0 + line.profile.slope * line.profile.slope)) +
        0.5 * kappa / ((1.0 + kappa * rail.value) * sqrt(1.0 + rail.slope * rail.slope));  // (14), (15)
    places.wheel_s[i] = s;
    places.rail_y[i] = here.rail_point.y;
    places.normal[i] = -line.n;
    places.point[i] = line.p + here.gap * line.n;
  }
}

/// How far the middle of a loaded strip at the end of a run is from where the load vanishes [m].
double to_edge(double width, double load, double inner_load) {
  return load < inner_load ? std::min(width * load / (inner_load - load), width) : 0.5 * width;
}

/// Sums the strips first .. last-1 to one patch; false if none of them carries load.
template <Scalar T>
bool gather(Strips<T> const& strips, StripPlaces<T> const& places, int first, int last, StripPatch<T>& patch) {
  using std::sqrt;
  Vec3<T> force{}, centre{};
  T sum(0.0), s(0.0), y(0.0), area(0.0), along_x(0.0), across(0.0), position(0.0);
  for (int i = first; i < last; ++i) {
    double const load = value_of(strips.load[at(i)]);
    if (!(load > 0.0)) continue;
    T const width = strips.width[at(i / per_region)];
    T const f = strips.load[at(i)] * width;
    T const& a = strips.half_length[at(i)];
    sum += f;
    force += f * places.normal[at(i)];
    centre += f * places.point[at(i)];
    s += f * places.wheel_s[at(i)];
    y += f * places.rail_y[at(i)];
    position += f * strips.position[at(i)];
    area += 2.0 * a * width;
    along_x += 0.25 * f * a * a;
  }
  if (!(sum > 0.0)) return false;
  T const inverse = 1.0 / sum;
  patch.normal = sqrt(dot(force, force));
  patch.direction = (1.0 / patch.normal) * force;
  patch.point = inverse * centre;
  patch.wheel_s = inverse * s;
  patch.rail_y = inverse * y;
  position = inverse * position;
  patch.moment = {};
  patch.approach = patch.peak_pressure = patch.width = 0.0;
  double left_edge = 0.0;
  for (int i = first; i < last; ++i) {
    patch.approach = std::max(patch.approach, value_of(strips.interpenetration[at(i)]));
    double const load = value_of(strips.load[at(i)]);
    if (!(load > 0.0)) continue;
    T const width = strips.width[at(i / per_region)];
    T const f = strips.load[at(i)] * width;
    T const aside = strips.position[at(i)] - position;
    across += f * (aside * aside + width * width / 12.0);
    patch.moment += cross(places.point[at(i)] - patch.point, f * places.normal[at(i)]);
    patch.peak_pressure = std::max(patch.peak_pressure, 2.0 * load / (pi * value_of(strips.half_length[at(i)])));
    // The patch's edges lie where the load of its outermost strips runs out.
    double const h = value_of(width);
    double const middle = value_of(strips.position[at(i)]);
    auto const neighbour = [&](int j) { return j >= first && j < last ? value_of(strips.load[at(j)]) : 0.0; };
    if (!(neighbour(i - 1) > 0.0)) left_edge = middle - to_edge(h, load, neighbour(i + 1));
    if (!(neighbour(i + 1) > 0.0)) patch.width += middle + to_edge(h, load, neighbour(i - 1)) - left_edge;
  }
  // Of a Hertz pressure the second moments are a^2/5 and b^2/5, and pi a b the area.
  T const ratio = sqrt(along_x / across);  // a/b
  T const product = area / pi;
  patch.a = sqrt(product * ratio);
  patch.b = sqrt(product / ratio);
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
  strips.regions = find_regions(wheel.pair, here, search, regions);
  for (int k = 0; k < strips.regions; ++k)
    lay_strips(wheel.pair, *wheel.wheel_arc, pose, regions[at(k)], k, strips, places);
  solve_strips(wheel.material, strips);

  StripSolution<T> out;
  auto const add = [&](int first, int last, T const& weight) {
    if (out.count == StripSolution<T>::capacity || !(weight > 0.0)) return;
    auto& patch = out.patch[at(out.count)];
    if (!gather(strips, places, first, last, patch)) return;
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
      double const length = wheel.wheel_arc->length(top.s);
      int next = cut[at(cuts - 1)];
      while (next < last && value_of(strips.position[at(next)]) < length) ++next;
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
