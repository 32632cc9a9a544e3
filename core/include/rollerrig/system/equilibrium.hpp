// system/equilibrium.hpp - static and steady-rolling equilibrium, solved by Newton's method with the exact Jacobian.
//
// Unknown: coordinates, wheelset spin rates, inner nodes of dampers. Given: rollers turn (or rails move) at the running
// speed, all other rates are zero. Equations: accelerations and node rates vanish; a vehicle that is free along its track may
// keep up to 10 N of rolling resistance that nothing can balance (it coasts). Where Newton's method leads nowhere the system
// is let run there in heavily damped motion first.
#pragma once
#include <string>
#include <vector>

#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {

/// A coordinate kept at a value while the others find their equilibrium.
struct FixedCoordinate {
  int body{0};
  int coordinate{coord_y};
  double value{0.0};  ///< [m or rad]
};

struct Equilibrium {
  bool converged{false};
  int iterations{0};      ///< Jacobians evaluated
  double residual{0.0};   ///< largest unbalanced force [N] or moment [N m]
  std::vector<double> x;  ///< state
};

/// @param speed  running speed [m/s]; may be zero
/// @param t      time at which tables are read [s]
/// @param fixed   coordinates that keep their value
/// @param near   state close to the one looked for, such as that of a neighbouring speed, or the one without the fixed
///               coordinates: Newton's method starts there, with the spins of rolling, and with wheelsets that have fixed
///               coordinates stood on their wheels; empty, or where it leads nowhere: from a first guess
/// @param only_near  Newton's method alone, from that state as it is: continuation takes a smaller step where it leads nowhere
Equilibrium solve_equilibrium(Dynamics& dynamics, double speed, double t,
                              std::vector<FixedCoordinate> const& fixed = {}, std::vector<double> const& near = {},
                              bool only_near = false);

/// Lowers or lifts a body in the state x to where what carries it balances what presses on it, within `reach` [m] and to a
/// `resolution` [m]; whether there is such a place.
bool set_down(Dynamics& dynamics, double t, std::vector<double>& x, int body, double reach, double resolution);

}  // namespace rollerrig
