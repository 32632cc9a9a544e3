#include "rollerrig/contact/normal/strip_contact.hpp"

#include <cmath>
#include <vector>

#include "rollerrig/contact/normal/region_pieces.hpp"
#include "rollerrig/contact/normal/strip_patch.hpp"

namespace rollerrig {
namespace {

constexpr std::size_t most_wheels = 16;                              // of one batch; more come in several
constexpr std::size_t most_parts = 4;                                // of a region
constexpr std::size_t most_readings = 3 * GapScan::most_minima / 2;  // of a wheel

constexpr std::size_t refined_strips = 32;
constexpr int refined_passes = 10;
// Change of the force in the last pass from which on these count, and beyond which they alone do [-].
constexpr double unsettled = 0.01, not_settled = 0.02;

/// A region, or a piece of one, to be solved, and what came out. Some are solved as one and as several pieces, with weights.
template <Scalar T>
struct Region {
  int wheel{0}, group{0};
  bool joined{false};  ///< several pieces of the group as one
  RegionEnd left, right;
  std::array<T, 2> end;  ///< their places [m]
  T weight{1.0};         ///< of this reading of the group
  std::size_t parts{1};
  std::array<T, most_parts> cut;  ///< place along the arc behind each part but the last [m]
  T merged{1.0};                  ///< weight of the whole as one patch, the rest goes to its parts (S8)
  // Found:
  T change;                                         ///< of the force in the last pass, over the force [-]
  T depth;                                          ///< of the paraboloid that stands for it [m]
  std::array<StripPatch<T>, most_parts + 1> patch;  ///< the whole, then its parts
  T factor{1.0}, size{1.0};                         ///< what other regions leave of the force, of lengths and pressure
};

/// All regions of some wheels.
template <Scalar T>
struct Batch {
  std::span<StripWheel<T>> wheels;
  int count{0};
  std::array<Region<T>, most_wheels * most_readings> region;
  std::vector<RegionStrips<T>> strips;  ///< of each region, as far as its wheel asks for them

  RegionStrips<T>* strips_of(int index) {
    if (!wheels[at(region[at(index)].wheel)].strips) return nullptr;
    if (strips.size() <= at(index)) strips.resize(at(index) + 1);
    return &strips[at(index)];
  }
};

template <Scalar T>
void add_region(Batch<T>& batch, int wheel, int group, Divisions<T> const& divisions, Piece<T> const& from,
                Piece<T> const& to, T const& weight) {
  Region<T>& region = batch.region[at(batch.count++)];
  region.wheel = wheel;
  region.group = group;
  region.joined = &to != &from;
  region.weight = weight;
  region.left = from.left;
  region.right = to.right;
  region.end = {from.end[0], to.end[1]};
  region.parts = 1;
  region.merged = region.factor = region.size = T(1.0);
  for (int i = from.first; i < to.last; ++i) {
    auto const& here = divisions[at(i)];
    if (!here.possible || !(here.merged < 1.0) || region.parts == most_parts) continue;
    region.merged = select(here.merged < region.merged, here.merged, region.merged);
    region.cut[region.parts++ - 1] = here.place;
  }
  if (auto* strips = batch.strips_of(batch.count - 1)) strips->count = 0;
}

template <Scalar T>
void find_regions(Batch<T>& batch) {
  batch.count = 0;
  Divisions<T> divisions;
  Pieces<T> piece;
  for (std::size_t i = 0; i < batch.wheels.size(); ++i) {
    auto const& wheel = batch.wheels[i];
    auto const scan = scan_gap(wheel.wheel->pair, *wheel.wheel->nodes, numbers_of(wheel.pose));
    find_divisions(*wheel.wheel, wheel.pose, scan, divisions);
    int const pieces = find_pieces(scan, divisions, piece);
    for (int from = 0, to = 0; from < pieces; from = ++to) {
      T joined(1.0);
      for (; piece[at(to)].joined > 0.0; ++to)
        joined = select(piece[at(to)].joined < joined, piece[at(to)].joined, joined);
      auto const add = [&](int first, int last, T const& weight) {
        add_region(batch, static_cast<int>(i), from, divisions, piece[at(first)], piece[at(last)], weight);
      };
      add(from, to, joined);
      if (joined < 1.0)
        for (int k = from; k <= to; ++k) add(k, k, T(1.0 - joined));
    }
  }
}

/// Shares of the strips in the part between two places along the wheel's arc.
template <class T, std::size_t n>
void shares_between(Strips<T, n> const& strips, T const& from, T const& to, StripRow<T, n>& share) {
  for (std::size_t i = 0; i < n; ++i)
    share[i] = strip_detail::share_between(strips.position[i], strips.width[i], from, to);
}

/// Regions side by side, with n strips each. L: T, or lanes of it.
template <class L, std::size_t n, Scalar T>
void solve_pack(Batch<T>& batch, int first, int count, int passes) {
  using N = NumberOf<L>;
  constexpr int lanes = lanes_of<N>;
  StripTables const& tables = strip_tables();
  RegionPack<L> pack;
  std::size_t parts = 1;
  std::array<L, most_parts + 1> cut;
  cut.fill(L(1e3));
  cut[0] = L(-1e3);
  for (int i = 0; i < lanes; ++i) {
    auto const& region = batch.region[at(first + std::min(i, count - 1))];
    auto const& wheel = batch.wheels[at(region.wheel)];
    pack.pair.set(i, wheel.wheel->pair, wheel.wheel->nodes->arc().abscissae());
    set_lane(pack.pose, i, wheel.pose);
    set_lane(pack.compliance, i, wheel.wheel->material.compliance() / pi);
    for (std::size_t k = 0; k < 2; ++k) {
      RegionEnd const& end = k == 0 ? region.left : region.right;
      if constexpr (std::same_as<L, T>)
        pack.end[k].place = region.end[k];
      else
        set_lane(pack.end[k].place, i, region.end[k]);
      set_lane(pack.end[k].low, i, std::min(end.inside, end.outside));
      set_lane(pack.end[k].high, i, std::max(end.inside, end.outside));
      set_lane(pack.end[k].is_root, i, end.is_root ? 1.0 : 0.0);
    }
    parts = std::max(parts, region.parts);
    for (std::size_t k = 1; k < region.parts; ++k) {
      if constexpr (std::same_as<L, T>)
        cut[k] = region.cut[k - 1];
      else
        set_lane(cut[k], i, region.cut[k - 1]);
    }
  }
  Strips<L, n> strips;
  StripPlaces<L, n> places;
  lay_strips(tables, pack, strips, places);
  solve_strips(tables, strips, passes);
  for (int i = 0; i < count; ++i)
    if (auto* all = batch.strips_of(first + i)) take_strips(tables, strips, places, i, *all);
  StripRow<L, n> share;
  share.fill(L(1.0));
  for (std::size_t k = 0; k <= (parts > 1 ? parts : 0); ++k) {
    if (k > 0) shares_between(strips, cut[k - 1], k == parts ? L(1e3) : cut[k], share);
    StripPatch<L> const part = part_of(tables, strips, places, share);
    for (int i = 0; i < count; ++i) {
      auto const own = [i](auto const& x) {
        if constexpr (std::same_as<L, T>)
          return x;
        else
          return lane(x, i);
      };
      auto& region = batch.region[at(first + i)];
      if (k == 0) region.depth = own(strips.depth), region.change = own(strips.change);
      if (k == 0 || k <= region.parts) region.patch[k] = part.template converted<T>(own);
    }
  }
}

template <Scalar T>
StripPatch<T> mixed(StripPatch<T> const& a, StripPatch<T> const& b, T const& s) {
  using std::sqrt;
  auto const mix = [&](auto const& x, auto const& y) { return x + s * (y - x); };
  double const part = value_of(s);
  auto const mix_number = [&](double x, double y) { return x + part * (y - x); };
  Vec3<T> const direction = mix(a.direction, b.direction);
  return {T(1.0),
          mix(a.force, b.force),
          mix(a.normal, b.normal),
          (1.0 / sqrt(dot(direction, direction))) * direction,
          mix(a.point, b.point),
          mix(a.moment, b.moment),
          mix(a.wheel_s, b.wheel_s),
          mix(a.rail_y, b.rail_y),
          mix(a.a, b.a),
          mix(a.b, b.b),
          mix_number(a.approach, b.approach),
          mix_number(a.peak_pressure, b.peak_pressure),
          mix_number(a.length, b.length),
          mix_number(a.width, b.width)};
}

/// How far a solution has not settled, 0 to 1.
template <Scalar T>
T open_part(T const& change) {
  T const size = select(change < 0.0, -change, change);
  return strip_detail::smooth_step(T((size - unsettled) / (not_settled - unsettled)));
}

/// Solves a region that has not settled once more, with many strips and passes, and leaves it to them as far as they have.
template <Scalar T>
void refine(Batch<T>& batch, int index) {
  Region<T>& region = batch.region[at(index)];
  if (std::abs(value_of(region.change)) <= unsettled) return;  // not: what is no number
  Region<T> const few = region;
  solve_pack<T, refined_strips>(batch, index, 1, refined_passes);
  auto* strips = batch.strips_of(index);
  if (!std::isfinite(value_of(region.change))) {
    region = few;
    if (strips) strips->count = static_cast<int>(strip_count);
    return;
  }
  T const s = open_part(few.change) * (1.0 - open_part(region.change));
  for (std::size_t k = 0; k <= (region.parts > 1 ? region.parts : 0); ++k)
    region.patch[k] = mixed(few.patch[k], region.patch[k], s);
  if (strips) {
    weigh(*strips, 0, static_cast<int>(strip_count), T(1.0 - s));
    weigh(*strips, static_cast<int>(strip_count), strips->count, s);
  }
  ++batch.wheels[at(region.wheel)].found.refined;
}

/// As many at once as there are, at most W.
template <int W, Scalar T>
void solve_regions(Batch<T>& batch) {
  for (int first = 0; first < batch.count;) {
    int const left = batch.count - first;
    if constexpr (!std::same_as<T, double> || W == 1) {
      solve_pack<T, strip_count>(batch, first++, 1, strip_passes);
    } else {
      constexpr int half = W > 2 ? W / 2 : W;
      if (left == 1)  // one number at a time is quicker than lanes that are filled with repetitions
        solve_pack<double, strip_count>(batch, first++, 1, strip_passes);
      else if (left <= half)
        solve_pack<Lanes<half>, strip_count>(batch, first, left, strip_passes), first += half;
      else
        solve_pack<Lanes<W>, strip_count>(batch, first, std::min(left, W), strip_passes), first += W;
    }
  }
  for (int i = 0; i < batch.count; ++i) refine(batch, i);
}

/// What the loads of several regions of a wheel make of each other: each deflects the others as a point load does, as far as its
/// direction is theirs. That takes so much of their interpenetration, and the force of a region goes with the 3/2 power of what is left.
/// Coupling is weak: a few rounds.
template <Scalar T>
void couple(Material const& material, std::span<Region<T>> regions) {
  using std::sqrt;
  double const compliance = material.compliance() / pi;
  constexpr int rounds = 8;
  for (int round = 0; regions.size() > 1 && round < rounds; ++round)
    for (auto& r : regions) {
      T taken(0.0);
      for (auto const& other : regions) {
        bool const same_group = other.group == r.group;
        if (&other == &r || (same_group && (r.joined || other.joined))) continue;
        auto const between = other.patch[0].point - r.patch[0].point;
        T const facing = dot(other.patch[0].direction, r.patch[0].direction);
        T const force = other.factor * other.patch[0].force * (same_group ? T(1.0) : other.weight);
        taken += compliance * facing * force / sqrt(dot(between, between));
      }
      T const left = 1.0 - taken / r.depth;
      T const part = select(left > 1e-6, left, T(1e-6));
      r.size = sqrt(part);
      r.factor = part * r.size;
    }
}

template <Scalar T>
void add_patch(Region<T> const& region, std::size_t part, T const& weight, RegionStrips<T> const* strips,
               StripWheel<T>& wheel) {
  auto& found = wheel.found;
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
  if (strips) {
    T const from = part > 1 ? region.cut[part - 2] : T(-1e3);
    T const to = part > 0 && part < region.parts ? region.cut[part - 1] : T(1e3);
    strips_of_part(*strips, from, to, region.factor, region.size, T(pi * patch.a * patch.b),
                   (*wheel.strips)[at(found.count)]);
  }
  found.patch[at(found.count++)] = patch;
}

template <Scalar T>
void collect(Batch<T>& batch) {
  for (int first = 0; first < batch.count;) {
    int const wheel = batch.region[at(first)].wheel;
    int last = first;
    while (last < batch.count && batch.region[at(last)].wheel == wheel) ++last;
    std::span<Region<T>> const regions(&batch.region[at(first)], at(last - first));
    auto& owner = batch.wheels[at(wheel)];
    couple(owner.wheel->material, regions);
    for (int i = first; i < last; ++i) {
      auto const& region = batch.region[at(i)];
      auto const* strips = batch.strips_of(i);
      add_patch(region, 0, T(region.weight * region.merged), strips, owner);
      if (!(region.merged < 1.0)) continue;
      T const weight = region.weight * (1.0 - region.merged);
      for (std::size_t k = 1; k <= region.parts; ++k) add_patch(region, k, weight, strips, owner);
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
    for (auto& wheel : batch.wheels) wheel.found.count = wheel.found.refined = 0;
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
