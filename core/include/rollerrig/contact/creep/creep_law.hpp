// contact/creep/creep_law.hpp - the creep laws a configuration can name: from creepage and ellipse to the force on the wheel.
//
//   creepage, ellipse, adhesion -> [creep law] -> tangential force and spin moment on the wheel
//
// To add a law: write a struct with `CreepForce<T> operator()(CreepQuery<T> const&) const` in a header of its own, give it a
// name in CreepLawKind and a line in creep_force(); how a configuration then asks for it is in docs/how_to/contact_law.md.
#pragma once
#include "rollerrig/contact/adhesion/adhesion.hpp"
#include "rollerrig/contact/creep/creep_table.hpp"
#include "rollerrig/contact/creep/fastsim.hpp"
#include "rollerrig/contact/creep/kalker_laws.hpp"
#include "rollerrig/contact/creep/polach.hpp"

namespace rollerrig {

enum class CreepLawKind : int { kalker_linear, kalker_saturated, fastsim, modified_fastsim, polach, table };

/// A law and the parameters it needs.
struct CreepLaw {
  CreepLawKind kind{CreepLawKind::kalker_saturated};
  bool saturate_spin_moment{false};  ///< kalker_saturated
  StiffnessReduction reduction{};    ///< modified_fastsim
  double k_A{1.0};                   ///< polach: k_A
  double k_S{1.0};                   ///< polach: k_S
  CreepTable const* table{nullptr};  ///< table
};

template <Scalar T>
CreepForce<T> creep_force(CreepLaw const& law, CreepQuery<T> const& query) {
  switch (law.kind) {
    case CreepLawKind::kalker_linear: return KalkerLinear{}(query);
    case CreepLawKind::fastsim: return Fastsim{}(query);
    case CreepLawKind::modified_fastsim: return Fastsim{true, law.reduction}(query);
    case CreepLawKind::polach: return Polach{law.k_A, law.k_S}(query);
    case CreepLawKind::table: return TableLaw{law.table}(query);
    case CreepLawKind::kalker_saturated: break;
  }
  return KalkerSaturated{law.saturate_spin_moment}(query);
}

/// The law on a rail whose condition weakens it, in place of the law's own reductions. k_A and k_S are Polach's; any other
/// law gets the same slope at the origin, (k_A + k_S)/2 of Kalker's: its surfaces give way by so much more everywhere.
template <Scalar T>
CreepForce<T> creep_force(CreepLaw const& law, CreepQuery<T> const& query, RailSurface<T> const& rail) {
  if (law.kind == CreepLawKind::polach) return Polach<T>{rail.k_A, rail.k_S}(query);
  T const left = 0.5 * (rail.k_A + rail.k_S);
  auto weak = query;
  weak.stiffness = {left * query.stiffness.f11, left * query.stiffness.f22, left * query.stiffness.f23,
                    left * query.stiffness.f33};
  if (law.kind == CreepLawKind::modified_fastsim) return Fastsim{true, {}}(weak);
  return creep_force(law, weak);
}

}  // namespace rollerrig
