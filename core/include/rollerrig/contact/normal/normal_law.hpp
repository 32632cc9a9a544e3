// contact/normal/normal_law.hpp - the laws of normal contact a configuration can name: how the surfaces carry load.
//
//   pose over rail or roller -> [normal law] -> patches of one wheel: load, centre, ellipse
//
// To add a law: a struct in a header of its own, with its name, its fields and
// `int operator()(NormalSetting const&, RelativePose<T> const&, PatchList<P>&) const`, which returns the number of patches, and
// its line below: docs/how_to/contact_law.md. Where the surfaces overlap, geometry/gap_nodes.hpp says. A law
// that is cheaper for several wheels at once has `void operator()(std::span<NormalContact<T, P> const>) const` instead.
#pragma once
#include <span>

#include "rollerrig/contact/normal/hertz_ellipses.hpp"
#include "rollerrig/contact/normal/strip_contact.hpp"
#include "rollerrig/fields.hpp"

namespace rollerrig {

using NormalLaw = OneOf<HertzEllipses,  // the paper's
                        ElasticStrips>;

template <Scalar T, std::derived_from<NormalPatch<T>> P>
void normal_patches(NormalLaw const& law, std::span<NormalContact<T, P> const> wheels) {
  std::visit(
      [&](auto const& chosen) {
        if constexpr (requires { chosen(wheels); })
          chosen(wheels);
        else
          for (auto const& w : wheels) *w.count = chosen(w.wheel, *w.pose, *w.patches);
      },
      law);
}

}  // namespace rollerrig
