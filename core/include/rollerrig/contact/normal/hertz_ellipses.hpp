// contact/normal/hertz_ellipses.hpp - the paper's normal contact: Hertz' ellipse at each indented minimum of the gap.
//
//   minima of the gap -> contact points -> Hertz (12)-(19) -> patches, weighted by (F4) where two merge
#pragma once
#include <array>

#include "rollerrig/contact/normal/hertz.hpp"
#include "rollerrig/contact/normal/normal_patch.hpp"
#include "rollerrig/geometry/contact_point.hpp"
#include "rollerrig/geometry/gap_nodes.hpp"

namespace rollerrig {

/// The weight of each patch where two indented minima of the gap are about to merge.
///
/// The paper adds one Hertz contact per indented minimum. A minimum can vanish by meeting the maximum beside it (a fold)
/// while it is still indented; its whole force, tens of kilonewtons for S1002 on UIC60 near the centred position, would
/// then drop to zero in an instant. Here a patch counts in full while the barrier between it and its neighbour, the height
/// of the maximum over the minimum, is at least a fraction (the merging criterion) of its own approach; below that its weight
/// falls smoothly, to zero at the fold. The patch with the highest barrier always counts in full: a lone patch is untouched.
///
///     t_k = barrier_k / (merging_criterion approach_k),   S_k = t^2 (3 - 2 t) for t < 1, else 1,   weight_k = S_k / max_j S_j
///
/// A patch between two others has the product of two S. Above 0.01 the rule acts on the centred position of S1002 on UIC60 in
/// soft material and moves its linear critical speed: docs/theory/contact_forces.md, (F4).
/// Source: our own rule; the paper is silent. Runs count how often it acts.
template <Scalar T>
using BlendingWeights = std::array<T, GapMinima::capacity>;

/// @param points             contact points of the minima, in order
/// @param merging_criterion  [-]; 0: every patch counts in full
template <Scalar T>
BlendingWeights<T> blending_weights(WheelRollerPair const& pair, RelativePose<T> const& pose, GapMinima const& minima,
                                    ContactPoint<T> const* points, double merging_criterion) {
  BlendingWeights<T> weight;
  std::size_t const n = minima.count;
  for (std::size_t k = 0; k < n; ++k) weight[k] = T(1.0);
  for (std::size_t k = 0; k + 1 < n; ++k) {
    auto const& top = minima.barrier[k];
    double const shallower = std::min(-minima.minimum[k].gap, -minima.minimum[k + 1].gap);
    if (!(top.gap + shallower < merging_criterion * shallower)) continue;  // a barrier in full: both count
    T const top_gap = contact_point(pair, pose, top).gap;
    for (std::size_t side : {k, k + 1}) {
      T const t = (top_gap - points[side].gap) / (merging_criterion * -points[side].gap);
      T const s = select(t < 1.0, t * t * (3.0 - 2.0 * t), T(1.0));
      weight[side] = weight[side] * select(t > 0.0, s, T(0.0));
    }
  }
  T largest(0.0);
  for (std::size_t k = 0; k < n; ++k) largest = select(weight[k] > largest, weight[k], largest);
  for (std::size_t k = 0; k < n; ++k) weight[k] = largest > 0.0 ? weight[k] / largest : T(1.0);
  return weight;
}

/// Hertz' ellipse and load at patch.point.
template <Scalar T>
void hertz_patch(Material const& material, NormalPatch<T>& patch) {
  using std::sqrt;
  auto const& point = patch.point;
  auto const hertz = hertz_contact(material, point.combined_curvature());  // (13), (14), (16)
  T const root_depth = sqrt(select(point.gap < 0.0, -point.gap, T(regularisation::approach)));
  patch.a = hertz.a_per_root * root_depth;  // (17), (18)
  patch.b = hertz.b_per_root * root_depth;
  patch.log_aspect = hertz.log_aspect;
  patch.limited = hertz.limited;
  patch.elastic = elastic_force(hertz.stiffness, point.gap);  // (12)
  patch.length = 2.0 * hertz.ahead_per_root * value_of(root_depth);
  patch.width = 2.0 * hertz.reach_per_root * value_of(root_depth);
  patch.peak_pressure = 1.5 / pi * value_of(patch.elastic) / (value_of(patch.a) * value_of(patch.b));
}

struct HertzEllipses {
  static constexpr char const* name = "hertz";
  double merging_criterion{0.01};
  static constexpr auto fields() {
    return members(Member{"merging_criterion", &HertzEllipses::merging_criterion, "1",
                          "criterion of normal/hertz_ellipses.hpp; 0: patches appear and vanish at full force",
                          not_negative});
  }

  template <Scalar T, std::derived_from<NormalPatch<T>> P>
  int operator()(NormalSetting const& wheel, RelativePose<T> const& pose, PatchList<P>& patches) const {
    auto const minima = find_minima(wheel.pair, *wheel.nodes, numbers_of(pose));
    std::array<ContactPoint<T>, GapMinima::capacity> points;
    for (std::size_t k = 0; k < minima.count; ++k) points[k] = contact_point(wheel.pair, pose, minima.minimum[k]);
    auto const weight = blending_weights(wheel.pair, pose, minima, points.data(), merging_criterion);
    for (std::size_t k = 0; k < minima.count; ++k) {
      NormalPatch<T>& patch = patches[k];
      patch.point = points[k];
      patch.weight = weight[k];
      hertz_patch(wheel.material, patch);
    }
    return static_cast<int>(minima.count);
  }
};

}  // namespace rollerrig
