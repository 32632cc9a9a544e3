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

struct TrainMotion {
  double speed;           ///< [m/s]
  double distance{};      ///< since the start [m]
  double acceleration{};  ///< [m/s^2]
  double last{};          ///< V' before its extrapolation [m/s^2]
  bool first{true};
  void state(auto& archive) { archive(speed, distance, acceleration, last, first); }

  /// V' over the next step.
  ///
  /// @param retarding  force of track brakes [N]
  void accelerate(TravellingFrame const& frame, Dynamics const& plant, Inputs const& inputs, double retarding);
  void advance(double step) {
    distance += step * (speed + 0.5 * step * acceleration);
    speed += step * acceleration;
  }
};

inline void TrainMotion::accelerate(TravellingFrame const& frame, Dynamics const& plant, Inputs const& inputs,
                                    double retarding) {
  Model const& model = plant.model();
  auto const& work = plant.work();
  double force = plant.evaluation().longitudinal_force - frame.train_mass * model.gravity * model.resistance.gradient;
  force -= model.resistance.force(speed) + retarding;
  double momentum_rate = 0.0, momentum = 0.0, offset = 0.0, free_mass = 0.0;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    Body const& body = model.bodies[b];
    if (!body.in_moving_frame || body.locked[coord_x]) continue;
    momentum_rate += body.mass * (work.acceleration[b][coord_x] + inputs.speed.slope);
    momentum += body.mass * work.motion[b].v.x;
    offset += body.mass * work.motion[b].p.x;
    free_mass += body.mass;
  }
  constexpr double on_speed = 2.0, on_place = 1.0;  // [1/s], [1/s^2]: keeps free bodies near their design positions
  double const wanted = frame.fixed_mass > 0.0 ? (force - momentum_rate) / frame.fixed_mass
                                               : force / frame.train_mass + on_speed * momentum / free_mass +
                                                     on_place * offset / free_mass;
  acceleration = first ? wanted : 1.5 * wanted - 0.5 * last;
  last = wanted;
  first = false;
}

}  // namespace rollerrig
