#include "rollerrig/simulate/actuator_states.hpp"

#include <algorithm>
#include <cmath>

namespace rollerrig {
namespace {

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

}  // namespace

ActuatorStates::ActuatorStates(MechatronicSetup const& setup)
    : axle_(setup.axles.size()),
      cylinder_(setup.axles.size()),
      supply_{std::visit([](auto const& air) { return air.start(); }, setup.actuators.pneumatics.air)} {}

/// All cylinders together: they may draw on one reservoir.
void ActuatorStates::step_pneumatics(MechatronicSetup const& setup, double t, PerAxle<double> const& valve) {
  Pneumatics const& pneumatics = setup.actuators.pneumatics;
  PerAxle<DumpValve> command{};
  PerAxle<double> demand{};
  for (std::size_t i = 0; i < cylinder_.size(); ++i) {
    command[i] = static_cast<DumpValve>(static_cast<int>(valve[i]));
    demand[i] = setup.actuators.brake_demand.at(t);
  }
  auto const step = [&](auto const& air) {
    air.step(pneumatics.control_valve, cylinder_, supply_, command, demand, setup.step);
  };
  std::visit(step, pneumatics.air);
}

void ActuatorStates::step(MechatronicSetup const& setup, double t, ActingCommands const& acting, Dynamics const& plant,
                          Inputs& inputs) {
  double const h = setup.step;
  auto const& [valve, factor, roller_torque] = acting;
  auto const line = [&](double from, double to) { return HeldInput{t, from, (to - from) / h}; };
  auto const spin = [&](int body) { return plant.work().motion[at(body)].rate[coord_pitch]; };
  PerAxle<double> before{};
  for (std::size_t i = 0; i < axle_.size(); ++i) before[i] = cylinder_[i].pressure;
  if (setup.braked()) step_pneumatics(setup, t, valve);
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    AxleParts const& parts = setup.axles[i];
    Axle& axle = axle_[i];
    double const speed = spin(parts.wheelset), pressure = cylinder_[i].pressure;

    if (parts.brake != absent) inputs.cylinder[at(parts.brake)] = line(before[i], pressure);
    axle.stand_in = setup.actuators.motors_stand_in ? setup.actuators.brake.torque(pressure, speed) : 0.0;
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
