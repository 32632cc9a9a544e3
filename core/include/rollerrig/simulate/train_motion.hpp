// simulate/train_motion.hpp - speed of the train on track: its frame moves with it.
//
//   forces of the rails on all wheels, resistance, gradient -> [V' for the next step] -> V(t) on straight lines
//
// Any V(t) describes the same physics; this one keeps the bodies near their places. V' is that of the forces at the step's start,
// extrapolated by half a step. docs/theory/rig_control.md, (D8).
#pragma once
#include "rollerrig/simulate/setup.hpp"
#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {

class TrainMotion {
 public:
  explicit TrainMotion(double speed) : speed_{speed} {}

  /// V' over the next step.
  ///
  /// @param retarding  force of track brakes [N]
  void accelerate(TravellingFrame const& frame, Dynamics const& plant, Inputs const& inputs, double retarding);
  void advance(double step) {
    distance_ += step * (speed_ + 0.5 * step * acceleration_);
    speed_ += step * acceleration_;
  }

  double speed() const { return speed_; }                ///< [m/s]
  double distance() const { return distance_; }          ///< since the start [m]
  double acceleration() const { return acceleration_; }  ///< [m/s^2]

  void state(auto& archive) { archive(speed_, distance_, acceleration_, last_, first_); }

 private:
  double speed_, distance_{0.0}, acceleration_{0.0}, last_{0.0};
  bool first_{true};
};

}  // namespace rollerrig
