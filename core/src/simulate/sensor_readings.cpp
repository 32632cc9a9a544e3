#include "rollerrig/simulate/sensor_readings.hpp"

namespace rollerrig {
namespace {

/// Streams of noise of one axle.
enum Noise : std::uint64_t { of_axle = 0, of_roller = 1, of_load = 16, of_torque = 17, of_vehicle = 32 };

std::uint64_t stream_of(Sensors const& sensors, std::size_t axle) { return sensors.seed * 64 + 2 * axle; }

double spin(Dynamics const& plant, int body) { return plant.work().motion[at(body)].rate[coord_pitch]; }

/// Null: it is in the model.
SimulatedAxleStates::Axle const* simulated_axle(MechatronicSetup const& setup, SimulatedAxleStates const& simulated,
                                                std::size_t axle) {
  std::size_t const first = setup.under_test();
  return axle < first ? nullptr : &simulated.axle[axle - first];
}

}  // namespace

double axle_load(Dynamics const& plant, AxleParts const& parts) {
  double sum = 0.0;
  for (int c : parts.contacts)
    for (int k = 0; c != absent && k < plant.patch_count(c); ++k) sum += plant.patch(c, k).force.z;
  return sum;
}

void SensorReadings::SpeedSensor::start(AnySpeedSensor const& sensor, AxleTurn const& turn, std::uint64_t stream) {
  now = turn;
  std::visit([&](auto const& law) { state = law.start(turn, stream); }, sensor);
}

void SensorReadings::SpeedSensor::follow(AnySpeedSensor const& sensor, AxleTurn const& turn, std::uint64_t stream) {
  now = turn;
  visit_with_state([&](auto const& law, auto& own) { law.follow(own, turn, stream); }, sensor, state);
}

double SensorReadings::SpeedSensor::read(AnySpeedSensor const& sensor, double period, std::uint64_t stream) {
  return visit_with_state([&](auto const& law, auto& own) { return law.read(own, now, period, stream); }, sensor,
                          state);
}

void SensorReadings::start(MechatronicSetup const& setup, Dynamics const& plant, SimulatedAxleStates const& simulated,
                           Measurements& measured) {
  Sensors const& sensors = setup.sensors;
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    AxleParts const& parts = setup.axles[i];
    Axle& axle = axle_[i] = {};
    SimulatedAxleStates::Axle const* only = simulated_axle(setup, simulated, i);
    measured.axle_speed[i] = measured.vehicle_axle_speed[i] =
        only != nullptr ? only->wheels.speed : spin(plant, parts.wheelset);
    measured.roller_speed[i] = parts.roller != absent ? -spin(plant, parts.roller) : 0.0;
    std::uint64_t const stream = stream_of(sensors, i);
    AxleTurn const wheels{0.0, 0.0, measured.axle_speed[i]};
    axle.speed.start(sensors.axles, wheels, stream + of_axle);
    axle.roller_speed.start(sensors.rollers, {0.0, 0.0, measured.roller_speed[i]}, stream + of_roller);
    if (sensors.vehicle) axle.vehicle_speed.start(*sensors.vehicle, wheels, stream + of_vehicle);
    axle.torque_flange.reset(0.0);
    axle.load_cell.reset(only != nullptr ? only->load : axle_load(plant, parts));
  }
}

void SensorReadings::follow(MechatronicSetup const& setup, Dynamics const& plant, double time, double const* z,
                            ActuatorStates const& actuators, SimulatedAxleStates const& simulated) {
  auto const& map = plant.map();
  Sensors const& sensors = setup.sensors;
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    AxleParts const& parts = setup.axles[i];
    Axle& axle = axle_[i];
    std::uint64_t const stream = stream_of(sensors, i);
    SimulatedAxleStates::Axle const* only = simulated_axle(setup, simulated, i);
    AxleTurn const wheels = only != nullptr
                                ? AxleTurn{time, only->angle, only->wheels.speed}
                                : AxleTurn{time, z[map.angle[at(parts.wheelset)]], spin(plant, parts.wheelset)};
    axle.speed.follow(sensors.axles, wheels, stream + of_axle);
    if (sensors.vehicle) axle.vehicle_speed.follow(*sensors.vehicle, wheels, stream + of_vehicle);
    if (parts.roller != absent)
      axle.roller_speed.follow(sensors.rollers, {time, -z[map.angle[at(parts.roller)]], -spin(plant, parts.roller)},
                               stream + of_roller);
    double const torque = actuators.axle(i).drive[0];
    axle.drive.follow(torque);
    if (sensors.roller_torque) axle.torque_flange.follow(*sensors.roller_torque, torque, setup.step);
    axle.load_cell.follow(sensors.axle_load, only != nullptr ? only->load : axle_load(plant, parts), setup.step);
  }
}

void SensorReadings::read(MechatronicSetup const& setup, double period, Measurements& measured) {
  Sensors const& sensors = setup.sensors;
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    Axle& axle = axle_[i];
    std::uint64_t const stream = stream_of(sensors, i);
    measured.axle_speed[i] = axle.speed.read(sensors.axles, period, stream + of_axle);
    measured.vehicle_axle_speed[i] = sensors.vehicle
                                         ? axle.vehicle_speed.read(*sensors.vehicle, period, stream + of_vehicle)
                                         : measured.axle_speed[i];
    measured.axle_load[i] = axle.load_cell.read(sensors.axle_load, stream + of_load);
    if (setup.axles[i].roller == absent) continue;
    measured.roller_speed[i] = axle.roller_speed.read(sensors.rollers, period, stream + of_roller);
    axle.torque =
        sensors.roller_torque ? axle.torque_flange.read(*sensors.roller_torque, stream + of_torque) : axle.drive.now();
  }
}

void SensorReadings::read_roller_torques(MechatronicSetup const& setup, PerAxle<double> const* command,
                                         Measurements& measured) {
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    Axle& axle = axle_[i];
    double const mean = axle.drive.take();
    double const of_flange = 0.5 * (axle.sampled_torque + axle.torque);
    axle.sampled_torque = axle.torque;
    measured.roller_torque[i] = command != nullptr ? (*command)[i] : setup.sensors.roller_torque ? of_flange : mean;
  }
}

}  // namespace rollerrig
