// contact/adhesion/recovered_rail.hpp - what the leading wheels leave behind: energy dissipated on each piece of rail.
//
//   energy per area that a wheel dissipates -> [cells along the rail] -> what the following wheels find
//
// Rail that no wheel has touched yet is as contaminated as ever.
#pragma once
#include "rollerrig/contact/adhesion/rail_cells.hpp"

namespace rollerrig {

class RecoveredRail {
 public:
  static constexpr int cells = RailCells::cells;

  /// @param cell  length of a cell [m]
  void reset(double cell = 0.05) { energy_.reset(cell); }

  /// Energy per area already dissipated at an arc length [J/m^2].
  double at(double arc_length) const { return energy_.at(arc_length); }

  /// What a wheel finds: read in the cell ahead of it, in which nothing is its own yet.
  double before(double arc_length) const { return at(arc_length + energy_.cell_length()); }

  /// A wheel has run from one arc length to another (forward) and dissipated this energy per area.
  void dissipate(double from, double to, double energy_per_area) { energy_.add(from, to, energy_per_area); }

  void state(auto& archive) { archive(energy_); }

 private:
  RailCells energy_;
};

}  // namespace rollerrig
