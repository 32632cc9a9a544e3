// simulate/linear_model.hpp - small motions about a state: how derivatives and outputs follow states and inputs, exactly.
//
//   dynamics at (t, x, inputs) -> [sweeps of the Jacobian] -> x' = A x + B u,  y = C x + D u
//
// An input enters the dynamics as a straight line over time: its column is what a slope of 1 adds to the derivative by time.
#pragma once
#include "rollerrig/simulate/recorded_rows.hpp"
#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {

/// u: torques of the model's axles, then of its rollers [N m], then the pressures of its brakes' cylinders [Pa].
/// y: the recorder's columns of all bodies, then of all wheels.
struct LinearModel {
  Eigen::MatrixXd a, b, c, d;
};

/// @param inputs  what acts in that state
LinearModel linear_model(Dynamics& dynamics, double t, double const* x, Inputs inputs);

}  // namespace rollerrig
