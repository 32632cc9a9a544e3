// contact/normal/blending_weight.hpp - how much of each patch counts where two indented minima of the gap are about to become one.
//
// The paper adds one Hertz contact per indented minimum. A minimum can vanish by meeting the maximum beside it (a fold)
// while it is still indented; its whole force, tens of kilonewtons for S1002 on UIC60 near the centred position, would
// then drop to zero in an instant. Here a patch counts in full while the barrier between it and its neighbour, the height
// of the maximum over the minimum, is at least a fraction (merging_criterion) of its own approach; below that its share falls
// smoothly, to zero at the fold. The patch with the highest barrier always counts in full, so a lone patch is untouched.
//
//     t_k = barrier_k / (merging_criterion approach_k),   S_k = t^2 (3 - 2 t) for t < 1, else 1,   share_k = S_k / max_j S_j
//
// A patch between two others has the product of two S. Above 0.01 the rule acts on the centred position of S1002 on UIC60 in
// soft material and moves its linear critical speed: docs/theory/contact_forces.md, (F4).
// Source: our own rule; the paper is silent. Runs count how often it acts.
#pragma once
#include <array>

#include "rollerrig/geometry/contact_point.hpp"
#include "rollerrig/geometry/search.hpp"

namespace rollerrig {

template <Scalar T>
using PatchShares = std::array<T, ContactSearch::max_minima>;

/// @param points         contact points of the search's minima, in order
/// @param merging_criterion  [-]; 0: every patch counts in full
template <Scalar T>
PatchShares<T> patch_shares(WheelRollerPair const& pair, RelativePose<T> const& pose, ContactSearch const& search,
                            ContactPoint<T> const* points, double merging_criterion) {
  PatchShares<T> share;
  int const n = search.count();
  for (int k = 0; k < n; ++k) share[static_cast<std::size_t>(k)] = T(1.0);
  for (int k = 0; k + 1 < n; ++k) {
    auto const& top = search.barrier(k);
    double const lower = std::min(-search[k].gap, -search[k + 1].gap);  // the shallower approach
    if (!(top.gap + lower < merging_criterion * lower)) continue;       // a barrier in full: nothing fades
    T const top_gap = contact_point(pair, pose, top.s, top.gradient).gap;
    for (int side : {k, k + 1}) {
      T const t = (top_gap - points[side].gap) / (merging_criterion * -points[side].gap);
      T const s = select(t < 1.0, t * t * (3.0 - 2.0 * t), T(1.0));
      auto& own = share[static_cast<std::size_t>(side)];
      own = own * select(t > 0.0, s, T(0.0));
    }
  }
  T largest(0.0);
  for (int k = 0; k < n; ++k)
    largest = select(share[static_cast<std::size_t>(k)] > largest, share[static_cast<std::size_t>(k)], largest);
  for (int k = 0; k < n; ++k)
    share[static_cast<std::size_t>(k)] = largest > 0.0 ? share[static_cast<std::size_t>(k)] / largest : T(1.0);
  return share;
}

}  // namespace rollerrig
