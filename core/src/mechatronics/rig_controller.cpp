#include "rollerrig/mechatronics/rig_controller.hpp"

#include <algorithm>
#include <cmath>

namespace rollerrig {
namespace {

AxleSample sample_of(Measurements const& now, std::size_t k) {
  return {now.roller_speed[k], now.axle_speed[k], now.roller_torque[k], now.true_force[k], now.true_torque[k]};
}

}  // namespace

RigController::State RigController::start(Measurements const& now, double train_speed, double period) const {
  State s;
  s.train = {train, train_speed};
  s.rail.reset(rail.cell);
  s.sand.reset(rail.cell);
  for (std::size_t k = 0; k < at(now.under_test); ++k) {
    AxleState& axle = s.axle[k];
    std::visit([&](auto const& law) { axle.estimator = law.start(assumed, period, sample_of(now, k)); }, estimator);
    axle.axle_torque = first_state(axle_torque);
    axle.feedback = first_state(feedback);
    axle.drive_command = first_state(drive_command);
  }
  return s;
}

void RigController::step(State& s, Measurements const& now, double period, PerAxle<double>& torque) const {
  PerAxle<double> torques{};
  for (std::size_t k = 0; k < at(now.under_test); ++k) {
    auto const estimate = [&](auto const& law, auto& state) {
      return law.step(state, assumed, sample_of(now, k), period);
    };
    s.axle[k].estimate = visit_with_state(estimate, estimator, s.axle[k].estimator);
    torques[k] = s.axle[k].estimate.torque = torque_of_axle(s.axle[k], now, k, period);
    lock_or_unlock(s.train.axle[k], s.train.speed, now.axle_speed[k]);
  }
  double const from = s.train.distance;
  auto const rail_force = [&](int i, double slip, double speed, double load) {
    return rail.force(slip, speed, load, now.time, from + train.position[at(i)], s.axle[at(i)].rail.energy,
                      s.axle[at(i)].rail.sand, now.rail_friction);
  };
  s.train.step(train, now.under_test, torques, measured_loads ? &now.axle_load : nullptr,
               now.track_brake_force - now.force_of_others, period, rail_force);
  FoundRail const found{{&s.rail, 1}, &s.sand, now.sand_flow.data()};
  double const r = train.wheel_radius;
  for (int i = 0; i < now.under_test; ++i) {  // front to back: the leading axle cleans for the following ones
    AxleState& axle = s.axle[at(i)];
    VirtualAxle const& wheels = s.train.axle[at(i)];
    rail.pass(axle.rail,
              {from + train.position[at(i)], s.train.distance - from, s.train.speed, r * wheels.speed, wheels.force,
               2.0 * pi * r, period},
              found, at(i));
    axle.feed_forward = assumed.roller_inertia * r / assumed.roller_radius * wheels.rate -
                        assumed.roller_radius * wheels.force;  // (D5)
    double wanted = axle.feed_forward;
    if (wheels.locked) {
      axle.feedback = first_state(feedback);
    } else {
      TrackingError const error{axle.feed_forward, wheels.speed - now.axle_speed[at(i)], period};
      auto const correct = [&](auto const& law, auto& state) { return law.step(state, assumed, error, largest); };
      wanted = visit_with_state(correct, feedback, axle.feedback);
    }
    WantedTorque const total{axle.feed_forward, wanted, now.drive_torque[at(i)]};
    auto const ask = [&](auto const& law, auto& state) { return law.step(state, total, period); };
    double const asked = visit_with_state(ask, drive_command, axle.drive_command);
    axle.feed_forward += asked - wanted;
    torque[at(i)] = std::clamp(asked, -largest, largest);
  }
}

/// The laws of rig_laws.hpp take the error of a wheel, which turns R/r times as fast as the roller that it rolls on.
double RigController::torque_for_speed(StateOf<AnyFeedback>& state, double feed_forward, double wanted,
                                       double roller_speed, double period) const {
  double const error = assumed.roller_radius / assumed.wheel_radius * (wanted - roller_speed);
  auto const correct = [&](auto const& law, auto& own) {
    return law.step(own, assumed, TrackingError{feed_forward, error, period}, largest);
  };
  return std::clamp(visit_with_state(correct, feedback, state), -largest, largest);
}

double RigController::torque_of_axle(AxleState& axle, Measurements const& now, std::size_t k, double period) const {
  auto const bandwidth = [](auto const& law) {
    if constexpr (requires { law.bandwidth; }) return law.bandwidth;
    return 0.0;
  };
  TorqueSample const sample{axle.estimate.torque, std::visit(bandwidth, estimator), now.motor_torque[k],
                            now.brake_torque[k]};
  auto const take = [&](auto const& law, auto& state) { return law.step(state, sample, period); };
  return visit_with_state(take, axle_torque, axle.axle_torque);
}

/// The brake of a locked wheel holds against whatever the roller exerts: what is estimated of its torque is the reaction to the
/// drive's own, delayed by the estimator, and through (D3) it would return to the drive with the gain J_r (r/R)^2 / J_w.
void RigController::lock_or_unlock(VirtualAxle& axle, double train_speed, double axle_speed) const {
  double const rolling = train.wheel_radius * axle_speed;
  bool const stands = std::fabs(rolling) < locked_speed && train_speed - rolling > locked_speed;
  axle.locked = stands && (axle.locked || train.wheel_radius * std::fabs(axle.speed) < locked_speed);
  if (axle.locked) axle.speed = axle_speed;
}

}  // namespace rollerrig
