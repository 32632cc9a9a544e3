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
    double motor[2]{};     ///< torque of the traction motor [N m], its rate
    double drive[2]{};     ///< of the roller's drive
    double pressure[2]{};  ///< of control valve and cylinder over the ambient [Pa]
    double air{};          ///< taken by the cylinder since the start, at ambient pressure [m^3]
    double stand_in{};     ///< brake torque that the motor stands in for [N m]
    int dump_cycles{};     ///< times that the dump valve has opened to vent
    DumpValve valve{DumpValve::fill};
  };

  explicit ActuatorStates(std::size_t axles) : axle_(axles) {}

  void step(MechatronicSetup const& setup, double t, ActingCommands const& acting, Dynamics const& plant,
            Inputs& inputs);
  Axle const& axle(std::size_t i) const { return axle_[i]; }

 private:
  std::vector<Axle> axle_;
};

}  // namespace rollerrig
