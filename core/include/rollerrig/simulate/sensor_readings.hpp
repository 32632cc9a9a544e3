// simulate/sensor_readings.hpp - encoders, load cells and torque flanges of all axles.
//
//   plant at a step -> [sensors] -> measurements at the controllers' sampling instants
#pragma once
#include <vector>

#include "rollerrig/fields.hpp"
#include "rollerrig/simulate/actuator_states.hpp"
#include "rollerrig/simulate/setup.hpp"
#include "rollerrig/system/dynamics.hpp"

namespace rollerrig {

class SensorReadings {
 public:
  explicit SensorReadings(std::size_t axles) : axle_(axles) {}

  void start(MechatronicSetup const& setup, Dynamics const& plant, SimulatedAxleStates const& simulated,
             Measurements& measured);
  /// Each step: edges of phonic wheels, lags, and means of the drives' torques.
  ///
  /// @param z  the plant's quadratures, for the angles
  void follow(MechatronicSetup const& setup, Dynamics const& plant, double time, double const* z,
              ActuatorStates const& actuators, SimulatedAxleStates const& simulated);
  /// At a controller's instant, to be called after follow().
  void read(MechatronicSetup const& setup, double period, Measurements& measured);
  /// Torque of the drives since the last call [N m].
  ///
  /// @param command  acting; null: not to be taken for the torque
  void read_roller_torques(MechatronicSetup const& setup, PerAxle<double> const* command, Measurements& measured);
  double torque_reading(std::size_t axle) const { return axle_[axle].torque; }  ///< of the torque flange [N m]

  void state(auto& archive) { archive(axle_); }

 private:
  struct SpeedSensor {
    StateOf<AnySpeedSensor> state{};
    AxleTurn now{};
    void start(AnySpeedSensor const& sensor, AxleTurn const& turn, std::uint64_t stream);
    void follow(AnySpeedSensor const& sensor, AxleTurn const& turn, std::uint64_t stream);
    double read(AnySpeedSensor const& sensor, double period, std::uint64_t stream);
  };
  struct Axle {
    SpeedSensor speed, roller_speed, vehicle_speed;
    ForceReading torque_flange, load_cell;
    MeanTorque drive;
    double torque{0.0},
        sampled_torque{0.0};  ///< of the flange now, and at the last sample of the rig's controller [N m]
    void state(auto& archive) {
      for (SpeedSensor* one : {&speed, &roller_speed, &vehicle_speed}) archive(one->state, one->now);
      archive(torque_flange, load_cell, drive, torque, sampled_torque);
    }
  };
  std::vector<Axle> axle_;
};

/// Vertical force of rail or rollers on both wheels of an axle, in the last evaluation [N].
double axle_load(Dynamics const& plant, AxleParts const& parts);

}  // namespace rollerrig
