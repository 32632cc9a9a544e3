// contact/creep/creep_law.hpp - the creep laws a configuration can name: from creepage and ellipse to the force on the wheel.
//
//   creepage, ellipse, adhesion -> [creep law] -> tangential force and spin moment on the wheel
//
// To add a law: a struct in a header of its own, with its name, its fields and
// `CreepForce<T> operator()(CreepQuery<T> const&) const`, and its line below: docs/how_to/contact_law.md. The patches of several
// wheels are asked in lanes: by one call of a law that takes no decision on a T and says so with `static constexpr bool
// in_lanes = true`, patch by patch of any other.
#pragma once
#include "rollerrig/contact/adhesion/friction.hpp"
#include "rollerrig/contact/creep/creep_table.hpp"
#include "rollerrig/contact/creep/fastsim.hpp"
#include "rollerrig/contact/creep/kalker_laws.hpp"
#include "rollerrig/contact/creep/polach.hpp"
#include "rollerrig/contact/creep/strip_theory.hpp"

namespace rollerrig {

using CreepLaw = OneOf<KalkerSaturated,  // the paper's
                       KalkerLinear,     //
                       Coefficients,     //
                       Fastsim,          //
                       ModifiedFastsim,  //
                       Polach,           //
                       TableLaw,         //
                       StripTheory>;

/// Whether the law wants the strips of a patch as well.
template <class... Laws>
bool follows_strips(std::variant<Laws...> const& law) {
  return std::visit([]<class Law>(Law const&) { return requires { requires Law::follows_strips; }; }, law);
}

/// The answer of `ask` to query and rail: in one call, or lane by lane.
template <class Law, class T, class Ask, template <class> class... In>
CreepForce<T> answer(Ask const& ask, In<T> const&... in) {
  if constexpr (lanes_of<T> == 1 || requires { requires Law::in_lanes; })
    return ask(in...);
  else
    return each_lane<CreepForce>(ask, in...);
}

template <Scalar T>
CreepForce<T> creep_force(CreepLaw const& law, CreepQuery<T> const& query) {
  return std::visit(
      [&]<class Law>(Law const& chosen) { return answer<Law, T>([&](auto const& q) { return chosen(q); }, query); },
      law);
}

/// The law on a rail whose condition reduces the creep curve's stiffness. A law with k_A and k_S takes the rail's in place of
/// its own by a second operator(); any other law gets the same slope at the origin, (k_A + k_S)/2 of Kalker's (A4): its surfaces
/// are so much more compliant everywhere, beside what it reduces itself.
template <Scalar T>
CreepForce<T> creep_force(CreepLaw const& law, CreepQuery<T> const& query, RailSurface<T> const& rail) {
  return std::visit(
      [&]<class Law>(Law const& chosen) {
        auto const ask = [&](auto const& q, auto const& r) {
          if constexpr (requires { chosen(q, r); })
            return chosen(q, r);
          else
            return chosen(with_reduced_stiffness(q, mean_reduction(r)));
        };
        return answer<Law, T>(ask, query, rail);
      },
      law);
}

}  // namespace rollerrig
