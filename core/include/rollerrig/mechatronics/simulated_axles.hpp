// mechatronics/simulated_axles.hpp - the axles of the train that are neither on rollers nor in the 3-D model.
//
//   motion of the train, cylinders, motors, rail as the axles ahead left it -> [each axle: (N1)] -> axle speeds, force on the train
//
//     J_w w_i' = C_i + B_i(w_i) - r T_i        (N1)
//     F        = sum T_i                       (N2), into (D4) on a rig, into the travelling frame's V' on track
//     N_i      = N_i0 + t_i (v' + g i)         (D9)
//
// Source  the same laws as of the virtual train; docs/theory/virtual_train.md. Energy is counted at the middle of each step, where
//         the change of 1/2 J_w w^2 is the work of the torques exactly.
#pragma once
#include <cmath>
#include <vector>

#include "rollerrig/fields.hpp"
#include "rollerrig/mechatronics/virtual_rail.hpp"
#include "rollerrig/mechatronics/virtual_train.hpp"

namespace rollerrig {

/// Empty lists: every axle of the train is under test.
struct SimulatedAxles {
  double wheelset_inertia{}, wheel_radius{}, gradient_force{};
  std::vector<double> static_load{}, load_transfer{}, position{};

  std::size_t count() const { return static_load.size(); }

  static constexpr auto fields() {
    using P = SimulatedAxles;
    return members(Member{"wheelset_inertia", &P::wheelset_inertia, "kg m^2",
                          "moment of inertia of a wheelset with the rotor of its motor, J_w", not_negative},
                   Member{"wheel_radius", &P::wheel_radius, "m", "radius of the wheels, r", not_negative},
                   Member{"gradient_force", &P::gradient_force, "m/s^2", "downhill force per mass, g i"},
                   Member{"static_load", &P::static_load, "N", "static load of each axle, N_i0", positive},
                   Member{"load_transfer", &P::load_transfer, "kg", "load transfer of each axle, t_i in (D9)"},
                   Member{"position", &P::position, "m",
                          "position of each axle along the running direction, as of the axles under test"});
  }
};

/// The train over a step.
struct TrainStep {
  double time{};          ///< at its start [s]
  double distance{};      ///< at its start [m]
  double speed{};         ///< at its middle [m/s]
  double acceleration{};  ///< [m/s^2]
};

struct SimulatedAxleStates {
  struct Axle {
    VirtualAxle wheels{};
    double angle{};       ///< turned since the start [rad]
    double slip{};        ///< r w less the train's speed, mean of the last step [m/s]
    double load{};        ///< [N]
    double work{};        ///< of motor and brake on the axle since the start [J]
    double to_train{};    ///< work of the rail's force on the train [J]
    double dissipated{};  ///< by slip [J]
    RailUnderAxle rail{};
    void state(auto& archive) { archive(wheels, angle, slip, load, work, to_train, dissipated, rail); }
  };

  std::vector<Axle> axle;
  double force{0.0};  ///< (N2), mean of the last step [N]
  void state(auto& archive) { archive(axle, force); }

  explicit SimulatedAxleStates(SimulatedAxles const& axles, double speed) : axle(axles.count()) {
    for (std::size_t i = 0; i < axle.size(); ++i)
      axle[i].wheels.speed = speed / axles.wheel_radius, axle[i].load = axles.static_load[i];
  }

  /// One step of length h.
  ///
  /// @param rail    of both wheels
  /// @param found   what the axles ahead have left
  /// @param torque  of motors, axle by axle [N m]
  /// @param brake   brake(i, w) -> torque of the friction brake [N m]
  template <class Torque, class Brake>
  void step(SimulatedAxles const& axles, VirtualRail const& rail, TrainStep const& train, double h,
            FoundRail const& found, Torque&& torque, Brake&& brake) {
    force = 0.0;
    double const r = axles.wheel_radius;
    for (std::size_t i = 0; i < axle.size(); ++i) {
      Axle& own = axle[i];
      double const place = train.distance + axles.position[i];
      own.load = std::fmax(
          0.0, axles.static_load[i] + axles.load_transfer[i] * (train.acceleration + axles.gradient_force));  // (D9)
      auto const rail_force = [&](double w) {
        return rail.force(r * w - train.speed, train.speed, own.load, train.time, place, own.rail.energy, own.rail.sand,
                          found.friction);
      };
      double const driving = torque(i);
      own.wheels.step({axles.wheelset_inertia, r}, driving, h, rail_force, [&](double w) { return brake(i, w); });
      double const w = own.wheels.middle_speed, of_rail = own.wheels.force;
      own.slip = r * w - train.speed;
      own.angle += h * w;
      own.work += h * (driving + own.wheels.brake_torque) * w;
      own.to_train += h * of_rail * train.speed;
      own.dissipated += h * of_rail * own.slip;
      force += of_rail;
      rail.pass(own.rail, {place, h * train.speed, train.speed, r * w, of_rail, 2.0 * pi * r, h}, found, i);
    }
  }
};

}  // namespace rollerrig
