// Small assembled models for the tests of plant and model file: a wheelset on driven or free rollers, alone or with machines.
#pragma once
#include "rollerrig/plant/model_file.hpp"
#include "rollerrig/simulate/driver.hpp"
#include "system/models.hpp"

namespace rollerrig::test {

/// Coarse profiles: a file of some 20 kB.
inline Parts small_parts(bool driven) {
  Setup setup;
  setup.driven = driven;
  Parts parts = wheelset_parts(setup);
  parts.profiles = {spline_of(s1002, -60e-3, 60e-3, 1e-3), spline_of(uic60, -42e-3, 28e-3, 1e-3)};
  parts.speed.points = {{0.0}, {setup.speed}};
  return parts;
}

inline AssembledModel assembled(Parts const& parts, std::optional<MechatronicSetup> setup = {}) {
  AssembledModel a;
  a.name = "small";
  a.model = parts.build();
  Dynamics dynamics(a.model);
  a.start = solve_equilibrium(dynamics, 20.0, 0.0, {}).x;
  for (std::size_t i = 0; i < parts.bodies.size(); ++i) a.names.bodies.push_back("body_" + std::to_string(i));
  for (std::size_t i = 0; i < parts.elements.size(); ++i) a.names.elements.push_back("element_" + std::to_string(i));
  a.options.method = integrate::Method::rodas4;
  a.options.relative_tolerance = 1e-6;
  a.options.absolute_tolerance = {1e-8};
  a.options.maximum_step = 0.01;
  a.options.final_time = 1.0;
  a.setup = std::move(setup);
  if (a.setup) a.names.axles = {"axle_1"};
  return a;
}

/// A braked axle with slide protection and a speed sensor that counts teeth.
inline AssembledModel braked() {
  Parts parts = small_parts(true);
  MechatronicSetup setup;
  setup.step = 1e-3, setup.speed = 20.0, setup.rail_cell = 0.05;
  AxleParts axle;
  axle.wheelset = 0, axle.axle_torque = 0, axle.contacts = {0, 1};
  parts.axle_torques.push_back({.wheelset = 0});
  setup.axles = {axle};
  Actuators& act = setup.actuators;
  act.by_traction_motors = true;
  act.brake_demand.points = {{0.0, 0.1}, {0.0, 3e5}};
  act.brake = {0.02, 500.0, {{0.0, 10.0}, {0.4, 0.35}}, 0.25, 2.0, 0.1};
  act.pneumatics.control_valve = {2e5, 2e5, 20.0, 1e5, 0.01};
  act.motor.bandwidth = act.roller_drive.bandwidth = 100.0;
  setup.sensors.axles = PulsePeriod{.teeth = 100.0, .pitch_error = 0.01, .timeout = 0.3};
  setup.sensors.rollers = setup.sensors.axles;
  setup.sensors.axle_load = {.bandwidth = 100.0, .noise = 10.0, .resolution = 1.0, .range = 1e6};
  SlipAndDeceleration law;
  law.vent_slip = 0.1, law.vent_slip_speed = 0.5, law.vent_deceleration = 3.0, law.fill_slip = 0.05,
  law.fill_slip_speed = 0.3;
  law.pulse_time = 0.02, law.pulse_pause = 0.1;
  WheelSlideProtection const protection{.law = law,
                                        .wheel_radius = 0.46,
                                        .reference_deceleration = 1.5,
                                        .filter_time = 0.02,
                                        .recovery_acceleration = 1.0,
                                        .longest_vent = 5.0};
  setup.controllers.push_back({{.every = 5, .delay = 3}, protection});
  return assembled(parts, setup);
}

}  // namespace rollerrig::test
