// simulate/linear_model.hpp - small motions about a state: how derivatives and outputs follow states and inputs, exactly.
//
//   dynamics at (t, x, inputs) -> [sweeps of the Jacobian] -> x' = A x + B u,  y = C x + D u
//
// An input enters the dynamics as a straight line over time: its column is what a slope of 1 adds to the derivative by time.
#pragma once
#include <span>
#include <vector>

#include "rollerrig/integrate/options.hpp"
#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {

class Driver;

/// u: torques of the model's axles, then of its rollers [N m], then the pressures of its brakes' cylinders [Pa].
/// y: the recorder's columns of all bodies, then of all wheels.
struct LinearModel {
  Eigen::MatrixXd a, b, c, d;
};

/// @param inputs  what acts in that state
LinearModel linear_model(Dynamics& dynamics, double t, double const* x, Inputs inputs);

/// Under the inputs of a run's start, with constant cylinder pressures [Pa] and torques of the rollers [N m] in their place.
///
/// @param pressure, roller_torque  one for each brake and each roller torque of the model; empty: those of the start
LinearModel linear_model(Driver& driver, double t, double const* x, std::span<double const> pressure,
                         std::span<double const> roller_torque);

/// What one step [s] of a fixed-step method does to a small deviation from x: integrate/amplification.hpp.
Eigen::MatrixXd step_amplification(Dynamics& dynamics, integrate::Method method, double step, double t,
                                   double const* x);

/// Steady rolling of a braked vehicle: its state, and the torques that hold the rollers at their speed.
///
///   steady rolling without brakes, cylinder pressures -> [Newton's method on the exact linearisation] -> state, roller torques
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
