// contact/creep_law.hpp - the creep laws a configuration can name: from creepage and ellipse to the force on the wheel.
//
//   creepage, ellipse, adhesion -> [creep law] -> tangential force and spin moment on the wheel
//
// To add a law: write a struct with `CreepForce<T> operator()(CreepQuery<T> const&) const` in a header of its own, give it a
// name in CreepLawKind and a line in creep_force(); how a configuration then asks for it is in docs/how_to/contact_law.md.
#pragma once
#include "rig/contact/creep_table.hpp"
#include "rig/contact/fastsim.hpp"
#include "rig/contact/kalker_laws.hpp"
#include "rig/contact/polach.hpp"

namespace rig {

enum class CreepLawKind : int { kalker_linear, kalker_saturated, fastsim, modified_fastsim, polach, table };

/// A law and the parameters it needs.
struct CreepLaw {
  CreepLawKind kind{CreepLawKind::kalker_saturated};
  bool saturate_spin_moment{false};  ///< kalker_saturated
  StiffnessReduction reduction{};    ///< modified_fastsim
  double stick_reduction{1.0};       ///< polach: k_A
  double slip_reduction{1.0};        ///< polach: k_S
  CreepTable const* table{nullptr};  ///< table
};

template <Scalar T>
CreepForce<T> creep_force(CreepLaw const& law, CreepQuery<T> const& query) {
  switch (law.kind) {
    case CreepLawKind::kalker_linear: return KalkerLinear{}(query);
    case CreepLawKind::fastsim: return Fastsim{}(query);
    case CreepLawKind::modified_fastsim: return Fastsim{true, law.reduction}(query);
    case CreepLawKind::polach: return Polach{law.stick_reduction, law.slip_reduction}(query);
    case CreepLawKind::table: return TableLaw{law.table}(query);
    case CreepLawKind::kalker_saturated: break;
  }
  return KalkerSaturated{law.saturate_spin_moment}(query);
}

}  // namespace rig
