// contact/normal/blending_weight.hpp - the weight of each patch where two indented minima of the gap are about to merge.
//
// The paper adds one Hertz contact per indented minimum. A minimum can vanish by meeting the maximum beside it (a fold)
// while it is still indented; its whole force, tens of kilonewtons for S1002 on UIC60 near the centred position, would
// then drop to zero in an instant. Here a patch counts in full while the barrier between it and its neighbour, the height
// of the maximum over the minimum, is at least a fraction (the merging criterion) of its own approach; below that its weight
// falls smoothly, to zero at the fold. The patch with the highest barrier always counts in full: a lone patch is untouched.
//
//     t_k = barrier_k / (merging_criterion approach_k),   S_k = t^2 (3 - 2 t) for t < 1, else 1,   weight_k = S_k / max_j S_j
//
// A patch between two others has the product of two S. Above 0.01 the rule acts on the centred position of S1002 on UIC60 in
// soft material and moves its linear critical speed: docs/theory/contact_forces.md, (F4).
// Source: our own rule; the paper is silent. Runs count how often it acts.
#pragma once
#include <array>

#include "rollerrig/geometry/contact_point.hpp"
#include "rollerrig/geometry/gap_minima.hpp"

namespace rollerrig {

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

}  // namespace rollerrig
