#include "rollerrig/simulate/sensor_readings.hpp"

namespace rollerrig {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Streams of noise of one axle.
enum Noise : std::uint64_t { of_axle = 0, of_roller = 1, of_load = 16, of_torque = 17 };

double spin(Dynamics const& plant, int body) { return plant.work().motion[at(body)].rate[coord_pitch]; }

}  // namespace

double axle_load(Dynamics const& plant, AxleParts const& parts) {
  double sum = 0.0;
  for (int c : parts.contacts)
    for (int k = 0; c != absent && k < plant.patch_count(c); ++k) sum += plant.patch(c, k).force.z;
  return sum;
}

void SensorReadings::start(MechatronicSetup const& setup, Dynamics const& plant, Measurements& measured) {
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    AxleParts const& parts = setup.axles[i];
    Axle& axle = axle_[i] = {};
    measured.axle_speed[i] = spin(plant, parts.wheelset);
    measured.roller_speed[i] = parts.roller != absent ? -spin(plant, parts.roller) : 0.0;
    axle.encoder.reset(0.0, measured.axle_speed[i]);
    axle.roller_encoder.reset(0.0, measured.roller_speed[i]);
    axle.torque_flange.reset(0.0);
    axle.load_cell.reset(axle_load(plant, parts));
  }
}

void SensorReadings::follow(MechatronicSetup const& setup, Dynamics const& plant, ActuatorStates const& actuators) {
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    double const torque = actuators.axle(i).drive[0];
    axle_[i].drive.follow(torque);
    if (setup.sensors.roller_torque) axle_[i].torque_flange.follow(*setup.sensors.roller_torque, torque, setup.step);
    axle_[i].load_cell.follow(setup.sensors.axle_load, axle_load(plant, setup.axles[i]), setup.step);
  }
}

void SensorReadings::read(MechatronicSetup const& setup, Dynamics const& plant, double const* z, double period,
                          Measurements& measured) {
  auto const& map = plant.map();
  Sensors const& sensors = setup.sensors;
  for (std::size_t i = 0; i < axle_.size(); ++i) {
    AxleParts const& parts = setup.axles[i];
    Axle& axle = axle_[i];
    std::uint64_t const stream = sensors.seed * 64 + 2 * i;
    measured.axle_speed[i] = axle.encoder.step(sensors.axles, z[map.angle[at(parts.wheelset)]],
                                               spin(plant, parts.wheelset), period, stream + of_axle);
    measured.axle_load[i] = axle.load_cell.read(sensors.axle_load, stream + of_load);
    if (parts.roller == absent) continue;
    measured.roller_speed[i] = axle.roller_encoder.step(sensors.rollers, -z[map.angle[at(parts.roller)]],
                                                        -spin(plant, parts.roller), period, stream + of_roller);
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
