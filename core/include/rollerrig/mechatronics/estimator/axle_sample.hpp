// mechatronics/estimator/axle_sample.hpp - what an estimator of the contact force sees of one axle, and what it returns.
//
// Signs   roller speed W is positive when the roller turns as under a wheel that rolls forward; its drive's torque U and the
//         force T on the wheel are positive forward; so is the torque C on the axle.
//
//     J_r W' = U + R T        (D1)     J_w w' = C - r T        (D2)
#pragma once
#include <tuple>

#include "rollerrig/fields.hpp"

namespace rollerrig {

/// Wheel and roller as the controller assumes them; they may differ from the rig's.
struct AssumedParameters {
  double roller_inertia{}, roller_radius{}, wheelset_inertia{}, wheel_radius{};

  static constexpr auto fields() {
    using P = AssumedParameters;
    return members(Member{"roller_inertia", &P::roller_inertia, "kg m^2",
                          "moment of inertia of a roller axle about its axis as assumed, J_r", positive},
                   Member{"roller_radius", &P::roller_radius, "m", "radius of the rollers as assumed, R", positive},
                   Member{"wheelset_inertia", &P::wheelset_inertia, "kg m^2",
                          "moment of inertia of a wheelset about its axis as assumed, J_w", positive},
                   Member{"wheel_radius", &P::wheel_radius, "m", "radius of the wheels as assumed, r", positive});
  }
};

/// One axle at one sample.
struct AxleSample {
  double roller_speed{}, wheel_speed{};  ///< W, w as measured [rad/s]
  double roller_torque{};                ///< U since the last sample, as far as it is known [N m]
  double true_force{}, true_torque{};    ///< T [N] and C [N m] at the sample: for the estimator `exact`
};

struct ContactForceEstimate {
  double force{};   ///< T [N]
  double torque{};  ///< C [N m]
  void state(auto& archive) { archive(force, torque); }
};

/// C from the wheel's acceleration behind a low-pass of first order, (D2).
struct AxleTorqueFilter {
  double last_speed{}, rate{};  ///< w [rad/s], w' [rad/s^2]

  double step(AssumedParameters const& p, double low_pass, double wheel_speed, double force, double period) {
    rate += low_pass * ((wheel_speed - last_speed) / period - rate);
    last_speed = wheel_speed;
    return p.wheelset_inertia * rate + p.wheel_radius * force;
  }
  void state(auto& archive) { archive(last_speed, rate); }
};

}  // namespace rollerrig
