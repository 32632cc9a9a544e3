// contact/creep/creep_law.hpp - the creep laws a configuration can name: from creepage and ellipse to the force on the wheel.
//
//   creepage, ellipse, adhesion -> [creep law] -> tangential force and spin moment on the wheel
//
// To add a law: a struct in a header of its own, with its name, its fields and
// `CreepForce<T> operator()(CreepQuery<T> const&) const`, and its line below: docs/how_to/contact_law.md.
#pragma once
#include "rollerrig/contact/adhesion/adhesion_map.hpp"
#include "rollerrig/contact/creep/creep_table.hpp"
#include "rollerrig/contact/creep/fastsim.hpp"
#include "rollerrig/contact/creep/kalker_laws.hpp"
#include "rollerrig/contact/creep/polach.hpp"

namespace rollerrig {

using CreepLaw = OneOf<KalkerSaturated,  // the paper's
                       KalkerLinear,     //
                       Fastsim,          //
                       ModifiedFastsim,  //
                       Polach,           //
                       TableLaw>;

template <Scalar T>
CreepForce<T> creep_force(CreepLaw const& law, CreepQuery<T> const& query) {
  return std::visit([&](auto const& chosen) { return chosen(query); }, law);
}

/// The law on a rail whose condition reduces the creep curve's stiffness, in place of the law's own reductions. A law with
/// k_A and k_S, or with reductions of its own, takes the rail's by a second operator(); any other law gets the same slope at
/// the origin, (k_A + k_S)/2 of Kalker's (A4): its surfaces are so much more compliant everywhere.
template <Scalar T>
CreepForce<T> creep_force(CreepLaw const& law, CreepQuery<T> const& query, RailSurface<T> const& rail) {
  return std::visit(
      [&](auto const& chosen) {
        if constexpr (requires { chosen(query, rail); })
          return chosen(query, rail);
        else
          return chosen(with_reduced_stiffness(query, mean_reduction(rail)));
      },
      law);
}

}  // namespace rollerrig
