// mechatronics/virtual_train.hpp - the train on the degraded rail that the rig's controller integrates.
//
//   torque C on each axle (estimated) -> [virtual train] -> wheel speeds, contact forces and train speed to be reproduced
//
//     J_w w_v' = C - r T_v        (D3)
//     M v'     = sum T_v - R(v) - M g i - F        (D4)
//     F        of brakes that act on the rail, less that of the axles of simulated_axles.hpp
//     T_v      from the adhesion law at the virtual slip r w_v - v, per axle
//     N_i      = N_i0 + t_i (v' + g i)         (D9)
//
// Source  Malvezzi, Pugi et al., rig for degraded adhesion; Davis' formula for R(v).
#pragma once
#include <cmath>
#include <limits>
#include <vector>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/measurements.hpp"

namespace rollerrig {

// One axle that is only computed: its rotation on the degraded rail.
//     J_w w' = C + B(w) - r T(w)        (D3), the brake's part B apart where it follows the axle's own speed
// Integration  theta method (one unknown, Newton): the slope of T over w is stiff at small slip, as that of B is where the pads
//              hold. theta = 1/2, and for a rate times step above 2 as much larger as damps it in one step.

struct SpinningWheels {
  double inertia{};  ///< J_w, of both wheels and what turns with them [kg m^2]
  double radius{};   ///< r [m]
};

struct VirtualAxle {
  double speed{};         ///< w [rad/s]
  double middle_speed{};  ///< mean of the last step [rad/s]
  double rate{};          ///< over the last step [rad/s^2]
  double force{};         ///< T [N]
  double brake_torque{};  ///< B [N m]
  bool locked{};          ///< it keeps its speed, whatever torque acts on it
  void state(auto& archive) { archive(speed, middle_speed, rate, force, brake_torque, locked); }

  /// @param torque  C, constant over the step [N m]
  /// @param rail    rail(w) -> T, forward [N]
  /// @param brake   brake(w) -> B, against the turning [N m]
  template <class Rail, class Brake>
  void step(SpinningWheels const& wheels, double torque, double period, Rail&& rail, Brake&& brake) {
    auto const held = [&](double w) { return rail(w) - brake(w) / wheels.radius; };
    double const before = speed, reach = implicit_part(wheels, period, held);
    rate = locked ? 0.0 : solved_rate(wheels, torque, reach, held);
    double const within = speed + reach * rate;
    force = rail(within), brake_torque = brake(within);
    speed += period * rate;
    middle_speed = 0.5 * (before + speed);
  }

 private:
  /// theta h: 1/2 h, or (1 - 1/(lambda h)) h for a rate lambda beyond 2/h.
  template <class Held>
  double implicit_part(SpinningWheels const& wheels, double period, Held&& held) const {
    double const w = speed, dw = 1e-6 * (1.0 + std::fabs(w));
    double const stiffness = wheels.radius * (held(w + dw) - held(w - dw)) / (2.0 * dw * wheels.inertia);
    return stiffness * period > 2.0 ? period - 1.0 / stiffness : 0.5 * period;
  }

  /// Solves J_w a = C - r T(w + reach a) for a: Newton with a numerical slope, halving where it leaves the bracket. T over
  /// slip is steep in the middle and flat outside, where Newton alone oscillates without end.
  template <class Held>
  double solved_rate(SpinningWheels const& wheels, double torque, double reach, Held&& held) const {
    double const J = wheels.inertia, r = wheels.radius, w = speed;
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    double a = (torque - r * held(w)) / J;
    for (int iteration = 0; iteration < 60; ++iteration) {
      double const at = w + reach * a;
      double const t = held(at);
      double const dw = 1e-6 * (1.0 + std::fabs(at));
      double const slope = (held(at + dw) - t) / dw;
      double const residual = J * a - torque + r * t;
      (residual > 0.0 ? high : low) = a;
      // Beyond the peak of adhesion T falls with slip: the step must not change its sign.
      double next = a - residual / std::fmax(J + r * slope * reach, 0.2 * J);
      bool const close = std::fabs(next - a) * reach < 1e-12 * (1.0 + std::fabs(w));
      if (!close && !(next > low && next < high) && std::isfinite(high - low)) next = 0.5 * (low + high);
      a = next;
      if (close) break;
    }
    return a;
  }
};

struct VirtualTrain {
  double mass{}, wheelset_inertia{}, wheel_radius{}, resistance_constant{}, resistance_linear{};
  double resistance_quadratic{}, gradient{}, gravity{};
  std::vector<double> static_load{}, load_transfer{}, position{};

  static constexpr auto fields() {
    using P = VirtualTrain;
    return members(
        Member{"mass", &P::mass, "kg", "mass that these axles carry and brake, M", positive},
        Member{"wheelset_inertia", &P::wheelset_inertia, "kg m^2",
               "moment of inertia of a wheelset about its axis, J_w", positive},
        Member{"wheel_radius", &P::wheel_radius, "m", "radius of the wheels, r", positive},
        Member{"resistance_constant", &P::resistance_constant, "N", "running resistance R = A + B v + C v^2: A"},
        Member{"resistance_linear", &P::resistance_linear, "N s/m", "running resistance R = A + B v + C v^2: B"},
        Member{"resistance_quadratic", &P::resistance_quadratic, "N s^2/m^2",
               "running resistance R = A + B v + C v^2: C"},
        Member{"gradient", &P::gradient, "1", "gradient of the line, positive uphill, i"},
        Member{"gravity", &P::gravity, "m/s^2", "acceleration of free fall, g"},
        Member{"static_load", &P::static_load, "N", "static load of each axle, N_i0"},
        Member{"load_transfer", &P::load_transfer, "kg", "load transfer of each axle, t_i in (D9)"},
        Member{"position", &P::position, "m", "position of each axle along the train"});
  }

  double resistance(double v) const {
    return resistance_constant + resistance_linear * v + resistance_quadratic * v * v;
  }
};

struct VirtualTrainState {
  double speed{};         ///< v [m/s]
  double distance{};      ///< [m]
  double acceleration{};  ///< v' [m/s^2]
  PerAxle<VirtualAxle> axle{};
  void state(auto& archive) { archive(speed, distance, acceleration, axle); }

  VirtualTrainState() = default;
  VirtualTrainState(VirtualTrain const& train, double at_speed) : speed{at_speed} {
    axle.fill({.speed = at_speed / train.wheel_radius});
  }

  /// One sample under the torques `axle_torque` [N m], constant over it.
  ///
  /// @param axles  under test: the first ones of the train's lists
  /// @param load   of each of them [N], in place of (D9); null: (D9)
  /// @param retarding  F [N]
  /// @param law    law(axle, slip speed [m/s], train speed [m/s], axle load [N]) -> force T_v on the axle, forward [N]
  template <class Law>
  void step(VirtualTrain const& train, int axles, PerAxle<double> const& axle_torque, PerAxle<double> const* load,
            double retarding, double period, Law&& law) {
    double const half = 0.5 * period;
    double const speed_middle = std::fmax(0.0, speed + half * acceleration);
    double const specific_force = acceleration + train.gravity * train.gradient;
    double sum = 0.0;
    for (int i = 0; i < axles; ++i) {
      auto const k = at(i);
      double const carries =
          load != nullptr ? (*load)[k] : train.static_load[k] + train.load_transfer[k] * specific_force;
      auto const rail = [&](double w) { return law(i, train.wheel_radius * w - speed_middle, speed_middle, carries); };
      auto const no_brake = [](double /*w*/) { return 0.0; };  // it is in the torque
      axle[k].step({train.wheelset_inertia, train.wheel_radius}, axle_torque[k], period, rail, no_brake);
      sum += axle[k].force;
    }
    acceleration = (sum - train.resistance(speed_middle) - retarding) / train.mass - train.gravity * train.gradient;
    distance += period * speed_middle;
    speed = std::fmax(0.0, speed + period * acceleration);
  }
};

}  // namespace rollerrig
