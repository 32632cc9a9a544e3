#include "rollerrig/simulate/actuator_states.hpp"

#include <algorithm>
#include <cmath>

namespace rollerrig {
namespace {

constexpr int brake_parts = 8;              ///< of a step: the flow near equal pressures changes fast
constexpr double largest_motor_part = 0.2;  ///< of a second-order torque loop, over its time constant

std::size_t at(int i) { return static_cast<std::size_t>(i); }

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

/// One step of a brake's pneumatics in fine midpoint steps.
void step_brake(PneumaticBrake const& brake, ActuatorStates::Axle& axle, double demand, double h) {
  double const part = h / brake_parts;
  for (int k = 0; k < brake_parts; ++k) {
    double rate[2], middle[2], inflow = 0.0;
    brake.rates(axle.pressure, demand, axle.valve, rate, inflow);
    for (int j = 0; j < 2; ++j) middle[j] = axle.pressure[j] + 0.5 * part * rate[j];
    brake.rates(middle, demand, axle.valve, rate, inflow);
    for (int j = 0; j < 2; ++j) axle.pressure[j] = std::max(0.0, axle.pressure[j] + part * rate[j]);
    axle.air += brake.air(part * inflow);
  }
}

}  // namespace

void ActuatorStates::step(MechatronicSetup const& setup, double t, ActingCommands const& acting, Dynamics const& plant,
                          Inputs& inputs) {
  double const h = setup.step;
  auto const& [valve, factor, roller_torque] = acting;
  auto const line = [&](double from, double to) { return HeldInput{t, from, (to - from) / h}; };
  auto const spin = [&](int body) { return plant.work().motion[at(body)].rate[coord_pitch]; };
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    AxleParts const& parts = setup.axles[i];
    Axle& axle = axle_[i];
    double const speed = spin(parts.wheelset);

    auto const position = static_cast<DumpValve>(static_cast<int>(valve[i]));
    axle.dump_cycles += position == DumpValve::vent && axle.valve != DumpValve::vent;
    axle.valve = position;
    double const before = axle.pressure[1];
    bool const braked = parts.brake != absent || setup.actuators.motors_stand_in;
    if (braked) step_brake(setup.actuators.brake, axle, setup.actuators.brake_demand.at(t), h);
    if (parts.brake != absent) inputs.cylinder[at(parts.brake)] = line(before, axle.pressure[1]);

    axle.stand_in = setup.actuators.motors_stand_in ? setup.actuators.brake.torque(axle.pressure[1], speed) : 0.0;
    if (parts.axle_torque != absent) {
      double const from = axle.motor[0];
      double const demand = factor[i] * setup.actuators.torque_demand.at(t) + axle.stand_in;
      step_motor(setup.actuators.motor, axle.motor, demand, speed, h);
      inputs.axle_torque[at(parts.axle_torque)] = line(from, axle.motor[0]);
    }
    if (parts.roller_torque != absent) {
      double const from = axle.drive[0];
      step_motor(setup.actuators.roller_drive, axle.drive, roller_torque[i], -spin(parts.roller), h);
      inputs.roller_torque[at(parts.roller_torque)] = line(from, axle.drive[0]);
    }
  }
}

}  // namespace rollerrig
