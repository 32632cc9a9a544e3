// contact/patch_lanes.hpp - creep forces of the patches of several wheels at once, side by side in lanes.
//
//   patches of all wheels under load -> [lanes of patches] -> contact/patch.hpp, once for as many patches as there are lanes
#pragma once
#include <span>

#include "rollerrig/contact/patch.hpp"

namespace rollerrig {

/// At most W patches, W not below 2. Lanes behind the last one repeat it.
template <int W>
void add_creep_forces_in_lanes(ContactLaws const& laws, double time, std::span<MovingPatch<double> const> patches);

/// Creepages and forces of patches of one set of laws, friction aside: by plain numbers or dual ones one after the other, in
/// lanes as many at once as a register holds.
template <Scalar T>
void add_creep_forces(ContactLaws const& laws, T const& time, std::span<MovingPatch<T> const> patches);

}  // namespace rollerrig
