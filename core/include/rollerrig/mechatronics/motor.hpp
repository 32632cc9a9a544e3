// mechatronics/motor.hpp - a drive from torque command to torque: limits of torque, power and speed, then the torque loop's lag.
//
//   command (constant between samples) -> [limits over speed] -> [first or second order lag] -> torque on wheelset or roller
//
// Signs   torque and speed of the driven axle, positive forward; a gearbox is in the numbers (torque times ratio, speed over it).
#pragma once
#include <cmath>
#include <limits>
#include <optional>

#include "rollerrig/fields.hpp"
#include "rollerrig/math/curves.hpp"

namespace rollerrig {

/// What keeps a drive from the torque that it is asked for.
enum class DriveLimit : int { none, torque, power, speed };

struct Motor {
  PiecewiseLinear envelope{};
  double bandwidth{}, damping_ratio{};
  std::optional<double> largest_torque{}, largest_power{}, largest_speed{};

  static constexpr auto fields() {
    return members(
        Member{"envelope", &Motor::envelope, "N m", "largest |torque| over |speed| [rad/s]; empty: no limit"},
        Member{"bandwidth", &Motor::bandwidth, "rad/s", "bandwidth of the torque loop", positive},
        Member{"damping_ratio", &Motor::damping_ratio, "1",
               "damping ratio of a torque loop of second order; 0: first order", not_negative},
        Member{"largest_torque", &Motor::largest_torque, "N m", "largest torque of the driven axle; absent: no limit",
               not_negative},
        Member{"largest_power", &Motor::largest_power, "W",
               "largest |torque x speed| of the driven axle; absent: no limit", not_negative},
        Member{"largest_speed", &Motor::largest_speed, "rad/s",
               "speed of the driven axle beyond which there is no torque; absent: no limit", not_negative});
  }

  /// The command within what the motor can do at this speed.
  template <Scalar T>
  T within_envelope(T const& command, T const& speed) const {
    T const fast = select(speed < 0.0, -speed, speed);
    T limit = select(command < 0.0, -command, command);
    if (!envelope.empty()) limit = least(limit, envelope.at(fast));
    if (largest_torque) limit = least(limit, T(*largest_torque));
    if (largest_power)
      limit = select(limit * fast > *largest_power, *largest_power / select(fast > 0.0, fast, T(1.0)), limit);
    if (largest_speed) limit = select(fast > *largest_speed, T(0.0), limit);
    limit = select(limit > 0.0, limit, T(0.0));
    return select(command > limit, limit, select(command < -limit, -limit, command));
  }

  /// Which limit a command meets at this speed, if any; a controller that never asks for more than the drive's torque meets it.
  DriveLimit limit_met(double command, double speed) const {
    double const wanted = std::fabs(command), fast = std::fabs(speed);
    if (wanted == 0.0) return DriveLimit::none;
    if (largest_speed && fast > *largest_speed) return DriveLimit::speed;
    double torque = largest_torque.value_or(std::numeric_limits<double>::infinity());
    if (!envelope.empty()) torque = std::fmin(torque, envelope.at(fast));
    if (largest_power && std::fmin(torque, wanted) * fast > *largest_power) return DriveLimit::power;
    return wanted >= torque ? DriveLimit::torque : DriveLimit::none;
  }

  template <Scalar T>
  static T least(T const& a, T const& b) {
    return select(a < b, a, b);
  }

  /// Rate of the loop's states: torque, and for a second-order loop its rate.
  ///
  ///     tau' = w_b (c - tau)      or      tau'' = w_b^2 (c - tau) - 2 zeta w_b tau'
  template <Scalar T>
  void rates(T const* state, T const& command, T const& speed, T* rate) const {
    T const wanted = within_envelope(command, speed);
    if (damping_ratio > 0.0) {
      rate[0] = state[1];
      rate[1] = bandwidth * bandwidth * (wanted - state[0]) - 2.0 * damping_ratio * bandwidth * state[1];
    } else {
      rate[0] = bandwidth * (wanted - state[0]);
    }
  }
};

/// How late the torque is behind what a controller wants now, for slow changes: command's delay, half a sample for which it is
/// held, lag of the torque loop [s]. A loop around all of them divides them by 1 + g.
///
/// @param gain  g of such a loop, (D21); 0: none
inline double torque_lag(Motor const& motor, double period, double delay, double gain) {
  double const ratio = motor.damping_ratio > 0.0 ? 2.0 * motor.damping_ratio : 1.0;
  return (delay + 0.5 * period + ratio / motor.bandwidth) / (1.0 + gain);
}

/// Of a geared rotor on the axle that it drives, its casing fixed to the ground [kg m^2]: n^2 J_m, docs/theory/adhesion.md.
constexpr double reflected_inertia(double rotor_inertia, double gear_ratio) {
  return rotor_inertia * (gear_ratio * gear_ratio);
}

}  // namespace rollerrig
