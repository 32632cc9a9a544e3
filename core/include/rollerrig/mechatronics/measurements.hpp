// mechatronics/measurements.hpp - what controllers see of the axles at an instant, and what they command.
//
//   plant -> sensors -> [measurements] -> controllers -> [commands], after their delay -> actuators
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string_view>
#include <vector>

#include "rollerrig/scalar.hpp"

namespace rollerrig {

/// How many axles of a train sensors, controllers and actuators have room for; more are refused.
constexpr int most_axles = 32;

template <class V>
using PerAxle = std::array<V, at(most_axles)>;

/// Per axle; only the first `axles` entries count.
struct Measurements {
  double time{};     ///< [s]
  int axles{};       ///< of the train: first those under test, then those that are only simulated
  int under_test{};  ///< on rollers, or in the 3-D model
  PerAxle<double> axle_speed{}, roller_speed{};  ///< as the rig's sensors see them [rad/s]
  PerAxle<double> vehicle_axle_speed{};          ///< as the vehicle's own sensors see them [rad/s]
  PerAxle<double> roller_torque{};               ///< since the last sample of the rig's controller [N m]
  PerAxle<double> drive_torque{};                ///< of the roller's drive now [N m]
  PerAxle<double> motor_torque{};                ///< of the traction motor, as its drive reports it [N m]
  PerAxle<double> brake_torque{};                ///< from cylinder pressure and the pads' friction [N m]
  PerAxle<double> axle_load{};                   ///< vertical force of rail or rollers on both wheels [N]
  PerAxle<double> dump_valve{};                  ///< acting command of the dump valve
  PerAxle<double> brake_demand{};                ///< cylinder pressure asked for [Pa]
  PerAxle<double> sand_flow{};                   ///< in front of each axle, on each rail [kg/s]
  double track_brake_force{};                    ///< of all bogies, against running [N]
  double force_of_others{};                      ///< (N2), mean since the last sample of the rig's controller [N]
  double rail_friction{1.0};                     ///< of the virtual rail, over what its law says
  /// What really acts: T of (D1) [N], torque of motor and brake [N m]; for the estimator `exact` alone.
  PerAxle<double> true_force{}, true_torque{};

  void state(auto& archive) {
    archive(time, axle_speed, roller_speed, vehicle_axle_speed, roller_torque, drive_torque, motor_torque, brake_torque,
            axle_load, dump_valve, brake_demand, sand_flow, track_brake_force, force_of_others, rail_friction,
            true_force, true_torque);
  }
};

/// What an actuator of each axle takes from a controller.
enum class Command : int { dump_valve, torque_factor, roller_torque, cylinder_pressure };

/// Per command and axle.
struct AxleCommands {
  PerAxle<double> dump_valve{}, torque_factor{}, roller_torque{}, cylinder_pressure{};
  void state(auto& archive) { archive(dump_valve, torque_factor, roller_torque, cylinder_pressure); }
};

struct CommandField {
  PerAxle<double> AxleCommands::* of;
  std::string_view name, unit, meaning, allowed;
  double initial;          ///< before the first command
  double lowest, highest;  ///< allowed
  bool whole;              ///< only whole numbers are

  bool allows(PerAxle<double> const& values) const {
    return std::ranges::all_of(values,
                               [&](double v) { return v >= lowest && v <= highest && (!whole || v == std::round(v)); });
  }
};

constexpr double unlimited = 1e300;       ///< beyond any torque
constexpr double highest_pressure = 1e7;  ///< of a brake cylinder [Pa]

inline constexpr CommandField command_fields[] = {
    {&AxleCommands::dump_valve, "valve", "1", "command of the dump valve: 0 fill, 1 hold, 2 vent",
     "0 fill, 1 hold, 2 vent", 0.0, 0.0, 2.0, true},
    {&AxleCommands::torque_factor, "torque_factor", "1", "part of the traction demand that is admitted", "0 to 1", 1.0,
     0.0, 1.0, false},
    {&AxleCommands::roller_torque, "roller_torque", "N m",
     "torque of the roller's drive, positive drives the wheel forward", "N m, any finite number", 0.0, -unlimited,
     unlimited, false},
    {&AxleCommands::cylinder_pressure, "cylinder_pressure", "Pa",
     "pressure in the axle's brake cylinder, over the ambient", "0 to 1e7 Pa", 0.0, 0.0, highest_pressure, false},
};
constexpr CommandField const& field_of(Command command) { return command_fields[at(command)]; }

/// A column of what a controller sees of each axle, and an input of a controller alone.
struct MeasurementField {
  std::string_view name, unit, meaning;
  PerAxle<double> Measurements::* of{};  ///< null: of the train, or of the rig's controller
  double lowest{-unlimited}, highest{unlimited};
  bool whole{false};
};

inline constexpr MeasurementField measurement_fields[] = {
    {"axle_speed", "rad/s", "measured speed of each axle: for rig_control the rig's sensors, else the vehicle's own",
     &Measurements::axle_speed},
    {"roller_speed", "rad/s", "measured speed of each roller axle, positive as under a wheel that rolls forward",
     &Measurements::roller_speed},
    {"roller_torque", "N m",
     "torque of each roller drive since the last sample, as measured; positive drives the wheel forward",
     &Measurements::roller_torque},
    {"estimated_force", "N", "our estimate of the contact force on each axle, forward"},
    {"estimated_torque", "N m", "our estimate of the torque on each axle"},
    {"virtual_speed", "rad/s", "speed of each axle of the virtual train"},
    {"feed_forward", "N m", "our feed-forward torque of each roller drive"},
    {"axle_load", "N", "measured vertical force under each axle", &Measurements::axle_load},
    {"drive_torque", "N m", "torque of each roller drive now, as measured", &Measurements::drive_torque},
    {"motor_torque", "N m", "torque of the traction motor of each axle, as its drive reports it",
     &Measurements::motor_torque},
    {"brake_torque", "N m", "torque of each axle's friction brake, from cylinder pressure and nominal pad friction",
     &Measurements::brake_torque},
    {"sand_flow", "kg/s", "flow of sand in front of each axle, on each rail", &Measurements::sand_flow},
    {"dump_valve", "1", "command of each axle's dump valve that acts: 0 fill, 1 hold, 2 vent",
     &Measurements::dump_valve, 0.0, 2.0, true},
    {"brake_demand", "Pa", "cylinder pressure demanded of each axle", &Measurements::brake_demand, 0.0,
     highest_pressure},
    {"track_brake_force", "N", "force of all track brakes against running, the same number for each axle"},
    {"force_of_others", "N",
     "force of the simulated axles on the train, mean since the last sample, forward; the same number for each axle"},
};
constexpr std::size_t measurement_index(std::string_view name) {
  auto const found = std::ranges::find(measurement_fields, name, &MeasurementField::name);
  if (found == std::end(measurement_fields)) throw "there is no such column";
  return at(found - std::begin(measurement_fields));
}
/// Where the number of a column is; the rig's controller has speed sensors of its own.
constexpr PerAxle<double> Measurements::* place_of(MeasurementField const& field, bool of_rollers) {
  return field.of == &Measurements::axle_speed && !of_rollers ? &Measurements::vehicle_axle_speed : field.of;
}

/// Commands of one controller between their sample and their acting.
class DelayedCommands {
 public:
  /// @param initial  acts before the first command
  /// @param delay    steps from a sample to the command's acting
  DelayedCommands(double initial, int delay) : delay_{delay}, sent_(at(delay) + 2) { acting_.fill(initial); }

  void send(PerAxle<double> const& value, std::int64_t step) {
    sent_[(first_ + count_++) % sent_.size()] = {value, step + delay_};
  }

  /// Takes up what acts from this step on.
  void advance(std::int64_t step) {
    for (; count_ > 0 && sent_[first_].acts_at <= step; --count_) {
      acting_ = sent_[first_].value;
      first_ = (first_ + 1) % sent_.size();
    }
  }

  PerAxle<double> const& acting() const { return acting_; }
  /// What was sent last, acting or still to act.
  PerAxle<double> const& newest() const {
    return count_ > 0 ? sent_[(first_ + count_ - 1) % sent_.size()].value : acting_;
  }

  void state(auto& archive) {
    archive(acting_, sent_);
    archive.within(first_, std::size_t{0}, sent_.size() - 1);
    archive.within(count_, std::size_t{0}, sent_.size());
  }
  /// Those that act and those that will.
  void each(auto const& look) const {
    look(acting_);
    for (Sent const& sent : sent_) look(sent.value);
  }

 private:
  struct Sent {
    PerAxle<double> value{};
    std::int64_t acts_at{0};
    void state(auto& archive) { archive(value, acts_at); }
  };

  int delay_;
  PerAxle<double> acting_{};
  std::vector<Sent> sent_;  ///< ring
  std::size_t first_{0}, count_{0};
};

}  // namespace rollerrig
