#include "rollerrig/simulate/setup.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "rollerrig/mechatronics/measurements.hpp"
#include "rollerrig/system/model.hpp"

namespace rollerrig {
namespace {

constexpr double motor_resolution = 1000.0;  ///< of a second-order torque loop: bandwidth times step; it is cut finer

template <class Item>
void need_item(std::vector<Item> const& items, int index, std::string const& owner, char const* name,
               bool may_be_absent) {
  bool const known = index >= 0 && index < static_cast<int>(items.size());
  need(known || (may_be_absent && index == absent),
       owner + ": " + name + " = " + std::to_string(index) + ", the model has " + std::to_string(items.size()));
}

/// Encoders count its turning: a body of revolution that is free to turn.
void need_turning(Model const& model, int body, std::string const& owner, char const* name) {
  need(model.map.angle[at(body)] >= 0, owner + ": " + name + ", body " + std::to_string(body) + ", does not turn");
}

void check_axle(AxleParts const& parts, Model const& model, std::string const& owner) {
  need_item(model.bodies, parts.wheelset, owner, "wheelset", false);
  need_turning(model, parts.wheelset, owner, "wheelset");
  need_item(model.axle_torques, parts.axle_torque, owner, "axle_torque", true);
  need_item(model.brakes, parts.brake, owner, "brake", true);
  need_item(model.bodies, parts.roller, owner, "roller", true);
  need_item(model.roller_torques, parts.roller_torque, owner, "roller_torque", true);
  for (int contact : parts.contacts) need_item(model.contacts, contact, owner, "contacts", true);
  need(parts.roller_torque == absent || parts.roller != absent, owner + ": roller_torque needs a roller");
  need(!parts.electrodynamic || parts.axle_torque != absent, owner + ": electrodynamic needs an axle_torque");
  if (parts.roller == absent) return;
  need_turning(model, parts.roller, owner, "roller");
  int const left = parts.contacts[0];
  need(left != absent && model.contacts[at(left)].roller == parts.roller,
       owner + ": contacts must be those of its roller");
}

void check_motor(Motor const& motor, double step, char const* name) {
  need(!(motor.damping_ratio > 0.0) || motor.bandwidth * step <= motor_resolution,
       std::string(name) + ": bandwidth is too high for the step");
}

void check_law(RigController const& control, std::size_t axles) {
  for (auto const* of_axles : {&control.train.static_load, &control.train.load_transfer, &control.train.position})
    need(of_axles->size() >= axles,
         "rig_control: train: static_load, load_transfer and position need one number per axle");
}
void check_law(WheelSlideProtection const& control, std::size_t /*axles*/) {
  auto const check = [](auto const& law) {
    if constexpr (requires { law.check(); }) law.check();
  };
  std::visit(check, control.law);
}
void check_law(WheelSlipControl const& /*control*/, std::size_t /*axles*/) {}
/// Of a reservoir or a relay valve for each axle, and for as many more as there may be; or none.
void check_numbers(std::vector<int> const& numbers, std::size_t axles, std::size_t most, std::string const& owner) {
  need(numbers.empty() || (numbers.size() >= axles && numbers.size() <= most),
       owner + " needs one number per axle, or none");
  for (int number : numbers)
    need(number >= 0 && at(number) < most, owner + ": allowed is 0 to " + std::to_string(most - 1));
}
void check_law(BrakeUnit const& unit, std::size_t axles) {
  check_numbers(unit.reservoir, axles, at(most_axles), "brake_unit: reservoir");
  check_numbers(unit.relay_valve, axles, at(most_axles), "brake_unit: relay_valve");
}

/// Axles that are only simulated stand behind those of the model in the lists, wherever they are in the train.
void check_simulated(MechatronicSetup const& setup) {
  SimulatedAxles const& simulated = setup.simulated;
  std::size_t const count = simulated.count(), axles = setup.axles.size();
  need(count < axles, "SimulatedAxles: of " + std::to_string(axles) + " axles one at least must be under test");
  need(simulated.load_transfer.size() == count && simulated.position.size() == count,
       "SimulatedAxles: static_load, load_transfer and position need one number per axle");
  need(setup.brake_delay.empty() || setup.brake_delay.size() == axles,
       "MechatronicSetup: brake_delay needs one number per axle, or none");
  check_numbers(setup.reservoir, axles, axles, "MechatronicSetup: reservoir");
  check_numbers(setup.relay_valve, axles, axles, "MechatronicSetup: relay_valve");
  for (std::size_t i = axles - count; i < axles; ++i)
    need(setup.axles[i].wheelset == absent, "axle " + std::to_string(i) + ": wheelset must be absent: it is simulated");
  if (count == 0) return;
  need(simulated.wheel_radius > 0.0 && simulated.wheelset_inertia > 0.0,
       "SimulatedAxles: wheel_radius and wheelset_inertia must be positive");
  need(setup.rail.has_value(), "SimulatedAxles: rail: needed is one of VirtualRail(...)");
  bool const rolls = setup.frame.train_mass > 0.0 ||
                     std::any_of(setup.controllers.begin(), setup.controllers.end(),
                                 [](auto const& one) { return std::holds_alternative<RigController>(one.controller); });
  need(rolls, "SimulatedAxles: needed is a train that they belong to, on track or of rig_control");
}

}  // namespace

void check_controller(SampledController const& sampled, std::size_t axles) {
  check_fields(sampled.sampling, "Sampling");
  std::visit([&](auto const& law) { check_law(law, axles); }, sampled.controller);
}

void check_setup(MechatronicSetup const& setup, Model const& model) {
  check_fields(setup, "MechatronicSetup");
  std::size_t const axles = setup.axles.size();
  need(axles >= 1, "MechatronicSetup: axles must not be empty");
  need(axles <= at(most_axles),
       "at most " + std::to_string(most_axles) + " axles have sensors and actuators, not " + std::to_string(axles));
  check_simulated(setup);
  for (std::size_t i = 0; i < setup.under_test(); ++i) check_axle(setup.axles[i], model, "axle " + std::to_string(i));
  if (auto const& machine = setup.actuators.electrodynamic)
    check_value(machine->blending_delay / setup.step, delay_steps, "ElectrodynamicBrake", "blending_delay / step");
  if (auto const& sanding = setup.sanding)
    check_value(sanding->delay / setup.step, delay_steps, "Sanding", "delay / step");
  check_motor(setup.actuators.motor, setup.step, "motor");
  check_motor(setup.actuators.roller_drive, setup.step, "roller_drive");
  need(!setup.brake_unit_is_sampled() || (setup.braked() && !setup.actuators.electrodynamic),
       "brake_unit: needed are brakes, and no electrodynamic ones, which it would have to blend with its own");
  for (SampledController const& sampled : setup.controllers) check_controller(sampled, setup.under_test());
}

}  // namespace rollerrig
