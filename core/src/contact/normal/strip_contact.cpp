#include "rollerrig/contact/normal/strip_contact.hpp"

#include "rollerrig/contact/normal/strip_patch.hpp"

namespace rollerrig {
namespace {

constexpr std::size_t most_wheels = 16;  // of one batch; more come in several
constexpr std::size_t most_parts = 4;    // of a region

constexpr std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// A region to be solved, and what came out.
template <Scalar T>
struct Region {
  int wheel{0};
  InterpenetrationRegion const* range{nullptr};
  std::size_t parts{1};
  std::array<double, most_parts> cut;  ///< wheel abscissa behind each part but the last [m]
  T merged{1.0};                       ///< weight of the whole as one patch, the rest goes to its parts (S8)
  // Found:
  T force, response;  ///< sum of the strips' forces [N], and for a metre more of interpenetration [N/m]
  std::array<StripPatch<T>, most_parts + 1> patch;  ///< the whole, then its parts
  T factor{1.0}, size{1.0};                         ///< what other regions leave of the force, of lengths and pressure
};

/// All regions of some wheels.
template <Scalar T>
struct Batch {
  std::span<StripWheel<T>> wheels;
  std::array<GapScan, most_wheels> scan;
  int count{0};
  std::array<Region<T>, most_wheels * max_regions> region;
};

RelativePose<double> numbers(RelativePose<double> const& pose) { return pose; }
RelativePose<double> numbers(RelativePose<StripDual> const& pose) { return numbers_of(pose); }

/// Gap at an extreme found by the nodes, exact: its place is polished first.
template <Scalar T>
T gap_at(WheelRollerPair const& pair, RelativePose<T> const& pose, double s) {
  auto const plain = numbers(pose);
  ReducedSlope f;
  for (int i = 0; i < 2; ++i) {
    f = reduce_with_slope(pair, plain, s);
    double const step = std::abs(f.gradient) > 1e-3 ? -f.residual / f.gradient : 0.0;
    s += std::clamp(step, -0.3e-3 * pair.size, 0.3e-3 * pair.size);
  }
  return contact_point(pair, pose, s, std::abs(f.gradient) > 1e-3 ? f.gradient : 1e9).gap;
}

/// Where a region counts as two patches: at rises between its minima that do not lie deep in the material. (S8)
template <Scalar T>
void find_parts(StripWheel<T> const& wheel, GapScan const& scan, Region<T>& region) {
  WheelRollerPair const& pair = wheel.wheel->pair;
  ArcLength const& arc = wheel.wheel->nodes->arc();
  for (int i = region.range->first; i < region.range->last; ++i) {
    auto const &left = scan.minimum[at(i)], &right = scan.minimum[at(i + 1)], &top = scan.rise[at(i)];
    constexpr double sure = 0.03;  // the nodes' estimate is closer
    double const about = top.gap / std::max(left.gap, right.gap);
    if (about > 0.9 + sure || region.parts == most_parts) continue;
    T const g = gap_at(pair, wheel.pose, arc.abscissa(left.position));
    T const h = gap_at(pair, wheel.pose, arc.abscissa(right.position));
    T const shallower = select(g < h, h, g);  // both negative
    double const cut = arc.abscissa(top.position);
    T const m = strip_detail::smooth_step(T((gap_at(pair, wheel.pose, cut) / shallower - 0.7) / 0.2));
    if (!(m < 1.0)) continue;
    region.merged = select(m < region.merged, m, region.merged);
    region.cut[region.parts++ - 1] = cut;
  }
}

template <Scalar T>
void find_regions(Batch<T>& batch) {
  batch.count = 0;
  for (std::size_t i = 0; i < batch.wheels.size(); ++i) {
    auto const& wheel = batch.wheels[i];
    batch.scan[i] = scan_gap(wheel.wheel->pair, *wheel.wheel->nodes, numbers(wheel.pose));
    for (int k = 0; k < batch.scan[i].regions; ++k) {
      Region<T>& region = batch.region[at(batch.count++)];
      region.wheel = static_cast<int>(i);
      region.range = &batch.scan[i].region[at(k)];
      region.parts = 1;
      region.merged = region.factor = region.size = T(1.0);
      find_parts(wheel, batch.scan[i], region);
    }
  }
}

template <class L, Scalar T>
void take_patch(RegionPart<L> const& from, int i, StripPatch<T>& to) {
  auto const get = [i](L const& x) {
    if constexpr (std::same_as<L, T>)
      return x;
    else
      return lane(x, i);
  };
  auto const get3 = [&](Vec3<L> const& v) { return Vec3<T>{get(v.x), get(v.y), get(v.z)}; };
  to = {T(1.0),
        get(from.normal),
        get3(from.direction),
        get3(from.point),
        get3(from.moment),
        get(from.wheel_s),
        get(from.rail_y),
        get(from.a),
        get(from.b),
        lane(from.approach, i),
        lane(from.peak_pressure, i),
        lane(from.length, i),
        lane(from.width, i)};
}

/// Shares of the strips in the part between two places of the wheel's profile: of strips that are cut, a fraction.
template <class T>
void share_between(StripPlaces<T> const& places, NumberOf<T> const& from, NumberOf<T> const& to, StripRow<T>& share) {
  constexpr std::size_t n = strip_count;
  T const inverse = static_cast<double>(n - 1) / (places.wheel_s[n - 1] - places.wheel_s[0]);
  auto const before = [&](NumberOf<T> const& s, std::size_t i) {
    T const t = (s - places.wheel_s[i]) * inverse + 0.5;
    return select(t < 0.0, T(0.0), select(t > 1.0, T(1.0), t));
  };
  for (std::size_t i = 0; i < n; ++i) share[i] = before(to, i) - before(from, i);
}

/// Regions side by side. L: T, or lanes of it.
template <class L, Scalar T>
void solve_pack(Batch<T>& batch, int first, int count) {
  using N = NumberOf<L>;
  constexpr int lanes = lanes_of<N>;
  StripTables const& tables = strip_tables();
  RegionPack<L> pack;
  std::size_t parts = 1;
  bool coupled = false;
  std::array<N, most_parts + 1> cut;
  for (auto& c : cut) c = N(1e3);
  cut[0] = N(-1e3);
  for (int i = 0; i < lanes; ++i) {
    auto const& region = batch.region[at(first + std::min(i, count - 1))];
    auto const& wheel = batch.wheels[at(region.wheel)];
    coupled = coupled || batch.scan[at(region.wheel)].regions > 1;
    pack.pair.set(i, wheel.wheel->pair, wheel.wheel->nodes->arc().abscissae());
    set_lane(pack.pose, i, wheel.pose);
    set_lane(pack.compliance, i, wheel.wheel->material.compliance() / pi);
    for (std::size_t k = 0; k < 2; ++k) {
      RegionEnd const& end = k == 0 ? region.range->left : region.range->right;
      set_lane(pack.end[k].place, i, end.position);
      set_lane(pack.end[k].low, i, std::min(end.inside, end.outside));
      set_lane(pack.end[k].high, i, std::max(end.inside, end.outside));
      set_lane(pack.end[k].is_root, i, end.is_root ? 1.0 : 0.0);
    }
    parts = std::max(parts, region.parts);
    for (std::size_t k = 1; k < region.parts; ++k) set_lane(cut[k], i, region.cut[k - 1]);
  }
  Strips<L> strips;
  StripPlaces<L> places;
  lay_strips(tables, pack, strips, places);
  solve_strips(tables, strips, coupled);
  StripRow<L> share;
  share.fill(L(1.0));
  L response(0.0);
  for (auto const& g : strips.response) response += strips.width * g;
  for (std::size_t k = 0; k <= (parts > 1 ? parts : 0); ++k) {
    if (k > 0) share_between(places, cut[k - 1], k == parts ? N(1e3) : cut[k], share);
    RegionPart<L> const part = part_of(tables, strips, places, share);
    for (int i = 0; i < count; ++i) {
      auto& region = batch.region[at(first + i)];
      if (k == 0) {
        if constexpr (std::same_as<L, T>)
          region.force = part.force, region.response = response;
        else
          region.force = lane(part.force, i), region.response = lane(response, i);
      }
      if (k == 0 || k <= region.parts) take_patch(part, i, region.patch[k]);
    }
  }
}

/// As many at once as there are, at most W.
template <int W, Scalar T>
void solve_regions(Batch<T>& batch) {
  for (int first = 0; first < batch.count;) {
    int const left = batch.count - first;
    if constexpr (!std::same_as<T, double> || W == 1) {
      solve_pack<T>(batch, first++, 1);
    } else {
      constexpr int half = W > 2 ? W / 2 : W;
      if (left == 1)  // one number at a time is quicker than lanes that are filled with repetitions
        solve_pack<double>(batch, first++, 1);
      else if (left <= half)
        solve_pack<Lanes<half>>(batch, first, left), first += half;
      else
        solve_pack<Lanes<W>>(batch, first, std::min(left, W)), first += W;
    }
  }
}

/// What the loads of several regions of a wheel make of each other: each deflects the others as a point load does, which takes
/// so much of their interpenetration, and the force of a region goes with the 3/2 power of that. Coupling is weak: a few rounds.
template <Scalar T>
void couple(Material const& material, std::span<Region<T>> regions) {
  using std::sqrt;
  double const compliance = material.compliance() / pi;
  constexpr int rounds = 8;
  for (int round = 0; regions.size() > 1 && round < rounds; ++round)
    for (auto& r : regions) {
      T taken(0.0);
      for (auto const& other : regions) {
        if (&other == &r) continue;
        auto const between = other.patch[0].point - r.patch[0].point;
        taken += compliance * other.factor * other.force / sqrt(dot(between, between));
      }
      T const left = 1.0 - taken * r.response / (1.5 * r.force + 1e-30);
      T const part = select(left > 1e-6, left, T(1e-6));
      r.size = sqrt(part);
      r.factor = part * r.size;
    }
}

template <Scalar T>
void add_patch(Region<T> const& region, std::size_t part, T const& weight, StripSolution<T>& found) {
  if (found.count == StripSolution<T>::capacity || !(weight > 0.0)) return;
  StripPatch<T> patch = region.patch[part];
  patch.normal = region.factor * patch.normal;
  if (!(patch.normal > 1e-12)) return;
  patch.weight = weight;
  patch.moment = region.factor * patch.moment;
  patch.a = region.size * patch.a;
  patch.b = region.size * patch.b;
  patch.peak_pressure *= value_of(region.size);
  patch.length *= value_of(region.size);
  patch.width *= value_of(region.size);
  found.patch[at(found.count++)] = patch;
}

template <Scalar T>
void collect(Batch<T>& batch) {
  for (auto& wheel : batch.wheels) wheel.found.count = 0;
  for (int first = 0; first < batch.count;) {
    int const wheel = batch.region[at(first)].wheel;
    int last = first;
    while (last < batch.count && batch.region[at(last)].wheel == wheel) ++last;
    std::span<Region<T>> const regions(&batch.region[at(first)], at(last - first));
    auto& owner = batch.wheels[at(wheel)];
    couple(owner.wheel->material, regions);
    for (auto const& region : regions) {
      add_patch(region, 0, region.merged, owner.found);
      if (!(region.merged < 1.0)) continue;
      for (std::size_t k = 1; k <= region.parts; ++k) add_patch(region, k, T(1.0 - region.merged), owner.found);
    }
    first = last;
  }
}

}  // namespace

template <Scalar T, int W>
void strip_contacts(std::span<StripWheel<T>> wheels) {
  thread_local Batch<T> batch;  // scratch, too large to be set up in every call
  for (; !wheels.empty(); wheels = wheels.subspan(batch.wheels.size())) {
    batch.wheels = wheels.first(std::min(wheels.size(), most_wheels));
    find_regions(batch);
    solve_regions<W>(batch);
    collect(batch);
  }
}

template void strip_contacts<double, native_lanes>(std::span<StripWheel<double>>);
template void strip_contacts<StripDual, native_lanes>(std::span<StripWheel<StripDual>>);
#if ROLLERRIG_LANES
template void strip_contacts<double, 1>(std::span<StripWheel<double>>);  // what lanes are compared with
#endif

}  // namespace rollerrig
