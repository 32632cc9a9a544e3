// simulate/actuator_states.hpp - brakes, traction motors and roller drives of all axles over one sampling step.
//
//   commands, demands, speeds of axles and rollers -> [actuators, exact or in fine steps] -> inputs on straight lines
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "rollerrig/mechatronics/measurements.hpp"
#include "rollerrig/simulate/setup.hpp"
#include "rollerrig/system/force_assembly.hpp"

namespace rollerrig {

/// What a caller asks for from outside, axle by axle; it holds until the caller asks for something else.
struct CallerDemands {
  AxleCommands commands{};          ///< where the case has no controller for them, or an external one
  PerAxle<double> brake_demand{};   ///< cylinder pressure beside the case's own demand [Pa]
  PerAxle<double> motor_torque{};   ///< of the traction motor beside the case's own demand [N m]
  PerAxle<double> speed_control{};  ///< of an external rig controller: 1 where the roller's drive goes to a speed
  PerAxle<double> roller_speed{};   ///< that speed [rad/s]
  double train_force{0.0};          ///< on the train, forward [N]
  double rail_friction{1.0};        ///< of the virtual rail and under simulated axles, over what its law says

  void state(auto& archive) {
    archive(commands, brake_demand, motor_torque, speed_control, roller_speed, train_force, rail_friction);
  }
};

/// Cylinder pressure asked of an axle, by the case and by the caller [Pa].
inline double brake_demand(MechatronicSetup const& setup, CallerDemands const& caller, std::size_t axle, double t) {
  return std::fmax(0.0, setup.demand(axle, t) + caller.brake_demand[axle]);
}

class ActuatorStates {
 public:
  struct Axle {
    double motor[2]{};  ///< torque of the traction motor [N m], its rate
    double drive[2]{};  ///< of the roller's drive
    double stand_in{};  ///< brake torque that the motor stands in for [N m]
    double asked{};     ///< of all brakes of the axle together, not negative [N m]
    ElectrodynamicBrake::State electrodynamic{};
    double drive_wanted{};                  ///< power asked of the roller's drive [W]
    std::array<double, 4> drive_limited{};  ///< how long each DriveLimit has held it back [s]

    /// Of the traction motor on the axle, driving and braking [N m].
    double of_motor() const { return motor[0] + electrodynamic.torque; }
    void state(auto& archive) { archive(motor, drive, stand_in, asked, electrodynamic, drive_wanted, drive_limited); }
  };

  explicit ActuatorStates(MechatronicSetup const& setup);

  /// @param axle_speed, roller_speed  true ones, positive forward [rad/s]
  void step(MechatronicSetup const& setup, std::int64_t step, AxleCommands const& acting, CallerDemands const& caller,
            PerAxle<double> const& axle_speed, PerAxle<double> const& roller_speed, double train_speed, Inputs& inputs);
  Axle const& axle(std::size_t i) const { return axle_[i]; }
  BrakeCylinders const& cylinders() const { return cylinders_; }
  Cylinder const& cylinder(std::size_t i) const { return cylinders_.cylinder(i); }
  double track_brake() const { return track_brake_; }  ///< excitation, 0 to 1

  void state(auto& archive) { archive(axle_, cylinders_, track_brake_, counted_); }

 private:
  void step_drive(MechatronicSetup const& setup, std::size_t axle, double command, double roller_speed);
  void step_electrodynamic(MechatronicSetup const& setup, std::int64_t step, AxleCommands const& acting,
                           PerAxle<double> const& demand, PerAxle<double> const& axle_speed);
  void step_pneumatics(MechatronicSetup const& setup, PerAxle<double> const& valve, PerAxle<double> const& asked,
                       PerAxle<double> const& axle_speed);

  std::vector<Axle> axle_;
  BrakeCylinders cylinders_;
  double track_brake_{0.0};
  DelayedCommands counted_;  ///< torque of the motors that brake, as the pneumatic brakes know it
};

}  // namespace rollerrig
