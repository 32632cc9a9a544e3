// contact/normal/normal_law.hpp - the laws of normal contact a configuration can name: how the surfaces carry load.
//
//   indented minima of the gap -> [normal law] -> patches of one wheel: load, centre, ellipse
//
// To add a law: a struct in a header of its own, with its name, its fields and
// `int operator()(NormalSetting const&, RelativePose<T> const&, ContactSearch const&, PatchList<P>&) const`, which returns
// the number of patches, and its line below: docs/how_to/contact_law.md.
#pragma once
#include "rollerrig/contact/normal/hertz_ellipses.hpp"
#include "rollerrig/contact/normal/strip_contact.hpp"
#include "rollerrig/fields.hpp"

namespace rollerrig {

using NormalLaw = OneOf<HertzEllipses,  // the paper's
                        ElasticStrips>;

template <Scalar T, std::derived_from<NormalPatch<T>> P>
int normal_patches(NormalLaw const& law, NormalSetting const& wheel, RelativePose<T> const& pose,
                   ContactSearch const& search, PatchList<P>& patches) {
  return std::visit([&](auto const& chosen) { return chosen(wheel, pose, search, patches); }, law);
}

}  // namespace rollerrig
