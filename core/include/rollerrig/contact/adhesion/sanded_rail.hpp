// contact/adhesion/sanded_rail.hpp - sand on the rail: laid in front of a wheel, found by it and by all that follow.
//
//   flow of sand, way of the train -> [cells along the rail] -> mass per length under each wheel -> adhesion_map.hpp, (A19)
//
// Each wheel crushes and throws off a part of what it runs over. Sand is laid one cell ahead of the wheel and taken off one cell
// behind it, so that a wheel finds the same everywhere in a cell.
#pragma once
#include "rollerrig/contact/adhesion/rail_cells.hpp"

namespace rollerrig {

class SandedRail {
 public:
  void reset(double cell) { sand_.reset(cell); }

  /// Mass per length that a wheel finds [kg/m].
  double at(double arc_length) const { return sand_.at(arc_length); }

  /// A wheel runs from one arc length to another, a mass of sand in front of it [kg].
  ///
  /// @param kept  of the sand under the wheel that stays on the rail [-]
  void run(double from, double to, double mass, double kept) {
    double const cell = sand_.cell_length(), way = to - from;
    if (mass > 0.0) {
      bool const stands = way < shortest;  // then all of it falls on one cell
      sand_.add(from + cell, stands ? from + 2.0 * cell : to + cell, mass / (stands ? cell : way));
    }
    if (kept < 1.0) sand_.keep(from - cell, to - cell, kept);
  }

  void state(auto& archive) { archive(sand_); }

 private:
  static constexpr double shortest = 1e-9;  ///< way of a step [m]
  RailCells sand_;
};

}  // namespace rollerrig
