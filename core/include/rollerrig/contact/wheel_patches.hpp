// contact/wheel_patches.hpp - all patches of one wheel, whichever way its surfaces carry normal load.
//
//   minima of the search -> [Hertz at each, or strips over what overlaps] -> patches with force and moment on the wheel
#pragma once
#include "rollerrig/contact/normal/blending_weight.hpp"
#include "rollerrig/contact/normal/strip_contact.hpp"
#include "rollerrig/contact/patch.hpp"

namespace rollerrig {

template <Scalar T>
using WheelPatches = std::array<Patch<T>, ContactSearch::max_minima>;

/// The paper's: one ellipse per indented minimum, handed over by (F4).
template <Scalar T>
int hertz_patches(WheelRollerPair const& pair, ContactLaws const& laws, ContactSearch const& search,
                  RelativePose<T> const& pose, ContactMotion<T> const& motion, T const& time,
                  WheelPatches<T>& patches) {
  std::array<ContactPoint<T>, ContactSearch::max_minima> points;
  auto const n = static_cast<std::size_t>(search.count());
  for (std::size_t k = 0; k < n; ++k) {
    auto const& root = search[static_cast<int>(k)];
    points[k] = contact_point(pair, pose, root.s, root.gradient);
  }
  auto const share = patch_shares(pair, pose, search, points.data(), laws.merging_criterion);
  for (std::size_t k = 0; k < n; ++k) {
    patches[k] = patch_force(laws, points[k], pose, motion, time);
    patches[k].scale(share[k]);
  }
  return search.count();
}

/// Strips: the creep law works on the equivalent ellipse at the pressures' centre. The wheel has one normal damper (12), which
/// its patches share by their load, so that a patch comes and goes without a step. (S6)-(S9)
template <Scalar T>
int strip_patches(WheelRollerPair const& pair, ContactLaws const& laws, ContactSearch const& search,
                  RelativePose<T> const& pose, ContactMotion<T> const& motion, T const& time,
                  WheelPatches<T>& patches) {
  auto const contact =
      strip_contact_of(pair, {laws.strip_kernel, laws.hertz, laws.wheel_arc}, laws.material, pose, search);
  auto const n = static_cast<std::size_t>(contact.count);
  T total(0.0);
  for (std::size_t k = 0; k < n; ++k) total += contact.patch[k].share * contact.patch[k].normal;
  for (std::size_t k = 0; k < n; ++k) {
    auto const& strip = contact.patch[k];
    ContactPoint<T> point{};
    point.wheel_s = strip.wheel_s;
    point.rail_y = strip.rail_y;
    point.gap = T(-strip.approach);
    point.p = strip.point;
    point.n = strip.direction;
    auto patch = patch_carried(laws, point, pose, motion, time, [&](Patch<T>& own) {
      using std::log;
      own.a = strip.a;
      own.b = strip.b;
      own.hertz.log_aspect = log(strip.a / strip.b);
      own.hertz.limited = false;
      T const damping = strip.normal / total * laws.damping.force(own.gap_rate);
      own.normal = {strip.normal, select(strip.normal + damping > 0.0, damping, -strip.normal)};
      own.peak_pressure = T(strip.peak_pressure);
    });
    patch.moment += strip.moment;
    patch.elastic_power += dot(strip.moment, relative_turning(laws.roller, motion));
    patch.scale(strip.share);
    patches[k] = patch;
  }
  return contact.count;
}

template <Scalar T>
int wheel_patches(WheelRollerPair const& pair, ContactLaws const& laws, ContactSearch const& search,
                  RelativePose<T> const& pose, ContactMotion<T> const& motion, T const& time,
                  WheelPatches<T>& patches) {
  if (laws.normal == NormalContactKind::strips) return strip_patches(pair, laws, search, pose, motion, time, patches);
  return hertz_patches(pair, laws, search, pose, motion, time, patches);
}

}  // namespace rollerrig
