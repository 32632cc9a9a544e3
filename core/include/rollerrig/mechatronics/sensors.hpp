// mechatronics/sensors.hpp - what controllers see of speeds, torques and loads.
//
//   true motion and forces -> [sensors] -> measurements
//
// To add a speed sensor: a header in speed_sensor/, its line in AnySpeedSensor, its table in
// python/rollerrig/config/schema/rig_control.py.
#pragma once
#include <cstdint>
#include <optional>
#include <tuple>
#include <variant>

#include "rollerrig/mechatronics/force_sensor.hpp"
#include "rollerrig/mechatronics/speed_sensor/encoder.hpp"
#include "rollerrig/mechatronics/speed_sensor/pulse_frequency.hpp"
#include "rollerrig/mechatronics/speed_sensor/pulse_period.hpp"

namespace rollerrig {

using AnySpeedSensor = OneOf<Encoder, PulsePeriod, PulseFrequency>;

struct Sensors {
  AnySpeedSensor axles{}, rollers{};           ///< for the rig's controller
  std::optional<AnySpeedSensor> vehicle{};     ///< the vehicle's own, for its controllers; absent: those of `axles`
  std::optional<ForceSensor> roller_torque{};  ///< in the drive shaft of each roller axle; absent: its torque is known
  ForceSensor axle_load{};                     ///< vertical force of rail or rollers on both wheels of an axle
  std::uint64_t seed{};                        ///< of all noise

  static constexpr auto fields() {
    using P = Sensors;
    return members(Member{"axles", &P::axles}, Member{"rollers", &P::rollers}, Member{"vehicle", &P::vehicle},
                   Member{"roller_torque", &P::roller_torque}, Member{"axle_load", &P::axle_load},
                   Member{"seed", &P::seed, any_integer});
  }
};

}  // namespace rollerrig
