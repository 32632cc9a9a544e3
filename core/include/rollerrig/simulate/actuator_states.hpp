// simulate/actuator_states.hpp - brakes, traction motors and roller drives of all axles over one sampling step.
//
//   commands, demands, speeds of axles and rollers -> [actuators, exact or in fine steps] -> inputs on straight lines
#pragma once
#include <vector>

#include "rollerrig/simulate/setup.hpp"
#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {

/// What acts on the actuators over a step: per command, per axle.
using ActingCommands = std::array<PerAxle<double>, command_count>;

class ActuatorStates {
 public:
  struct Axle {
    double motor[2]{};  ///< torque of the traction motor [N m], its rate
    double drive[2]{};  ///< of the roller's drive
    double stand_in{};  ///< brake torque that the motor stands in for [N m]
  };

  explicit ActuatorStates(MechatronicSetup const& setup);

  void step(MechatronicSetup const& setup, double t, ActingCommands const& acting, Dynamics const& plant,
            Inputs& inputs);
  Axle const& axle(std::size_t i) const { return axle_[i]; }
  Cylinder const& cylinder(std::size_t i) const { return cylinder_[i]; }
  AirSupply const& supply() const { return supply_; }

 private:
  void step_pneumatics(MechatronicSetup const& setup, double t, PerAxle<double> const& valve);

  std::vector<Axle> axle_;
  std::vector<Cylinder> cylinder_;
  AirSupply supply_;
};

}  // namespace rollerrig
