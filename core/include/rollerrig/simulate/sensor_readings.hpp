// simulate/sensor_readings.hpp - encoders, load cells and torque flanges of all axles.
//
//   plant at a step -> [sensors] -> measurements at the controllers' sampling instants
#pragma once
#include <vector>

#include "rollerrig/simulate/actuator_states.hpp"
#include "rollerrig/simulate/setup.hpp"
#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {

class SensorReadings {
 public:
  explicit SensorReadings(std::size_t axles) : axle_(axles) {}

  void start(MechatronicSetup const& setup, Dynamics const& plant, Measurements& measured);
  /// Each step: lags, and means of the drives' torques.
  void follow(MechatronicSetup const& setup, Dynamics const& plant, ActuatorStates const& actuators);
  /// At a controller's instant.
  ///
  /// @param z  the plant's quadratures, for the angles
  void read(MechatronicSetup const& setup, Dynamics const& plant, double const* z, double period,
            Measurements& measured);
  /// Torque of the drives since the last call [N m].
  ///
  /// @param command  acting; null: not to be taken for the torque
  void read_roller_torques(MechatronicSetup const& setup, PerAxle<double> const* command, Measurements& measured);
  double torque_reading(std::size_t axle) const { return axle_[axle].torque; }  ///< of the torque flange [N m]

 private:
  struct Axle {
    EncoderReading encoder, roller_encoder;
    ForceReading torque_flange, load_cell;
    MeanTorque drive;
    double torque{0.0},
        sampled_torque{0.0};  ///< of the flange now, and at the last sample of the rig's controller [N m]
  };
  std::vector<Axle> axle_;
};

/// Vertical force of rail or rollers on both wheels of an axle, in the last evaluation [N].
double axle_load(Dynamics const& plant, AxleParts const& parts);

}  // namespace rollerrig
