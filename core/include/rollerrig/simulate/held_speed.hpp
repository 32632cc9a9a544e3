// simulate/held_speed.hpp - steady rolling of a braked vehicle: its state, and the torques that hold the rollers at their speed.
//
//   steady rolling without brakes, cylinder pressures -> [Newton's method on the exact linearisation] -> state, roller torques
#pragma once
#include <span>
#include <vector>

#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {

struct HeldSpeed {
  std::vector<double> x;
  std::vector<double> roller_torque;  ///< of each of the model, beside its table [N m]
  bool found{false};                  ///< else the wheels slide, or nothing holds the vehicle along the track
};

/// Rollers with a torque of their own keep the speed that they have in x; on track the frame has it.
///
/// @param x         near the state, for one steady rolling without brakes
/// @param pressure  of each brake of the model [Pa]
HeldSpeed hold_speed(Dynamics& dynamics, double t, double const* x, std::span<double const> pressure);

}  // namespace rollerrig
