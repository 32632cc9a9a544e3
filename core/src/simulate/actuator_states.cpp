#include "rollerrig/simulate/actuator_states.hpp"

#include <algorithm>
#include <cmath>

namespace rollerrig {
namespace {

constexpr double largest_motor_part = 0.2;  ///< of a second-order torque loop, over its time constant

/// Steps of the blending's delay.
int blending_steps(MechatronicSetup const& setup) {
  auto const& machine = setup.actuators.electrodynamic;
  return machine ? static_cast<int>(std::lround(machine->blending_delay / setup.step)) : 0;
}

/// One step of a motor's torque loop: exact for a first-order loop under a constant command, else fine Runge-Kutta steps.
void step_motor(Motor const& motor, double* state, double command, double speed, double h) {
  double const wanted = motor.within_envelope(command, speed);
  if (!(motor.damping_ratio > 0.0)) {
    state[0] = wanted + (state[0] - wanted) * std::exp(-motor.bandwidth * h);
    return;
  }
  int const parts = std::max(1, static_cast<int>(std::ceil(motor.bandwidth * h / largest_motor_part)));
  double const k = h / parts;
  for (int i = 0; i < parts; ++i) {
    double r1[2], r2[2], middle[2];
    motor.rates(state, wanted, 0.0, r1);  // the envelope has been applied
    for (int j = 0; j < 2; ++j) middle[j] = state[j] + 0.5 * k * r1[j];
    motor.rates(middle, wanted, 0.0, r2);
    for (int j = 0; j < 2; ++j) state[j] += k * r2[j];
  }
}

}  // namespace

ActuatorStates::ActuatorStates(MechatronicSetup const& setup)
    : axle_(setup.axles.size()),
      cylinders_{setup.actuators.pneumatics, setup.reservoir, setup.relay_valve, setup.axles.size()},
      counted_{0.0, blending_steps(setup)} {}

/// The motors that brake, and what their axles are asked for in all.
void ActuatorStates::step_electrodynamic(MechatronicSetup const& setup, std::int64_t step, AxleCommands const& acting,
                                         PerAxle<double> const& demand, PerAxle<double> const& axle_speed) {
  Actuators const& actuators = setup.actuators;
  PerAxle<double> counted{};
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    Axle& axle = axle_[i];
    double const speed = axle_speed[i];
    axle.asked = actuators.brake.sliding_torque(demand[i], speed);
    if (!actuators.electrodynamic || !setup.axles[i].electrodynamic) continue;
    actuators.electrodynamic->step(axle.electrodynamic, axle.asked, speed, valve_of(acting.dump_valve[i]),
                                   acting.torque_factor[i], setup.step);
    counted[i] = axle.electrodynamic.counted;
  }
  counted_.send(counted, step);
  counted_.advance(step);
}

/// The drive of an axle's roller, and how long each of its limits has acted.
void ActuatorStates::step_drive(MechatronicSetup const& setup, std::size_t axle, double command, double roller_speed) {
  Axle& own = axle_[axle];
  Motor const& drive = setup.actuators.roller_drive;
  own.drive_wanted = command * roller_speed;
  own.drive_limited[at(static_cast<int>(drive.limit_met(command, roller_speed)))] += setup.step;
  step_motor(drive, own.drive, command, roller_speed, setup.step);
}

/// The cylinders, each for what the motor of its axle leaves to be braked.
void ActuatorStates::step_pneumatics(MechatronicSetup const& setup, PerAxle<double> const& valve,
                                     PerAxle<double> const& asked, PerAxle<double> const& axle_speed) {
  PerAxle<double> demand = asked;
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    if (!setup.axles[i].electrodynamic) continue;
    double const rest = std::fmax(0.0, axle_[i].asked - counted_.acting()[i]);
    demand[i] = std::fmin(demand[i], setup.actuators.brake.pressure(rest, axle_speed[i]));
  }
  cylinders_.step(setup.actuators.pneumatics, valve, demand, setup.step);
}

void ActuatorStates::step(MechatronicSetup const& setup, std::int64_t step, AxleCommands const& acting,
                          CallerDemands const& caller, PerAxle<double> const& axle_speed,
                          PerAxle<double> const& roller_speed, double train_speed, Inputs& inputs) {
  double const h = setup.step, t = h * static_cast<double>(step);
  auto const line = [&](double from, double to) { return HeldInput{t, from, (to - from) / h}; };
  PerAxle<double> before{}, motor_before{}, pressure_demand{};
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    pressure_demand[i] = brake_demand(setup, caller, i, t);
    before[i] = cylinder(i).pressure;
    motor_before[i] = axle_[i].of_motor();
  }
  if (setup.braked()) {
    step_electrodynamic(setup, step, acting, pressure_demand, axle_speed);
    if (setup.brake_unit_is_sampled())
      cylinders_.take(setup.actuators.pneumatics.control_valve, acting.dump_valve, acting.cylinder_pressure);
    else
      step_pneumatics(setup, acting.dump_valve, pressure_demand, axle_speed);
  }
  if (auto const& brake = setup.actuators.track_brake) {
    double const from = track_brake_;
    track_brake_ = brake->next(track_brake_, t, train_speed, h);
    inputs.track_brake = line(from, track_brake_);
  }
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    AxleParts const& parts = setup.axles[i];
    Axle& axle = axle_[i];
    double const speed = axle_speed[i], pressure = cylinder(i).pressure;

    if (parts.brake != absent) inputs.cylinder[at(parts.brake)] = line(before[i], pressure);
    axle.stand_in = setup.actuators.by_traction_motors ? setup.actuators.brake.torque(pressure, speed) : 0.0;
    if (parts.driven()) {
      double const asked = setup.actuators.torque_demand.at(t) + caller.motor_torque[i];
      double const demand = acting.torque_factor[i] * asked + axle.stand_in;
      step_motor(setup.actuators.motor, axle.motor, demand, speed, h);
      if (parts.axle_torque != absent)
        inputs.axle_torque[at(parts.axle_torque)] = line(motor_before[i], axle.of_motor());
    }
    if (parts.roller_torque != absent) {
      double const from = axle.drive[0];
      step_drive(setup, i, acting.roller_torque[i], roller_speed[i]);
      inputs.roller_torque[at(parts.roller_torque)] = line(from, axle.drive[0]);
    }
  }
}

}  // namespace rollerrig
